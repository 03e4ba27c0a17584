//! A motion of a program.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::{Kinematics, Profile};

use crate::source::Activity;

/// A motion that begins at a time, and the state that it leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActiveMotion {
    pub(super) began: Span,
    pub(super) profile: Profile,
    pub(super) under_way: Activity,
    pub(super) afterwards: Activity,
}

impl ActiveMotion {
    pub(super) fn is_over(&self, at: Span) -> bool {
        Seconds::from(at - self.began) >= self.profile.duration()
    }

    pub(super) fn at(&self, at: Span) -> Kinematics {
        self.profile.at(Seconds::from(at - self.began))
    }

    /// Returns the first nanosecond at which it is certainly over.
    pub(super) fn end(&self) -> Span {
        // Rounded up and one more: at a rounded-down end the profile would be a fraction of a nanosecond from its
        // target.
        let nanos = (self.profile.duration().0 * 1e9).ceil();
        // A motion without duration takes no time at all, not one nanosecond.
        if nanos > 0.0 {
            self.began + Span::from_nanos(nanos as i64) + Span::from_nanos(1)
        } else {
            self.began
        }
    }
}
