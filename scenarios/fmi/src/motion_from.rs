//! Motion of a master between two inputs.

use coaxle_curve::profile::Kinematics;

/// The motion `seconds` after this one, at its acceleration. After no time it is the same, to the bit.
pub(crate) fn motion_from(motion: &Kinematics, seconds: f64) -> Kinematics {
    let Kinematics {
        position,
        velocity,
        acceleration,
    } = *motion;
    Kinematics {
        position: position + seconds * (velocity + seconds * acceleration / 2.0),
        velocity: velocity + seconds * acceleration,
        acceleration,
    }
}
