//! An axis by the plan of its node, where frames are missing.

use coaxle_clock::Seconds;
use coaxle_remote::{FarAxisOutput, FarCorrection, KnownMotion, PlannedAhead};

use super::super::promised::ShownInstants;
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

/// Time for which the promise has to reach the instant shown without a break before the plan is used, s: several renewals.
// Where a lead is hardly longer than the way, each plan reaches it for a part of the time, and the axis would change between plan
// and prediction: `presented/now` was off by 2.9 mm instead of 2.3, and was brought back 20 times.
const COVERED: f64 = 1.0;

/// Use of the plans of an axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PlanUse {
    /// Time for which the promise has reached the instant shown, s.
    covered: f64,
    /// Time from the instant shown to the end of the promise, s; none without a plan.
    ahead: Option<f64>,
    /// Instants of its node's run that the last two cycles showed, as far as a plan is known for them.
    shown: Option<ShownInstants>,
    /// True if the newest cycle showed the motion of the plan, and number of such own cycles.
    is_planned: bool,
    cycles: u64,
}

impl Axis {
    /// Takes the plan of a cycle, `elapsed` own cycles after the previous one. Returns it if it is to be used: then a silence
    /// takes nothing away.
    pub(in super::super) fn usable<'a>(
        &mut self,
        correction: &FarCorrection,
        planned: Option<PlannedAhead<'a>>,
        elapsed: u32,
    ) -> Option<PlannedAhead<'a>> {
        let later = self.presented.as_ref().and_then(|shown| shown.later());
        let lag = later.map_or(Seconds::ZERO, |later| later.by);
        let shown = correction.of_clock().map(|age| age - lag);
        let by_plan = planned.zip(shown);
        self.plan.ahead = by_plan.and_then(|(planned, shown)| {
            let end = planned.motion.known_until()? - planned.newest;
            Some(end.as_secs_f64() - shown.0)
        });
        self.plan.shown = by_plan.map(|(planned, shown)| {
            let now = planned.newest + shown.to_span();
            ShownInstants::after(self.plan.shown, now)
        });
        let reaches = |(planned, shown): &(PlannedAhead<'_>, Seconds)| {
            planned.motion.reaches(planned.newest, *shown)
        };
        let passed = (self.cycle_time * i64::from(elapsed)).as_secs_f64();
        self.plan.covered = match by_plan.filter(reaches) {
            Some(_) => (self.plan.covered + passed).min(COVERED),
            None => 0.0,
        };
        planned.filter(|_| self.plan.covered >= COVERED)
    }

    /// Instants of its node's run that the last two cycles showed; none without a plan, or without a known clock.
    pub(in super::super) const fn shown_instants(&self) -> Option<ShownInstants> {
        self.plan.shown
    }

    /// Notes how the newest cycle was calculated.
    pub(super) fn note_plan(&mut self, moved: &FarAxisOutput, elapsed: u32) {
        self.plan.is_planned = moved.is_planned;
        if moved.is_planned {
            self.plan.cycles = self.plan.cycles.saturating_add(elapsed.into());
            // A motion that has been promised is no surprise when it comes.
            self.seen.take_planned(&moved.set);
        }
    }

    /// Writes the signals of its plan.
    pub(super) fn show_plan(&self, signals: &mut FarAxisSignals) {
        signals.planned = self.plan.ahead.map(|_| self.plan.is_planned);
        signals.planned_cycles = self.plan.cycles;
        signals.promised_ahead_us = self.plan.ahead.map(|seconds| seconds * 1e6);
    }
}
