//! To come: camera.
