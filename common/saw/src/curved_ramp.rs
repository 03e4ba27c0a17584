//! The ramp from a start with acceleration: the velocity is the cubic over time that meets velocity and acceleration at both
//! ends, `v0 + a0·T·x + (3·Δv − 2·a0·T)·x² + (a0·T − 2·Δv)·x³`.
//!
//! Its acceleration is `(1 − x)·(a0 + 3·(2·Δv/T − a0)·x)`, and its jerk, linear, is greatest at one of
//! the ends. So each limit is just reached at durations that solve a quadratic equation. The shortest
//! duration that keeps all limits is one of these, as long as the velocity keeps its sign. Otherwise the
//! shortest is found by a search.

use super::checks::Checklist;
use super::path_piece::PathPiece;
use super::refusal::SawRefusal;
use super::task::SyncTask;

/// Factor between the durations of successive tries.
const NEXT_TRY: f64 = 1.1;
/// Number of tries: the last is ten thousand times as long as the first.
const TRIES: usize = 97;
/// Halvings between the last try that failed and the first that passed.
// A tenth of the duration, halved 40 times, is 1e-13 of it: the ROUNDING below.
const HALVINGS: usize = 40;
/// Smaller relative differences are rounding of a root; a ramp that reaches its limits is made longer by
/// this.
const ROUNDING: f64 = 1e-13;

/// Finds the shortest ramp of this task within acceleration, deceleration and jerk.
pub(super) fn shortest(task: &SyncTask) -> Result<PathPiece, SawRefusal> {
    let change = VelocityRise::of(task);
    let limits = task.checklist.dynamics_only();
    let lasting = |duration| ramp_lasting(task, duration);
    let passes = |duration| {
        let demands = lasting(duration).demands(task.master_velocity);
        limits.dynamics(&demands).is_ok()
    };
    let found = change.at_its_limits(&limits, passes);
    // Through standstill the two limits swap on the way, so no closed form covers it.
    let found = found.or_else(|| change.search(&limits, passes));
    found.map(lasting).ok_or(SawRefusal::NoRamp {
        slave_acceleration: change.acceleration,
    })
}

fn ramp_lasting(task: &SyncTask, duration: f64) -> PathPiece {
    PathPiece::curved_ramp(
        task.master_position,
        task.master_velocity * duration,
        task.slave_position,
        (task.slope(), task.curvature()),
        task.ratio,
    )
}

/// Change of velocity, over time.
#[derive(Clone, Copy, Debug)]
struct VelocityRise {
    /// Velocity at the start and at the end, u/s.
    velocity: (f64, f64),
    /// Acceleration at the start, u/s².
    acceleration: f64,
}

impl VelocityRise {
    fn of(task: &SyncTask) -> Self {
        Self {
            velocity: (task.slave_velocity, task.sync_velocity()),
            acceleration: task.curvature() * task.master_velocity * task.master_velocity,
        }
    }

    /// Returns Δv.
    fn rise(&self) -> f64 {
        self.velocity.1 - self.velocity.0
    }

    /// Returns the lower bound of the duration by three limits: the acceleration, the jerk that leads the
    /// acceleration to zero, and the jerk by which the velocity changes, `|Δv| ≤ |a0|·T + j·T²/2`. The
    /// duration needed is a small multiple of the greatest.
    fn least(&self, limits: &Checklist) -> f64 {
        let (steepest, jerk) = (limits.acceleration.max(limits.deceleration), limits.jerk);
        let (rise, start) = (self.rise().abs(), self.acceleration.abs());
        // The root of the quadratic, in the form without cancellation.
        let by_jerk = 2.0 * rise / (start + libm::sqrt(start * start + 2.0 * jerk * rise));
        // 0/0 without a rise and without an acceleration: no bound.
        let by_jerk = if by_jerk.is_finite() { by_jerk } else { 0.0 };
        (rise / steepest).max(start / jerk).max(by_jerk)
    }

    /// Returns the shortest of the durations at which a limit is reached; none if the velocity changes
    /// its sign on the way.
    fn at_its_limits(&self, limits: &Checklist, passes: impl Fn(f64) -> bool) -> Option<f64> {
        // Speeding up and slowing down would have to be distinguished along the ramp.
        if self.velocity.0 * self.velocity.1 < 0.0 {
            return None;
        }
        let mut durations = Durations::default();
        durations.add(self.least(limits));
        self.reach_jerk(limits.jerk, &mut durations);
        self.reach_acceleration(limits.acceleration, &mut durations);
        self.reach_acceleration(limits.deceleration, &mut durations);
        let mut durations = durations.in_order().iter();
        durations
            // The closed form first: it sorts out most of them
            // before the extremes of a path are calculated.
            .find(|&&duration| self.keeps(limits, duration) && passes(duration))
            .copied()
    }

    /// Adds the solutions of |6·Δv − 4·a0·T| = j·T² at the start, |6·Δv − 2·a0·T| = j·T² at the end.
    fn reach_jerk(&self, jerk: f64, durations: &mut Durations) {
        for share in [4.0, 2.0] {
            for side in [jerk, -jerk] {
                // j·T² + 4·a0·T − 6·Δv = 0, and the same with 2 for the end.
                durations.solve(side, share * self.acceleration, -6.0 * self.rise());
            }
        }
    }

    /// Adds the solutions for which the peak between the ends, (3·Δv − a0·T)²/(3·T·(2·Δv − a0·T)),
    /// reaches a limit of either sign.
    fn reach_acceleration(&self, limit: f64, durations: &mut Durations) {
        let (a, rise) = (self.acceleration, self.rise());
        for side in [limit, -limit] {
            durations.solve(
                // (3Δv − aT)² = 3T·side·(2Δv − aT), sorted by powers of T.
                a * (a + 3.0 * side),
                -6.0 * rise * (a + side),
                9.0 * rise * rise,
            );
        }
    }

    /// True if a ramp of this duration may pass: by its jerk, and, if its velocity keeps its sign, by its
    /// acceleration.
    fn keeps(&self, limits: &Checklist, duration: f64) -> bool {
        let (a, rise) = (self.acceleration, self.rise());
        let slack = 1.0 + 10.0 * ROUNDING;
        let bend = a * duration;
        let jerk = (6.0 * rise - 4.0 * bend)
            .abs()
            .max((6.0 * rise - 2.0 * bend).abs());
        if jerk > limits.jerk * duration * duration * slack {
            return false;
        }
        // Both velocities have one sign here, or are 0.
        let direction = (self.velocity.0 + self.velocity.1).signum();
        let is_kept = |acceleration: f64| {
            let along = acceleration * direction;
            along <= limits.acceleration * slack && -along <= limits.deceleration * slack
        };
        let slope = 6.0 * rise - 3.0 * bend;
        // With k = 2Δv/T − a0 the peak lies at x = ½ − a0/6k: within the ramp if |a0| < 3|k|.
        let is_between = bend.abs() < slope.abs();
        let peak = (3.0 * rise - bend) * (3.0 * rise - bend) / (slope * duration);
        is_kept(a) && (!is_between || is_kept(peak))
    }

    /// Finds the first of longer and longer durations that passes, and from there bisects back to the one
    /// before.
    fn search(&self, limits: &Checklist, passes: impl Fn(f64) -> bool) -> Option<f64> {
        let first = self.least(limits);
        // Upwards, not by bisection from afar: the longer a ramp with a start
        // acceleration, the farther it goes beyond its velocities, and it may reverse.
        let mut tries = core::iter::successors(Some(first), |duration| Some(duration * NEXT_TRY));
        let mut passed = tries.by_ref().take(TRIES).find(|&try_| passes(try_))?;
        let mut failed = passed / NEXT_TRY;
        for _ in 0..HALVINGS {
            let middle = failed + (passed - failed) / 2.0;
            if passes(middle) {
                passed = middle;
            } else {
                failed = middle;
            }
        }
        Some(passed)
    }
}

/// Durations, all above zero.
#[derive(Debug, Default)]
struct Durations {
    all: [f64; Self::MOST],
    count: usize,
}

impl Durations {
    /// Lower bound, and two solutions for each of eight equations.
    const MOST: usize = 17;

    fn add(&mut self, duration: f64) {
        // Roots below zero or at infinity are no durations, and NaN is none either.
        if duration > 0.0 && duration.is_finite() && self.count < Self::MOST {
            self.all[self.count] = duration;
            self.count += 1;
        }
    }

    /// Adds the solutions of a·T² + b·T + c = 0 above zero, plus a small margin.
    fn solve(&mut self, a: f64, b: f64, c: f64) {
        let square = b * b - 4.0 * a * c;
        // The limit is not reached at any duration.
        if square < 0.0 {
            return;
        }
        // The larger one of the two sums: no cancellation.
        let q = -0.5 * (b + libm::sqrt(square).copysign(b));
        // For a = 0, the linear equation, the first is infinite and the second is its solution.
        for root in [q / a, c / q] {
            self.add(root * (1.0 + ROUNDING));
        }
    }

    fn in_order(&mut self) -> &[f64] {
        let all = &mut self.all[..self.count];
        all.sort_unstable_by(f64::total_cmp);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::SyncMask;
    use super::*;
    use proptest::prelude::*;

    fn limits(acceleration: f64, deceleration: f64, jerk: f64) -> Checklist {
        Checklist {
            mask: SyncMask::MAX_ACC | SyncMask::MAX_DEC | SyncMask::MAX_JERK,
            velocity: f64::INFINITY,
            acceleration,
            deceleration,
            jerk,
            software: (f64::NEG_INFINITY, f64::INFINITY),
            optional: (f64::NEG_INFINITY, f64::INFINITY),
            forward: true,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        /// Over a master at a velocity of one, so that its position is the time.
        #[test]
        fn nothing_shorter_is_found_by_looking_for_it(
            (from, to) in (0.0..1e3_f64, 0.0..1e3_f64), backwards in any::<bool>(),
            (up, down, jerk) in (10.0..1e4_f64, 10.0..1e4_f64, 10.0..1e6_f64), share in -1.0..1.0_f64,
        ) {
            let limits = limits(up, down, jerk);
            let sign = if backwards { -1.0 } else { 1.0 };
            let change = VelocityRise { velocity: (sign * from, sign * to), acceleration: share * up.min(down) };
            let passes = |duration: f64| {
                let (slope, curvature) = (change.velocity.0, change.acceleration);
                let ramp = PathPiece::curved_ramp(0.0, duration, 0.0, (slope, curvature), change.velocity.1);
                limits.dynamics(&ramp.demands(1.0)).is_ok()
            };
            if let Some(found) = change.at_its_limits(&limits, passes) {
                prop_assert!(passes(found));
                let search = change.search(&limits, passes);
                prop_assert!(search.is_none_or(|other| found <= other * (1.0 + 1e-9)), "{found} {search:?}");
            }
        }
    }

    #[test]
    fn a_change_without_a_reversal_has_its_limits() {
        let change = VelocityRise {
            velocity: (250.0, 500.0),
            acceleration: 500.0,
        };
        let limits = limits(2_500.0, 2_500.0, 5_000.0);
        let found = change
            .at_its_limits(&limits, |_| true)
            .expect("there is one");
        // The jerk at the end is at its limit: j·T² + 2·a0·T = 6·Δv.
        let expected = (-1_000.0 + libm::sqrt(1e6 + 4.0 * 5_000.0 * 1_500.0)) / 1e4;
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}
