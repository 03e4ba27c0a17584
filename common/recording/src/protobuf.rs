//! The part of the encoding of Protocol Buffers for rows and their schemas: fields with a number, of four
//! types.

/// An encoded value in a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WireValue<'a> {
    Varint(u64),
    Fixed64(u64),
    Bytes(&'a [u8]),
    Fixed32(u32),
}

/// Error of bytes that are not a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("received bytes that are no Protocol Buffers message, expected one")]
pub(crate) struct InvalidMessage;

const VARINT: u32 = 0;
const FIXED64: u32 = 1;
const BYTES: u32 = 2;
const FIXED32: u32 = 5;

pub(crate) fn put_varint(out: &mut Vec<u8>, mut value: u64) {
    // Seven bits per byte, lowest first; the highest bit says that another byte follows.
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn put_tag(out: &mut Vec<u8>, number: u32, shape: u32) {
    put_varint(out, u64::from(number << 3 | shape));
}

pub(crate) fn put_count(out: &mut Vec<u8>, number: u32, value: u64) {
    put_tag(out, number, VARINT);
    put_varint(out, value);
}

/// Writes an integer as `sint64`: small numbers of either sign are short.
pub(crate) fn put_integer(out: &mut Vec<u8>, number: u32, value: i64) {
    put_count(out, number, zigzag(value));
}

pub(crate) fn put_number(out: &mut Vec<u8>, number: u32, value: f64) {
    put_tag(out, number, FIXED64);
    out.extend_from_slice(&value.to_le_bytes());
}

pub(crate) fn put_bytes(out: &mut Vec<u8>, number: u32, value: &[u8]) {
    put_tag(out, number, BYTES);
    put_varint(out, value.len() as u64);
    out.extend_from_slice(value);
}

/// Writes a message within a message.
pub(crate) fn put_message(out: &mut Vec<u8>, number: u32, fill: impl FnOnce(&mut Vec<u8>)) {
    // The length precedes the content, and has itself a length that depends on it.
    let mut inner = Vec::new();
    fill(&mut inner);
    put_bytes(out, number, &inner);
}

const fn zigzag(value: i64) -> u64 {
    // 0, -1, 1, -2 … become 0, 1, 2, 3 …: a plain negative number would take ten bytes.
    (value << 1 ^ value >> 63) as u64
}

pub(crate) const fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

/// The fields of a message, each with its number, in their order there.
pub(crate) struct MessageFields<'a>(pub(crate) &'a [u8]);

impl<'a> MessageFields<'a> {
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        // Ten bytes at most: a longer one is no varint of 64 bits, and would shift beyond the width.
        for shift in (0..64).step_by(7) {
            let (byte, rest) = self.0.split_first()?;
            self.0 = rest;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (array, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*array)
    }

    fn bytes(&mut self) -> Option<&'a [u8]> {
        // Compared with what is there before it is used: a forged length allocates nothing.
        let length = usize::try_from(self.varint()?).ok()?;
        let (bytes, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(bytes)
    }

    fn field(&mut self) -> Option<(u32, WireValue<'a>)> {
        let tag = u32::try_from(self.varint()?).ok()?;
        let wire = match tag & 7 {
            VARINT => WireValue::Varint(self.varint()?),
            FIXED64 => WireValue::Fixed64(u64::from_le_bytes(self.array()?)),
            BYTES => WireValue::Bytes(self.bytes()?),
            FIXED32 => WireValue::Fixed32(u32::from_le_bytes(self.array()?)),
            // Groups (3 and 4) have no length, and are no longer written since proto3.
            _ => return None,
        };
        Some((tag >> 3, wire))
    }
}

impl<'a> Iterator for MessageFields<'a> {
    type Item = Result<(u32, WireValue<'a>), InvalidMessage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let field = self.field().ok_or(InvalidMessage);
        if field.is_err() {
            // The fields that follow cannot be parsed.
            self.0 = &[];
        }
        Some(field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_of_either_sign_come_back() {
        for value in [0, 1, -1, 63, -64, 64, i64::MAX, i64::MIN] {
            assert_eq!(unzigzag(zigzag(value)), value);
        }
        let mut bytes = Vec::new();
        put_integer(&mut bytes, 1, -1);
        assert_eq!(bytes, [8, 1]);
    }

    #[test]
    fn fields_come_back_in_their_order() {
        let mut bytes = Vec::new();
        put_count(&mut bytes, 1, 300);
        put_number(&mut bytes, 90, -0.5);
        put_bytes(&mut bytes, 3, b"word");
        let fields: Result<Vec<_>, _> = MessageFields(&bytes).collect();
        let expected = [
            (1, WireValue::Varint(300)),
            (90, WireValue::Fixed64((-0.5_f64).to_bits())),
            (3, WireValue::Bytes(b"word")),
        ];
        assert_eq!(fields.unwrap(), expected);
        for end in 1..bytes.len() {
            assert!(MessageFields(&bytes[..end]).count() <= 3, "{end}");
        }
        assert_eq!(MessageFields(&[0x80; 11]).last(), Some(Err(InvalidMessage)));
    }
}
