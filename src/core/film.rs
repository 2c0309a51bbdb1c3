//! To come: film.
