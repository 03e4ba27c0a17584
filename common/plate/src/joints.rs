//! Joints between the segments of a plate: continuous derivatives and steps.

use super::kind::Course;
use super::plate::Plate;
use coaxle_curve::law::{Motion, Segment};

/// A joint of two segments, with the slave on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Position of the master, x. For the seam of a cyclic plate, the start of its cycle.
    pub master: f64,
    /// The slave before the joint, u and derivatives with respect to the master.
    pub before: Motion,
    /// The slave after the joint.
    pub after: Motion,
    /// Tolerance for rounding.
    slack: Motion,
}

/// Tolerance of continuous derivatives, relative to the magnitudes involved; those at the ends of a
/// spline's pieces are the least exact.
const ROUNDING: f64 = 1e-7;

impl Joint {
    /// Returns the steps of velocity, acceleration and jerk, u/x, u/x² and u/x³; 0 for continuous ones.
    #[must_use]
    pub fn steps(&self) -> [f64; 3] {
        let Self {
            before,
            after,
            slack,
            ..
        } = self;
        // Exactly 0 within rounding, so that callers compare with 0 and need no tolerance of their own.
        let step = |before: f64, after: f64, slack: f64| {
            let step = after - before;
            if step.abs() <= slack { 0.0 } else { step }
        };
        [
            step(before.velocity, after.velocity, slack.velocity),
            step(before.acceleration, after.acceleration, slack.acceleration),
            step(before.jerk, after.jerk, slack.jerk),
        ]
    }

    fn between(master: f64, sides: [Motion; 2], before: &JointSide, after: &JointSide) -> Self {
        // The larger side: beside a long flat segment the rounding of a short steep one counts.
        let slack = |of: fn(&Motion) -> f64| ROUNDING * of(&before.size).max(of(&after.size));
        let [came, goes] = sides;
        Self {
            master,
            before: came,
            after: goes,
            slack: Motion {
                position: 0.0,
                velocity: slack(|size| size.velocity),
                acceleration: slack(|size| size.acceleration),
                jerk: slack(|size| size.jerk),
            },
        }
    }
}

/// A segment at a joint, and the magnitudes of its derivatives: their extremes, and those of its stroke
/// over its length.
#[derive(Clone, Copy)]
struct JointSide<'a> {
    segment: &'a Segment,
    size: Motion,
}

impl<'a> JointSide<'a> {
    fn of(segment: &'a Segment) -> Self {
        let extremes = segment.extremes();
        // A straight line has no acceleration of its own, yet its ends are rounded like stroke/length².
        let rate = 1.0 / (segment.end() - segment.start());
        let stroke = segment.at(segment.end()).position - segment.at(segment.start()).position;
        let velocity = stroke.abs() * rate;
        let acceleration = velocity * rate;
        Self {
            segment,
            size: Motion {
                position: 0.0,
                velocity: extremes.velocity.magnitude().max(velocity),
                acceleration: extremes.acceleration.magnitude().max(acceleration),
                jerk: extremes.jerk.magnitude().max(acceleration * rate),
            },
        }
    }

    fn start(&self) -> Motion {
        self.segment.at(self.segment.start())
    }

    fn end(&self) -> Motion {
        self.segment.at(self.segment.end())
    }
}

impl Plate {
    /// Returns the joints of the segments, by the master. Those of a cyclic plate begin with its seam,
    /// where its end meets its start; at both ends of a linear one the slave comes from standstill and
    /// returns to it.
    pub fn joints(&self) -> impl Iterator<Item = Joint> + '_ {
        let segments = self.curve().segments();
        let [first, last] = [&segments[0], &segments[segments.len() - 1]].map(JointSide::of);
        let (master, end_master) = self.master_range();
        let (start, end) = (first.start(), last.end());
        let standing = |motion: Motion| Motion {
            position: motion.position,
            ..Motion::default()
        };
        let seam = match self.course() {
            Course::Linear => Joint::between(master, [standing(start), start], &first, &first),
            Course::Cyclic => {
                let before = Motion {
                    // Without the lift the seam of a plate with lift would look like a step of the position.
                    position: end.position - self.lift(),
                    ..end
                };
                Joint::between(master, [before, start], &last, &first)
            }
        };
        let inner = segments[1..]
            .iter()
            .map(JointSide::of)
            // Each side is computed once and handed on, as extremes of a law are roots and so the costly part.
            .scan(first, |before, after| {
                let sides = [before.end(), after.start()];
                let joint = Joint::between(after.segment.start(), sides, before, &after);
                *before = after;
                Some(joint)
            });
        let stop = (self.course() == Course::Linear)
            .then(|| Joint::between(end_master, [end, standing(end)], &last, &last));
        core::iter::once(seam).chain(inner).chain(stop)
    }
}
