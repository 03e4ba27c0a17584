//! Samples of an axis, as its node's frames bring them.

use coaxle_clock::Seconds;
use coaxle_node::{AxisSample, FrameHeader};
use coaxle_remote::FarCorrection;

use super::super::frames::TakenFrame;
use super::super::seen::LARGEST_BEAT;
use super::Axis;

impl Axis {
    /// Takes its sample of the newest frame with this header.
    pub(in super::super) fn take(&mut self, sample: Option<AxisSample>, header: &FrameHeader) {
        let count = header.count;
        if let Some(mut sample) = sample {
            let has_come = self.sample.is_some();
            // 0 for the first sample and for a count that fell back: a way of no cycles, and not one of 2⁶⁴.
            let missed = count.saturating_sub(self.count) * u64::from(has_come);
            // By the sender's cycles and not by arrivals, whose jitter would move the predicted position.
            let passed = header.cycle_time.as_secs_f64() * missed as f64;
            if let Some(turns) = &mut self.turns {
                sample.set = turns.unwrapped(&sample.set, passed);
            }
            if let Some(encoder) = &mut self.encoder {
                encoder.take(&sample.set, count);
            }
            let before = self.sample.as_ref().map(|before| &before.set);
            let neighbour = before.map(|before| (before, passed, missed));
            self.seen.take(&sample.set, neighbour);
            self.has_gap = before.is_some() && missed > LARGEST_BEAT;
            // Over a gap a long way looks like a wrap.
            if let Some(before) = before.filter(|_| !self.has_gap) {
                self.wraps.take(before, &sample.set, passed);
            }
            if let Some(presented) = &mut self.presented {
                presented.take(count, &sample.set, header.present_after);
            }
            self.sample = Some(sample);
            self.count = count;
            self.missing_cycles = 0;
        } else {
            self.missing += 1;
        }
    }

    /// Takes its sample of any frame of the run that is followed; `header` is that of the newest one.
    pub(in super::super) fn take_beside(
        &mut self,
        sample: Option<&AxisSample>,
        frame: &TakenFrame<'_>,
        header: &FrameHeader,
    ) {
        let count = frame.count;
        let (Some(presented), Some(sample)) = (&mut self.presented, sample) else {
            return;
        };
        // Newer ones would be those of an axis that the image lacks.
        if self.sample.is_none() || count >= self.count {
            return;
        }
        let behind = header.cycle_time.as_secs_f64() * (self.count - count) as f64;
        let set = match &self.turns {
            Some(turns) => turns.beside(&sample.set, -behind),
            None => sample.set,
        };
        presented.take(count, &set, frame.present_after);
    }

    /// Correction for an axis that was missing in the newest frame.
    pub(in super::super) fn catch_up(
        &mut self,
        correction: &FarCorrection,
        header: &FrameHeader,
        elapsed: u32,
        age_limit: Option<u32>,
    ) -> FarCorrection {
        self.missing_cycles = self.missing_cycles.saturating_add(elapsed);
        // Before its first sample in a run the difference has no meaning, and none is used: the cycle then has no set
        // values.
        let behind = header.count.wrapping_sub(self.count) as f64;
        let older = correction.for_older(Seconds(behind * header.cycle_time.as_secs_f64()));
        match age_limit {
            // An axis that is missing from frames which still come is as old as one of a silent node.
            Some(limit) if self.missing_cycles > limit => older.for_silent(),
            _ => older,
        }
    }
}
