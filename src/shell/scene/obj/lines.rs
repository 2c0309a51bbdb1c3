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
    match text.find('#') {
        Some(at) => &text[..at],
        None => text,
    }
}

/// A name without a comment: that begins with a number sign after a blank, since names may have number signs.
pub(super) fn without_comment(name: &str) -> &str {
    let comment = name.char_indices().find(|(at, c)| *c == '#' && name[..*at].ends_with(char::is_whitespace));
    comment.map_or(name, |(at, _)| name[..at].trim_end())
}

/// Lines with the number of their beginning, ended by LF, CR or both; a backslash at the end of a line continues it,
/// unless that is a comment.
pub(super) fn logical_lines(source: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = physical_lines(source).enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut line = Cow::Borrowed(first);
        while let Some(part) = continued(&line) {
            let more = lines.next().map_or("", |(_, text)| text);
            line = Cow::Owned(format!("{part} {more}"));
        }
        Some((index + 1, line))
    })
}

/// The line without its backslash, if it is continued.
fn continued(line: &str) -> Option<&str> {
    let part = line.trim_end().strip_suffix('\\')?;
    (!line.trim_start().starts_with('#')).then_some(part)
}

fn physical_lines(source: &str) -> impl Iterator<Item = &str> {
    let mut rest = source;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = rest.bytes().position(|byte| byte == b'\n' || byte == b'\r').unwrap_or(rest.len());
        let (line, after) = rest.split_at(end);
        rest = after.strip_prefix("\r\n").unwrap_or(after.get(1..).unwrap_or(""));
        Some(line)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_every_way_and_are_continued() {
        let lines = |text: &'static str| logical_lines(text).collect::<Vec<_>>();
        for text in ["a\nb\n\nc", "a\r\nb\r\n\r\nc\r\n", "a\rb\r\rc\r"] {
            assert_eq!(lines(text), [(1, "a".into()), (2, "b".into()), (3, "".into()), (4, "c".into())]);
        }
        assert_eq!(lines("f 1 \\\r\n2 \\\n3\nv"), [(1, "f 1  2  3".into()), (4, "v".into())]);
        assert_eq!(lines("# C:\\\nv"), [(1, "# C:\\".into()), (2, "v".into())]);
        assert_eq!(lines("f 1\\"), [(1, "f 1 ".into())]);
    }

    #[test]
    fn comments_after_names_begin_after_a_blank() {
        for (text, name) in [("a # b", "a"), ("a#1", "a#1"), ("a\t#b", "a"), ("a b", "a b"), ("# a", "# a")] {
            assert_eq!(without_comment(text), name);
        }
    }
}
