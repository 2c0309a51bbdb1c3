//! To come: allocate.
