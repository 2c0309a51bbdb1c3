//! What a `uri` of a glTF file means: data in itself, or a file beside it.

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::path::{Path, PathBuf};

/// Where data are.
#[derive(Debug, PartialEq)]
pub(super) enum Place {
    Here(Vec<u8>),
    File(PathBuf),
}

/// What a `uri` in the file `path` means.
///
/// # Errors
/// If it is neither data nor the name of a file in or below the folder of `path`.
pub(super) fn resolve(path: &Path, uri: &str) -> Result<Place, String> {
    if let Some(rest) = strip_scheme(uri, "data") {
        return data(rest).map(Place::Here);
    }
    let name = String::from_utf8(unescape(uri)).map_err(|_| format!("{}: not UTF-8", shown(uri)))?;
    match is_inside(uri) && is_inside(&name) {
        true if !name.is_empty() => Ok(Place::File(path.with_file_name("").join(name))),
        true => Err("an empty uri".to_owned()),
        false => Err(format!("{}: expected a file in the folder of the glTF or below", shown(uri))),
    }
}

/// The start of a name that may be long.
fn shown(uri: &str) -> String {
    const MOST: usize = 80;
    let short: String = uri.chars().take(MOST).filter(|c| !c.is_control()).collect();
    if short.len() < uri.len() { format!("{short}…") } else { short }
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let (start, rest) = uri.split_once(':')?;
    start.eq_ignore_ascii_case(scheme).then_some(rest)
}

/// Whether a name stays in its folder, on any system: neither absolute, nor of a scheme or drive, nor upwards.
fn is_inside(name: &str) -> bool {
    let mut parts = name.split(['/', '\\']);
    let relative = !name.starts_with(['/', '\\']);
    let scheme = name.split(['/', '\\']).next().is_some_and(|first| first.contains(':'));
    relative && !scheme && !name.contains('\0') && parts.all(|part| part != "..")
}

/// Data after `data:`.
fn data(rest: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = rest.split_once(',').ok_or("data without a comma before them")?;
    let bytes = unescape(data);
    if !kind.trim_end().to_ascii_lowercase().ends_with(";base64") {
        return Ok(bytes);
    }
    let padding = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&STANDARD, padding).decode(bytes).map_err(|e| format!("base64: {e}"))
}

/// Bytes written as `%41` (RFC 3986).
fn unescape(text: &str) -> Vec<u8> {
    let (mut bytes, mut rest) = (Vec::with_capacity(text.len()), text.as_bytes());
    while let [first, after @ ..] = rest {
        let pair = after.get(..2).and_then(|pair| std::str::from_utf8(pair).ok());
        let escaped = pair.filter(|_| *first == b'%').and_then(|pair| u8::from_str_radix(pair, 16).ok());
        bytes.push(escaped.unwrap_or(*first));
        rest = if escaped.is_some() { &after[2..] } else { after };
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_files_beside() {
        let at = |uri| resolve(Path::new("/a/b/s.gltf"), uri);
        let file = |name: &str| Ok(Place::File(PathBuf::from(name)));
        assert_eq!(at("t.bin"), file("/a/b/t.bin"));
        assert_eq!(at("sub/my%20t.bin"), file("/a/b/sub/my t.bin"));
        assert_eq!(at("100%.bin"), file("/a/b/100%.bin"));
        assert_eq!(resolve(Path::new("s.gltf"), "t.bin"), file("t.bin"));
    }

    #[test]
    fn names_that_lead_out_are_refused() {
        for uri in [
            "../t.bin",
            "a/../../t",
            "/etc/passwd",
            "%2e%2e/t",
            "..\\t",
            "\\\\host\\t",
            "C:\\t",
            "C:/t",
            "file:///t",
            "http://host/t",
            "%2Fetc/passwd",
            "a%00b",
            "",
        ] {
            let refused = resolve(Path::new("/a/s.gltf"), uri);
            assert!(refused.as_ref().is_err_and(|message| !message.contains('\n')), "{uri}: {refused:?}");
        }
    }

    #[test]
    fn data_are_decoded() {
        let at = |uri| resolve(Path::new("s.gltf"), uri);
        let here = |bytes: &[u8]| Ok(Place::Here(bytes.to_vec()));
        assert_eq!(at("data:application/octet-stream;base64,AAEC"), here(&[0, 1, 2]));
        assert_eq!(at("data:;base64,AAE="), here(&[0, 1]));
        assert_eq!(at("DATA:;base64,AAE"), here(&[0, 1]));
        assert_eq!(at("data:,a%20b"), here(b"a b"));
        assert!(at("data:;base64,A*").is_err());
        assert!(at("data:nothing").is_err());
    }
}
