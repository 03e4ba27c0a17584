//! The frames of the node that is played: good ones, and mutations of them.

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, CycleTime};
use coaxle_node::frame::{KeySeal, PRESENTED_VERSION, body_capacity, encode_body};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader};

/// A frame with its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlayedFrame {
    pub(super) header: FrameHeader,
    pub(super) axis: NcToPlcAxis,
}

/// Mutation of a good frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum Mutation {
    /// Other values of its fields.
    Fields(fn(&mut PlayedFrame)),
    /// Another body, with its send stamp and a right check sum.
    Body(fn(&mut Vec<u8>)),
    /// Another body, without a send stamp.
    Bare(fn(&mut Vec<u8>)),
    /// Other bytes of the whole frame.
    Bytes(fn(&mut Vec<u8>)),
    /// The check sum of another key.
    OtherKey,
}

/// Places of fields in a body: the numbers between the version and them. The axes follow their number.
pub(super) const CYCLE_TIME: usize = 4;
pub(super) const AXES: usize = 5;

/// Writes frames under the key of the node that is played.
#[derive(Debug)]
pub(super) struct FrameWriter {
    seal: KeySeal,
    other_key: KeySeal,
}

impl FrameWriter {
    pub(super) fn new(node: &NodeName) -> Self {
        let seal = |channel| KeySeal::new(&node.channel_key(channel));
        Self {
            seal: seal(Channel::Axes),
            other_key: seal(Channel::Slaves),
        }
    }

    /// A good frame.
    pub(super) fn frame(&self, frame: &PlayedFrame) -> Vec<u8> {
        let mut sealed = Vec::new();
        (self.seal).seal(&frame.body(), frame.header.send_stamp, &mut sealed);
        sealed
    }

    /// A frame with one thing changed.
    pub(super) fn mutated(&self, frame: &PlayedFrame, mutation: Mutation) -> Vec<u8> {
        let (mut changed, mut body, mut sealed) = (*frame, frame.body(), Vec::new());
        let stamp = frame.header.send_stamp;
        match mutation {
            Mutation::Fields(change) => {
                change(&mut changed);
                sealed = self.frame(&changed);
            }
            Mutation::Body(change) => {
                change(&mut body);
                self.seal.seal(&body, stamp, &mut sealed);
            }
            Mutation::Bare(change) => {
                change(&mut body);
                self.seal.seal(&body, None, &mut sealed);
            }
            Mutation::Bytes(change) => {
                sealed = self.frame(frame);
                change(&mut sealed);
            }
            Mutation::OtherKey => self.other_key.seal(&body, stamp, &mut sealed),
        }
        sealed
    }
}

impl PlayedFrame {
    /// Gives the axis an error.
    pub(super) fn fail(&mut self, error: u32) {
        self.axis.error_code = error;
        self.axis.state_word |= StateWord::ERROR;
    }

    /// Goes on by ten seconds.
    pub(super) fn leap(&mut self) {
        let ahead = 10_000_000_000 / self.header.cycle_time.span().as_nanos().unsigned_abs();
        self.header.count += ahead;
        self.header.index = CycleIndex::of_count(self.header.count);
    }

    /// Doubles the cycle time, or halves one that cannot be doubled.
    pub(super) fn change_cycle_time(&mut self) {
        let span = self.header.cycle_time.span();
        let other = CycleTime::new(span * 2).or_else(|_| CycleTime::new(span / 2));
        self.header.cycle_time = other.expect("one of them is in range");
    }

    fn body(&self) -> Vec<u8> {
        let mut body = vec![0; body_capacity(1)];
        let length = encode_body(&self.header, &[self.axis], &mut body);
        body.truncate(length.expect("the buffer holds it"));
        body
    }
}

/// Replaces a field by any number: a header takes none out of range. What follows it stays.
pub(super) fn replace(body: &mut Vec<u8>, field: usize, number: u64) {
    body.splice(place(body, field)..place(body, field + 1), varint(number));
}

/// Removes all axes.
pub(super) fn remove_axes(body: &mut Vec<u8>) {
    replace(body, AXES, 0);
    body.truncate(place(body, AXES + 1));
}

/// Makes it a body of version 2 with this presentation delay, which follows the cycle time.
pub(super) fn present_after(body: &mut Vec<u8>, nanos: u64) {
    body[0] = PRESENTED_VERSION;
    let behind = place(body, CYCLE_TIME + 1);
    body.splice(behind..behind, varint(nanos));
}

/// Place behind the version and this many numbers.
fn place(body: &[u8], numbers: usize) -> usize {
    let length = |bytes: &[u8]| bytes.iter().take_while(|byte| **byte >= 0x80).count() + 1;
    (0..numbers).fold(1, |at, _| at + length(&body[at..]))
}

fn varint(mut number: u64) -> Vec<u8> {
    let mut out = Vec::new();
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
    out
}

#[cfg(test)]
mod tests {
    use super::super::script::{Play, SCRIPT};
    use super::*;
    use coaxle_clock::Span;
    use coaxle_node::frame::sender_id;
    use coaxle_node::{Intake, PresentAfter, Rejection};

    fn played(node: &NodeName) -> PlayedFrame {
        PlayedFrame {
            header: FrameHeader {
                sender: sender_id(node),
                epoch: 0x0123_4567_89ab_cdef,
                index: CycleIndex(4_464),
                count: 70_000,
                cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
                present_after: None,
                send_stamp: Some(Span::from_micros(53)),
            },
            axis: NcToPlcAxis {
                axis_id: 300,
                set_position: 2.5,
                ..NcToPlcAxis::default()
            },
        }
    }

    /// Frames that the script has for a rule.
    fn bad_frames(rule: &str, writer: &FrameWriter, good: &PlayedFrame) -> Vec<Vec<u8>> {
        let step = SCRIPT.iter().find(|step| step.rule.name == rule).unwrap();
        let Play::Beside(mutations) = step.play else {
            panic!("{step:?}");
        };
        let frames = mutations.iter().map(|bad| writer.mutated(good, *bad));
        frames.collect()
    }

    #[test]
    fn every_bad_frame_is_refused_for_its_reason_and_the_good_one_is_not() {
        let node = NodeName::new("press").unwrap();
        let (writer, mut frame) = (FrameWriter::new(&node), played(&node));
        let mut intake = Intake::new(&node.channel_key(Channel::Axes), &node, &[300]);
        let header = intake.accept(&writer.frame(&frame)).unwrap().header;
        let stamp = frame.header.send_stamp;
        assert_eq!((header.count, header.send_stamp), (70_000, stamp));
        let delay = PresentAfter::new(Span::from_millis(30));
        frame.header.present_after = delay;
        let header = intake.accept(&writer.frame(&frame)).unwrap().header;
        assert_eq!((header.count, header.present_after), (70_000, delay));
        frame.header.present_after = None;
        for (rule, reason) in [
            ("wrong-version", Rejection::WrongVersion),
            ("truncated", Rejection::Truncated),
            ("wrong-checksum", Rejection::WrongChecksum),
            ("malformed", Rejection::Malformed),
            ("trailing-bytes", Rejection::TrailingBytes),
            ("cycle-time-range", Rejection::CycleTimeOutOfRange),
            ("present-after-range", Rejection::PresentAfterOutOfRange),
            ("foreign-sender", Rejection::ForeignSender),
            ("axis-missing", Rejection::AxisMissing),
            ("implausible", Rejection::Implausible),
        ] {
            for bad in bad_frames(rule, &writer, &frame) {
                assert_eq!(intake.accept(&bad).map(|_| ()), Err(reason), "{bad:?}");
            }
        }
        for rule in ["other-run", "other-cycle-time", "other-count"] {
            for strange in bad_frames(rule, &writer, &frame) {
                assert!(
                    intake.accept(&strange).is_ok(),
                    "by itself it is a good one"
                );
            }
        }
    }
}
