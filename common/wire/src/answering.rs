//! The part of a node that answers questions about its clock.

use coaxle_clock::cycle::Turn;
use coaxle_clock::{CycleTime, Instant, Local};

use crate::channel::Channel;
use crate::exchange::{
    ANSWERS_CAPACITY, AnswerHeader, MAX_ANSWERS, Question, Reply, encode_answers,
};
use crate::message::Outgoing;

/// Answers, in each cycle, the questions that came before it: all in one frame.
#[derive(Clone, Debug)]
pub struct Answering {
    sender: u32,
    epoch: u64,
    start: Instant<Local>,
    cycle_time: CycleTime,
    waiting: [(Instant<Local>, Question); MAX_ANSWERS],
    count: usize,
    body: [u8; ANSWERS_CAPACITY],
    /// Length of the body that waits to be sent, and the cycle it belongs to.
    pending: Option<(usize, Instant<Local>)>,
    counters: AnsweringCounters,
}

/// What became of the questions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AnsweringCounters {
    /// Answered.
    pub answered: u64,
    /// Not answered: too many came in one cycle.
    pub dropped: u64,
}

impl Answering {
    /// Answers as the node with the id `sender`, in its run `epoch`, whose cycle 0 is due at `start`.
    #[must_use]
    pub fn new(sender: u32, epoch: u64, start: Instant<Local>, cycle_time: CycleTime) -> Self {
        Self {
            sender,
            epoch,
            start,
            cycle_time,
            waiting: [<_>::default(); MAX_ANSWERS],
            count: 0,
            body: [0; ANSWERS_CAPACITY],
            pending: None,
            counters: AnsweringCounters::default(),
        }
    }

    /// Stores a question that arrived at `at`.
    pub fn hear(&mut self, at: Instant<Local>, question: &Question) {
        if let Some(place) = self.waiting.get_mut(self.count) {
            *place = (at, *question);
            self.count += 1;
        } else {
            self.counters.dropped = self.counters.dropped.saturating_add(1);
        }
    }

    /// Answers in the cycle `turn`, which really began at `now`, what had arrived by then.
    pub fn answer(&mut self, turn: &Turn, now: Instant<Local>) {
        let mut replies = [Reply::default(); MAX_ANSWERS];
        let (mut answered, mut kept) = (0, 0);
        for n in 0..self.count {
            let (at, question) = self.waiting[n];
            if at <= now {
                let heard = at - self.start;
                replies[answered] = Reply { question, heard };
                answered += 1;
            } else {
                self.waiting[kept] = self.waiting[n];
                kept += 1;
            }
        }
        self.count = kept;
        self.counters.answered = self.counters.answered.saturating_add(answered as u64);
        self.pending = (answered > 0).then(|| {
            let header = AnswerHeader {
                sender: self.sender,
                epoch: self.epoch,
                count: turn.count,
                cycle_time: self.cycle_time,
            };
            let length = encode_answers(&header, &replies[..answered], &mut self.body);
            (length, turn.ideal_start)
        });
    }

    /// The answers of the newest cycle, once.
    pub fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let (length, ideal_start) = self.pending.take()?;
        Some(Outgoing {
            channel: Channel::Answers,
            far: 0,
            ideal_start,
            body: &self.body[..length],
        })
    }

    /// What became of the questions so far.
    #[must_use]
    pub const fn counters(&self) -> AnsweringCounters {
        self.counters
    }
}
