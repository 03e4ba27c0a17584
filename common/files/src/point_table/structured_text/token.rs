//! Words, numbers and signs of structured text.

/// A piece of the text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    Word(&'a str),
    Number(f64),
    /// `:=` is `=`, `..` is `~`.
    Sign(char),
    /// A malformed number.
    Garbled(&'a str),
}

/// Splits a text into tokens; comments, pragmas and strings are skipped.
pub(super) struct Tokens<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self {
            rest: text.trim_start_matches('\u{feff}'),
            line: 1,
        }
    }

    /// Advances by this number of bytes, which end at a character boundary.
    fn take(&mut self, bytes: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at_checked(bytes).unwrap_or((self.rest, ""));
        self.rest = rest;
        self.line += taken.bytes().filter(|byte| *byte == b'\n').count();
        taken
    }

    fn take_while(&mut self, belongs: impl Fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|c| !belongs(c));
        self.take(end.unwrap_or(self.rest.len()))
    }

    /// Skips to the end of the construct that begins here, or to the end of the text.
    fn pass(&mut self, open: usize, close: &str) {
        let inner = self.rest.get(open..).unwrap_or_default();
        // A construct that is not closed ends with the text.
        let end = inner
            .find(close)
            .map_or(self.rest.len(), |at| open + at + close.len());
        self.take(end);
    }

    /// Skips a comment with those nested in it, as IEC 61131-3 has them from edition 3 on.
    fn pass_comment(&mut self, open: &str, close: &str) {
        let mut depth = 0_usize;
        loop {
            let end = self.rest.find(close);
            let (inner, length) = match (self.rest.find(open), end) {
                (Some(begin), end) if end.is_none_or(|end| begin < end) => {
                    depth += 1;
                    (begin, open.len())
                }
                (_, Some(end)) => {
                    depth -= 1;
                    (end, close.len())
                }
                // A comment that is not closed ends with the text.
                (_, None) => (self.rest.len(), 0),
            };
            self.take(inner + length);
            if depth == 0 || self.rest.is_empty() {
                return;
            }
        }
    }

    fn pass_what_says_nothing(&mut self) {
        loop {
            self.take_while(char::is_whitespace);
            match self.rest.as_bytes() {
                // Comments and strings may hold brackets and colons that mean nothing.
                [b'/', b'/', ..] => self.pass(2, "\n"),
                [b'(', b'*', ..] => self.pass_comment("(*", "*)"),
                [b'/', b'*', ..] => self.pass_comment("/*", "*/"),
                [b'{', ..] => self.pass(1, "}"),
                [b'\'', ..] => self.pass(1, "'"),
                [b'"', ..] => self.pass(1, "\""),
                _ => return,
            }
        }
    }

    /// A number: `1`, `-` is a sign of its own, `1.5e-3`, `1_000`, `16#FF`. Two points behind a digit are no fraction.
    fn number(&mut self) -> Token<'a> {
        let bytes = self.rest.as_bytes();
        let is_part = |at: usize| {
            bytes
                .get(at)
                .is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_')
        };
        let mut end = 0;
        while is_part(end)
            || bytes.get(end) == Some(&b'#')
            // `1..3` is a range: the point belongs to the number only before a digit.
            || bytes.get(end) == Some(&b'.') && bytes.get(end + 1).is_some_and(u8::is_ascii_digit)
            || matches!(bytes.get(end), Some(b'+' | b'-')) && is_exponent(&bytes[..end])
        {
            end += 1;
        }
        let text = self.take(end);
        number_of(text).map_or(Token::Garbled(text), Token::Number)
    }
}

/// True if a sign may follow: `1.5e`.
fn is_exponent(before: &[u8]) -> bool {
    // In base 16 an `E` is a digit.
    matches!(before.last(), Some(b'e' | b'E')) && !before.contains(&b'#')
}

fn number_of(text: &str) -> Option<f64> {
    let plain = text.replace('_', "");
    match plain.split_once('#') {
        None => plain.parse().ok(),
        Some((base, digits)) => {
            // The bases of IEC 61131-3.
            let base = base.parse().ok().filter(|base| [2, 8, 16].contains(base))?;
            u32::from_str_radix(digits, base).ok().map(f64::from)
        }
    }
}

impl<'a> Iterator for Tokens<'a> {
    /// Token with its line, from 1.
    type Item = (usize, Token<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        self.pass_what_says_nothing();
        let line = self.line;
        let first = self.rest.chars().next()?;
        let token = if first.is_ascii_digit() {
            self.number()
        } else if first.is_alphabetic() || first == '_' {
            Token::Word(self.take_while(|c| c.is_alphanumeric() || c == '_'))
        } else if self.rest.starts_with(":=") {
            self.take(2);
            Token::Sign('=')
        } else if self.rest.starts_with("..") {
            self.take(2);
            Token::Sign('~')
        } else {
            self.take(first.len_utf8());
            // Not a sign of the language, so that none is taken for one of ours.
            Token::Sign(if matches!(first, '=' | '~') {
                '\0'
            } else {
                first
            })
        };
        Some((line, token))
    }
}
