//! Packets: target, source, content.

use super::{u16_at, u32_at};

/// The TCP port of AMS.
pub const AMS_PORT: u16 = 48_898;
/// Greatest length of a packet: no reply to a gateway's request is longer.
// A notification of 128 axes has 17 kB: 128 bytes each, and 8 in front.
pub const MOST_PACKET_BYTES: usize = 1 << 20;
/// The flags of a request.
pub const REQUEST: u16 = 4;
/// The flags of a reply.
pub const REPLY: u16 = 5;

const TCP_HEADER: usize = 6;
const AMS_HEADER: usize = 32;

/// An end of an ADS connection: an AMS net id and a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AmsAddress {
    /// The net id.
    pub net_id: [u8; 6],
    /// The port.
    pub port: u16,
}

/// A packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Receiver of the packet.
    pub target: AmsAddress,
    /// Sender of the packet.
    pub source: AmsAddress,
    /// The command.
    pub command: u16,
    /// [`REQUEST`] or [`REPLY`].
    pub flags: u16,
    /// 0, or an error of the router.
    pub error: u32,
    /// Number that matches a reply to its request.
    pub invoke: u32,
    /// Data of the command.
    pub data: &'a [u8],
}

/// Error of bytes that are not AMS packets. The bytes that follow cannot be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AmsError {
    /// A length too short for a header, or longer than any packet expected.
    #[error("an AMS packet of {received} bytes came, expected {AMS_HEADER} to {MOST_PACKET_BYTES}")]
    Length {
        /// The length in the header.
        received: usize,
    },
    /// Contradicting lengths in the two headers.
    #[error("an AMS packet of {received} bytes says that it has {stated} bytes of data")]
    Data {
        /// The length of the packet.
        received: usize,
        /// The length of the data in the header.
        stated: usize,
    },
}

impl Packet<'_> {
    /// Replaces the content of `out` by the packet's bytes.
    pub fn write(&self, out: &mut Vec<u8>) {
        let address = |address: AmsAddress, out: &mut Vec<u8>| {
            out.extend_from_slice(&address.net_id);
            out.extend_from_slice(&address.port.to_le_bytes());
        };
        // The data of a request are a symbol's name or an image: far below 4 GiB.
        let data = self.data.len() as u32;
        out.clear();
        // A reserved word of zero marks an AMS packet. The router uses others for its own messages.
        out.extend_from_slice(&[0, 0]);
        out.extend_from_slice(&(AMS_HEADER as u32 + data).to_le_bytes());
        address(self.target, out);
        address(self.source, out);
        out.extend_from_slice(&self.command.to_le_bytes());
        out.extend_from_slice(&self.flags.to_le_bytes());
        out.extend_from_slice(&data.to_le_bytes());
        out.extend_from_slice(&self.error.to_le_bytes());
        out.extend_from_slice(&self.invoke.to_le_bytes());
        out.extend_from_slice(self.data);
    }
}

/// Returns the packet at the start of `bytes`, and its length; none while it is incomplete. A packet of
/// the router itself, about ports and routes, is skipped.
///
/// # Errors
/// [`AmsError`]: the connection is unusable.
pub fn take_packet(bytes: &[u8]) -> Result<Option<(Option<Packet<'_>>, usize)>, AmsError> {
    let (Some(kind), Some(length)) = (u16_at(bytes, 0), u32_at(bytes, 2)) else {
        return Ok(None);
    };
    let received = length as usize;
    // Messages of the router have no AMS header.
    let least = if kind == 0 { AMS_HEADER } else { 0 };
    // Checked before the rest arrives: a wrong length would make the buffer wait for gigabytes.
    if !(least..=MOST_PACKET_BYTES).contains(&received) {
        return Err(AmsError::Length { received });
    }
    let end = TCP_HEADER + received;
    // A stream has no packets: the rest comes with a later read.
    let Some(content) = bytes.get(TCP_HEADER..end) else {
        return Ok(None);
    };
    if kind != 0 {
        return Ok(Some((None, end)));
    }
    let packet = parse(content).ok_or(AmsError::Length { received })?;
    // At 20, between the flags and the error.
    let stated = u32_at(content, 20).unwrap_or_default() as usize;
    // Two lengths that disagree: bytes were lost or inserted, and the next header cannot be found.
    if packet.data.len() == stated {
        Ok(Some((Some(packet), end)))
    } else {
        Err(AmsError::Data { received, stated })
    }
}

fn parse(content: &[u8]) -> Option<Packet<'_>> {
    let address = |offset: usize| {
        Some(AmsAddress {
            net_id: content.get(offset..offset + 6)?.try_into().ok()?,
            port: u16_at(content, offset + 6)?,
        })
    };
    Some(Packet {
        target: address(0)?,
        source: address(8)?,
        command: u16_at(content, 16)?,
        flags: u16_at(content, 18)?,
        error: u32_at(content, 24)?,
        invoke: u32_at(content, 28)?,
        data: content.get(AMS_HEADER..)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PLC: AmsAddress = AmsAddress {
        net_id: [5, 12, 34, 56, 1, 1],
        port: 851,
    };
    const OWN: AmsAddress = AmsAddress {
        net_id: [192, 168, 1, 10, 1, 1],
        // A port above 0x8000, as clients have.
        port: 0x8001,
    };

    /// The request for the state of a PLC, byte by byte.
    #[test]
    fn a_packet_has_its_fields_where_they_belong() {
        let packet = Packet {
            target: PLC,
            source: OWN,
            command: 4,
            flags: REQUEST,
            error: 0,
            invoke: 0x0102_0304,
            data: &[],
        };
        let mut bytes = Vec::new();
        packet.write(&mut bytes);
        let expected = [
            // 0x0353 is 851, and 0x8001 the port of the gateway, lowest byte first.
            0, 0, 32, 0, 0, 0, 5, 12, 34, 56, 1, 1, 0x53, 3, 192, 168, 1, 10, 1, 1, 1, 0x80, 4, 0,
            4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 3, 2, 1,
        ];
        assert_eq!(bytes, expected);
        // 6 bytes of the TCP header and 32 of the AMS header.
        assert_eq!(take_packet(&bytes), Ok(Some((Some(packet), 38))));
    }

    #[test]
    fn a_packet_is_taken_once_it_is_whole_and_no_more_than_it() {
        let packet = Packet {
            target: OWN,
            source: PLC,
            command: 2,
            flags: REPLY,
            error: 7,
            invoke: 9,
            data: &[1, 2, 3],
        };
        let mut bytes = Vec::new();
        packet.write(&mut bytes);
        for length in 0..bytes.len() {
            assert_eq!(take_packet(&bytes[..length]), Ok(None));
        }
        let end = bytes.len();
        // The first bytes of a following packet stay.
        bytes.extend_from_slice(&[0, 0, 32]);
        assert_eq!(take_packet(&bytes), Ok(Some((Some(packet), end))));
    }

    #[test]
    fn lengths_that_cannot_be_are_refused() {
        let received = 31;
        // A byte less than the header has.
        let short = [0, 0, 31, 0, 0, 0];
        assert_eq!(take_packet(&short), Err(AmsError::Length { received }));
        // 4 GiB: refused before any of it is waited for.
        let endless = [0, 0, 255, 255, 255, 255];
        assert!(take_packet(&endless).is_err());
        let mut contradicting = vec![0, 0, 32, 0, 0, 0];
        contradicting.extend_from_slice(&[0; 20]);
        // At offset 20 of the header: one byte of data is stated, and none is there.
        contradicting.extend_from_slice(&[1, 0, 0, 0]);
        contradicting.extend_from_slice(&[0; 8]);
        let (received, stated) = (32, 1);
        let error = AmsError::Data { received, stated };
        assert_eq!(take_packet(&contradicting), Err(error));
        // Packets of a router about ports are skipped.
        assert_eq!(take_packet(&[0, 16, 2, 0, 0, 0, 1, 2]), Ok(Some((None, 8))));
    }

    proptest! {
        #[test]
        fn no_bytes_do_harm(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            let _ = take_packet(&bytes);
        }
    }
}
