//! Run of a frame, and its place in it: epoch, cycle time, count, index.

use coaxle_node::FrameHeader;

use super::rules::{SenderRule, Tallies};
use crate::conform::rule::{Mismatch, ensure, mismatch};

/// Greatest distance of counts within a run. Frames are not lost or late by more: the node has restarted.
const FAR: u64 = 64;

/// Place of a frame in its run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::conform::sender) enum FramePlace {
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
pub(in crate::conform::sender) struct RunChecks {
    /// The newest frame with a place in the current run.
    newest: Option<FrameHeader>,
    /// The epochs of the runs before.
    ended: Vec<u64>,
}

impl RunChecks {
    /// Place of the frame; none for a frame without a place, which other rules need not check.
    pub(in crate::conform::sender) fn take(
        &mut self,
        header: &FrameHeader,
        tallies: &mut Tallies,
    ) -> Option<FramePlace> {
        let Some(newest) = self.newest else {
            tallies.count(SenderRule::Epoch, Ok(()));
            tallies.count(SenderRule::CycleTime, Ok(()));
            return self.begin(header);
        };
        if header.epoch != newest.epoch {
            tallies.count(SenderRule::Epoch, self.check_epoch(&newest, header));
            return self.begin(header);
        }
        let [own, due] = [header, &newest].map(|of| of.cycle_time.span());
        if !tallies.check(SenderRule::CycleTime, own == due, || {
            let received = format!("{own} at count {}", header.count);
            mismatch(received, format!("{due} all through the epoch"))
        }) {
            return None;
        }
        self.place(&newest, header, tallies)
    }

    /// Checks the epoch of another run.
    fn check_epoch(&self, newest: &FrameHeader, header: &FrameHeader) -> Result<(), Mismatch> {
        let (new, old) = (header.epoch, newest.epoch);
        ensure(!self.ended.contains(&new), || {
            let expected = "another one after each start, and one publisher under the key";
            mismatch(format!("{new:016x} once more, after {old:016x}"), expected)
        })?;
        let ahead = header.count.checked_sub(newest.count);
        ensure(!ahead.is_some_and(|n| (1..=FAR).contains(&n)), || {
            let received = format!(
                "{new:016x} after {old:016x}, though the count goes on from {} to {}",
                newest.count, header.count
            );
            mismatch(received, "the same all through a run")
        })
    }

    /// Place of a frame of the run by its count.
    fn place(
        &mut self,
        newest: &FrameHeader,
        header: &FrameHeader,
        tallies: &mut Tallies,
    ) -> Option<FramePlace> {
        let (count, before) = (header.count, newest.count);
        if before.saturating_sub(count) > FAR {
            let received = format!(
                "{:016x} still, though the count begins anew with {count} after {before}",
                header.epoch
            );
            let case = mismatch(received, "another one after a restart, drawn at random");
            tallies.count(SenderRule::Epoch, Err(case));
            return self.begin(header);
        }
        if !tallies.check(SenderRule::Count, count > before, || {
            let received = format!("count {count} after {before}");
            mismatch(received, format!("{} or more", before + 1))
        }) {
            return None;
        }
        tallies.count(SenderRule::Epoch, Ok(()));
        let counts = count - before;
        // Both are taken modulo 65 536.
        let (index, due) = (header.index.0, newest.index.0.wrapping_add(counts as u16));
        tallies.check(SenderRule::Index, index == due, || {
            let last = newest.index.0;
            let received = format!("index {index} at count {count}, after {last} at {before}");
            mismatch(received, due.to_string())
        });
        self.newest = Some(*header);
        Some(FramePlace::Goes { counts })
    }

    fn begin(&mut self, header: &FrameHeader) -> Option<FramePlace> {
        let before = self.newest.replace(*header).map(|frame| frame.epoch);
        self.ended
            .extend(before.filter(|epoch| *epoch != header.epoch));
        Some(FramePlace::Begins)
    }
}
