//! Check that the reported velocity and acceleration of an axis match its reported positions.

use coaxle_axis::set_value_guard::PACE;
use coaxle_curve::profile::{Kinematics, Limits};

/// Rounding of a calculated position, relative to the largest number on the way, and of a limit,
/// relative: as for the set positions themselves.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
const RELATIVE: f64 = 1e-9;
/// Tolerance of accelerations in units of a cycle of the jerk: a target and its limited version may
/// follow each other, so that accelerations of two motions are compared, each with its own
/// deviation from its positions.
const MOTIONS: f64 = 2.0;
/// Tolerance of two velocities against their positions, in units of the velocity change by the jerk
/// of a cycle.
const VELOCITIES: f64 = 1.0;
/// Tolerance of two velocities in units of the velocity change by the acceleration limit in a
/// cycle, if no jerk limit applies. An acceleration that reverses from one cycle to the next shifts
/// the mean of two velocities by ½, and each velocity may deviate from its positions by 1.
const FREE: f64 = 1.5;
/// Time at the highest velocity whose distance is the largest number in the calculation of a position, s.
const WAY: f64 = 1.0;

/// Compares the velocity and the acceleration reported with the set positions with the differences
/// of these.
///
/// A drive feeds both forward. With the time `t` since the cycle before, jerk limit `j` and acceleration limit `a`:
///
/// * The mean of two velocities is the distance between the positions over `t`, to `j·t²`: the
///   trapezoidal rule is off by `j·t²/12` on a motion with that jerk, the half cycle of a
///   difference by `j·t²/4`, and a velocity may deviate by `½·j·t²`, or by more if the next one
///   cannot compensate while the acceleration grows. A slewed master adds its [pace](PACE) of the
///   velocity. That deviation decreases by `a·t − |Δ|` in a cycle whose positions change their velocity by `Δ`: the reported one
///   changes by at most `a·t`, and has to follow them. In wide schedules 500360 and 503539 a gear followed its master at −305 u/s, 1 %
///   beside its positions, and had to reverse with all of its acceleration; in 700308 with nine tenths of it in one of the cycles. Velocities after skipped cycles, and in the cycle after that, may use all that the
///   limits admit within those: three positions that far apart do not show where in between the
///   axis was accelerated. From a cycle later on that deviation decreases in the same way. In swarm schedule 4957 an axis reversed after
///   135 skipped cycles with all of its acceleration, which left nothing to compensate it.
/// * An acceleration is the second difference, to twice `j` times the time from it to the middle of
///   the three positions, which is `t` for equal cycles.
/// * Both keep their limits, and the velocity changes from cycle to cycle by at most `a·t` plus the
///   tolerance of the first point.
///
/// The pace is a property of the master, which the guard of an axis assumes as well; the check
/// assumes no other property of the guard.
///
/// While the jerk is free, or too high to matter, the tolerances are `1½·a·t` and `2·a` instead.
#[derive(Clone, Copy, Debug)]
pub struct ReportedCheck {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    cycle_time: f64,
    /// The newest set values, and the difference of their position to the one before.
    last: Option<Kinematics>,
    difference: Option<Difference>,
    /// The times that were skipped before the newest differences, s.
    skipped: [f64; 3],
    /// Positions since the jerk was free.
    since_free: u8,
    /// Deviation of the velocity, by the pace or by skipped cycles, that could not be compensated yet, u/s.
    uncompensated: f64,
}

/// A velocity by two positions, u/s, and the time between them, s.
#[derive(Clone, Copy, Debug)]
struct Difference {
    velocity: f64,
    time: f64,
}

/// A reported value that does not match the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportedMismatch {
    /// The value concerned.
    pub what: ReportedValue,
    /// Deviation from the positions, or the value itself if beyond a limit: u/s, u/s².
    pub value: f64,
    /// Allowed deviation or limit, without rounding.
    pub limit: f64,
}

/// A value that an axis reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportedValue {
    /// Velocity, or its change.
    Velocity,
    /// Acceleration of the axis.
    Acceleration,
}

impl ReportedCheck {
    /// Creates the check of an axis with these limits, in a node of this cycle time, s.
    #[must_use]
    pub fn new(limits: &Limits, cycle_time: f64) -> Self {
        Self {
            velocity: limits.velocity(),
            acceleration: limits.acceleration().max(limits.deceleration()),
            jerk: limits.jerk(),
            cycle_time,
            last: None,
            difference: None,
            skipped: [0.0; 3],
            since_free: 0,
            uncompensated: 0.0,
        }
    }

    /// Restarts the check: the next set values are a preset, because the axis was switched on,
    /// homed or reset.
    pub const fn restart(&mut self) {
        self.last = None;
        self.difference = None;
        self.skipped = [0.0; 3];
        self.since_free = 0;
        self.uncompensated = 0.0;
    }

    /// Permits any jerk at the next set values.
    pub const fn free_jerk(&mut self) {
        self.since_free = 0;
    }

    /// Takes the next set values, a number of cycles after those before. Returns the fault of each
    /// of the two reported values.
    pub fn push(&mut self, set: &Kinematics, cycles: u32) -> [Option<ReportedMismatch>; 2] {
        let is_finite = [set.position, set.velocity, set.acceleration]
            .iter()
            .all(|value| value.is_finite());
        let Some(last) = self.last.replace(*set).filter(|_| is_finite) else {
            self.difference = None;
            self.since_free = 0;
            self.last = is_finite.then_some(*set);
            return [None; 2];
        };
        let time = f64::from(cycles.max(1)) * self.cycle_time;
        let now = Difference {
            velocity: (set.position - last.position) / time,
            time,
        };
        let before = self.difference.replace(now);
        let skipped = before.map_or(0.0, |before| before.time - self.cycle_time);
        self.skipped = [skipped, self.skipped[0], self.skipped[1]];
        // Divided as the positions are: of a velocity, and again below for an acceleration.
        let rounding = self.rounding(set, &last) / time;
        self.uncompensated = self.left_over(set, &last, now, before);
        let found = [
            self.of_velocity(set, &last, now, rounding),
            before.and_then(|before| self.of_acceleration(set, now, before, rounding)),
        ];
        if self.skipped.iter().any(|time| *time > 0.0) {
            let deviation = now.velocity - 0.5 * (set.velocity + last.velocity);
            self.uncompensated = self.uncompensated.max(deviation.abs());
        }
        self.since_free = (self.since_free + 1).min(4);
        found
    }

    /// The deviation that this cycle can have left, u/s.
    fn left_over(
        &self,
        set: &Kinematics,
        last: &Kinematics,
        now: Difference,
        before: Option<Difference>,
    ) -> f64 {
        let compensated = before.map_or(f64::INFINITY, |before| {
            // Two differences are velocities of the middles of their times.
            let most = 0.5 * self.acceleration * (now.time + before.time);
            (most - (now.velocity - before.velocity).abs()).max(0.0)
        });
        let velocities = [now.velocity, set.velocity, last.velocity];
        let fastest = velocities
            .into_iter()
            .fold(0.0_f64, |most, velocity| most.max(velocity.abs()));
        (self.uncompensated - compensated).max(PACE * fastest)
    }

    fn of_velocity(
        &self,
        set: &Kinematics,
        last: &Kinematics,
        now: Difference,
        rounding: f64,
    ) -> Option<ReportedMismatch> {
        // The longest gap among the last ones counts: the axis may have used its limits anywhere within it.
        let time = now.time + self.skipped.into_iter().fold(0.0, f64::max);
        let by_acceleration = self.acceleration * time;
        let free = FREE * by_acceleration;
        let by_jerk = match self.has_jerk() {
            // A jerk too high to matter would otherwise allow more than the acceleration limit can cause.
            true => free.min(VELOCITIES * self.jerk * time * time),
            false => free,
        };
        // A slewed master runs at another pace than its velocities, by at most this share.
        let beside = by_jerk + self.uncompensated;
        let found = |value: f64, limit: f64, more: f64| {
            let most = limit + more + RELATIVE * self.velocity + rounding;
            (value > most).then_some(ReportedMismatch {
                what: ReportedValue::Velocity,
                value,
                limit,
            })
        };
        let mean = 0.5 * (set.velocity + last.velocity);
        let step = (set.velocity - last.velocity).abs();
        found((now.velocity - mean).abs(), beside, 0.0)
            // Order by cause: a velocity that does not match its positions mostly exceeds its
            // limit as well.
            .or_else(|| found(set.velocity.abs(), self.velocity, beside))
            .or_else(|| found(step, by_acceleration, beside))
    }

    fn of_acceleration(
        &self,
        set: &Kinematics,
        now: Difference,
        before: Difference,
        rounding: f64,
    ) -> Option<ReportedMismatch> {
        let spanned = now.time + before.time;
        // Second divided difference for unequal cycles: 2·(v₁ - v₀)/(t₁ + t₀).
        let second = 2.0 * (now.velocity - before.velocity) / spanned;
        // Mean of the three instants 0, -t₁ and -(t₁ + t₀), to which a second difference belongs.
        let to_middle = (2.0 * now.time + before.time) / 3.0;
        let most = 2.0 * self.acceleration;
        let beside = match self.has_jerk() {
            true => most.min(MOTIONS * self.jerk * to_middle),
            false => most,
        };
        let found = |value: f64, limit: f64, more: f64| {
            // Both velocities are off by up to r = `rounding`: 2·(r + r) over the time that they span.
            let rounding = RELATIVE * self.acceleration + 4.0 * rounding / spanned;
            (value > limit * (1.0 + RELATIVE) + more + rounding).then_some(ReportedMismatch {
                what: ReportedValue::Acceleration,
                value,
                limit,
            })
        };
        // The pace changes velocity and time alike, so that it enters twice.
        let slewed = 2.0 * PACE * second.abs();
        found((set.acceleration - second).abs(), beside + slewed, 0.0)
            .or_else(|| found(set.acceleration.abs(), self.acceleration, beside))
    }

    const fn has_jerk(&self) -> bool {
        // Three positions after the free one span only cycles in which the jerk was bounded.
        self.since_free >= 3
    }

    /// Greatest rounding of one of the current positions, u.
    fn rounding(&self, set: &Kinematics, last: &Kinematics) -> f64 {
        let largest = set.position.abs().max(last.position.abs());
        4.0 * ROUNDING * largest.max(WAY * self.velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::Seconds;
    use coaxle_curve::profile::{Profile, to_position};
    use proptest::prelude::*;

    const T: f64 = 1e-3;

    fn limits() -> Limits {
        Limits::new(1_000.0, 5_000.0, 5_000.0, 1e5).unwrap()
    }

    fn set(position: f64, velocity: f64, acceleration: f64) -> Kinematics {
        Kinematics {
            position,
            velocity,
            acceleration,
        }
    }

    /// Faults in the last of these set values.
    fn found(all: &[Kinematics]) -> [Option<ReportedMismatch>; 2] {
        let mut check = ReportedCheck::new(&limits(), T);
        let mut last = [None; 2];
        for set in all {
            last = check.push(set, 1);
        }
        last
    }

    #[test]
    fn a_slave_that_stands_is_not_told_the_velocity_of_its_master() {
        let reported = [set(7.0, 500.0, 0.0); 5];
        let [velocity, acceleration] = found(&reported);
        let velocity = velocity.expect("it stands");
        assert_eq!(
            (velocity.what, velocity.value),
            (ReportedValue::Velocity, 500.0)
        );
        assert!((velocity.limit - 15.1).abs() < 1e-9);
        assert_eq!(acceleration, None);
    }

    #[test]
    fn a_velocity_that_steps_is_found_where_positions_do_not_show_it() {
        // Half a cycle of the step is within the error of the trapezoidal rule here.
        let coarse = Limits::new(1_000.0, 5_000.0, 5_000.0, 1e9).unwrap();
        let mut check = ReportedCheck::new(&coarse, T);
        for velocity in [0.0, 0.0, 0.0, 0.0] {
            assert_eq!(check.push(&set(0.0, velocity, 0.0), 1), [None; 2]);
        }
        let [velocity, _] = check.push(&set(0.0, 500.0, 0.0), 1);
        assert_eq!(
            velocity.map(|reported| reported.what),
            Some(ReportedValue::Velocity)
        );
    }

    #[test]
    fn an_acceleration_beside_the_second_difference_is_found() {
        let reported = |acceleration| [set(7.0, 0.0, acceleration); 5];
        assert_eq!(found(&reported(199.0)), [None; 2]);
        let [_, acceleration] = found(&reported(310.0));
        let acceleration = acceleration.expect("3 times the jerk of a cycle");
        assert_eq!(acceleration.value, 310.0);
        assert!((acceleration.limit - 200.0).abs() < 1e-9);
    }

    /// Wide schedules 500360 and 503539: an axis whose velocity is beside its positions by less than the pace of its master brakes with all of
    /// its acceleration.
    #[test]
    fn a_deviation_by_the_pace_stays_while_the_acceleration_is_at_its_limit() {
        let faults = |acceleration: f64, cycles: i32| {
            let mut check = ReportedCheck::new(&limits(), T);
            let mut found = 0;
            let (mut position, mut velocity) = (0.0, 300.0);
            for cycle in -10..cycles {
                let braking = if cycle < 0 { 0.0 } else { acceleration };
                position += (velocity - 0.5 * braking * T) * T;
                velocity -= braking * T;
                let [of_velocity, _] = check.push(&set(position, velocity + 8.0, -braking), 1);
                found += usize::from(of_velocity.is_some());
            }
            found
        };
        // 8 u/s are 2.7 % of 300 u/s, and 8 % of 100.
        assert_eq!(faults(5_000.0, 40), 0);
        // With less than all of it the velocity can compensate, by the difference.
        assert!(faults(2_500.0, 80) > 10);
        assert_eq!(faults(4_990.0, 40), 0);
    }

    /// An axis at rest whose stated velocity is `velocity` in the last cycles, as many as there are limits to compare it by.
    fn standing(check: &mut ReportedCheck, velocity: &[f64]) -> Vec<bool> {
        let found = velocity.iter().map(|velocity| {
            let [found, _] = check.push(&set(7.0, *velocity, 0.0), 1);
            found.is_some()
        });
        found.collect()
    }

    /// A velocity that deviates from its positions by the jerk of one cycle may be that of a motion; one of a cycle later is
    /// not.
    #[test]
    fn a_velocity_of_another_cycle_is_found_where_the_jerk_binds() {
        // 1e5 u/s³ make 0.1 u/s of a cycle, and the pace 3 % of the velocity.
        let reported = |velocity: f64| {
            let mut check = ReportedCheck::new(&limits(), T);
            let _ = standing(&mut check, &[0.0; 5]);
            standing(&mut check, &[0.5 * velocity, velocity, velocity])
        };
        assert_eq!(reported(0.099), [false; 3]);
        assert_eq!(reported(0.105), [false, false, true]);
        let late = |cycles: f64| {
            let start = set(0.0, 0.0, 0.0);
            let profile: Profile = to_position(&start, 400.0, &limits());
            let mut check = ReportedCheck::new(&limits(), T);
            (0..200).any(|k| {
                let at = |cycle: f64| profile.at(Seconds(cycle * T));
                let reported = Kinematics {
                    velocity: at(f64::from(k) + cycles).velocity,
                    ..at(f64::from(k))
                };
                check.push(&reported, 1) != [None; 2]
            })
        };
        assert!(!late(0.0));
        assert!(late(1.0) && late(-1.0));
    }

    /// An acceleration may reverse from one cycle to the next where no jerk limit binds.
    #[test]
    fn a_velocity_beside_its_positions_is_found_where_the_jerk_is_free() {
        let coarse = Limits::new(1_000.0, 5_000.0, 5_000.0, 1e9).unwrap();
        // 5 000 u/s² make 5 u/s of a cycle, and the velocity may deviate by 1½ of these; it then changes as fast as it may.
        let reported = |velocity: f64| {
            let mut check = ReportedCheck::new(&coarse, T);
            let _ = standing(&mut check, &[0.0; 5]);
            standing(&mut check, &[4.0, velocity, velocity])
        };
        assert_eq!(reported(7.4), [false; 3]);
        assert_eq!(reported(7.8), [false, false, true]);
        // All along the limit, there and back again, each turn in the middle of a cycle.
        let mut check = ReportedCheck::new(&coarse, T);
        let turns = |k: u32| {
            let (t, half) = (T * (f64::from(k % 8) + 0.5), 4.0 * T);
            let (away, sign) = if t < half { (t, 1.0) } else { (t - half, -1.0) };
            let velocity = 5_000.0 * sign * (away - 0.5 * half);
            set(
                2_500.0 * sign * away * (away - half),
                velocity,
                5_000.0 * sign,
            )
        };
        assert!((0..100).all(|k| check.push(&turns(k), 1)[0].is_none()));
    }

    /// After skipped cycles a velocity is compared within the limits over these cycles, for three differences and no more.
    #[test]
    fn what_was_skipped_is_made_up_for_within_three_cycles() {
        // Nine cycles of the jerk make 8.1 u/s.
        let after = |velocity: f64, cycles: usize| {
            let mut check = ReportedCheck::new(&limits(), T);
            let _ = standing(&mut check, &[0.0; 5]);
            let _ = check.push(&set(7.0, 0.0, 0.0), 9);
            standing(&mut check, &[velocity; 4][..cycles])
        };
        assert_eq!(after(8.0, 3), [false; 3]);
        assert_eq!(after(8.0, 4), [false, false, false, true]);
        assert_eq!(after(8.6, 2), [false, true]);
    }

    /// Swarm schedule 4957: after skipped cycles an axis reverses with all of its acceleration.
    #[test]
    fn what_was_skipped_stays_while_the_acceleration_is_at_its_limit() {
        let faults = |acceleration: f64, cycles: i32| {
            let mut check = ReportedCheck::new(&limits(), T);
            let _ = check.push(&set(0.0, 0.0, 0.0), 1);
            let (mut position, mut velocity) = (0.0, -100.0);
            let mut found = 0;
            for cycle in 0..cycles {
                position += (velocity + 0.5 * acceleration * T) * T;
                velocity += acceleration * T;
                let skipped = if cycle == 0 { 9 } else { 1 };
                let reported = set(position, velocity + 6.0, acceleration);
                let [of_velocity, _] = check.push(&reported, skipped);
                found += usize::from(of_velocity.is_some());
            }
            found
        };
        assert_eq!(faults(5_000.0, 20), 0);
        assert!(faults(2_500.0, 20) > 10);
    }

    #[test]
    fn what_is_set_anew_is_no_step() {
        let mut check = ReportedCheck::new(&limits(), T);
        check.push(&set(0.0, 0.0, 0.0), 1);
        check.restart();
        assert_eq!(check.push(&set(90.0, 0.0, 0.0), 1), [None; 2]);
    }

    proptest! {
        #[test]
        fn a_motion_tells_what_it_does_whatever_cycles_were_skipped(
            offset in -1e4..1e4f64,
            from in -900.0..900.0f64,
            way in -400.0..400.0f64,
            skipped in prop::collection::vec(1..9u32, 1..300),
        ) {
            let start = set(offset, from, 0.0);
            let profile: Profile = to_position(&start, offset + way, &limits());
            let mut check = ReportedCheck::new(&limits(), T);
            let mut now = 0;
            for cycles in std::iter::once(0).chain(skipped) {
                now += cycles;
                let set = profile.at(Seconds(f64::from(now) * T));
                prop_assert_eq!(check.push(&set, cycles), [None; 2]);
            }
        }
    }
}
