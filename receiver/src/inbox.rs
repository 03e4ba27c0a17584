//! The inbox: messages wait here for the cycle they belong to.
//!
//! Each cycle reads an input image: the newest message that had arrived when the cycle ideally
//! began. So a scan that wakes late sees what a punctual one would have seen, and what the link
//! model holds back stays away until it is due.

use std::collections::VecDeque;

use coaxle_clock::{Age, AgeGate, Instant, Local, Span};
use coaxle_node::{Message, Sample};

use crate::snapshot::Counters;

/// Messages that can wait: more than a second's worth at a millisecond.
pub(crate) const CAPACITY: usize = 1024;

/// Waiting messages, and the input image.
#[derive(Debug)]
pub(crate) struct Inbox {
    waiting: VecDeque<(Instant<Local>, Sample)>,
    age_limit: Option<Span>,
    sender: Option<Sender>,
    image: Option<Sample>,
    counters: Counters,
    /// Messages missing from earlier runs of the sender.
    lost_before: u64,
}

/// The run of the sender that is being followed.
#[derive(Debug)]
struct Sender {
    epoch: u64,
    gate: Option<AgeGate>,
    sequence: Sequence,
}

impl Inbox {
    /// An inbox that drops what is older than `age_limit`, if there is one.
    pub(crate) fn new(age_limit: Option<Span>) -> Self {
        Self {
            waiting: VecDeque::with_capacity(CAPACITY),
            age_limit,
            sender: None,
            image: None,
            counters: Counters::default(),
            lost_before: 0,
        }
    }

    /// Stores a message. When there are too many, the oldest goes.
    pub(crate) fn store(&mut self, at: Instant<Local>, message: &Message) {
        match message {
            Message::Rejected(reason) => self.counters.rejected.count(*reason),
            // The receiver keeps these itself.
            Message::Question(_) | Message::Answer(_) => {}
            Message::Sample(sample) => {
                self.counters.received += 1;
                if self.waiting.len() == CAPACITY {
                    self.waiting.pop_front();
                    self.counters.overflow += 1;
                }
                self.waiting.push_back((at, *sample));
            }
        }
    }

    /// The input image of the cycle that ideally begins at `cycle_start`; none as long as nothing
    /// has come.
    ///
    /// Every message that is taken in and young enough is shown to `heard`, with its arrival.
    pub(crate) fn image(
        &mut self,
        cycle_start: Instant<Local>,
        mut heard: impl FnMut(Instant<Local>, &Sample),
    ) -> Option<Sample> {
        for _ in 0..self.waiting.len() {
            let Some((at, sample)) = self.waiting.pop_front() else {
                break;
            };
            if at <= cycle_start {
                if self.take(at, &sample, cycle_start) {
                    heard(at, &sample);
                }
            } else {
                self.waiting.push_back((at, sample));
            }
        }
        self.image
    }

    pub(crate) fn counters(&self) -> Counters {
        let lost = self.sender.as_ref().map_or(0, |s| s.sequence.missing());
        Counters {
            lost: self.lost_before.saturating_add(lost),
            ..self.counters
        }
    }

    /// Whether the message is new and young enough.
    fn take(&mut self, at: Instant<Local>, sample: &Sample, now: Instant<Local>) -> bool {
        let count = sample.header.count;
        match &mut self.sender {
            Some(sender) if sender.epoch == sample.header.epoch => {
                let place = sender.sequence.place(count);
                match place {
                    Place::Repeated => self.counters.duplicates += 1,
                    Place::Overtaken => self.counters.late += 1,
                    Place::Newest => {}
                }
                let gate = &mut sender.gate;
                let stale = |gate: &mut AgeGate| gate.judge(count, at, now) == Age::Stale;
                if gate.as_mut().is_some_and(stale) {
                    self.counters.stale += 1;
                    return false;
                }
                if place == Place::Newest {
                    self.image = Some(*sample);
                }
                place != Place::Repeated
            }
            _ => {
                self.follow(at, sample, now);
                true
            }
        }
    }

    /// The first message of a run of the sender.
    fn follow(&mut self, at: Instant<Local>, sample: &Sample, now: Instant<Local>) {
        if let Some(before) = &self.sender {
            self.counters.restarts += 1;
            self.lost_before = self.lost_before.saturating_add(before.sequence.missing());
        }
        let mut gate = self
            .age_limit
            .map(|limit| AgeGate::new(sample.header.cycle_time, limit));
        if let Some(gate) = &mut gate {
            let _ = gate.judge(sample.header.count, at, now);
        }
        self.sender = Some(Sender {
            epoch: sample.header.epoch,
            gate,
            sequence: Sequence::starting_at(sample.header.count),
        });
        self.image = Some(*sample);
    }
}

/// Which counts of a run have come, exactly, for all that are at most 64 behind the newest.
#[derive(Clone, Copy, Debug)]
struct Sequence {
    first: u64,
    newest: u64,
    /// Bit n: count `newest − n` has come.
    seen: u64,
    distinct: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Newest,
    Overtaken,
    Repeated,
}

impl Sequence {
    const fn starting_at(count: u64) -> Self {
        Self {
            first: count,
            newest: count,
            seen: 1,
            distinct: 1,
        }
    }

    fn place(&mut self, count: u64) -> Place {
        if count > self.newest {
            let ahead = count - self.newest;
            self.seen = if ahead < 64 { self.seen << ahead } else { 0 } | 1;
            self.newest = count;
            self.distinct += 1;
            return Place::Newest;
        }
        let behind = self.newest - count;
        let bit = if behind < 64 { 1 << behind } else { 0 };
        if count < self.first || bit == 0 || self.seen & bit != 0 {
            return if behind == 0 || bit != 0 && self.seen & bit != 0 {
                Place::Repeated
            } else {
                Place::Overtaken
            };
        }
        self.seen |= bit;
        self.distinct += 1;
        Place::Overtaken
    }

    const fn missing(&self) -> u64 {
        (self.newest - self.first).saturating_add(1) - self.distinct
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::{CycleIndex, CycleTime};
    use coaxle_motion::axis::NcToPlcAxis;
    use coaxle_node::{FrameHeader, Rejection};

    fn sample(epoch: u64, count: u64) -> Message {
        Message::Sample(Sample {
            header: FrameHeader {
                sender: 1,
                epoch,
                index: CycleIndex::of_count(count),
                count,
                cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
                send_stamp: None,
            },
            axis: NcToPlcAxis::default(),
        })
    }

    fn at(micros: i64) -> Instant<Local> {
        Instant::EPOCH + Span::from_micros(micros)
    }

    fn inbox() -> Inbox {
        Inbox::new(Some(Span::from_millis(7)))
    }

    fn count_of(image: Option<Sample>) -> Option<u64> {
        image.map(|sample| sample.header.count)
    }

    fn image(inbox: &mut Inbox, cycle_start: Instant<Local>) -> Option<Sample> {
        inbox.image(cycle_start, |_, _| {})
    }

    #[test]
    fn a_cycle_sees_what_had_arrived_when_it_ideally_began() {
        let mut inbox = inbox();
        inbox.store(at(900), &sample(1, 0));
        inbox.store(at(1_100), &sample(1, 1));
        assert_eq!(count_of(image(&mut inbox, at(800))), None);
        assert_eq!(count_of(image(&mut inbox, at(1_000))), Some(0));
        assert_eq!(count_of(image(&mut inbox, at(2_000))), Some(1));
        assert_eq!(
            count_of(image(&mut inbox, at(3_000))),
            Some(1),
            "the image stays"
        );
    }

    #[test]
    fn repeated_overtaken_and_lost_messages_are_told_apart() {
        let mut inbox = inbox();
        for (micros, count) in [
            (0, 10),
            (100, 12),
            (200, 11),
            (300, 12),
            (400, 11),
            (500, 15),
        ] {
            inbox.store(at(micros), &sample(1, count));
        }
        assert_eq!(count_of(image(&mut inbox, at(1_000))), Some(15));
        let counters = inbox.counters();
        assert_eq!(counters.duplicates, 2);
        assert_eq!(counters.late, 1);
        assert_eq!(counters.lost, 2, "13 and 14");
        assert_eq!(counters.received, 6);
    }

    #[test]
    fn a_new_run_of_the_sender_is_followed_at_once() {
        let mut inbox = inbox();
        inbox.store(at(0), &sample(1, 70_000));
        inbox.store(at(1_000), &sample(1, 70_003));
        inbox.store(at(2_000), &sample(2, 0));
        assert_eq!(count_of(image(&mut inbox, at(2_000))), Some(0));
        let counters = inbox.counters();
        assert_eq!((counters.restarts, counters.lost), (1, 2));
    }

    #[test]
    fn counts_at_the_end_of_their_range_are_only_counted() {
        let mut inbox = inbox();
        for epoch in 1..=3 {
            inbox.store(at(0), &sample(epoch, 0));
            inbox.store(at(0), &sample(epoch, u64::MAX));
        }
        let _ = image(&mut inbox, at(0));
        assert_eq!(inbox.counters().lost, u64::MAX);
    }

    #[test]
    fn a_backlog_never_reaches_the_image() {
        let mut inbox = inbox();
        for count in 0..100 {
            inbox.store(at(1_000 * count), &sample(1, count as u64));
            let _ = image(&mut inbox, at(1_000 * count));
        }
        // The receiver stood still for a second; half of the backlog comes, all of it old.
        for count in 100..600 {
            inbox.store(at(1_100_000), &sample(1, count));
        }
        assert_eq!(count_of(image(&mut inbox, at(1_100_000))), Some(99));
        assert_eq!(inbox.counters().stale, 500);
        // Then a fresh one.
        inbox.store(at(1_101_000), &sample(1, 1_101));
        assert_eq!(count_of(image(&mut inbox, at(1_101_000))), Some(1_101));
    }

    #[test]
    fn too_many_messages_push_out_the_oldest() {
        let mut inbox = inbox();
        for count in 0..CAPACITY as u64 + 10 {
            inbox.store(at(0), &sample(1, count));
        }
        assert_eq!(inbox.counters().overflow, 10);
        assert_eq!(inbox.waiting.len(), CAPACITY);
    }

    #[test]
    fn refused_frames_are_counted_by_reason() {
        let mut inbox = inbox();
        inbox.store(at(0), &Message::Rejected(Rejection::WrongChecksum));
        inbox.store(at(0), &Message::Rejected(Rejection::WrongChecksum));
        inbox.store(at(0), &Message::Rejected(Rejection::Implausible));
        let rejected = inbox.counters().rejected;
        assert_eq!(rejected.of(Rejection::WrongChecksum), 2);
        assert_eq!(rejected.of(Rejection::Implausible), 1);
        assert_eq!(rejected.total(), 3);
    }
}
