//! An axis by the plan of its node, where frames are missing.

use coaxle_clock::Seconds;
use coaxle_remote::{FarAxisOutput, FarCorrection, KnownMotion, PlannedAhead};

use super::presented::Presented;
use super::{Axis, AxisScan};
use crate::signals::FarAxisSignals;

/// What is known of an axis besides its newest frame.
pub(super) fn known<'a>(presented: Option<&'a Presented>, scan: &AxisScan<'a>) -> KnownMotion<'a> {
    KnownMotion {
        later: presented.and_then(Presented::later),
        planned: scan.planned,
    }
}

impl Axis {
    /// True if the motion is promised at the instant that is shown: a silence takes nothing away.
    pub(super) fn is_promised(
        &self,
        correction: &FarCorrection,
        planned: Option<PlannedAhead<'_>>,
    ) -> bool {
        let later = self.presented.as_ref().and_then(|shown| shown.later());
        let lag = later.map_or(Seconds::ZERO, |later| later.by);
        let known = planned.zip(correction.of_clock());
        known.is_some_and(|(planned, age)| planned.motion.reaches(planned.newest, age - lag))
    }

    /// Notes how the newest cycle was calculated.
    pub(super) fn note_plan(&mut self, moved: &FarAxisOutput, elapsed: u32) {
        self.is_planned = moved.is_planned;
        if moved.is_planned {
            self.planned_cycles = self.planned_cycles.saturating_add(elapsed.into());
            // A motion that has been promised is no surprise when it comes.
            self.seen.take_planned(&moved.set);
        }
    }

    /// Writes the signals of its plan.
    pub(super) fn show_plan(
        &self,
        moved: &FarAxisOutput,
        scan: &AxisScan<'_>,
        signals: &mut FarAxisSignals,
    ) {
        signals.planned = scan.planned.map(|_| self.is_planned);
        signals.planned_cycles = self.planned_cycles;
        signals.promised_ahead_us = scan.planned.and_then(|planned| {
            let shown = planned.newest + moved.correction_time?.to_span();
            let ahead = planned.motion.known_until()? - shown;
            Some(ahead.as_micros_f64())
        });
    }
}
