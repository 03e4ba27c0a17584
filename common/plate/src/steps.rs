//! Steps of the slave's velocity.

use super::kind::Course;
use super::plate::Plate;
use coaxle_curve::law::Segment;

/// A place at which the slave's velocity steps. No slave can follow it except slowly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityStep {
    /// Position of the master, x.
    pub master: f64,
    /// The velocity before it, u/x, or over time in the characteristics.
    pub before: f64,
    /// The velocity after it, in that unit.
    pub after: f64,
}

impl VelocityStep {
    /// Returns the size of the step.
    #[must_use]
    pub const fn size(&self) -> f64 {
        (self.after - self.before).abs()
    }
}

/// Steps that are within rounding, relative to the velocities of the plate.
// Slopes of spline pieces meet within 1e-11 of the greatest slope (test `rows_are_passed`).
const ROUNDING: f64 = 1e-9;

impl Plate {
    /// Returns the largest of [`Self::velocity_steps`], the first of equal ones; none without any.
    #[must_use]
    pub fn largest_velocity_step(&self) -> Option<VelocityStep> {
        self.velocity_steps().reduce(|most, step| {
            if step.size() > most.size() {
                step
            } else {
                most
            }
        })
    }

    /// Returns the places inside the plate at which the slave's velocity steps, in the order of the
    /// master; of a cyclic plate its seam, too, where the end leads to the start. The edges of a linear
    /// plate do not count.
    ///
    /// A law that leads from or to a point with a velocity other than the point's makes a step, and so
    /// does each row of a table with straight lines.
    pub fn velocity_steps(&self) -> impl Iterator<Item = VelocityStep> + '_ {
        let segments = self.curve().segments();
        let seam = match self.course() {
            // At its edges a linear plate comes from and returns to standstill by definition, whatever its
            // points say.
            Course::Linear => None,
            Course::Cyclic => segments.last().zip(segments.first()),
        };
        let inner = segments.iter().zip(segments.iter().skip(1));
        // The seam is reported at the start of the next cycle.
        inner.chain(seam).filter_map(|(before, after)| {
            let step = VelocityStep {
                master: before.end(),
                before: before.at(before.end()).velocity,
                after: after.at(after.start()).velocity,
            };
            // Beside two rests both velocities are 0 up to rounding, which must be compared with the stroke's
            // own slope.
            let mean = |s: &Segment| {
                let stroke = s.at(s.end()).position - s.at(s.start()).position;
                (stroke / (s.end() - s.start())).abs()
            };
            let size = mean(before)
                .max(mean(after))
                .max(step.before.abs())
                .max(step.after.abs());
            (step.size() > ROUNDING * size).then_some(step)
        })
    }
}
