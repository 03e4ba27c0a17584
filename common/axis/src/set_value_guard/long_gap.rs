//! A stop over any number of cycles, in a few steps.

use super::SetValueGuard;
use super::approach::stopping;
use super::differences::Differences;

/// Two cycles whose accelerations change alike to this part of the jerk limit belong to one step.
// A velocity w in units of the closed forms is rounded by w·ε, and the acceleration √(2w) that releases it by √w·ε: 2e-10 at 1e12.
const ALIKE: f64 = 1e-9;

/// Greatest number of steps, so that the time of an update is bounded.
// A stop has eight at most: the acceleration falls, is held at the limit and is released, with a part of a cycle between each two,
// and a last rounding. Only along a wall there are more.
const MOST_STEPS: u32 = 64;

impl SetValueGuard {
    /// Brakes the axis to a stop for this number of cycles. Once at rest it stands.
    ///
    /// The change of the acceleration is the same for as long as one limit of the stop binds. Such cycles are one step, whose end has
    /// a closed form, and each of them keeps the limits as a single one does.
    pub(super) fn brake_for(&mut self, cycles: u32) {
        let mut left = cycles;
        for _ in 0..MOST_STEPS {
            let set = &self.history.set;
            if left == 0 || (set.velocity == 0.0 && set.acceleration == 0.0) {
                return;
            }
            let change = self.change_to_stop(set);
            let alike = self.cycles_alike(change, left);
            // All of the jerk or none of it: over many cycles its rounding would add up, to a way beyond a wall.
            let whole = libm::round(change);
            let is_rounding = alike > 1 && (change - whole).abs() <= ALIKE;
            self.history.set = self.after_change(if is_rounding { whole } else { change }, alike);
            left -= alike;
        }
    }

    /// The change of the acceleration in the next cycle of a stop, in units of the closed forms.
    fn change_to_stop(&self, set: &Differences) -> f64 {
        let next = (self.envelope.next_accelerations(set)).nearest(stopping(&self.envelope, set));
        next - self.envelope.scaled(set).b
    }

    /// The number of cycles, at most `most`, in which the acceleration changes by this.
    fn cycles_alike(&self, change: f64, most: u32) -> u32 {
        let is_alike = |after: u32| {
            (self.change_to_stop(&self.after_change(change, after)) - change).abs() <= ALIKE
        };
        // Found by doubling, then by halving: a few limits bind one after the other, each for many cycles.
        let (mut last, mut step) = (0_u32, 1_u32);
        while last.saturating_add(step) < most && is_alike(last + step) {
            last += step;
            step = step.saturating_mul(2);
        }
        while step > 1 {
            step /= 2;
            if last.saturating_add(step) < most && is_alike(last + step) {
                last += step;
            }
        }
        last + 1
    }

    /// The series after this number of cycles in each of which the acceleration changes by this.
    fn after_change(&self, change: f64, cycles: u32) -> Differences {
        match cycles {
            0 => self.history.set,
            _ => (self.envelope).after_change(&self.history.set, change, f64::from(cycles)),
        }
    }
}
