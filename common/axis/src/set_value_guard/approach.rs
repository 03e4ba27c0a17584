//! Acceleration of the next cycle, if only the limits of jerk and acceleration applied.
//!
//! All values are in units of the closed forms.

use super::closed_forms::{acceleration_to_gain, stop_way};
use super::differences::Differences;
use super::envelope::{Envelope, Scaled};
use super::root::last_not_above;
use super::target::Course;

/// Share of the jerk for the approach to an accelerating or rough target: the rest is for the target's
/// motion meanwhile.
const JERK_SHARE: f64 = 0.5;

/// Share of the highest acceleration from which a target counts as accelerating.
const ACCELERATED: f64 = 1e-3;

/// Least share of the highest acceleration used towards a target that uses all of it.
const LEAST: f64 = 0.05;

/// Approach to a target that is at `position` at the end of the cycle: the acceleration from which
/// a stop, relative to the target, ends at the target.
pub(super) fn towards_position(
    envelope: &Envelope,
    set: &Differences,
    position: f64,
    course: &Course,
) -> f64 {
    let Scaled { w, b, .. } = envelope.scaled(set);
    let target = scaled_course(envelope, position, course);
    let distance = envelope.scaled_way(set.position - position);
    let most = envelope.acceleration;
    // At constant velocity the target's frame moves evenly, and a stop in it may use all of the jerk.
    let is_even = target.b.abs() <= ACCELERATED * most && !course.is_rough;
    let share = if is_even { 1.0 } else { JERK_SHARE };
    // In the target's frame only the acceleration is left that the target does not use. 0 would never close in on it.
    let upper = (most - target.b).max(LEAST * most) / share;
    let lower = (most + target.b).max(LEAST * most) / share;
    // The jerk limit in these units: the acceleration changes by 1 at most in a cycle.
    last_not_above(b - 1.0, b + 1.0, |next| {
        let speed = (w + next - target.w) / share;
        let acceleration = (next - target.b) / share;
        // A cycle with the velocity w + next, then the stop: with a share β of the jerk, β·D(w/β, b/β).
        distance + w + next + share * stop_way(speed, acceleration, upper, lower)
    })
}

/// Approach to the velocity of a target, at any position.
pub(super) fn towards_velocity(envelope: &Envelope, set: &Differences, course: &Course) -> f64 {
    let Scaled { w, .. } = envelope.scaled(set);
    let target = scaled_course(envelope, set.position, course);
    // Velocities of the cycle before, so that axis and target take their next step together.
    target.b - acceleration_to_gain(w - (target.w - target.b))
}

/// Approach to standstill.
pub(super) fn stopping(envelope: &Envelope, set: &Differences) -> f64 {
    -acceleration_to_gain(envelope.scaled(set).w)
}

/// A target faster than the axis is followed at the highest velocity.
fn scaled_course(envelope: &Envelope, position: f64, course: &Course) -> Scaled {
    let fastest = envelope.highest_velocity();
    // Otherwise the stop in its frame would be planned from a velocity that the axis never reaches.
    let velocity = course.velocity.max(-fastest).min(fastest);
    envelope.scaled(&Differences::each_cycle(
        position,
        velocity,
        course.acceleration,
    ))
}
