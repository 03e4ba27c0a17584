//! The true motion that an axis follows.

use coaxle_clock::{Instant, Span};
use coaxle_receiver::config::GearConfig;
use coaxle_sim::{Oracle, Truth};

use super::cuts::TrueMotion;
use super::shown_later;
use crate::row::Reference;

/// True motion of the followed axis.
#[derive(Clone, Copy)]
pub(super) struct FollowedMotion<'a> {
    pub(super) oracle: &'a Oracle<Reference>,
    pub(super) gear: Option<GearConfig>,
    /// Time after its generation at which it is shown.
    pub(super) later: Span,
    pub(super) start: Instant<Reference>,
}

impl FollowedMotion<'_> {
    /// The root as it is to be shown at an instant.
    pub(super) fn at(&self, at: Instant<Reference>) -> Option<Truth> {
        shown_later::at(self.oracle, at, self.later)
    }

    /// Position and velocity of the followed axis, from those of the axis at the root.
    pub(super) fn moves(&self, root: &Truth) -> Option<(f64, f64)> {
        let GearConfig { ratio, offset } = self.gear?;
        Some((ratio * root.position + offset, ratio * root.velocity))
    }
}

impl TrueMotion for FollowedMotion<'_> {
    fn far_position(&self, at: Instant<Reference>) -> Option<f64> {
        let (position, _) = self.moves(&self.at(at)?)?;
        Some(position)
    }

    fn time(&self, at: Instant<Reference>) -> f64 {
        seconds(at - self.start)
    }
}

/// Returns the seconds as people write them: 2.3, where a product with 1e-9 gives 2.3000000000000003.
pub(super) fn seconds(span: Span) -> f64 {
    span.as_nanos() as f64 / 1e9
}
