//! What a texture statement of an MTL file says: options, a name, more options.

use crate::scene::texture::Lay;

/// A texture statement.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Map {
    /// The name as written, which may hold blanks.
    pub name: String,
    /// The name without options that seem to follow it, and how the picture lies by these.
    pub shorter: Option<(String, Lay)>,
    /// How the picture lies.
    pub lay: Lay,
    /// Options that are skipped.
    pub skipped: Vec<String>,
}

/// Reads the arguments of a texture statement.
pub(super) fn parse(text: &str) -> Map {
    let mut map = Map::default();
    let name = map.take_options(text).trim();
    map.name = name.to_owned();
    // Options after the name: no file is likely to be called so, but it is looked for first.
    let after = name.match_indices(" -").chain(name.match_indices("\t-")).map(|(at, _)| at).filter(|at| {
        let word = name[at + 1..].split_whitespace().next().unwrap_or_default();
        arguments(word).is_some()
    });
    if let Some(at) = after.min() {
        let mut after = Map { lay: map.lay, ..Map::default() };
        after.take_options(&name[at..]);
        map.skipped.append(&mut after.skipped);
        map.shorter = Some((name[..at].trim().to_owned(), after.lay));
    }
    map
}

/// Fewest and most arguments of an option.
fn arguments(option: &str) -> Option<(usize, usize)> {
    Some(match option.to_ascii_lowercase().as_str() {
        "-s" | "-o" | "-t" => (1, 3),
        "-mm" => (2, 2),
        "-bm" | "-boost" | "-texres" | "-clamp" | "-blendu" | "-blendv" | "-cc" | "-imfchan" | "-type"
        | "-colorspace" => (1, 1),
        _ => return None,
    })
}

impl Map {
    /// Takes options and their arguments off the front; returns the rest.
    fn take_options<'a>(&mut self, text: &'a str) -> &'a str {
        let mut rest = text.trim_start();
        loop {
            let (word, after) = next_word(rest);
            let Some((least, most)) = arguments(word) else { return rest };
            let (mut values, mut left) = (Vec::new(), after);
            while values.len() < most {
                let (value, after) = next_word(left);
                // Beyond the least only numbers can be meant, and something must be left to be the name.
                let is_number = value.parse::<f32>().is_ok();
                if value.is_empty() || values.len() >= least && !is_number || most > 1 && !is_number {
                    break;
                }
                values.push(value);
                left = after;
            }
            self.option(&word.to_ascii_lowercase(), &values);
            rest = left;
        }
    }

    fn option(&mut self, option: &str, values: &[&str]) {
        let pair = |otherwise: f32| {
            let value = |i: usize| values.get(i).and_then(|v| v.parse().ok()).filter(|v: &f32| v.is_finite());
            [value(0).unwrap_or(otherwise), value(1).unwrap_or(otherwise)]
        };
        match option {
            "-s" => self.lay.scale = pair(1.0),
            "-o" => self.lay.offset = pair(0.0),
            "-clamp" => self.lay.clamp = values.first().is_some_and(|v| v.eq_ignore_ascii_case("on")),
            // What they say is done already.
            "-blendu" | "-blendv" | "-cc" | "-texres" | "-colorspace" => {}
            other => self.skipped.push(other.to_owned()),
        }
    }
}

/// The first word and what follows it.
fn next_word(text: &str) -> (&str, &str) {
    let text = text.trim_start();
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    (&text[..end], text[end..].trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_names_are_told_apart() {
        for (text, name, scale, offset, clamp) in [
            ("t.png", "t.png", [1.0, 1.0], [0.0, 0.0], false),
            ("my wood.png", "my wood.png", [1.0, 1.0], [0.0, 0.0], false),
            ("-o 0.0 -7.0 0.0 -s 1.0 10.0 1.0 -clamp on t.png", "t.png", [1.0, 10.0], [0.0, -7.0], true),
            ("-s 2 t.png", "t.png", [2.0, 1.0], [0.0, 0.0], false),
            ("-s 2 3 4.png", "4.png", [2.0, 3.0], [0.0, 0.0], false),
            ("-mm 0 1 -bm 0.5 -imfchan l -texres 512 a b.png", "a b.png", [1.0, 1.0], [0.0, 0.0], false),
            ("-clamp off -T 1 1 1 x.png", "x.png", [1.0, 1.0], [0.0, 0.0], false),
            ("-s a.png", "a.png", [1.0, 1.0], [0.0, 0.0], false),
            ("-unknown.png", "-unknown.png", [1.0, 1.0], [0.0, 0.0], false),
            ("", "", [1.0, 1.0], [0.0, 0.0], false),
        ] {
            let map = parse(text);
            assert_eq!((map.name.as_str(), map.lay.scale, map.lay.offset), (name, scale, offset), "{text}");
            assert_eq!((map.lay.clamp, map.shorter), (clamp, None), "{text}");
        }
        let after = parse("t.png -bm 1");
        assert_eq!(
            (after.shorter, after.skipped),
            (Some(("t.png".to_owned(), Lay::default())), vec!["-bm".to_owned()])
        );
        assert_eq!(parse("a -b.png").shorter, None);
        assert_eq!(parse("-mm 0 1 t.png").skipped, ["-mm"]);
    }
}
