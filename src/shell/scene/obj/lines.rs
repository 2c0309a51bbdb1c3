//! Lines of OBJ and MTL files: key and data, without comments, continued ones joined.

use std::borrow::Cow;

/// The first word of a line and the trimmed rest.
pub(super) fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (key, rest.trim_start())
}

/// What stands before a comment.
pub(super) fn data(text: &str) -> &str {
    text.split('#').next().unwrap_or_default()
}

/// Lines with the number of their beginning; a backslash at the end of a line continues it.
pub(super) fn logical_lines(source: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = source.lines().enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut line = Cow::Borrowed(first);
        while let Some(part) = line.trim_end().strip_suffix('\\') {
            let more = lines.next().map_or("", |(_, text)| text);
            line = Cow::Owned(format!("{part} {more}"));
        }
        Some((index + 1, line))
    })
}
