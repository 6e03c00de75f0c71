//! Text from files and arguments, as a terminal may show it.

use std::borrow::Cow;

/// A text in which every character that a terminal would obey is written as an escape sequence of Rust,
/// such as
/// `\u{1b}`. Line breaks and tabs stay.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| is_hidden(c) && !matches!(c, '\n' | '\t');
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        match obeyed(character) {
            true => shown.extend(character.escape_unicode()),
            false => shown.push(character),
        }
    }
    Cow::Owned(shown)
}

/// Whether a character controls how others are shown: control characters, and those that change the direction
/// of a text.
pub(crate) fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_terminal_obeys_is_escaped() {
        assert!(matches!(printable("é\n\tx"), Cow::Borrowed(_)));
        assert_eq!(printable("a\x1b]0;title\x07\u{9b}\u{202e}"), "a\\u{1b}]0;title\\u{7}\\u{9b}\\u{202e}");
    }
}
