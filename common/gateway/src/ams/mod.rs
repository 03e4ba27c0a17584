//! AMS/TCP and ADS as bytes: packets, requests, replies, notifications. Nothing here sends.
//!
//! A packet is the AMS/TCP header (two reserved bytes, the length of the rest), the AMS header (target, source, command,
//! flags, length of the data, error, invoke id: 32 bytes) and data that depend on the command. All numbers have
//! their lowest byte first. Beckhoff's documentation of TwinCAT ADS, *AMS/TCP packet* and *ADS commands*.

mod notification;
mod packet;
mod refusal;
mod request;

pub use notification::{NotifiedSample, notified};
pub use packet::{
    AMS_PORT, AmsAddress, AmsError, MOST_PACKET_BYTES, Packet, REPLY, REQUEST, take_packet,
};
pub use refusal::AdsRefusal;
pub use request::{
    ADD_NOTIFICATION, DELETE_NOTIFICATION, EVERY_CYCLE, HANDLE_BY_NAME, NOTIFICATION, READ,
    READ_STATE, READ_WRITE, RELEASE_HANDLE, VALUE_BY_HANDLE, WRITE, add_notification, read,
    read_bytes, read_write, result, write,
};

/// Returns the number at an offset; none beyond the end.
fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    // `checked_add`: the offset may come from a length in the packet, near the greatest number.
    let four = bytes.get(offset..offset.checked_add(4)?)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

/// Returns the two-byte number at an offset; none beyond the end.
fn u16_at(bytes: &[u8], offset: usize) -> Option<u16> {
    let two = bytes.get(offset..offset.checked_add(2)?)?;
    Some(u16::from_le_bytes(two.try_into().ok()?))
}
