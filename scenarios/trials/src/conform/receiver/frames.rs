//! The frames of the node that is played: good ones, and those that are to be refused.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_node::frame::{
    FORMAT_VERSION, KeySeal, PRESENTED_VERSION, body_capacity, encode_body, sender_id,
};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, PresentAfter};

/// Fields of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FrameContent {
    pub(super) sender: u32,
    pub(super) epoch: u64,
    pub(super) index: u16,
    pub(super) count: u64,
    pub(super) cycle_time_ns: u32,
    /// Presentation delay; 0 in a frame of version 1.
    pub(super) present_after_ns: u32,
    pub(super) stamp: Option<Span>,
    pub(super) axis: NcToPlcAxis,
}

/// Writes frames under the key of the node that is played.
#[derive(Debug)]
pub(super) struct FrameWriter {
    seal: KeySeal,
    other_key: KeySeal,
}

/// Frames to be refused for one reason.
pub(super) type BadFrames = fn(&FrameWriter, &FrameContent) -> Vec<Vec<u8>>;

impl FrameWriter {
    pub(super) fn new(node: &NodeName) -> Self {
        let key = |channel| node.channel_key(channel);
        Self {
            seal: KeySeal::new(&key(Channel::Axes)),
            other_key: KeySeal::new(&key(Channel::Slaves)),
        }
    }

    /// A whole frame.
    pub(super) fn frame(&self, content: &FrameContent) -> Vec<u8> {
        self.sealed(&content.body(), content.stamp)
    }

    /// Frames of other versions.
    pub(super) fn versions(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let of = |version| {
            let mut body = content.body();
            body[0] = version;
            self.sealed(&body, content.stamp)
        };
        vec![of(0), of(PRESENTED_VERSION + 1), of(255)]
    }

    /// Frames without their end: nothing, too little, cut on the way, cut before it was sealed.
    pub(super) fn truncated(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let (whole, body) = (self.frame(content), content.body());
        vec![
            Vec::new(),
            whole[..4].to_vec(),
            whole[..whole.len() / 2].to_vec(),
            self.sealed(&body[..body.len() - 9], None),
        ]
    }

    /// Frames with a bit flipped, and with the check sum of another key.
    pub(super) fn check_sums(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let mut flipped = self.frame(content);
        let middle = flipped.len() / 2;
        flipped[middle] ^= 1;
        let mut strayed = Vec::new();
        self.other_key
            .seal(&content.body(), content.stamp, &mut strayed);
        vec![flipped, strayed]
    }

    /// Frames with a number that is too long, an option that begins with 2, and 129 axes.
    pub(super) fn malformed(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let mut long = vec![FORMAT_VERSION, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x01];
        long.extend(content.body());
        let mut option = content.body();
        option.push(2);
        let mut many = content.prefix(129);
        many.extend(content.axis_bytes());
        vec![
            self.sealed(&long, None),
            self.sealed(&option, None),
            self.sealed(&many, None),
        ]
    }

    /// A frame with a byte behind the send stamp.
    pub(super) fn trailing(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let mut body = content.body();
        // An absent stamp; sealing puts another one behind it.
        body.push(0);
        vec![self.sealed(&body, None)]
    }

    /// Frames with cycle times out of range.
    pub(super) fn cycle_times(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let of = |cycle_time: Span| {
            self.frame(&FrameContent {
                cycle_time_ns: cycle_time.as_nanos() as u32,
                ..*content
            })
        };
        let nano = Span::from_nanos(1);
        vec![
            of(Span::ZERO),
            of(CycleTime::MIN - nano),
            of(CycleTime::MAX + nano),
        ]
    }

    /// Frames with a presentation delay out of range.
    pub(super) fn delays(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let of = |present_after_ns| {
            self.frame(&FrameContent {
                present_after_ns,
                ..*content
            })
        };
        vec![
            of(PresentAfter::LONGEST.as_nanos() as u32 + 1),
            of(u32::MAX),
        ]
    }

    /// A frame of another sender.
    pub(super) fn senders(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let sender = content.sender ^ 1;
        vec![self.frame(&FrameContent { sender, ..*content })]
    }

    /// Frames with another axis, and without any.
    pub(super) fn axes(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let mut other = *content;
        other.axis.axis_id = other.axis.axis_id.wrapping_add(1_000);
        vec![
            self.frame(&other),
            self.sealed(&content.prefix(0), content.stamp),
        ]
    }

    /// Frames with NaN, and with a value too large for an axis.
    pub(super) fn numbers(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let of = |change: fn(&mut NcToPlcAxis)| {
            let mut other = *content;
            change(&mut other.axis);
            self.frame(&other)
        };
        vec![
            of(|axis| axis.set_position = f64::NAN),
            of(|axis| axis.set_velocity = f64::INFINITY),
            of(|axis| axis.actual_position = -2.0 * NcToPlcAxis::LARGEST),
        ]
    }

    /// A frame of another run.
    pub(super) fn runs(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let epoch = content.epoch ^ 0x5555;
        vec![self.frame(&FrameContent { epoch, ..*content })]
    }

    /// A frame of this run, with twice its cycle time.
    pub(super) fn other_cycle_times(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let nanos = i64::from(content.cycle_time_ns);
        let longest = CycleTime::MAX.as_nanos();
        let other = if nanos * 2 <= longest {
            nanos * 2
        } else {
            nanos / 2
        };
        vec![self.frame(&FrameContent {
            cycle_time_ns: other as u32,
            ..*content
        })]
    }

    /// A frame of this run, ten seconds ahead.
    pub(super) fn counts(&self, content: &FrameContent) -> Vec<Vec<u8>> {
        let ahead = 10_000_000_000 / u64::from(content.cycle_time_ns.max(1));
        let count = content.count + ahead;
        vec![self.frame(&FrameContent {
            count,
            index: CycleIndex::of_count(count).0,
            ..*content
        })]
    }

    fn sealed(&self, body: &[u8], stamp: Option<Span>) -> Vec<u8> {
        let mut frame = Vec::new();
        self.seal.seal(body, stamp, &mut frame);
        frame
    }
}

impl FrameContent {
    /// The id of a node.
    pub(super) fn sender_of(node: &NodeName) -> u32 {
        sender_id(node)
    }

    fn body(&self) -> Vec<u8> {
        let mut body = self.prefix(1);
        body.extend(self.axis_bytes());
        body
    }

    /// Every field before the axes. Written by hand, as a header takes no cycle time out of range.
    fn prefix(&self, axes: u64) -> Vec<u8> {
        let (version, delay) = match self.present_after_ns {
            0 => (FORMAT_VERSION, None),
            nanos => (PRESENTED_VERSION, Some(nanos.into())),
        };
        let mut out = vec![version];
        let first = [
            self.sender.into(),
            self.epoch,
            self.index.into(),
            self.count,
            self.cycle_time_ns.into(),
        ];
        for number in first.into_iter().chain(delay).chain([axes]) {
            varint(&mut out, number);
        }
        out
    }

    fn axis_bytes(&self) -> Vec<u8> {
        let header = FrameHeader {
            sender: 0,
            epoch: 0,
            index: CycleIndex(0),
            count: 0,
            cycle_time: CycleTime::new(CycleTime::MIN).expect("it is one"),
            present_after: None,
            send_stamp: None,
        };
        let mut out = vec![0; body_capacity(1)];
        let mut length = |axes: &[NcToPlcAxis]| {
            encode_body(&header, axes, &mut out).expect("the buffer holds it")
        };
        // The number of axes takes one byte, be it 0 or 1.
        let (before, all) = (length(&[]), length(&[self.axis]));
        out[before..all].to_vec()
    }
}

fn varint(out: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::{Intake, Rejection};

    fn content(node: &NodeName) -> FrameContent {
        FrameContent {
            sender: FrameContent::sender_of(node),
            epoch: 0x0123_4567_89ab_cdef,
            index: 4_464,
            count: 70_000,
            cycle_time_ns: 2_000_000,
            present_after_ns: 0,
            stamp: Some(Span::from_micros(53)),
            axis: NcToPlcAxis {
                axis_id: 300,
                set_position: 2.5,
                ..NcToPlcAxis::default()
            },
        }
    }

    #[test]
    fn every_bad_frame_is_refused_for_its_reason_and_the_good_one_is_not() {
        let node = NodeName::new("press").unwrap();
        let (writer, content) = (FrameWriter::new(&node), content(&node));
        let mut intake = Intake::new(&node.channel_key(Channel::Axes), &node, &[300]);
        let good = writer.frame(&content);
        let header = intake.accept(&good).unwrap().header;
        assert_eq!((header.count, header.send_stamp), (70_000, content.stamp));
        let presented = writer.frame(&FrameContent {
            present_after_ns: 30_000_000,
            ..content
        });
        let header = intake.accept(&presented).unwrap().header;
        let delay = PresentAfter::new(Span::from_millis(30));
        assert_eq!((header.count, header.present_after), (70_000, delay));
        let bad: [(BadFrames, Rejection); 10] = [
            (FrameWriter::versions, Rejection::WrongVersion),
            (FrameWriter::truncated, Rejection::Truncated),
            (FrameWriter::check_sums, Rejection::WrongChecksum),
            (FrameWriter::malformed, Rejection::Malformed),
            (FrameWriter::trailing, Rejection::TrailingBytes),
            (FrameWriter::cycle_times, Rejection::CycleTimeOutOfRange),
            (FrameWriter::delays, Rejection::PresentAfterOutOfRange),
            (FrameWriter::senders, Rejection::ForeignSender),
            (FrameWriter::axes, Rejection::AxisMissing),
            (FrameWriter::numbers, Rejection::Implausible),
        ];
        for (make, reason) in bad {
            for frame in make(&writer, &content) {
                assert_eq!(intake.accept(&frame).map(|_| ()), Err(reason), "{frame:?}");
            }
        }
        let strange: [BadFrames; 3] = [
            FrameWriter::runs,
            FrameWriter::other_cycle_times,
            FrameWriter::counts,
        ];
        for make in strange {
            for frame in make(&writer, &content) {
                assert!(intake.accept(&frame).is_ok(), "by itself it is a good one");
            }
        }
    }
}
