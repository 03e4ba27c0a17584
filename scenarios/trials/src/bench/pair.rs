//! A sending and a receiving process, measured for a given time.

use coaxle_clock::Span;
use coaxle_os::machine;

use super::plan::{PeerPlan, PeerReport};
use super::process::Process;
use super::turns::BenchProgress;

/// Time for both to meet and warm up, which does not count.
// A receiver has data 0.28 s after its start at the latest (docs/SPEED.md, "Secure transports").
pub(super) const WARM_UP: Span = Span::from_millis(500);

/// Time after which a process ends by itself if it is not ended.
// Long enough for slow starts of both, so that it never ends a measurement that still runs.
const PATIENCE: Span = Span::from_secs(30);

/// The sender and the receiver.
pub(super) struct Pair {
    pub(super) sender: PeerPlan,
    pub(super) receiver: PeerPlan,
    /// Command line prefix of the receiver's program, if any.
    pub(super) before_receiver: Vec<String>,
    pub(super) warm_up: Span,
}

/// Reports of both over the measured time.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    pub(super) sender: PeerReport,
    pub(super) receiver: PeerReport,
    /// Processor load of each, 1: a whole processor; absent where the system does not report it.
    pub(super) load: Option<[f64; 2]>,
}

impl Pair {
    /// A pair on this machine, without anything between.
    pub(super) const fn new(sender: PeerPlan, receiver: PeerPlan) -> Self {
        Self {
            sender,
            receiver,
            before_receiver: Vec::new(),
            warm_up: WARM_UP,
        }
    }

    /// Lets both run, and keeps the records within the measured time.
    ///
    /// # Errors
    /// Either process fails, or Ctrl-C came.
    pub(super) fn measure(
        &self,
        time: Span,
        turns: &mut BenchProgress<'_>,
    ) -> anyhow::Result<Measured> {
        let limit = self.warm_up + time + PATIENCE;
        // A connecting process tries again only after a while: the listening one begins.
        let sender = Process::start("sending process", &self.sender, limit, &[])?;
        let before = &self.before_receiver;
        let receiver = Process::start("receiving process", &self.receiver, limit, before)?;
        turns.wait(self.warm_up)?;
        // Both readings for one span: reading them at its ends leaves start and warm-up out.
        let taken = || Some([sender.processor_time()?, receiver.processor_time()?]);
        let (begin, before) = (machine::now(), taken());
        turns.wait(time)?;
        let (end, after) = (machine::now(), taken());
        let share = |before: Span, after: Span| {
            (after - before).as_secs_f64() / (end - begin).as_secs_f64()
        };
        let load = before
            .zip(after)
            .map(|(before, after)| [0, 1].map(|side| share(before[side], after[side])));
        // While there is still a sender to follow.
        let receiver = receiver.end()?;
        let mut measured = Measured {
            sender: sender.end()?,
            receiver,
            load,
        };
        // Cycles of the sender need no cut: only those of a frame that stays are looked up.
        measured.keep_within(begin.as_nanos(), end.as_nanos());
        Ok(measured)
    }
}

impl Measured {
    fn keep_within(&mut self, begin: i64, end: i64) {
        // By arrival alone: a message on its way at the begin counts, one on its way at the end does not.
        let within = |at: i64| (begin..end).contains(&at);
        let received = &mut self.receiver;
        received.frames.retain(|frame| within(frame.arrived));
        received.messages.retain(|message| within(message.arrived));
        received.looks.retain(|look| within(look.at));
    }

    /// Requests for real time that the system did not grant to either process.
    pub(super) fn denied(&self) -> impl Iterator<Item = &String> {
        self.sender.denied.iter().chain(&self.receiver.denied)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::plan::MessageArrival;

    #[test]
    fn what_came_before_and_after_does_not_count() {
        let message = |arrived| MessageArrival {
            count: 1,
            woke: 0,
            left: 0,
            arrived,
        };
        let mut measured = Measured::default();
        measured.receiver.messages = [9, 10, 19, 20].map(message).into();
        measured.keep_within(10, 20);
        let kept = measured.receiver.messages.iter();
        assert!(kept.map(|message| message.arrived).eq([10, 19]));
    }
}
