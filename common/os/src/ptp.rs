//! State of the PTP service of a machine, by the management messages of IEEE 1588 and `TIME_STATUS_NP` of linuxptp.

use std::io;

/// Connection to a PTP service, which is asked and answers later.
pub trait PtpService: Send + Sized {
    /// Connects to the service of this machine.
    ///
    /// # Errors
    /// No service, or a refusal.
    fn open() -> io::Result<Self>;

    /// Asks for its state.
    ///
    /// # Errors
    /// A service that is gone.
    fn ask(&mut self) -> io::Result<()>;

    /// Returns the newest answer; none if there is none since the last call. Does not wait.
    fn answer(&mut self) -> Option<PtpState>;
}

/// State of a PTP service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PtpState {
    /// Identity of the grandmaster, most significant byte first.
    pub grandmaster: u64,
    /// Offset from the master when it was last measured, ns.
    pub offset_ns: i64,
    /// True if there is a grandmaster other than the service itself.
    pub is_present: bool,
}

/// Length of the common header of PTP messages.
const HEADER: usize = 34;
/// Place of the first TLV in a management message: after the target port, two hop counts, the action and a reserved byte.
const TLV: usize = HEADER + 14;
/// `TIME_STATUS_NP`, a management id of linuxptp.
const TIME_STATUS_NP: u16 = 0xC000;
/// Type of a TLV with the answer to a management message.
const MANAGEMENT: u16 = 0x0001;
/// Message type of management messages.
const MANAGEMENT_MESSAGE: u8 = 0x0D;
/// Length of the data of `TIME_STATUS_NP`.
// master_offset i64, ingress_time i64, scaled rate offset i32, phase change i32, time base indicator u16, last phase change 12 bytes,
// presence i32, identity 8 bytes; all most significant byte first.
const DATA: usize = 8 + 8 + 4 + 4 + 2 + 12 + 4 + 8;

/// Returns the message that asks for `TIME_STATUS_NP`.
pub(crate) fn request(sequence: u16) -> Vec<u8> {
    // Type, length, id: a request has no data.
    let length = (TLV + 6) as u16;
    let mut message = vec![MANAGEMENT_MESSAGE, 0x02];
    message.extend(length.to_be_bytes());
    // Domain, reserved, flags, correction, reserved: all zero, and so is the identity of the own port but for its number.
    message.extend([0; 4 + 8 + 4 + 8]);
    message.extend(1_u16.to_be_bytes());
    message.extend(sequence.to_be_bytes());
    // Control field of management messages, and no interval.
    message.extend([0x04, 0x7F]);
    // To all ports, over no boundary; GET.
    message.extend([0xFF; 10]);
    message.extend([0, 0, 0, 0]);
    message.extend(MANAGEMENT.to_be_bytes());
    message.extend(2_u16.to_be_bytes());
    message.extend(TIME_STATUS_NP.to_be_bytes());
    message
}

/// Reads the answer; none if the message is another one.
pub(crate) fn answer(message: &[u8]) -> Option<PtpState> {
    let is_management = message.first()? & 0x0F == MANAGEMENT_MESSAGE;
    let tlv = message.get(TLV..)?;
    let word = |at: usize| Some(u16::from_be_bytes(tlv.get(at..at + 2)?.try_into().ok()?));
    let is_answer = word(0)? == MANAGEMENT && word(4)? == TIME_STATUS_NP;
    let data = tlv
        .get(6..6 + DATA)
        .filter(|_| is_management && is_answer)?;
    let eight = |at: usize| data[at..at + 8].try_into().ok();
    Some(PtpState {
        offset_ns: i64::from_be_bytes(eight(0)?),
        is_present: data[DATA - 12..DATA - 8] != [0; 4],
        grandmaster: u64::from_be_bytes(eight(DATA - 8)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_a_management_message_of_its_own_length() {
        let message = request(7);
        assert_eq!(message.len(), 54);
        assert_eq!(message[..4], [0x0D, 2, 0, 54]);
        assert_eq!(message[28..32], [0, 1, 0, 7]);
        assert_eq!(message[48..], [0, 1, 0, 2, 0xC0, 0]);
    }

    /// Answer of ptp4l 3.1.1, 326 ns off a grandmaster at the other end of a pair of virtual cards.
    const ANSWER: &str = "0d02006800000000000000000000000000000000aa6ae6fffe47deac00000007047f\
        0000000000000000000100000200\
        00010034c000000000000000014618ec68a34fbe54bb000000000000000000000000000000000000000000000000\
        0001f266e7fffe2237b5";

    #[test]
    fn an_answer_is_read_and_anything_else_is_none() {
        let bytes = (0..ANSWER.len()).step_by(2);
        let byte = |at| u8::from_str_radix(&ANSWER[at..at + 2], 16).expect("a byte");
        let mut message: Vec<u8> = bytes.map(byte).collect();
        let expected = PtpState {
            grandmaster: 0xf266_e7ff_fe22_37b5,
            offset_ns: 326,
            is_present: true,
        };
        assert_eq!(answer(&message), Some(expected));
        for length in 0..message.len() {
            assert_eq!(answer(&message[..length]), None, "{length}");
        }
        message[53] = 1;
        assert_eq!(answer(&message), None);
        message[53] = 0;
        message[0] = 0x0B;
        assert_eq!(answer(&message), None);
    }
}
