//! Whether an EXR file can hold what its head claims: asked before there is memory for it.

use exr::meta::MetaData;
use exr::meta::header::Header;
use std::fs::File;
use std::io::{BufReader, Seek};

/// Bytes of pixels that a byte of a file can stand for: 1032 in deflate, a third more where that packs 24 bits of 32.
const MOST_PACKED: u64 = 1_500;

/// Reads the head of an EXR file and goes back to the file's start.
///
/// # Errors
/// One line, if there is no such head, or if it claims more pixels than a file of that length can hold.
pub(crate) fn head(mut file: &File) -> Result<MetaData, String> {
    let head = MetaData::read_from_buffered(BufReader::new(file), false).map_err(|e| e.to_string())?;
    let bytes = |header: &Header| {
        (header.layer_size.area() as u64).saturating_mul(header.channels.bytes_per_pixel as u64)
    };
    let claimed = head.headers.iter().map(bytes).fold(0, u64::saturating_add);
    let there = file.metadata().map_err(|e| e.to_string())?.len();
    if claimed > there.saturating_mul(MOST_PACKED) {
        return Err(format!("its head claims {claimed} bytes of pixels, too many for {there} bytes of file"));
    }
    file.rewind().map_err(|e| e.to_string())?;
    Ok(head)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// The head of a sound file with its width changed to 10⁹: found by the fuzz target `picture`.
    #[test]
    fn a_few_bytes_cannot_claim_a_billion_pixels() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(include_bytes!("../../../tests/doors/found/picture-claim")).unwrap();
        file.rewind().unwrap();
        let reason = head(&file).err().unwrap();
        assert_eq!(reason, "its head claims 24000000000 bytes of pixels, too many for 740 bytes of file");
    }
}
