//! Detectors of what is not noise around one line: jumps of the phase, changes of the drift, teeth of polled arrivals,
//! messages that come in batches or as a backlog, and counts that come again.
//!
//! A detector only notices. What follows from it is in `follow_shift`, `follow_teeth` and `drift_change`.

mod attributed;
mod backlog;
mod batches;
mod counts;
mod drift_step;
mod shift;
mod teeth;

pub(super) use attributed::Attributed;
pub(super) use backlog::{Backlog, Pace};
pub(super) use batches::{Arrival, Batches, Picked};
pub(super) use counts::{Counts, News};
pub(super) use drift_step::{DriftStep, DriftSteps};
pub(super) use shift::{Bounds, Evidence, ShiftDetector, skipped_cycles};
pub(super) use teeth::{Jump, ShownDrift, Teeth, bounds, cell_of, lowest_level, within_cell};

#[cfg(feature = "perturb")]
pub(super) const TUNED: &[crate::tuning::TunedBlock] = &[
    backlog::TUNED,
    batches::TUNED,
    counts::TUNED,
    drift_step::TUNED,
    shift::TUNED,
    teeth::TUNED,
];
