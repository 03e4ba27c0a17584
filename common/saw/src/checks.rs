//! Checks of a path against the sync mode.

use coaxle_curve::law::Extreme;
use coaxle_curve::profile::Limits;

use super::SyncMask;
use super::demands::SlaveDemands;
use super::refusal::{Check, Violation};

/// Tolerance of a limit for rounding, relative to the magnitudes involved.
// 4500 ε, for the sums of a few dozen products in a profile at its limits.
const ROUNDING: f64 = 1e-12;

/// Checks to make, and their limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Checklist {
    pub(super) mask: SyncMask,
    /// Limits, u/s, u/s², u/s², u/s³.
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    pub(super) deceleration: f64,
    pub(super) jerk: f64,
    /// The axis's software limits and the command's own, u; infinite if there is none.
    pub(super) software: (f64, f64),
    pub(super) optional: (f64, f64),
    /// True if the master moves towards larger positions.
    pub(super) forward: bool,
}

/// Start and end of a path: position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SyncEnds {
    pub(super) start: (f64, f64),
    pub(super) sync: (f64, f64),
}

impl Checklist {
    /// True if nothing is checked.
    pub(super) const fn is_empty(&self) -> bool {
        !self.mask.intersects(SyncMask::CHECKS)
    }

    /// Returns these limits with only the dynamics checked.
    pub(super) fn dynamics_only(&self) -> Self {
        let details = self.mask & SyncMask::DETAILED_ERROR_CODES;
        Self {
            // A refusal keeps the kind of code that the command asks for.
            mask: details | SyncMask::MAX_ACC | SyncMask::MAX_DEC | SyncMask::MAX_JERK,
            ..*self
        }
    }

    /// Returns the checks that the axis makes in any case.
    pub(super) fn of_axis(&self, own: &Limits) -> Self {
        let details = self.mask & SyncMask::DETAILED_ERROR_CODES;
        let positions = SyncMask::MIN_POS | SyncMask::MAX_POS;
        Self {
            mask: details | positions | SyncMask::MAX_DYNAMICS,
            velocity: own.velocity(),
            acceleration: own.acceleration(),
            deceleration: own.deceleration(),
            jerk: own.jerk(),
            ..*self
        }
    }

    /// # Errors
    /// The first violation, in the order of the manual.
    pub(super) fn pass(&self, demands: &SlaveDemands, ends: &SyncEnds) -> Result<(), Violation> {
        // In the order of the codes in TF5055 8.1: the first violation has the lowest.
        self.positions(demands, ends)?;
        self.speed(demands)?;
        self.velocity_shoots(demands, ends)?;
        self.reversals(demands, ends)?;
        self.dynamics(demands)
    }

    /// Checks whether the path is too fast, and in which direction.
    pub(super) fn speed(&self, demands: &SlaveDemands) -> Result<(), Violation> {
        let velocity = &demands.course.velocity;
        let slack = ROUNDING * self.velocity;
        let checked = SyncMask::MAX_VELO;
        let (up, down) = (self.velocity, -self.velocity);
        self.at_most(checked, Check::MaxVelo, velocity.maximum, up, slack)?;
        self.at_least(checked, Check::MinVelo, velocity.minimum, down, slack)
    }

    fn positions(&self, demands: &SlaveDemands, ends: &SyncEnds) -> Result<(), Violation> {
        let position = &demands.course.position;
        let (low, high) = (position.minimum, position.maximum);
        let (start, sync) = (ends.start.0, ends.sync.0);
        // Relative to the positions, whose rounding it is. A limit of 0 has no size of its own.
        let slack = ROUNDING * position.magnitude();

        let (min, max) = self.software;
        self.at_least(SyncMask::MIN_POS, Check::MinPos, low, min, slack)?;
        self.at_most(SyncMask::MAX_POS, Check::MaxPos, high, max, slack)?;
        let (min, max) = self.optional;
        let (checked, check) = (SyncMask::OPTIONAL_MIN_POS, Check::OptionalMinPos);
        self.at_least(checked, check, low, min, slack)?;
        let (checked, check) = (SyncMask::OPTIONAL_MAX_POS, Check::OptionalMaxPos);
        self.at_most(checked, check, high, max, slack)?;

        // Names go by the direction of the slave; the bounds are the same either way.
        let (under, over) = if sync < start {
            (Check::UndershootPosBackward, Check::OvershootPosBackward)
        } else {
            (Check::UndershootPosForward, Check::OvershootPosForward)
        };
        let (lower, upper) = (start.min(sync), start.max(sync));
        self.at_least(SyncMask::UNDERSHOOT_POS, under, low, lower, slack)?;
        self.at_most(SyncMask::OVERSHOOT_POS, over, high, upper, slack)
    }

    fn velocity_shoots(&self, demands: &SlaveDemands, ends: &SyncEnds) -> Result<(), Violation> {
        let velocity = &demands.course.velocity;
        let (start, sync) = (ends.start.1, ends.sync.1);
        let slack = ROUNDING * velocity.magnitude();
        let (over, under) = match (self.forward, start < sync) {
            (true, true) => (
                Check::OvershootVeloForwardFromBelow,
                Check::UndershootVeloForwardFromBelow,
            ),
            (true, false) => (
                Check::OvershootVeloForwardFromAbove,
                Check::UndershootVeloForwardFromAbove,
            ),
            (false, true) => (
                Check::OvershootVeloBackwardFromBelow,
                Check::UndershootVeloBackwardFromBelow,
            ),
            (false, false) => (
                Check::OvershootVeloBackwardFromAbove,
                Check::UndershootVeloBackwardFromAbove,
            ),
        };
        let (lower, upper) = (start.min(sync), start.max(sync));
        self.at_most(
            SyncMask::OVERSHOOT_VELO,
            over,
            velocity.maximum,
            upper,
            slack,
        )?;
        self.at_least(
            SyncMask::UNDERSHOOT_VELO,
            under,
            velocity.minimum,
            lower,
            slack,
        )
    }

    /// Checks for reversals. A velocity beyond zero counts only if the slave neither starts nor ends
    /// there.
    fn reversals(&self, demands: &SlaveDemands, ends: &SyncEnds) -> Result<(), Violation> {
        let velocity = &demands.course.velocity;
        let (start, sync) = (ends.start.1, ends.sync.1);
        let slack = ROUNDING * velocity.magnitude();
        // A slave that starts or ends above zero has to pass it.
        if start <= 0.0 && sync <= 0.0 {
            let check = self.towards(
                Check::OvershootVeloZeroForward,
                Check::OvershootVeloZeroBackward,
            );
            let checked = SyncMask::OVERSHOOT_VELO_ZERO;
            self.at_most(checked, check, velocity.maximum, 0.0, slack)?;
        }
        if start >= 0.0 && sync >= 0.0 {
            let check = self.towards(
                Check::UndershootVeloZeroForward,
                Check::UndershootVeloZeroBackward,
            );
            let checked = SyncMask::UNDERSHOOT_VELO_ZERO;
            self.at_least(checked, check, velocity.minimum, 0.0, slack)?;
        }
        Ok(())
    }

    /// Checks acceleration, deceleration and jerk.
    pub(super) fn dynamics(&self, demands: &SlaveDemands) -> Result<(), Violation> {
        let (limit, slack) = (self.acceleration, ROUNDING * self.acceleration);
        // Magnitudes by the direction of motion, since a negative acceleration may speed a slave up.
        let faster = demands.speeding_up;
        self.at_most(SyncMask::MAX_ACC, Check::MaxAcc, faster, limit, slack)?;
        let (limit, slack) = (self.deceleration, ROUNDING * self.deceleration);
        let slower = demands.slowing_down;
        self.at_most(SyncMask::MAX_DEC, Check::MaxDec, slower, limit, slack)?;
        let (limit, slack) = (self.jerk, ROUNDING * self.jerk);
        let jerk = &demands.course.jerk;
        let checked = SyncMask::MAX_JERK;
        self.at_most(checked, Check::MaxJerk, jerk.maximum, limit, slack)?;
        self.at_least(checked, Check::MinJerk, jerk.minimum, -limit, slack)
    }

    const fn towards(&self, forward: Check, backward: Check) -> Check {
        if self.forward { forward } else { backward }
    }

    fn at_most(
        &self,
        checked: SyncMask,
        check: Check,
        extreme: Extreme,
        limit: f64,
        slack: f64,
    ) -> Result<(), Violation> {
        // NaN fails the comparison, and with it the check.
        let kept = !self.mask.contains(checked) || extreme.value <= limit + slack;
        self.kept(kept, check, extreme, limit)
    }

    fn at_least(
        &self,
        checked: SyncMask,
        check: Check,
        extreme: Extreme,
        limit: f64,
        slack: f64,
    ) -> Result<(), Violation> {
        let kept = !self.mask.contains(checked) || extreme.value >= limit - slack;
        self.kept(kept, check, extreme, limit)
    }

    fn kept(
        &self,
        kept: bool,
        check: Check,
        extreme: Extreme,
        limit: f64,
    ) -> Result<(), Violation> {
        if kept {
            return Ok(());
        }
        Err(Violation {
            check,
            measured: extreme.value,
            limit,
            master_position: extreme.master,
            detailed: self.mask.contains(SyncMask::DETAILED_ERROR_CODES),
        })
    }
}
