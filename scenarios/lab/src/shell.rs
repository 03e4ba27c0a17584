//! Command lines for a shell, to be copied from a report.

/// A word as a shell takes it: as it is, or in quotes.
#[must_use]
pub fn word(text: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"_-+=./:,@%".contains(&byte);
    if !text.is_empty() && text.bytes().all(is_plain) {
        text.to_owned()
    } else {
        in_quotes(text)
    }
}

/// A word in quotes, within which a shell changes nothing.
#[must_use]
pub fn in_quotes(text: &str) -> String {
    // A quote ends the quoted part, stands for itself behind a backslash, and the next part begins (POSIX, 2.2.2).
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_quoted_where_a_shell_would_take_it_apart() {
        for (text, expected) in [
            ("saw", "saw"),
            ("out/a-1.toml", "out/a-1.toml"),
            ("", "''"),
            ("my saw.toml", "'my saw.toml'"),
            ("$(reboot)", "'$(reboot)'"),
            ("~/saw", "'~/saw'"),
            ("it's", r"'it'\''s'"),
            ("sä;ge", "'sä;ge'"),
        ] {
            assert_eq!(word(text), expected);
        }
        assert_eq!(in_quotes("a=['b']"), r"'a=['\''b'\'']'");
    }
}
