//! Transcendental functions, eight lanes at a time.
