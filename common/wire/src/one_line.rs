//! Quotation of texts from elsewhere in a message.

/// Characters kept of a long text: of its beginning, and of its end.
const KEPT: (usize, usize) = (1_500, 500);

/// Greatest number of characters that [`one_line`] returns.
pub const MOST_CHARACTERS: usize = KEPT.0 + 3 + KEPT.1;

/// Returns a text on one line that a person can read. Line breaks become spaces, other control characters
/// are escaped, and the middle of a long text is left out. Input from a file or the network may be of any
/// length and content.
#[must_use]
pub fn one_line(text: &str) -> String {
    let mut line = String::new();
    for (n, part) in text.lines().map(str::trim_end).enumerate() {
        if n > 0 && !line.is_empty() && !part.is_empty() {
            line.push(' ');
        }
        part.chars().for_each(|c| push(c, &mut line));
    }
    without_middle(line)
}

fn push(c: char, line: &mut String) {
    // U+2028 and U+2029 break lines too, U+202A to U+202E and U+2066 to U+2069 turn their direction.
    if c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}') {
        line.extend(c.escape_default());
    } else {
        line.push(c);
    }
}

fn without_middle(line: String) -> String {
    // No text has more characters than bytes.
    if line.len() <= MOST_CHARACTERS {
        return line;
    }
    let count = line.chars().count();
    if count <= MOST_CHARACTERS {
        return line;
    }
    let (head, tail) = KEPT;
    let mut short: String = line.chars().take(head).collect();
    short.push_str(" … ");
    short.extend(line.chars().skip(count - tail));
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_joined_and_control_characters_escaped() {
        for (text, expected) in [
            ("", ""),
            ("as it is, °µ", "as it is, °µ"),
            ("first\n  |\r\n\nlast\n", "first   | last"),
            ("bell\u{7} \u{1b}[2J", "bell\\u{7} \\u{1b}[2J"),
            ("a\u{2028}b\u{202e}c", "a\\u{2028}b\\u{202e}c"),
        ] {
            assert_eq!(one_line(text), expected, "{text:?}");
        }
    }

    #[test]
    fn of_a_long_text_the_ends_are_kept() {
        let long = format!("begin{}end", "µ".repeat(1_000_000));
        let short = one_line(&long);
        assert!(short.starts_with("beginµ") && short.ends_with("µend"));
        assert_eq!(short.chars().count(), MOST_CHARACTERS);
        let fits = "µ".repeat(MOST_CHARACTERS);
        assert_eq!(one_line(&fits), fits);
    }
}
