//! To come: kernel.
