//! Text of files as people have them: byte-order marks, UTF-16, Latin-1; and what a file is that is no text at all.

use crate::machine::{free_memory, giga};
use std::path::Path;
use std::{fs, io};

/// Makes sure that a path leads to a file or a folder: what has no end, or waits for somebody to write, is never read.
///
/// # Errors
/// If there is nothing, or something else.
pub(super) fn check_regular(path: &Path) -> io::Result<()> {
    let what = fs::metadata(path)?;
    if what.is_file() || what.is_dir() { Ok(()) } else { Err(io::Error::other("it is no regular file")) }
}

/// From this size on it is asked whether there is memory for a file: a file with holes can claim any size.
const LARGE: u64 = 1 << 26;

/// The bytes of a file.
///
/// # Errors
/// If it cannot be read, is no regular file, or larger than the memory that is free.
pub(super) fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    check_regular(path)?;
    let size = fs::metadata(path)?.len();
    let free = if size < LARGE { None } else { free_memory() };
    match free.filter(|free| *free < size) {
        Some(free) => Err(io::Error::other(format!(
            "not enough memory: the file has {}, {} are free",
            giga(size),
            giga(free)
        ))),
        None => fs::read(path),
    }
}

/// The text of a file: UTF-8, UTF-16 by its mark or its zeros, else Latin-1.
pub(super) fn decode(bytes: Vec<u8>) -> String {
    match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => return utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return utf16(rest, u16::from_be_bytes),
        [a, 0, b, 0, ..] if *a > 0 && *b > 0 => return utf16(&bytes, u16::from_le_bytes),
        [0, a, 0, b, ..] if *a > 0 && *b > 0 => return utf16(&bytes, u16::from_be_bytes),
        _ => {}
    }
    match String::from_utf8(bytes) {
        Ok(text) => match text.strip_prefix('\u{feff}') {
            Some(rest) => rest.to_owned(),
            None => text,
        },
        Err(error) => error.as_bytes().iter().map(|byte| char::from(*byte)).collect(),
    }
}

fn utf16(bytes: &[u8], word: fn([u8; 2]) -> u16) -> String {
    let words = bytes.as_chunks::<2>().0.iter().map(|pair| word(*pair));
    char::decode_utf16(words).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// First bytes of files that are often taken for something else, and what they are.
const BEGINNINGS: [(&[u8], &str); 26] = [
    (b"version https://git-lfs", "a Git LFS pointer, not the file itself: run `git lfs pull`"),
    (b"\x1f\x8b", "a gzip archive: unpack it first"),
    (b"PK\x03\x04", "a zip archive: unpack it first"),
    (b"7z\xbc\xaf", "a 7z archive: unpack it first"),
    (b"\xfd7zXZ", "an xz archive: unpack it first"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard archive: unpack it first"),
    (b"BZh", "a bzip2 archive: unpack it first"),
    (b"Rar!", "a RAR archive: unpack it first"),
    (b"ply", "a PLY mesh"),
    (b"glTF", "a binary glTF: its name should end in .glb"),
    (b"Kaydara FBX", "an FBX scene"),
    (b"; FBX", "an FBX scene"),
    (b"BLENDER", "a Blender scene"),
    (b"solid ", "an STL mesh"),
    (b"OFF", "an OFF mesh"),
    (b"#usda", "a USD scene"),
    (b"PXR-USDC", "a USD scene"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x76\x2f\x31\x01", "an EXR picture"),
    (b"%PDF", "a PDF document"),
    (b"<!doctype html", "a web page (HTML), perhaps of a failed download"),
    (b"<html", "a web page (HTML), perhaps of a failed download"),
    (b"<scene", "an XML scene"),
    (b"<", "an XML document"),
    (b"{", "JSON; if it is glTF, its name should end in .gltf"),
];

/// What a file seems to be that is neither an OBJ nor a scene file, by its first bytes.
pub(super) fn other_kind(bytes: &[u8]) -> Option<&'static str> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let begins = |with: &[u8]| text.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with));
    let known = BEGINNINGS.iter().find(|(with, _)| begins(with)).map(|(_, kind)| *kind);
    known.or_else(|| is_binary(bytes).then_some("binary data"))
}

/// Whether there are zeros among the first bytes of what is not UTF-16.
fn is_binary(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1024)];
    let zeros = |parity: usize| head.iter().skip(parity).step_by(2).filter(|byte| **byte == 0).count();
    let marked = head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff");
    let wide = marked || zeros(0).max(zeros(1)) * 5 > head.len() * 2 && zeros(0).min(zeros(1)) == 0;
    head.contains(&0) && !wide
}

/// Whether a text looks like an OBJ: its first statement is one.
pub(super) fn looks_like_obj(text: &str) -> bool {
    let statements =
        text.split(['\n', '\r']).map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let word = statements.take(1).find_map(|line| line.split_whitespace().next());
    word.is_some_and(|word| ["v", "vn", "vt", "f", "o", "g", "mtllib", "usemtl"].contains(&word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_however_it_is_written() {
        let wide = |word: fn(u16) -> [u8; 2]| "v 1 ü\n".encode_utf16().flat_map(word).collect::<Vec<u8>>();
        let [little, big] = [wide(u16::to_le_bytes), wide(u16::to_be_bytes)];
        let marked = |mark: &[u8], rest: &[u8]| [mark, rest].concat();
        let texts = [
            "v 1 ü\n".as_bytes().to_vec(),
            marked(b"\xef\xbb\xbf", "v 1 ü\n".as_bytes()),
            b"v 1 \xfc\n".to_vec(),
            marked(b"\xff\xfe", &little),
            marked(b"\xfe\xff", &big),
            little,
            big,
        ];
        for text in texts {
            assert_eq!(other_kind(&text), None, "{text:?}");
            assert_eq!(decode(text.clone()), "v 1 ü\n", "{text:?}");
        }
    }

    #[test]
    fn other_files_are_recognised() {
        for (bytes, word) in [
            (&b"version https://git-lfs.github.com/spec/v1\noid"[..], "LFS"),
            (b"\x1f\x8b\x08\0", "gzip"),
            (b"\n <!DOCTYPE HTML><html>", "HTML"),
            (b"ply\nformat ascii", "PLY"),
            (b"glTF\x02\0\0\0", "glb"),
            (b"a\0\0\0b\0\0\0\0\0", "binary"),
        ] {
            assert!(other_kind(bytes).is_some_and(|kind| kind.contains(word)), "{word}");
        }
        for text in ["", "v 0 0 0\n", "[film]\n", "# made by\n"] {
            assert_eq!(other_kind(text.as_bytes()), None, "{text}");
        }
    }
}
