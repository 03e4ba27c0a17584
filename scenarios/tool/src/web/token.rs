//! Token of a page: the right to change anything by it.
//!
//! Every process of the PC reaches a page on loopback, also those of other users. The address with the token is printed
//! or logged once, where only the user who started the page sees it; the page sends the token with each change.

use std::fmt::{self, Write};

/// A random text in the address of a page.
#[derive(Clone)]
pub(crate) struct PageToken(String);

impl PageToken {
    /// Draws a token.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub(crate) fn draw() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes)?;
        let mut text = String::new();
        for byte in bytes {
            // Writing to a string does not fail.
            let _ = write!(text, "{byte:02x}");
        }
        Ok(Self(text))
    }

    /// True for the token itself, in the same time for any other text of its length.
    pub(super) fn is(&self, received: &[u8]) -> bool {
        let own = self.0.as_bytes();
        let pairs = own.iter().zip(received);
        let differences = pairs.fold(0, |all, (own, received)| all | (own ^ received));
        own.len() == received.len() && differences == 0
    }

    /// Path and query of an address with the token.
    pub(super) fn query(&self) -> String {
        format!("/?token={}", self.0)
    }
}

/// Without the token itself: it must not get into a log by accident.
impl fmt::Debug for PageToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("PageToken")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ_and_only_the_whole_one_is_right() {
        let [one, other] = [(); 2].map(|()| PageToken::draw().unwrap());
        let text = one.0.as_bytes();
        assert!(one.is(text) && text.len() == 32);
        for wrong in [&b""[..], b"1", &text[1..], other.0.as_bytes()] {
            assert!(!one.is(wrong));
        }
        assert!(!format!("{one:?}").contains(&one.0));
    }
}
