//! Run of a frame, and its place in it: epoch, cycle time, count, index.

use coaxle_clock::CycleTime;
use coaxle_node::FrameHeader;

use super::rules::{COUNT, CYCLE_TIME, EPOCH, INDEX};
use crate::conform::rule::{RuleFinding, Tally};

/// Greatest distance of counts within a run. Frames are not lost or late by more: the node has restarted.
const FAR: u64 = 64;

/// Place of a frame in its run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FramePlace {
    /// The first frame.
    Begins,
    /// A frame after the one before.
    Goes {
        /// Number of cycles since that one.
        counts: u64,
    },
}

/// The runs of a node.
#[derive(Debug, Default)]
pub(super) struct RunChecks {
    current: Option<ObservedRun>,
    /// The epochs of those before.
    ended: Vec<u64>,
    epoch: Tally,
    cycle_time: Tally,
    count: Tally,
    index: Tally,
}

#[derive(Clone, Copy, Debug)]
struct ObservedRun {
    epoch: u64,
    cycle_time: CycleTime,
    count: u64,
    index: u16,
}

impl RunChecks {
    /// Place of the frame; none for a frame without a place, which other rules need not check.
    pub(super) fn take(&mut self, header: &FrameHeader) -> Option<FramePlace> {
        let Some(run) = self.current else {
            self.epoch.good();
            self.cycle_time.good();
            return self.begin(header);
        };
        if header.epoch != run.epoch {
            self.judge_epoch(&run, header);
            return self.begin(header);
        }
        if header.cycle_time != run.cycle_time {
            let span = |time: CycleTime| time.span().to_string();
            let received = format!("{} at count {}", span(header.cycle_time), header.count);
            let expected = format!("{} all through the epoch", span(run.cycle_time));
            self.cycle_time.bad(received, expected);
            return None;
        }
        self.cycle_time.good();
        self.place(run, header)
    }

    /// Counts a frame with a cycle time out of range.
    pub(super) fn cycle_time_out_of_range(&mut self, received: impl Into<String>) {
        self.cycle_time.bad(received, "100 µs to 100 ms");
    }

    pub(super) fn findings(&self) -> Vec<RuleFinding> {
        const NONE: &str = "no good frame came";
        let one = "it takes two good frames of a run";
        vec![
            RuleFinding::new(&EPOCH, self.epoch.outcome("frames", NONE)),
            RuleFinding::new(&CYCLE_TIME, self.cycle_time.outcome("frames", NONE)),
            RuleFinding::new(&COUNT, self.count.outcome("frames", one)),
            RuleFinding::new(&INDEX, self.index.outcome("frames", one)),
        ]
    }

    fn judge_epoch(&mut self, run: &ObservedRun, header: &FrameHeader) {
        let (new, old) = (header.epoch, run.epoch);
        let goes_on = header.count > run.count && header.count - run.count <= FAR;
        if self.ended.contains(&new) {
            let received = format!("{new:016x} once more, after {old:016x}");
            let expected = "another one after each start, and one publisher under the key";
            self.epoch.bad(received, expected);
        } else if goes_on {
            let received = format!(
                "{new:016x} after {old:016x}, though the count goes on from {} to {}",
                run.count, header.count
            );
            self.epoch.bad(received, "the same all through a run");
        } else {
            self.epoch.good();
        }
    }

    fn place(&mut self, run: ObservedRun, header: &FrameHeader) -> Option<FramePlace> {
        let Some(counts) = header.count.checked_sub(run.count).filter(|n| *n > 0) else {
            if run.count - header.count > FAR {
                let received = format!(
                    "{:016x} still, though the count begins anew with {} after {}",
                    run.epoch, header.count, run.count
                );
                let expected = "another one after a restart, drawn at random";
                self.epoch.bad(received, expected);
                return self.begin(header);
            }
            let received = format!("count {} after {}", header.count, run.count);
            self.count
                .bad(received, format!("{} or more", run.count + 1));
            return None;
        };
        self.epoch.good();
        self.count.good();
        // Both are taken modulo 65 536.
        let due = run.index.wrapping_add(counts as u16);
        self.index.check(header.index.0 == due, || {
            let received = format!(
                "index {} at count {}, after {} at {}",
                header.index.0, header.count, run.index, run.count
            );
            (received, due.to_string())
        });
        self.current = Some(ObservedRun::of(header));
        Some(FramePlace::Goes { counts })
    }

    fn begin(&mut self, header: &FrameHeader) -> Option<FramePlace> {
        let before = self.current.replace(ObservedRun::of(header));
        self.ended.extend(
            before
                .map(|run| run.epoch)
                .filter(|epoch| *epoch != header.epoch),
        );
        Some(FramePlace::Begins)
    }
}

impl ObservedRun {
    const fn of(header: &FrameHeader) -> Self {
        Self {
            epoch: header.epoch,
            cycle_time: header.cycle_time,
            count: header.count,
            index: header.index.0,
        }
    }
}
