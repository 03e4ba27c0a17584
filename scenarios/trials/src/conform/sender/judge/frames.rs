//! Frames as bytes: version, fields, check sum, sender.

use coaxle_axis::NcToPlcAxis;
use coaxle_node::frame::{FORMAT_VERSION, KeySeal, PRESENTED_VERSION, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, Rejection};

use super::rules::{SenderRule, Tallies};
use crate::conform::rule::mismatch;

/// The fields before the cycle time.
const BEFORE_CYCLE_TIME: usize = 4;
/// The fields before the presentation delay.
const BEFORE_PRESENT_AFTER: usize = 5;

/// The frames under one key.
#[derive(Debug)]
pub(super) struct FrameChecks {
    node: NodeName,
    key: String,
    seal: KeySeal,
}

impl FrameChecks {
    pub(super) fn new(node: &NodeName, channel: Channel) -> Self {
        let key = node.channel_key(channel);
        Self {
            node: node.clone(),
            seal: KeySeal::new(&key),
            key,
        }
    }

    /// Opens a frame; none if it is malformed, or that of another node.
    pub(super) fn open(
        &self,
        bytes: &[u8],
        tallies: &mut Tallies,
    ) -> Option<(FrameHeader, Vec<NcToPlcAxis>)> {
        let version = bytes.first().copied();
        let is_known = matches!(version, Some(FORMAT_VERSION | PRESENTED_VERSION));
        if !tallies.check(SenderRule::Version, is_known, || {
            let received = version.map_or("no byte".to_owned(), |byte| byte.to_string());
            mismatch(received, format!("{FORMAT_VERSION} or {PRESENTED_VERSION}"))
        }) {
            return None;
        }
        let mut axes = Vec::new();
        let opened = self.seal.open(bytes, |axis| axes.push(*axis));
        self.check_bytes(bytes, opened.err(), tallies);
        let header = opened.ok()?;
        let sender = sender_id(&self.node);
        let is_its_own = header.sender == sender;
        tallies.check(SenderRule::SenderId, is_its_own, || {
            let expected = format!("{sender}, the CRC-32 of {:?}", self.node.as_str());
            mismatch(header.sender.to_string(), expected)
        });
        is_its_own.then_some((header, axes))
    }

    /// Counts a frame by the reason for which it is refused, if it is.
    fn check_bytes(&self, bytes: &[u8], refused: Option<Rejection>, tallies: &mut Tallies) {
        let number = |before| {
            let number = varint_after(bytes, before);
            number.map_or("another one".to_owned(), |ns| format!("{ns} ns"))
        };
        let bad = |received, expected: &str| Err(mismatch(received, expected));
        let (rule, case) = match refused {
            None => (SenderRule::PresentAfter, Ok(())),
            Some(Rejection::CycleTimeOutOfRange) => {
                let case = bad(number(BEFORE_CYCLE_TIME), "100 µs to 100 ms");
                (SenderRule::CycleTime, case)
            }
            Some(Rejection::PresentAfterOutOfRange) => {
                let case = bad(number(BEFORE_PRESENT_AFTER), "0 to 4 s");
                (SenderRule::PresentAfter, case)
            }
            Some(Rejection::WrongChecksum) => {
                let expected = format!("the CRC-32 over the key {} and all before it", self.key);
                (SenderRule::CheckSum, bad(self.sum_of(bytes), &expected))
            }
            Some(reason) => {
                let received = format!("{} bytes: {reason}", bytes.len());
                let expected = "the fields of its version, and nothing besides";
                (SenderRule::Fields, bad(received, expected))
            }
        };
        if !matches!(rule, SenderRule::CheckSum | SenderRule::Fields) {
            tallies.count(SenderRule::CheckSum, Ok(()));
            tallies.count(SenderRule::Fields, Ok(()));
        }
        tallies.count(rule, case);
    }

    /// Input of a wrong check sum, where that can be guessed.
    fn sum_of(&self, bytes: &[u8]) -> String {
        let fits = |key: &str| {
            let opened = KeySeal::new(key).open(bytes, |_| {});
            !matches!(opened, Err(Rejection::WrongChecksum | Rejection::Truncated))
        };
        if fits("") {
            return "one over the frame without its key".to_owned();
        }
        let others = Channel::ALL.map(|channel| self.node.channel_key(channel));
        match others.iter().find(|key| **key != self.key && fits(key)) {
            Some(key) => format!("one for the key {key}"),
            None => "another one".to_owned(),
        }
    }
}

/// The number behind the version and `count` numbers.
fn varint_after(bytes: &[u8], count: usize) -> Option<u64> {
    let mut rest = bytes.get(1..)?;
    for n in 0..=count {
        let length = rest.iter().position(|byte| byte & 0x80 == 0)? + 1;
        let (number, behind) = rest.split_at(length);
        if n == count && length <= 9 {
            let bits = number.iter().rev().map(|byte| u64::from(byte & 0x7f));
            return Some(bits.fold(0, |all, bits| all << 7 | bits));
        }
        rest = behind;
    }
    None
}
