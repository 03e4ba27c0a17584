//! Lengths in a record, checked before it is parsed: the parser allocates a text before it reads its bytes.

use mcap::records::op;

/// A length that reaches beyond the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("received a {what} of {received} bytes, expected at most {most}, the rest of its record")]
pub struct TooLongPart {
    /// Part of the record.
    pub what: &'static str,
    /// Length received.
    pub received: u64,
    /// Number of bytes behind the length.
    pub most: u64,
}

/// Checks the lengths of all parts of a record.
///
/// # Errors
/// [`TooLongPart`], the first one.
pub(crate) fn check(opcode: u8, data: &[u8]) -> Result<(), TooLongPart> {
    let mut rest = Rest(data);
    // The fields in the order of https://mcap.dev/spec, up to the last one with a length.
    match opcode {
        op::SCHEMA => {
            rest.skip(2)?;
            rest.text()?;
            rest.text()
        }
        op::CHANNEL => {
            rest.skip(2 + 2)?;
            rest.text()?;
            rest.text()?;
            rest.map()
        }
        op::METADATA => {
            rest.text()?;
            rest.map()
        }
        op::ATTACHMENT => {
            rest.skip(8 + 8)?;
            rest.text()?;
            rest.text()?;
            rest.content()?;
            // The parser takes the check sum off the record before it compares lengths.
            rest.skip(4)
        }
        _ => Ok(()),
    }
}

/// Part of a record that has not been checked yet.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn skip(&mut self, length: u64) -> Result<(), TooLongPart> {
        self.part("field", length)
    }

    fn text(&mut self) -> Result<(), TooLongPart> {
        let length = self.length()?;
        self.part("text", length)
    }

    /// Texts in pairs, behind their number of bytes.
    fn map(&mut self) -> Result<(), TooLongPart> {
        let length = self.length()?;
        let Self(rest) = *self;
        self.part("list of texts", length)?;
        let mut pairs = Rest(&rest[..rest.len() - self.0.len()]);
        while !pairs.0.is_empty() {
            pairs.text()?;
        }
        Ok(())
    }

    /// Content of an attachment, whose length has 8 bytes.
    fn content(&mut self) -> Result<(), TooLongPart> {
        let bytes = self.taken::<8>()?;
        self.part("file", u64::from_le_bytes(bytes))
    }

    fn length(&mut self) -> Result<u64, TooLongPart> {
        let bytes = self.taken::<4>()?;
        Ok(u32::from_le_bytes(bytes).into())
    }

    fn taken<const N: usize>(&mut self) -> Result<[u8; N], TooLongPart> {
        let Self(before) = *self;
        self.skip(N as u64)?;
        let mut bytes = [0; N];
        bytes.copy_from_slice(&before[..N]);
        Ok(bytes)
    }

    fn part(&mut self, what: &'static str, received: u64) -> Result<(), TooLongPart> {
        let most = self.0.len() as u64;
        if received > most {
            return Err(TooLongPart {
                what,
                received,
                most,
            });
        }
        // At most the length of a slice, so that it fits.
        self.0 = &self.0[received as usize..];
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Vec<u8> {
        let length = (text.len() as u32).to_le_bytes();
        [&length, text.as_bytes()].concat()
    }

    #[test]
    fn records_pass_and_each_length_beyond_them_is_refused() {
        let map = {
            let pairs = [text("unit"), text("mm")].concat();
            [&(pairs.len() as u32).to_le_bytes(), pairs.as_slice()].concat()
        };
        let attached = [&3_u64.to_le_bytes()[..], b"a=1", &[0; 4]].concat();
        for (opcode, parts) in [
            (
                op::SCHEMA,
                vec![vec![1, 0], text("n"), text("proto"), text("data")],
            ),
            (
                op::CHANNEL,
                vec![vec![1, 0, 1, 0], text("t"), text("e"), map.clone()],
            ),
            (op::METADATA, vec![text("coaxle"), map]),
            (
                op::ATTACHMENT,
                vec![vec![0; 16], text("n"), text("t"), attached],
            ),
        ] {
            let record = parts.concat();
            assert_eq!(check(opcode, &record), Ok(()), "{opcode}");
            let mut at = 0;
            for part in &parts {
                let is_length = part.len() > 4 && (part.len() != 16);
                if is_length && !(opcode == op::SCHEMA && part == &text("data")) {
                    let mut forged = record.clone();
                    forged[at + 2] = 0xff;
                    let refused = check(opcode, &forged).unwrap_err();
                    assert!(refused.received > 0xff_0000 - 1, "{opcode}: {refused}");
                }
                at += part.len();
            }
            // Cut off anywhere but in the content of a schema, which the parser compares itself.
            for length in 0..record.len() {
                let cut = check(opcode, &record[..length]);
                let is_content = opcode == op::SCHEMA && length >= record.len() - 8;
                assert_eq!(cut.is_ok(), is_content, "{opcode}: {length}");
            }
        }
    }
}
