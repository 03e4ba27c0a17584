//! The data of requests and replies.

use super::refusal::AdsRefusal;
use super::u32_at;

/// The command that reads.
pub const READ: u16 = 2;
/// The command that writes.
pub const WRITE: u16 = 3;
/// The command that reads the state of the PLC: 5 is running.
pub const READ_STATE: u16 = 4;
/// The command that adds notifications.
pub const ADD_NOTIFICATION: u16 = 6;
/// The command that deletes them.
pub const DELETE_NOTIFICATION: u16 = 7;
/// The command of the PLC that carries them.
pub const NOTIFICATION: u16 = 8;
/// The command that writes and reads.
pub const READ_WRITE: u16 = 9;

/// The index group in which a handle is read for the written name of a symbol.
pub const HANDLE_BY_NAME: u32 = 0xf003;
/// The index group of values, with handles as offsets.
pub const VALUE_BY_HANDLE: u32 = 0xf005;
/// The index group to which a handle is written to release it.
pub const RELEASE_HANDLE: u32 = 0xf006;

/// Notifications come in each cycle of the PLC, changed or not.
pub const EVERY_CYCLE: u32 = 3;

/// Makes the data of [`READ`].
#[must_use]
pub fn read(group: u32, offset: u32, length: u32) -> Vec<u8> {
    numbers(&[group, offset, length])
}

/// Makes the data of [`WRITE`].
#[must_use]
pub fn write(group: u32, offset: u32, bytes: &[u8]) -> Vec<u8> {
    let mut data = numbers(&[group, offset, bytes.len() as u32]);
    data.extend_from_slice(bytes);
    data
}

/// Makes the data of [`READ_WRITE`].
#[must_use]
pub fn read_write(group: u32, offset: u32, length: u32, bytes: &[u8]) -> Vec<u8> {
    let mut data = numbers(&[group, offset, length, bytes.len() as u32]);
    data.extend_from_slice(bytes);
    data
}

/// Makes the data of [`ADD_NOTIFICATION`] for a value of this number of bytes, in each cycle of the PLC
/// and without delay. Both times are 0, which is the shortest in any unit of a device.
#[must_use]
pub fn add_notification(group: u32, offset: u32, length: u32) -> Vec<u8> {
    let mut data = numbers(&[group, offset, length, EVERY_CYCLE, 0, 0]);
    // Reserved bytes at the end of the request.
    data.extend_from_slice(&[0; 16]);
    data
}

/// Returns the data of a reply after its result.
///
/// # Errors
/// [`AdsRefusal`] if that is not 0. A reply without a result has none of the codes: 0xffffffff.
pub fn result(reply: &[u8]) -> Result<&[u8], AdsRefusal> {
    match u32_at(reply, 0) {
        Some(0) => Ok(&reply[4..]),
        Some(code) => Err(AdsRefusal(code)),
        // A code that no device has, since an error of a short reply must not read as success.
        None => Err(AdsRefusal(u32::MAX)),
    }
}

/// Returns the data read, of a reply after the result: a length and that number of bytes. None if they
/// are not there.
#[must_use]
pub fn read_bytes(behind_result: &[u8]) -> Option<&[u8]> {
    let length = u32_at(behind_result, 0)? as usize;
    // Fewer bytes than stated are an error. More are ignored.
    behind_result.get(4..)?.get(..length)
}

fn numbers(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_read_is_behind_result_and_length() {
        let reply = [0, 0, 0, 0, 2, 0, 0, 0, 7, 8, 9];
        let read = result(&reply).unwrap();
        assert_eq!(read_bytes(read), Some(&[7, 8][..]));
        assert_eq!(read_bytes(&[3, 0, 0, 0, 1, 2]), None);
        assert_eq!(read_bytes(&[255, 255, 255, 255]), None);
        assert_eq!(result(&[0x10, 7, 0, 0]), Err(AdsRefusal(0x710)));
        assert_eq!(result(&[0, 0]), Err(AdsRefusal(u32::MAX)));
    }

    #[test]
    fn requests_say_how_long_what_they_bring_is() {
        let data = read_write(HANDLE_BY_NAME, 0, 4, b"A.b");
        // Four numbers of four bytes, and three letters.
        assert_eq!(data.len(), 16 + 3);
        assert_eq!(u32_at(&data, 0), Some(0xf003));
        assert_eq!(u32_at(&data, 12), Some(3));
        // Six numbers and 16 reserved bytes.
        assert_eq!(add_notification(VALUE_BY_HANDLE, 9, 128).len(), 40);
        assert_eq!(write(VALUE_BY_HANDLE, 9, &[1, 2]).len(), 14);
        assert_eq!(read(VALUE_BY_HANDLE, 9, 2).len(), 12);
    }
}
