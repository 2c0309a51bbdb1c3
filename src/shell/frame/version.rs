//! Which pictures this program makes: a number for what its hash of a scene cannot see.

/// Raised with every change of the picture that the same scene and settings give: of shading, of sampling, of what the
/// loader makes of a file.
///
/// References and frames on disk are used again only if their hash of the scene is the one wanted, and this number is
/// part of it. `tests/picture_version.rs` renders small pictures and fails when their bits have changed and this
/// number has not.
pub const PICTURE_VERSION: u32 = 10;
