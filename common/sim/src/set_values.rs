//! Check that the set positions of an axis keep its limits, by their differences.

use coaxle_curve::profile::Limits;

/// Rounding of a calculated position, relative to the largest number on the way.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Rounding of a limit in addition, relative.
const RELATIVE: f64 = 1e-9;

/// Time at the highest velocity whose distance is the largest number in the calculation of a position, s.
const WAY: f64 = 1.0;

/// Rounding of a software limit, relative to the largest number on the way.
const WALL_ROUNDING: f64 = 128.0 * f64::EPSILON;

/// Bounds of every set position of an axis with limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SetValueBound {
    /// Finite number.
    Finite,
    /// First difference within the velocity.
    Velocity,
    /// Second difference within the acceleration and the deceleration, whichever is larger.
    Acceleration,
    /// Third difference within the jerk.
    Jerk,
    /// Position within the software limits; from beyond one, no farther out.
    SoftwareLimit,
}

/// A bound that a set position does not keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess {
    /// The bound.
    pub bound: SetValueBound,
    /// Value found: u, u/s, u/s² or u/s³, as a magnitude except for positions.
    pub value: f64,
    /// Value allowed, without rounding.
    pub limit: f64,
}

/// Monitors the set positions of one axis.
///
/// Velocity, acceleration and jerk are the divided differences of the last two, three and four
/// positions, times 1, 2 and 6. Each is a weighted mean of the derivative over the time that it
/// spans, so a motion that keeps a limit keeps it in them too, for any skipped cycles: only
/// rounding is allowed in addition. With `δ = 4ε·max(|p|, vmax·1 s)` and the cycle time `T` that is
/// `δ/T` on the velocity, `2δ/T²` on the acceleration, `4δ/T³` on the jerk, `32δ` on a software
/// limit, and 1e-9 of each but the last.
///
/// ```
/// use coaxle_curve::profile::Limits;
/// use coaxle_sim::{SetValueBound, SetValueCheck};
///
/// let limits = Limits::new(100.0, 1_000.0, 1_000.0, 50_000.0)?;
/// let mut check = SetValueCheck::new(&limits, [f64::NEG_INFINITY, 400.0], 1e-3);
/// let mut found = Vec::new();
/// for position in [0.0, 0.05, 0.10, 0.15, 0.2005] {
///     check.push(position, 1, |excess| found.push((excess.bound, excess.value.round())));
/// }
/// // 0.5 µm more than the velocity accounts for.
/// assert_eq!(found, [(SetValueBound::Jerk, 500_000.0)]);
/// # Ok::<(), coaxle_curve::profile::InvalidLimit>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SetValueCheck {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    min: f64,
    max: f64,
    cycle_time: f64,
    /// The last positions, newest first, and the number of known ones.
    last: [f64; 3],
    known: u8,
    /// The last velocity and acceleration, as far as the positions determine them.
    velocity_before: f64,
    acceleration_before: f64,
    /// The cycles between the last two positions, and between the two before.
    cycles: [f64; 2],
    /// Positions since the jerk was free.
    since_free: u8,
    largest: Shares,
}

/// The largest values, as shares of the limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    /// Share of the velocity.
    pub velocity: f64,
    /// Share of the larger of acceleration and deceleration.
    pub acceleration: f64,
    /// Share of the jerk.
    pub jerk: f64,
}

impl SetValueCheck {
    /// Creates the check of an axis with these limits, u/s, u/s² and u/s³, and software limits, u:
    /// infinite if there is none. Its cycle time is in s.
    #[must_use]
    pub fn new(limits: &Limits, [min, max]: [f64; 2], cycle_time: f64) -> Self {
        Self {
            velocity: limits.velocity(),
            acceleration: limits.acceleration().max(limits.deceleration()),
            jerk: limits.jerk(),
            min,
            max,
            cycle_time,
            last: [0.0; 3],
            known: 0,
            velocity_before: 0.0,
            acceleration_before: 0.0,
            cycles: [1.0; 2],
            since_free: 0,
            largest: Shares::default(),
        }
    }

    /// Restarts the check: the next position is a preset, because the axis was switched on, homed
    /// or reset.
    pub const fn restart(&mut self) {
        self.known = 0;
        self.since_free = 0;
    }

    /// Permits any jerk at the next position: differences of four positions with it are not checked.
    pub const fn free_jerk(&mut self) {
        self.since_free = 0;
    }

    /// Takes the next set position, u, `cycles` cycles after the one before. Reports each exceeded bound.
    pub fn push(&mut self, position: f64, cycles: u32, mut exceeded: impl FnMut(Excess)) {
        if !position.is_finite() {
            // Differences with a position that is no number would report every bound in the next three cycles.
            self.restart();
            exceeded(Excess {
                bound: SetValueBound::Finite,
                value: position,
                limit: f64::MAX,
            });
            return;
        }
        self.check_software_limits(position, &mut exceeded);
        if self.known > 0 {
            self.check_differences(position, f64::from(cycles.max(1)), &mut exceeded);
        }
        self.last = [position, self.last[0], self.last[1]];
        self.known = (self.known + 1).min(3);
        self.since_free = (self.since_free + 1).min(4);
    }

    /// The largest values since the start, including excesses and rounding.
    #[must_use]
    pub const fn largest(&self) -> Shares {
        self.largest
    }

    fn check_differences(&mut self, position: f64, cycles: f64, exceeded: &mut impl FnMut(Excess)) {
        let time = self.cycle_time;
        let [before, first] = self.cycles;
        let two = cycles + before;
        let three = two + first;
        let rounding = self.rounding(position) / time;
        let mut check = |bound, value: f64, limit: f64, rounding: f64, share: &mut f64| {
            let value = value.abs();
            *share = share.max(value / limit);
            // Infinite minus infinite is NaN, which exceeds nothing by comparison.
            if value > limit * (1.0 + RELATIVE) + rounding || value.is_nan() {
                exceeded(Excess {
                    bound,
                    value,
                    limit,
                });
            }
        };
        let velocity = (position - self.last[0]) / (cycles * time);
        // Divided differences times 2: (v₁ - v₀)·2/(t₁ + t₀), and times 6 in all for the jerk: 2·3.
        let acceleration = (velocity - self.velocity_before) * 2.0 / (two * time);
        let jerk = (acceleration - self.acceleration_before) * 3.0 / (three * time);
        let (largest, known) = (&mut self.largest, self.known);
        check(
            SetValueBound::Velocity,
            velocity,
            self.velocity,
            rounding,
            &mut largest.velocity,
        );
        if known >= 2 {
            check(
                SetValueBound::Acceleration,
                acceleration,
                self.acceleration,
                2.0 * rounding / time,
                &mut largest.acceleration,
            );
        }
        // Four positions make a third difference, and none of its cycles may be one of free jerk.
        if known >= 3 && self.since_free >= 3 {
            check(
                SetValueBound::Jerk,
                jerk,
                self.jerk,
                4.0 * rounding / (time * time),
                &mut largest.jerk,
            );
        }
        (self.velocity_before, self.acceleration_before) = (velocity, acceleration);
        self.cycles = [cycles, before];
    }

    fn check_software_limits(&self, position: f64, exceeded: &mut impl FnMut(Excess)) {
        let (mut low, mut high) = (self.min, self.max);
        if self.known > 0 {
            // An axis beyond a limit is to return: the last position is its limit then.
            (low, high) = (low.min(self.last[0]), high.max(self.last[0]));
        }
        let rounding = WALL_ROUNDING / ROUNDING * self.rounding(position);
        let limit = if position < low - rounding {
            self.min
        } else if position > high + rounding {
            self.max
        } else {
            return;
        };
        exceeded(Excess {
            bound: SetValueBound::SoftwareLimit,
            value: position,
            limit,
        });
    }

    /// Greatest rounding of one of the current positions, u.
    fn rounding(&self, position: f64) -> f64 {
        let known = self.last.iter().take(self.known.into());
        let largest = known.fold(position.abs(), |most, last| most.max(last.abs()));
        ROUNDING * largest.max(WAY * self.velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::SetValueBound::{Acceleration, Finite, Jerk, SoftwareLimit, Velocity};
    use super::*;
    use coaxle_clock::Seconds;
    use coaxle_curve::profile::{Kinematics, Profile, to_position, to_velocity};
    use proptest::prelude::*;

    const T: f64 = 1e-3;

    fn limits() -> Limits {
        Limits::new(100.0, 1_000.0, 2_000.0, 50_000.0).unwrap()
    }

    fn check() -> SetValueCheck {
        SetValueCheck::new(&limits(), [f64::NEG_INFINITY, f64::INFINITY], T)
    }

    /// Exceeded bounds in positions, each with its number of cycles after the one before.
    fn found(check: &mut SetValueCheck, positions: &[(f64, u32)]) -> Vec<SetValueBound> {
        let mut found = Vec::new();
        for (position, cycles) in positions {
            check.push(*position, *cycles, |excess| found.push(excess.bound));
        }
        found
    }

    fn each_cycle(positions: &[f64]) -> Vec<(f64, u32)> {
        positions.iter().map(|position| (*position, 1)).collect()
    }

    #[test]
    fn each_limit_is_found_by_its_own_difference() {
        // Positions of which only the k-th difference is 1.01 times the limit.
        let sums = |mut differences: Vec<f64>, order: usize| {
            for _ in 0..order {
                let mut sum = 0.0;
                for difference in &mut differences {
                    sum += *difference;
                    *difference = sum;
                }
            }
            each_cycle(&differences)
        };
        let one = |size: f64| vec![0.0, 0.0, 0.0, size, 0.0, 0.0];
        let free = Limits::new(1e9, 1e12, 1e12, 1e15).unwrap();
        for (bound, order, size, limits) in [
            (
                Velocity,
                1,
                100.0 * T,
                Limits::new(100.0, 1e12, 1e12, 1e15).unwrap(),
            ),
            (
                Acceleration,
                2,
                2_000.0 * T * T,
                Limits::new(1e9, 1_000.0, 2_000.0, 1e15).unwrap(),
            ),
            (
                Jerk,
                3,
                50_000.0 * T * T * T,
                Limits::new(1e9, 1e12, 1e12, 50_000.0).unwrap(),
            ),
        ] {
            // The highest velocity determines the resolution of positions.
            let velocity = limits.velocity().min(100.0);
            let limits = limits.with_velocity(velocity).unwrap();
            let none = [f64::NEG_INFINITY, f64::INFINITY];
            let of = |limits: &Limits, size: f64| {
                let positions = sums(one(size), order);
                found(&mut SetValueCheck::new(limits, none, T), &positions)
            };
            assert_eq!(of(&limits, 1.01 * size), [bound]);
            assert_eq!(of(&limits, size), []);
            assert_eq!(of(&limits, -1.01 * size), [bound]);
            assert_eq!(of(&free, 1.01 * size), []);
        }
    }

    #[test]
    fn what_is_no_number_is_found_and_is_no_history() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let positions = each_cycle(&[0.0, 0.0, 0.0, bad, 7.0, 7.0, 7.0, 7.0]);
            assert_eq!(found(&mut check(), &positions), [Finite]);
        }
    }

    #[test]
    fn a_restart_forgets_where_the_axis_was() {
        let mut check = check();
        assert_eq!(found(&mut check, &each_cycle(&[0.0; 4])), []);
        check.restart();
        assert_eq!(found(&mut check, &each_cycle(&[50.0; 4])), []);
        assert_eq!(
            found(&mut check, &each_cycle(&[51.0])),
            [Velocity, Acceleration, Jerk]
        );
    }

    #[test]
    fn a_stop_with_any_jerk_keeps_the_acceleration() {
        // From 10 u/s with the full deceleration from one cycle to the next.
        let mut check = check();
        let at = |k: f64| 10.0 * T * k;
        assert_eq!(
            found(&mut check, &each_cycle(&[at(0.0), at(1.0), at(2.0)])),
            []
        );
        let mut stops = check;
        let mut velocity = 10.0;
        let mut position = at(2.0);
        let mut next = || {
            velocity = f64::max(0.0, velocity - 2_000.0 * T);
            position += velocity * T;
            position
        };
        let ways: Vec<f64> = (0..10).map(|_| next()).collect();
        assert!(found(&mut check, &each_cycle(&ways)).contains(&Jerk));
        for way in &ways {
            stops.free_jerk();
            assert_eq!(found(&mut stops, &each_cycle(&[*way])), []);
        }
        // Three positions later no difference contains it.
        let rest = position;
        assert_eq!(
            found(&mut stops, &each_cycle(&[rest, rest, rest, rest])),
            []
        );
        let step = rest + 0.5 * 2_000.0 * T * T;
        assert_eq!(found(&mut stops, &each_cycle(&[step])), [Jerk]);
    }

    #[test]
    fn software_limits_may_be_touched_and_left_but_not_passed() {
        let mut check = SetValueCheck::new(&limits(), [-1.0, 1.0], T);
        let way = [0.999_99, 0.999_999, 1.0, 1.0, 1.0 + 1e-14, 0.999_999];
        assert_eq!(found(&mut check, &each_cycle(&way)), []);
        // From beyond a limit it may return.
        for side in [1.0, -1.0] {
            check.restart();
            let mut first = each_cycle(&[side * 1.5]);
            assert_eq!(found(&mut check, &first), [SoftwareLimit]);
            first = each_cycle(&[side * 1.499_999]);
            assert_eq!(found(&mut check, &first), []);
            first = each_cycle(&[side * 1.499_999_5]);
            assert_eq!(found(&mut check, &first), [SoftwareLimit]);
        }
    }

    #[test]
    fn the_largest_shares_are_kept() {
        let mut check = check();
        let way = [0.0, 0.0, 0.0, 0.5e-3 * T, 1e-3 * T];
        let _ = found(&mut check, &each_cycle(&way));
        let Shares {
            velocity,
            acceleration,
            jerk,
        } = check.largest();
        assert!((velocity - 0.5e-3 / 100.0).abs() < 1e-9);
        assert!((acceleration - 0.5 / 2_000.0).abs() < 1e-9);
        assert!((jerk - 500.0 / 50_000.0).abs() < 1e-6);
    }

    proptest! {
        /// Motions that use their limits fully, sampled at any of their cycles, far from zero.
        #[test]
        fn a_motion_that_keeps_its_limits_passes_whatever_cycles_were_skipped(
            offset in -1e4..1e4f64,
            from in -90.0..90.0f64,
            way in prop::option::of(-40.0..40.0f64),
            skipped in prop::collection::vec(1..30u32, 1..400),
        ) {
            let start = Kinematics { position: offset, velocity: from, acceleration: 0.0 };
            // The acceleration limit of such a motion, in both directions.
            let limits = Limits::new(100.0, 1_000.0, 1_000.0, 50_000.0).unwrap();
            let profile: Profile = match way {
                Some(way) => to_position(&start, offset + way, &limits),
                None => to_velocity(&start, -from, &limits),
            };
            let mut check = SetValueCheck::new(&limits, [f64::NEG_INFINITY, f64::INFINITY], T);
            let mut now = 0;
            for cycles in std::iter::once(0).chain(skipped) {
                now += cycles;
                let position = profile.at(Seconds(f64::from(now) * T)).position;
                let mut excess = None;
                check.push(position, cycles, |found| excess = Some(found));
                prop_assert_eq!(excess, None);
            }
        }
    }
}
