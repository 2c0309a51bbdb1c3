//! To come: tvi.
