//! Run of the sender, and the straight line through the phases of its messages.

use super::events::{Backlog, Batches, Bounds, Counts, DriftSteps, Teeth};
use super::line::{Bank, Calibration, Choice, Edge};
use super::noise::{Echo, FIRST_BLOCK, Jitter, Resolution, Waits};
use crate::instant::{Instant, Local, Remote, Span};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the bounds of usual residuals.
    StreamTuning {
        /// Greatest length of a queue.
        longest_queue: u16 = 256,
        /// Standard deviations of the line that bounds are wider by.
        unsure: f64 = 5.0,
        /// Normal widths below the line of a message that is early.
        // 3 in 100 000 are.
        early: f64 = 4.0,
        /// Normal widths above the line, beside one exponential width, of a message that is late.
        // A quarter are, at a ratio of 0.25.
        late: f64 = 2.0,
        /// Part of the exponential width, beside `late` normal ones, that a run of messages is above.
        // Half of all are.
        above: f64 = 0.25,
    }
}

/// Cells of a coarse clock that bounds are wider by.
// Not tuned: a stamp is up to a cell before its arrival, and so are those that the line is made of.
const CELLS: f64 = 2.0;

/// Messages that make one measurement.
pub(super) const BLOCK: usize = 8;

/// Run of the sender, and the line through its phases.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    pub(super) epoch: u64,
    pub(super) previous_epoch: Option<u64>,
    pub(super) first_count: u64,
    pub(super) first_arrival: Instant<Local>,
    /// The far time of the first count. Not its own once the index map changed.
    pub(super) origin: Instant<Remote>,
    pub(super) counts: Counts,
    pub(super) newest_arrival: Instant<Local>,
    /// Newest arrival of the messages that are used.
    pub(super) newest_used: Instant<Local>,
    /// Detection of a backlog while the line is being found.
    pub(super) backlog: Backlog,
    /// Selection of the messages that are used.
    pub(super) batches: Batches,
    /// Room that those leave for the line.
    pub(super) waits: Waits,
    pub(super) block: [Residual; FIRST_BLOCK],
    pub(super) filled: usize,
    /// Messages in a row that may have been held up.
    pub(super) held_up: u16,
    /// Line of all messages; none until the first block is full.
    pub(super) line: Option<Line>,
    pub(super) resolution: Resolution,
    /// Comparison of arrivals with the send stamps.
    pub(super) echo: Echo,
    /// The last jumps of the phase.
    pub(super) teeth: Teeth,
    /// Lower edge of these phases.
    pub(super) edge: Edge,
    /// Choice between the two lines.
    pub(super) choice: Choice,
    /// Calibration of the uncertainty of the line that is followed.
    pub(super) calibration: Calibration,
    /// Detection of phases on a line with another drift.
    pub(super) drift_steps: DriftSteps,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Residual {
    /// Counts since the first.
    pub(super) count: i64,
    /// Phase less the line, s.
    pub(super) value: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Count of the bank's estimate since the first.
    pub(super) at: i64,
    pub(super) bank: Bank,
    pub(super) bounds: Bounds,
}

impl Stream {
    /// Phase of a count that the line expects, s.
    pub(super) fn expected(&self, count: i64, seconds_per_count: f64) -> f64 {
        self.line.as_ref().map_or(0.0, |line| {
            let estimate = line.bank.combined();
            // Saturating, as a stranger may send any count.
            let ahead = count.saturating_sub(line.at) as f64 * seconds_per_count;
            estimate.offset + estimate.drift * ahead
        })
    }

    /// True if the link was still busy with the message before, `gap` earlier, when this one could have come: on a
    /// link that keeps the order its arrival then depends on the one before. Messages that come far faster than they
    /// are sent, as out of a mailbox, are a queue however many they are.
    pub(super) fn is_held_up(&mut self, residual: f64, gap: Span, is_queue: bool) -> bool {
        // The message before left the link that much earlier, as seen from when this one was due.
        let busy_until = residual - gap.as_secs_f64();
        let held_up = (self.line.as_ref()).is_some_and(|line| busy_until > line.bounds.level);
        if held_up && is_queue {
            return true;
        }
        self.held_up = if held_up { self.held_up + 1 } else { 0 };
        // A longer row is no queue: the line is wrong.
        if self.held_up > TUNING.longest_queue {
            self.held_up = TUNING.longest_queue;
            return false;
        }
        held_up
    }

    pub(super) fn block_is_full(&self) -> bool {
        let length = if self.line.is_some() {
            BLOCK
        } else {
            FIRST_BLOCK
        };
        self.filled >= length
    }

    /// The mean count of a block. Counts differ little, or were gone through by the detector.
    pub(super) fn middle(&self) -> i64 {
        let first = self.block[0].count;
        let length = self.filled.max(1) as i64;
        let (mut whole, mut parts) = (0, 0);
        for residual in &self.block[..self.filled] {
            let ahead = residual.count.saturating_sub(first);
            // Divided before they are added, as counts may be as large as they can be.
            whole += ahead / length;
            parts += ahead % length;
        }
        first.saturating_add(whole).saturating_add(parts / length)
    }
}

impl Line {
    /// The line through the very first phases, level as yet.
    pub(super) fn first(
        at: i64,
        phases: &[f64; FIRST_BLOCK],
        jitter: &mut Jitter,
        drift: f64,
    ) -> Self {
        jitter.guess(phases);
        // A prior of 1e20 s² is none, without a branch for it.
        let offset = jitter.locate(phases, 1e20).most_likely;
        let variance = jitter.variance() / FIRST_BLOCK as f64;
        let bank = Bank::new(offset, variance, drift * drift);
        let bounds = Self::bounds(&bank, jitter);
        Self { at, bank, bounds }
    }

    pub(super) fn bounds(bank: &Bank, jitter: &Jitter) -> Bounds {
        let unsure =
            TUNING.unsure * libm::sqrt(bank.combined().offset_variance) + CELLS * jitter.cell();
        let doubt = jitter.doubt();
        Bounds {
            patience: bank.correlated().patience(),
            level: jitter.moved(),
            early: jitter.moved() - TUNING.early * jitter.normal() * doubt - unsure,
            late: jitter.moved()
                + (TUNING.late * jitter.normal() + jitter.exponential()) * doubt
                + unsure,
            above: jitter.moved()
                + (TUNING.late * jitter.normal() + TUNING.above * jitter.exponential()) * doubt
                + unsure,
        }
    }
}
