//! An axis by the plan of its node, where frames are missing.

use coaxle_clock::{Seconds, Span};
use coaxle_remote::{FarAxisOutput, FarCorrection, KnownMotion, PlanCoverage, PlannedAhead};

use super::presented::Presented;
use super::{Axis, AxisScan};
use crate::promised::ShownInstants;
use crate::signals::FarAxisSignals;

/// What is known of an axis besides its newest frame.
pub(super) fn known<'a>(presented: Option<&'a Presented>, scan: &AxisScan<'a>) -> KnownMotion<'a> {
    KnownMotion {
        later: presented.and_then(Presented::later),
        planned: scan.planned,
    }
}

/// Use of the plans of an axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PlanUse {
    /// The newest cycle; none without a plan, or without a known clock.
    now: Option<PlannedCycle>,
    /// Number of own cycles that showed the motion of the plan.
    cycles: u64,
}

/// A cycle of an axis whose motion is planned.
#[derive(Clone, Copy, Debug)]
struct PlannedCycle {
    shown: ShownInstants,
    /// Instant until which the motion is promised.
    until: Span,
    coverage: PlanCoverage,
    /// True if it showed the motion of the plan.
    is_planned: bool,
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
        let last = self.plan.now.take();
        let later = self.presented.as_ref().and_then(|shown| shown.later());
        let lag = later.map_or(Seconds::ZERO, |later| later.by);
        let shown = correction.of_clock().map(|age| age - lag)?;
        let planned = planned?;
        let reaches = planned.motion.reaches(planned.newest, shown);
        let passed = self.cycle_time * i64::from(elapsed);
        let before = last.map_or_else(PlanCoverage::default, |last| last.coverage);
        let shown = planned.newest + shown.to_span();
        let now = PlannedCycle {
            shown: ShownInstants::after(last.map(|last| last.shown), shown),
            until: planned.motion.known_until()?,
            coverage: before.after(passed, reaches),
            is_planned: false,
        };
        self.plan.now = Some(now);
        now.coverage.suffices().then_some(planned)
    }

    /// Instants of its node's run that the last two cycles showed; none without a plan, or without a known clock.
    pub(in super::super) fn shown_instants(&self) -> Option<ShownInstants> {
        self.plan.now.map(|now| now.shown)
    }

    /// Notes how the newest cycle was calculated.
    pub(super) fn note_plan(&mut self, moved: &FarAxisOutput, elapsed: u32) {
        if let Some(now) = &mut self.plan.now {
            now.is_planned = moved.is_planned;
        }
        if moved.is_planned {
            self.plan.cycles = self.plan.cycles.saturating_add(elapsed.into());
            // A motion that has been promised is no surprise when it comes.
            self.seen.take_planned(&moved.set);
        }
    }

    /// Writes the signals of its plan.
    pub(super) fn show_plan(&self, signals: &mut FarAxisSignals) {
        let now = self.plan.now.as_ref();
        signals.planned = now.map(|now| now.is_planned);
        signals.planned_cycles = self.plan.cycles;
        signals.promised_ahead_us = now.map(|now| (now.until - now.shown.now()).as_micros_f64());
    }
}
