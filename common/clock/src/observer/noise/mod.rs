//! The deviations of arrivals from the line, as measured while the line is followed.
//!
//! [`Jitter`] is the model of independent delays, and finds the most likely place of a block of messages under it.
//! [`Correlation`] and [`CorrelatedDelay`] notice delays that last, [`Resolution`] the grid of the stamps, [`Echo`]
//! arrivals that do not depend on when a message was sent, and [`Waits`] the waits of messages that come in batches.

mod correlated_delay;
mod correlation;
mod echo;
mod hazard;
mod information;
mod jitter;
mod misfit;
mod pull;
mod resolution;
mod waits;

pub(super) use correlated_delay::CorrelatedDelay;
pub(super) use correlation::Correlation;
pub(super) use echo::Echo;
pub(super) use jitter::{FIRST_BLOCK, Jitter};
pub(super) use resolution::Resolution;
pub(super) use waits::Waits;

#[cfg(feature = "perturb")]
pub(super) const TUNED: &[crate::tuning::TunedBlock] = &[
    correlated_delay::TUNED,
    correlation::TUNED,
    echo::TUNED,
    jitter::TUNED,
    misfit::TUNED,
    resolution::TUNED,
    waits::TUNED,
];
