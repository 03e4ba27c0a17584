//! Set values that a drive is given later than they were calculated.
//!
//! A node that follows an axis which is shown later may calculate its slaves earlier than they are shown, so that
//! others can follow them in time. Each set value then waits for its instant: a drive shows at `t + hold-back` what was
//! calculated at `t`.

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;

use crate::waiting::{SLEW, WaitingSets};

/// Greatest number of cycles by which set values can be held back.
// A second of cycles of a millisecond, beyond which no operator waits; 32 kB.
pub const MOST_HELD_BACK: u32 = 1_000;

/// Waiting set values of a drive, in the drive's own positions.
#[derive(Debug)]
pub(crate) struct HeldBack {
    waiting: WaitingSets,
    /// Hold-back in force; zero where set values are shown at once.
    by: Span,
    shown: Kinematics,
}

impl HeldBack {
    /// Creates the place of waiting set values, which are shown at once at first.
    pub(crate) fn new() -> Self {
        Self {
            waiting: WaitingSets::new(MOST_HELD_BACK),
            by: Span::ZERO,
            shown: Kinematics::at_rest(0.0),
        }
    }

    /// Hold-back in force; zero where set values are shown at once.
    pub(crate) const fn by(&self) -> Span {
        self.by
    }

    /// Set values shown in the newest cycle, if they are held back.
    pub(crate) fn shown(&self) -> Option<&Kinematics> {
        (self.by > Span::ZERO).then_some(&self.shown)
    }

    /// True if what waits is what is shown, and stands.
    pub(crate) fn is_quiet(&self) -> bool {
        self.waiting
            .are_all(&Kinematics::at_rest(self.shown.position))
    }

    /// Shows set values at once from now on.
    pub(crate) const fn release(&mut self) {
        self.by = Span::ZERO;
        self.waiting.clear();
    }

    /// Begins in motion: what lies before `set` is a motion at its velocity. Returns what is shown now.
    pub(crate) fn begin_moving(&mut self, set: &Kinematics, by: Span) -> Kinematics {
        self.by = by;
        self.waiting.clear();
        self.waiting.push(set, Span::ZERO, by);
        self.show(set)
    }

    /// Takes the set values of a cycle, `passed` after the one before, and returns those that are shown in it. `wanted`
    /// is the hold-back that the axis is to have: it is adopted where the axis `stands`, and slewed in motion.
    pub(crate) fn step(
        &mut self,
        set: &Kinematics,
        passed: Span,
        wanted: Span,
        stands: bool,
    ) -> Kinematics {
        self.waiting.advance(passed);
        if self.by == Span::ZERO {
            // A moving axis would stand until its first set value is due.
            let begins = wanted > Span::ZERO && (stands || wanted <= passed / SLEW);
            if !begins {
                return *set;
            }
            self.waiting.clear();
            // Up to the instant of the next ones.
            self.waiting.push(set, passed, Span::ZERO);
        }
        self.by = wanted;
        self.waiting.push(set, passed, wanted);
        self.show(set)
    }

    /// Shows the set values of the present instant; the newest if none wait.
    fn show(&mut self, newest: &Kinematics) -> Kinematics {
        self.shown = self.waiting.due().unwrap_or(*newest);
        self.shown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Span = Span::from_millis(1);
    const NONE: Span = Span::ZERO;

    fn at(position: f64) -> Kinematics {
        Kinematics::at_rest(position)
    }

    /// A motion that begins at rest, with a jerk that does not change.
    fn motion(cycle: i64) -> Kinematics {
        at(7.0).after(cycle.max(0) as f64 * 1e-3, 900.0)
    }

    #[test]
    fn without_a_hold_back_every_value_passes_with_its_own_bits() {
        let mut held = HeldBack::new();
        for cycle in 0..10 {
            let set = motion(cycle);
            assert_eq!(held.step(&set, CYCLE, NONE, false), set);
        }
        assert_eq!(held.shown(), None);
    }

    #[test]
    fn by_whole_cycles_every_value_comes_later_with_its_own_bits() {
        let mut held = HeldBack::new();
        let by = Span::from_millis(25);
        for cycle in -5..200 {
            let shown = held.step(&motion(cycle), CYCLE, by, cycle < 0);
            assert_eq!(shown, motion(cycle - 25), "{cycle}");
        }
    }

    #[test]
    fn between_two_cycles_and_over_skipped_ones_it_is_the_motion() {
        let mut held = HeldBack::new();
        let by = Span::from_micros(25_300);
        let mut cycle = -5;
        while cycle < 400 {
            let step = 1 + i64::from(cycle % 7 == 0) * 3;
            cycle += step;
            let shown = held.step(&motion(cycle), CYCLE * step, by, cycle < 0);
            let truth = at(7.0).after((cycle as f64 - 25.3).max(0.0) * 1e-3, 900.0);
            // The jerk of the whole motion changes once, at its begin.
            let is_begin = (cycle - 26).abs() < 5;
            let bound = if is_begin { 1e-7 } else { 1e-12 };
            assert!((shown.position - truth.position).abs() < bound, "{cycle}");
        }
    }

    #[test]
    fn a_slewed_hold_back_leaves_the_motion_shown_alone() {
        let mut held = HeldBack::new();
        let mut by = Span::from_millis(10);
        for cycle in -20..3_000_i64 {
            // What is calculated goes ahead as much as the hold-back grows, and is shown at the same instants.
            by += Span::from_nanos(if cycle > 0 { 800 } else { 0 });
            let ahead = by.as_secs_f64() - 10e-3;
            let early = at(7.0).after((cycle as f64 * 1e-3 + ahead).max(0.0), 900.0);
            let shown = held.step(&early, CYCLE, by, cycle < 0);
            let truth = at(7.0).after((cycle as f64 - 10.0).max(0.0) * 1e-3, 900.0);
            let is_begin = (cycle - 10).abs() < 3;
            let bound = if is_begin { 1e-7 } else { 1e-10 };
            assert!((shown.position - truth.position).abs() < bound, "{cycle}");
        }
    }

    /// In a swarm schedule an acceleration of 1400 mm/s² was stated of an axis with a constant velocity, and it was stopped from there.
    #[test]
    fn a_motion_that_does_not_know_of_the_slew_is_shown_faster_and_not_in_waves() {
        let mut held = HeldBack::new();
        for rate in [930_i64, -930] {
            let mut by = Span::from_millis(10);
            for cycle in -20..3_000_i64 {
                by -= Span::from_nanos(if cycle > 0 { rate } else { 0 });
                let own = Kinematics {
                    position: 0.349 * cycle.max(-20) as f64,
                    velocity: 349.0,
                    acceleration: 0.0,
                };
                let shown = held.step(&own, CYCLE, by, cycle == -20);
                if cycle > 20 {
                    // The rate of what is shown: a cycle by the time between two instants.
                    let expected = 349.0 / (1.0 - rate as f64 * 1e-6);
                    assert!(
                        (shown.velocity - expected).abs() < 1e-3,
                        "{cycle}: {shown:?}"
                    );
                    assert!(shown.acceleration.abs() < 1.0, "{cycle}: {shown:?}");
                }
            }
            held.release();
        }
    }

    /// A swarm schedule had set values without a number.
    #[test]
    fn a_motion_that_fades_below_the_smallest_number_stands() {
        let mut held = HeldBack::new();
        let mut by = Span::from_millis(10);
        for cycle in -20..1_000_i32 {
            by -= Span::from_nanos(if cycle > 0 { 930 } else { 0 });
            let own = Kinematics {
                position: 7.0,
                velocity: 0.5_f64.powi(2 * cycle.max(0)),
                acceleration: 0.0,
            };
            let shown = held.step(&own, CYCLE, by, cycle == -20);
            let numbers = [shown.position, shown.velocity, shown.acceleration];
            assert!(numbers.iter().all(|n| n.is_finite()), "{cycle}: {shown:?}");
        }
    }

    #[test]
    fn it_begins_where_the_axis_stands() {
        let mut held = HeldBack::new();
        let by = Span::from_millis(10);
        for cycle in 0..50 {
            assert_eq!(held.step(&motion(cycle), CYCLE, by, false), motion(cycle));
        }
        assert_eq!(held.step(&at(9.0), CYCLE, by, true), at(9.0));
        assert_eq!(held.by(), by);
        assert!(held.is_quiet());
        for _ in 0..10 {
            assert_eq!(held.step(&motion(50), CYCLE, by, false), at(9.0));
        }
        assert!(!held.is_quiet());
        assert_eq!(held.step(&motion(50), CYCLE, by, false), motion(50));
        held.release();
        assert_eq!(held.step(&motion(70), CYCLE, by, false), motion(70));
    }

    #[test]
    fn begun_in_motion_it_comes_from_where_its_velocity_leads() {
        let mut held = HeldBack::new();
        let set = Kinematics {
            position: 100.0,
            velocity: 50.0,
            acceleration: 20.0,
        };
        let by = Span::from_millis(10);
        let shown = held.begin_moving(&set, by);
        assert!((shown.position - 99.5).abs() < 1e-12 && shown.velocity == 50.0);
        let ahead = |cycles: i64| set.after(cycles as f64 * 1e-3, 0.0);
        for cycle in 1..40 {
            let shown = held.step(&ahead(cycle), CYCLE, by, false);
            let expected = 100.0 + 0.05 * (cycle - 10) as f64;
            match cycle {
                ..10 => assert!((shown.position - expected).abs() < 1e-12),
                _ => assert_eq!(shown, ahead(cycle - 10)),
            }
        }
    }

    #[test]
    fn a_hold_back_that_falls_at_once_goes_on_with_the_newest() {
        let mut held = HeldBack::new();
        let (long, short) = (Span::from_millis(50), Span::from_millis(5));
        for cycle in -60..100 {
            let _ = held.step(&motion(cycle), CYCLE, long, cycle < 0);
        }
        for cycle in 100..120 {
            let shown = held.step(&motion(cycle), CYCLE, short, false);
            assert!(cycle < 106 || shown == motion(cycle - 5), "{cycle}");
        }
    }
}
