//! Ray packets.
