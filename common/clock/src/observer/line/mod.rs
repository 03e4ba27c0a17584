//! The straight line through the phases: estimators of it, their choice and their uncertainty.
//!
//! A [`Bank`] of Kalman filters follows the measurements of all messages, and the [`Edge`] the lowest phases, which is
//! the better line where delays are correlated. [`Choice`] decides which of both is followed, and [`Calibration`] compares
//! it with its own predictions.

mod bank;
mod bias;
mod calibration;
mod choice;
mod edge;
mod filter;
mod steadiness;

pub(crate) use bank::Bank;
pub(super) use calibration::Calibration;
pub(super) use choice::Choice;
pub(super) use edge::Edge;
pub(crate) use filter::Estimate;

#[cfg(feature = "perturb")]
pub(super) const TUNED: &[crate::tuning::TunedBlock] = &[
    bank::TUNED,
    calibration::TUNED,
    choice::TUNED,
    edge::TUNED,
    edge::CONSENSUS,
    edge::NOISE,
    edge::WINDOWS,
    filter::TUNED,
    steadiness::TUNED,
];
