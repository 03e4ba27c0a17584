//! The inbox of a far node: its messages wait here for the cycle they belong to.
//!
//! Each cycle reads an input image: the newest frame that had arrived when the cycle ideally
//! began. So a scan that wakes late sees what a punctual one would have seen, and what the link
//! model holds back stays away until it is due.

use std::collections::VecDeque;

use coaxle_clock::{Age, AgeGate, Instant, Local, Span};
use coaxle_node::{AxisSample, Frame, FrameHeader, Rejection, RejectionCounters};

use super::frames::{Frames, TakenFrame};
use super::held_back::{self, WaitingFrame};
use super::pace::Pace;
use super::run::{Admission, RunChoice};
use super::sequence::{Sequence, SequencePlace};
use crate::arrivals::INBOX_CAPACITY;
use crate::signals::FarNodeSignals;

/// Counters of the messages. Each received message is in order, a duplicate or late, was dropped,
/// is foreign, or waits; of the first three some are stale.
#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    received: u64,
    in_order: u64,
    expected: u64,
    lost: u64,
    duplicates: u64,
    late: u64,
    stale: u64,
    outdated: u64,
    overflow: u64,
    restarts: u64,
    rejected: RejectionCounters,
}

/// A waiting message.
#[derive(Clone, Copy, Debug)]
struct WaitingHeader {
    at: Instant<Local>,
    /// Start of the next cycle when it was stored.
    due: Instant<Local>,
    header: FrameHeader,
}

/// Waiting messages, and the input image.
#[derive(Debug)]
pub(crate) struct Inbox {
    waiting: VecDeque<WaitingHeader>,
    frames: Frames,
    age_limit: Option<Span>,
    choice: RunChoice,
    /// Number of runs followed up to now.
    runs: u64,
    run_of_image: u64,
    sender: Option<Sender>,
    image: Option<FrameHeader>,
    counters: Counters,
    /// Messages of earlier runs of the sender: expected, and missing.
    expected_before: u64,
    lost_before: u64,
}

/// The run of the sender that is being followed.
#[derive(Debug)]
struct Sender {
    gate: Option<AgeGate>,
    sequence: Sequence,
    pace: Pace,
}

impl Inbox {
    /// Creates an inbox that drops messages older than `age_limit`, if there is one, with room for
    /// the axes of this number of frames.
    pub(crate) fn new(age_limit: Option<Span>, frames: usize, axes: usize) -> Self {
        Self {
            waiting: VecDeque::with_capacity(INBOX_CAPACITY),
            frames: Frames::new(frames, axes),
            age_limit,
            choice: RunChoice::default(),
            runs: 0,
            run_of_image: 0,
            sender: None,
            image: None,
            counters: Counters::default(),
            expected_before: 0,
            lost_before: 0,
        }
    }

    /// Sets the age limit from now on.
    pub(crate) fn set_age_limit(&mut self, limit: Option<Span>) {
        if limit == self.age_limit {
            return;
        }
        self.age_limit = limit;
        if let (Some(sender), Some(image)) = (&mut self.sender, &self.image) {
            // The gate counts in cycles of the sender. A run that follows later creates its own.
            sender.gate = limit.map(|limit| AgeGate::new(image.cycle_time, limit));
        }
    }

    /// Counts a frame that was refused.
    pub(crate) fn reject(&mut self, reason: Rejection) {
        self.counters.rejected.count(reason);
    }

    /// Stores a frame. If there are too many, the oldest is dropped, or one of those that an injected
    /// delay holds back. The next cycle begins at `due`, or later.
    pub(crate) fn store(&mut self, at: Instant<Local>, frame: &Frame<'_>, due: Instant<Local>) {
        self.counters.received += 1;
        let header = frame.header;
        let waiting = WaitingHeader { at, due, header };
        if self.waiting.len() == INBOX_CAPACITY {
            self.make_room(&waiting);
            self.counters.overflow += 1;
        }
        self.waiting.push_back(waiting);
        // Frames of other runs must not replace those of the run that is followed.
        if self.choice.can_be_followed(at, &frame.header) {
            self.frames.keep(at, frame, due);
        }
    }

    /// Drops a message: a queue that grows would allocate.
    fn make_room(&mut self, new: &WaitingHeader) {
        let waiting = self.waiting.iter().map(|waiting| WaitingFrame {
            at: waiting.at,
            due: waiting.due,
            count: waiting.header.count,
        });
        // Without a delay the search would find nothing, and a flood would pay for it.
        let is_delayed = new.at > new.due;
        let spare = is_delayed.then(|| held_back::spare((0..).zip(waiting), new.due));
        // Otherwise the oldest goes: old messages are the least useful.
        self.waiting.remove(spare.flatten().unwrap_or(0));
    }

    /// Returns the input image of the cycle that ideally begins at `cycle_start`; none before the
    /// first message.
    ///
    /// Passes every accepted message that is young enough to `received`, with its arrival and true
    /// if another run begins with it.
    pub(crate) fn image(
        &mut self,
        cycle_start: Instant<Local>,
        mut received: impl FnMut(Instant<Local>, &FrameHeader, bool),
    ) -> Option<FrameHeader> {
        // A single turn of the queue: what is not due yet goes back behind the rest, in its order and without allocation.
        for _ in 0..self.waiting.len() {
            let Some(waiting) = self.waiting.pop_front() else {
                break;
            };
            let WaitingHeader { at, header, .. } = waiting;
            if at <= cycle_start {
                match self.choice.judge(at, &header) {
                    Admission::Foreign => {}
                    Admission::Begins => {
                        self.follow(at, &header, cycle_start);
                        self.frames.take_in(&header);
                        // The clock has to know of the other run before it takes a message of it.
                        received(at, &header, true);
                    }
                    Admission::Followed => {
                        if self.take(at, &header, cycle_start) {
                            self.frames.take_in(&header);
                            received(at, &header, false);
                        }
                    }
                }
            } else {
                self.waiting.push_back(waiting);
            }
        }
        self.image
    }

    /// The axes of the input image, if this cycle has renewed it.
    pub(crate) fn fresh_axes(&self) -> Option<&[Option<AxisSample>]> {
        self.frames.find(self.image.as_ref()?)
    }

    /// Frames of the image's run that this cycle has taken in, in any order.
    pub(super) fn taken_in(&self) -> impl Iterator<Item = TakenFrame<'_>> {
        let image = self.image.as_ref();
        image
            .into_iter()
            .flat_map(|image| self.frames.taken_in(image.epoch))
    }

    /// Ends the cycle that ideally began at `cycle_start`.
    pub(crate) fn end_cycle(&mut self, cycle_start: Instant<Local>) {
        self.frames.forget_until(cycle_start);
    }

    /// The run of a second node with this name, if one is received.
    pub(crate) fn rival(&self, now: Instant<Local>) -> Option<u64> {
        self.choice.rival(now)
    }

    /// Number of the image's run among the runs followed.
    pub(crate) const fn run_of_image(&self) -> u64 {
        self.run_of_image
    }

    /// True if the sender's cycles are too far from the stated ones to be followed.
    pub(crate) fn is_pace_refused(&self) -> bool {
        (self.sender.as_ref()).is_some_and(|sender| sender.pace.is_refused())
    }

    /// Writes the signals of the messages.
    pub(crate) fn show(&self, signals: &mut FarNodeSignals) {
        let counters = self.counters();
        signals.pace_ppm = self.sender.as_ref().and_then(|sender| sender.pace.ppm());
        signals.received = counters.received;
        signals.in_order = counters.in_order;
        signals.expected = counters.expected;
        signals.lost = counters.lost;
        signals.duplicates = counters.duplicates;
        signals.late = counters.late;
        signals.stale = counters.stale;
        signals.outdated = counters.outdated;
        signals.waiting = self.waiting.len() as u32;
        signals.overflow = counters.overflow;
        signals.restarts = counters.restarts;
        signals.foreign_frames = self.choice.foreign();
        let of = |reason| counters.rejected.of(reason);
        signals.rejected = counters.rejected.total();
        signals.rejected_wrong_version = of(Rejection::WrongVersion);
        signals.rejected_truncated = of(Rejection::Truncated);
        signals.rejected_wrong_checksum = of(Rejection::WrongChecksum);
        signals.rejected_malformed = of(Rejection::Malformed);
        signals.rejected_trailing_bytes = of(Rejection::TrailingBytes);
        signals.rejected_cycle_time_out_of_range = of(Rejection::CycleTimeOutOfRange);
        signals.rejected_present_after_out_of_range = of(Rejection::PresentAfterOutOfRange);
        signals.rejected_foreign_sender = of(Rejection::ForeignSender);
        signals.rejected_axis_missing = of(Rejection::AxisMissing);
        signals.rejected_implausible = of(Rejection::Implausible);
    }

    fn counters(&self) -> Counters {
        let sequence = self.sender.as_ref().map(|sender| &sender.sequence);
        let expected = sequence.map_or(0, Sequence::expected);
        let lost = sequence.map_or(0, Sequence::missing);
        Counters {
            expected: self.expected_before.saturating_add(expected),
            lost: self.lost_before.saturating_add(lost),
            // A run counts from the first of its frames that is used on, as its epoch does.
            restarts: self.run_of_image.saturating_sub(1),
            ..self.counters
        }
    }

    /// True if the message is new and young enough.
    fn take(&mut self, at: Instant<Local>, header: &FrameHeader, now: Instant<Local>) -> bool {
        let count = header.count;
        let Some(sender) = &mut self.sender else {
            return false;
        };
        // Before the age is judged: a stale message still counts as received, or it would be lost and stale at once.
        let place = sender.sequence.place(count);
        sender.pace.take(at, count);
        let gate = &mut sender.gate;
        let judge = |gate: &mut AgeGate| gate.judge(count, at, now) == Age::Stale;
        let is_stale = gate.as_mut().is_some_and(judge);
        let counters = &mut self.counters;
        counters.outdated += u64::from(place == SequencePlace::Outdated);
        counters.stale += u64::from(is_stale);
        match place {
            SequencePlace::Repeated => counters.duplicates += 1,
            SequencePlace::Overtaken | SequencePlace::Outdated => counters.late += 1,
            SequencePlace::Newest => counters.in_order += 1,
        }
        // Only the newest renews the image: an overtaken frame would move the axes back.
        if place == SequencePlace::Newest && !is_stale {
            self.renew(header);
        }
        // The arrival of an overtaken message is a measurement like any other. A repeated one would count twice.
        place != SequencePlace::Repeated && !is_stale
    }

    /// The first message of a run that is followed from now on.
    fn follow(&mut self, at: Instant<Local>, header: &FrameHeader, now: Instant<Local>) {
        self.runs += 1;
        self.counters.in_order += 1;
        if let Some(Sender { sequence, .. }) = &self.sender {
            // Counts of the next run begin elsewhere, so the sums of this one are kept aside.
            self.expected_before = self.expected_before.saturating_add(sequence.expected());
            self.lost_before = self.lost_before.saturating_add(sequence.missing());
        }
        let mut gate = self
            .age_limit
            .map(|limit| AgeGate::new(header.cycle_time, limit));
        if let Some(gate) = &mut gate {
            // Starts the gate. The first message of a run has nothing to be late against.
            let _ = gate.judge(header.count, at, now);
        }
        self.sender = Some(Sender {
            gate,
            sequence: Sequence::starting_at(header.count),
            pace: Pace::starting(at, header.count, header.cycle_time),
        });
        self.renew(header);
    }

    /// The image is a frame as a whole: without its axes it is none.
    fn renew(&mut self, header: &FrameHeader) {
        if self.frames.find(header).is_some() {
            self.image = Some(*header);
            self.run_of_image = self.runs;
        }
    }
}

#[cfg(test)]
mod tests;
