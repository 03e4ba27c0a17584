//! Frames as bytes: version, fields, check sum, sender.

use coaxle_axis::NcToPlcAxis;
use coaxle_node::frame::{FORMAT_VERSION, KeySeal, PRESENTED_VERSION, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, Rejection};

use super::rules::{CHECK_SUM, FRAME_FIELDS, PRESENT_AFTER, SENDER_ID, VERSION};
use crate::conform::rule::{RuleFinding, Tally};

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
    sender: u32,
    version: Tally,
    fields: Tally,
    check_sum: Tally,
    sender_id: Tally,
    present_after: Tally,
}

/// Result of opening a frame.
#[derive(Debug)]
pub(super) enum OpenedFrame {
    /// A good one.
    Good(FrameHeader, Vec<NcToPlcAxis>),
    /// A frame with a cycle time out of range, if it can be read.
    CycleTime(Option<u64>),
    /// A malformed frame, or that of another node.
    Other,
}

impl FrameChecks {
    pub(super) fn new(node: &NodeName, channel: Channel) -> Self {
        let key = node.channel_key(channel);
        Self {
            node: node.clone(),
            seal: KeySeal::new(&key),
            key,
            sender: sender_id(node),
            version: Tally::default(),
            fields: Tally::default(),
            check_sum: Tally::default(),
            sender_id: Tally::default(),
            present_after: Tally::default(),
        }
    }

    /// Number of frames received.
    pub(super) const fn all(&self) -> u64 {
        self.version.all()
    }

    pub(super) fn open(&mut self, bytes: &[u8]) -> OpenedFrame {
        let version = bytes.first().copied();
        let is_known = [FORMAT_VERSION, PRESENTED_VERSION]
            .map(Some)
            .contains(&version);
        self.version.check(is_known, || {
            let received = version.map_or("no byte".to_owned(), |byte| format!("{byte}"));
            (received, format!("{FORMAT_VERSION} or {PRESENTED_VERSION}"))
        });
        if !is_known {
            return OpenedFrame::Other;
        }
        let mut axes = Vec::new();
        let opened = self.seal.open(bytes, |axis| axes.push(*axis));
        let header = match opened {
            Ok(header) => header,
            Err(Rejection::CycleTimeOutOfRange) => {
                self.check_sum.good();
                self.fields.good();
                return OpenedFrame::CycleTime(varint_after(bytes, BEFORE_CYCLE_TIME));
            }
            Err(Rejection::PresentAfterOutOfRange) => {
                self.check_sum.good();
                self.fields.good();
                let nanos = varint_after(bytes, BEFORE_PRESENT_AFTER);
                let received = nanos.map_or("another one".to_owned(), |ns| format!("{ns} ns"));
                self.present_after.bad(received, "0 to 4 s");
                return OpenedFrame::Other;
            }
            Err(Rejection::WrongChecksum) => {
                self.check_sum.bad(
                    self.sum_of(bytes),
                    format!("the CRC-32 over the key {} and all before it", self.key),
                );
                return OpenedFrame::Other;
            }
            Err(reason) => {
                let received = format!("{} bytes: {reason}", bytes.len());
                self.fields
                    .bad(received, "the fields of its version, and nothing besides");
                return OpenedFrame::Other;
            }
        };
        self.check_sum.good();
        self.fields.good();
        self.present_after.good();
        self.sender_id.check(header.sender == self.sender, || {
            let expected = format!("{}, the CRC-32 of {:?}", self.sender, self.node.as_str());
            (header.sender.to_string(), expected)
        });
        match header.sender == self.sender {
            true => OpenedFrame::Good(header, axes),
            false => OpenedFrame::Other,
        }
    }

    pub(super) fn findings(&self) -> Vec<RuleFinding> {
        let none = "no frame came";
        let no_version = "no frame of version 1 or 2 came";
        let no_frame = "no whole frame came";
        vec![
            RuleFinding::new(&VERSION, self.version.outcome("frames", none)),
            RuleFinding::new(&FRAME_FIELDS, self.fields.outcome("frames", no_version)),
            RuleFinding::new(&CHECK_SUM, self.check_sum.outcome("frames", no_version)),
            RuleFinding::new(&SENDER_ID, self.sender_id.outcome("frames", no_frame)),
        ]
    }

    /// The finding about the presentation delay, whose rule is the last one.
    pub(super) fn present_after(&self) -> Vec<RuleFinding> {
        let none = "no whole frame came";
        vec![RuleFinding::new(
            &PRESENT_AFTER,
            self.present_after.outcome("frames", none),
        )]
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
