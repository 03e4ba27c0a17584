//! Where the velocity of the slave steps.

use super::kind::Course;
use super::plate::Plate;
use coaxle_curve::law::Segment;

/// A place at which the slave's velocity is another one right after it than right before it. No slave can follow that
/// but slowly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityStep {
    /// Where the master is, x.
    pub master: f64,
    /// The velocity before it, u/x, or over time where the characteristics say so.
    pub before: f64,
    /// The velocity after it, likewise.
    pub after: f64,
}

impl VelocityStep {
    /// How large it is.
    #[must_use]
    pub const fn size(&self) -> f64 {
        (self.after - self.before).abs()
    }
}

/// What cannot be told from rounding, beside the velocities of the plate.
const ROUNDING: f64 = 1e-9;

impl Plate {
    /// The largest of [`Self::velocity_steps`], the first of several that are; none without any.
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

    /// The places inside the plate at which the slave's velocity steps, in the order of the master; of a cyclic plate its
    /// seam, too, where the end leads to the start. What a linear plate does at its edges is up to whoever passes them.
    ///
    /// Laws that lead from or to a point with another velocity than it says make one, and so does each row of a
    /// table with straight lines.
    pub fn velocity_steps(&self) -> impl Iterator<Item = VelocityStep> + '_ {
        let segments = self.curve().segments();
        let seam = match self.course() {
            Course::Linear => None,
            Course::Cyclic => segments.last().zip(segments.first()),
        };
        let inner = segments.iter().zip(segments.iter().skip(1));
        // Of the seam the start of the next cycle is shown.
        inner.chain(seam).filter_map(|(before, after)| {
            let step = VelocityStep {
                master: before.end(),
                before: before.at(before.end()).velocity,
                after: after.at(after.start()).velocity,
            };
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
