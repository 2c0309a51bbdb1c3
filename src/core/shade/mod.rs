//! Materials, lights, integrators.
