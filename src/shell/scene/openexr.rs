//! EXR files from anywhere: what a head claims is compared with the file before there is memory for it, and a decoder that
//! fails in the middle is an error like any other.
//!
//! The `exr` crate decodes on threads of its own where it is let, and a panic there ends the program. So files are read on the
//! caller's thread.

use exr::image::read::image::{ReadImage, ReadLayers};
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, Vec2};
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Bytes of pixels that a byte of a file can stand for: 1032 in deflate, a third more where that packs 24 bits of 32.
const MOST_PACKED: u64 = 1_500;

/// Reads a file whose head passes `check`, on this thread.
///
/// # Errors
/// One line: why it is no EXR file, is damaged, or claims more pixels than a file of that length can hold.
pub(crate) fn read<F: Read + Seek, L, T>(
    mut file: F,
    check: impl FnOnce(&MetaData) -> Result<(), String>,
    reader: ReadImage<fn(f64), L>,
) -> Result<exr::image::Image<T>, String>
where
    for<'s> L: ReadLayers<'s, Layers = T>,
{
    let there = file.seek(SeekFrom::End(0)).and_then(|there| file.rewind().map(|()| there)).map_err(line)?;
    let head = MetaData::read_from_buffered(BufReader::new(&mut file), false).map_err(line)?;
    check_claim(&head, there)?;
    check(&head)?;
    file.rewind().map_err(line)?;
    let decode = || reader.non_parallel().from_buffered(BufReader::new(file));
    let decoded = catch_unwind(AssertUnwindSafe(decode)).map_err(|_| "its pixels are damaged".to_owned())?;
    decoded.map_err(line)
}

/// Makes sure that a file of `there` bytes can hold what its head claims.
fn check_claim(head: &MetaData, there: u64) -> Result<(), String> {
    let bytes = |header: &Header| {
        (header.layer_size.area() as u64).saturating_mul(header.channels.bytes_per_pixel as u64)
    };
    let claimed = head.headers.iter().map(bytes).fold(0, u64::saturating_add);
    match claimed > there.saturating_mul(MOST_PACKED) {
        true => Err(format!("its head claims {claimed} bytes of pixels, too many for {there} bytes of file")),
        false => Ok(()),
    }
}

/// Columns, rows and pixels of the first part that has the channels R, G and B; alpha is 1 where there is none.
pub(super) fn rgba<F: Read + Seek>(
    file: F,
    check: impl FnOnce(&MetaData) -> Result<(), String>,
) -> Result<(usize, usize, Vec<[f32; 4]>), String> {
    let new = |size: Vec2<usize>, _: &_| (size.width(), size.height(), vec![[0.0; 4]; size.area()]);
    let set =
        |picture: &mut (usize, usize, Vec<[f32; 4]>), at: Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
            picture.2[at.y() * picture.0 + at.x()] = [r, g, b, a];
        };
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level();
    let reader = reader.rgba_channels(new, set).first_valid_layer().all_attributes();
    Ok(read(file, check, reader)?.layer_data.channel_data.pixels)
}

fn line(error: impl ToString) -> String {
    error.to_string().replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// The head of a sound file with its width changed to 10⁹: found by the fuzz target `picture`.
    #[test]
    fn a_few_bytes_cannot_claim_a_billion_pixels() {
        let file = include_bytes!("../../../tests/doors/found/picture-claim");
        let reason = rgba(Cursor::new(file), |_| Ok(())).err().unwrap();
        assert_eq!(reason, "its head claims 24000000000 bytes of pixels, too many for 740 bytes of file");
    }
}
