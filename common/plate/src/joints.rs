//! Where one segment of a plate ends and the next begins: what goes on there, and what steps.

use super::kind::Course;
use super::plate::Plate;
use coaxle_curve::law::{Motion, Segment};

/// A place where segments meet; the slave on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Position of the master, x. Of the seam of a cyclic plate, where its cycle begins.
    pub master: f64,
    /// The slave as it comes, u and derivatives with respect to the master.
    pub before: Motion,
    /// The slave as it goes on.
    pub after: Motion,
    /// How much may be rounding.
    slack: Motion,
}

/// Derivatives that agree to so many of the magnitudes at hand go on; those at the ends of a spline's pieces are the least exact.
const ROUNDING: f64 = 1e-7;

impl Joint {
    /// By how much velocity, acceleration and jerk step, u/x, u/x² and u/x³; 0 what goes on.
    #[must_use]
    pub fn steps(&self) -> [f64; 3] {
        let Self {
            before,
            after,
            slack,
            ..
        } = self;
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

    fn between(master: f64, sides: [Motion; 2], segments: [&Segment; 2]) -> Self {
        let [before, after] = sides;
        let size = |of: fn(&Segment) -> f64| of(segments[0]).max(of(segments[1]));
        let mean = |segment: &Segment, power: i32| {
            let stroke = segment.at(segment.end()).position - segment.at(segment.start()).position;
            stroke.abs() * libm::pow(segment.end() - segment.start(), -f64::from(power))
        };
        let mean = |power| mean(segments[0], power).max(mean(segments[1], power));
        let velocity = size(|s| s.extremes().velocity.magnitude()).max(mean(1));
        let acceleration = size(|s| s.extremes().acceleration.magnitude()).max(mean(2));
        let jerk = size(|s| s.extremes().jerk.magnitude()).max(mean(3));
        Self {
            master,
            before,
            after,
            slack: Motion {
                position: 0.0,
                velocity: ROUNDING * velocity,
                acceleration: ROUNDING * acceleration,
                jerk: ROUNDING * jerk,
            },
        }
    }
}

impl Plate {
    /// All places where segments meet, by the master. Those of a cyclic plate begin with its seam, where its end meets its
    /// start; at both ends of a linear one the slave comes from standstill and stays in it.
    pub fn joints(&self) -> impl Iterator<Item = Joint> + '_ {
        let segments = self.curve().segments();
        let (first, last) = (&segments[0], &segments[segments.len() - 1]);
        let standing = |motion: Motion| Motion {
            position: motion.position,
            ..Motion::default()
        };
        let start = first.at(first.start());
        let end = last.at(last.end());
        let seam = match self.course() {
            Course::Linear => {
                Joint::between(first.start(), [standing(start), start], [first, first])
            }
            Course::Cyclic => {
                let before = Motion {
                    position: end.position - self.lift(),
                    ..end
                };
                Joint::between(first.start(), [before, start], [last, first])
            }
        };
        let inner = segments
            .iter()
            .zip(segments.iter().skip(1))
            .map(|(before, after)| {
                let sides = [before.at(before.end()), after.at(after.start())];
                Joint::between(after.start(), sides, [before, after])
            });
        let stop = (self.course() == Course::Linear)
            .then(|| Joint::between(last.end(), [end, standing(end)], [last, last]));
        core::iter::once(seam).chain(inner).chain(stop)
    }
}
