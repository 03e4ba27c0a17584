//! Laws against their textbooks, and their common properties.

mod peaks;
mod points;
mod properties;
mod reference;
mod textbook;

use std::vec::Vec;

use super::{Knot, Motion, MotionLaw, Segment};

/// Returns the laws between two points.
fn laws() -> Vec<MotionLaw> {
    let all = MotionLaw::ALL.iter().copied();
    all.filter(|law| !law.is_spline()).collect()
}

/// Makes a point of a master position and the slave's position, velocity, acceleration and jerk.
fn knot(master: f64, [position, velocity, acceleration, jerk]: [f64; 4]) -> Knot {
    Knot {
        master,
        motion: Motion {
            position,
            velocity,
            acceleration,
            jerk,
        },
    }
}

/// Makes the law from 0 to 1 over 0 to 1, with the velocities of its `V` ends. Laws with `M` ends start
/// and end at rest.
fn unit(law: MotionLaw, velocities: [f64; 2]) -> Segment {
    let start = knot(0.0, [0.0, velocities[0], 0.0, 0.0]);
    let end = knot(1.0, [1.0, velocities[1], 0.0, 0.0]);
    Segment::new(law, &start, &end).unwrap()
}

fn values(motion: &Motion) -> [f64; 4] {
    [
        motion.position,
        motion.velocity,
        motion.acceleration,
        motion.jerk,
    ]
}
