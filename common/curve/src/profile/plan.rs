//! The planners.

use super::limits::Limits;
use super::phases::{Kinematics, Profile};
use super::velocity_change::VelocityChange;

/// Plans the fastest change to a velocity, which is kept for ever; to zero it is a halt.
///
/// `target` is in u/s and is cut to the velocity limit. The change itself is time-optimal from any start
/// velocity and acceleration.
#[must_use]
#[inline]
pub fn to_velocity(start: &Kinematics, target: f64, limits: &Limits) -> Profile {
    // Cut, not refused: a target beyond the limit is reached as nearly as the axis may.
    let target = target.clamp(-limits.velocity(), limits.velocity());
    let mut profile = Profile::starting_from(start);
    VelocityChange::new(start, target, limits).append_to(&mut profile);
    profile
}

/// Plans the motion to a position where the axis stands still, from any start velocity and acceleration.
///
/// `target` is in u. An axis that cannot stop in time passes the target and returns. A start beyond the
/// limits is led back within them first.
///
/// The axis accelerates to its velocity limit and is stopped early enough. Each moment of stopping leads
/// to another place, later ones to farther ones, so the right moment is found by bisection, to the last
/// bit.
#[must_use]
pub fn to_position(start: &Kinematics, target: f64, limits: &Limits) -> Profile {
    // Distances, not positions: far from zero a position has few digits left.
    let here = Kinematics {
        position: 0.0,
        ..*start
    };
    let distance = target - start.position;
    // The earliest place of rest decides whether the axis has to go on or to come back.
    let stop_at_once = stopping_after(&here, 0.0, limits);
    let undershoot = distance - stop_at_once.end().position;

    let mut profile = if undershoot == 0.0 {
        stop_at_once
    } else if undershoot > 0.0 {
        onwards(&here, distance, limits)
    } else {
        onwards(&here.mirrored(), -distance, limits).mirrored()
    }
    .shifted(start.position);
    // The bisection ends within rounding of the target. A second command to it must find no distance left.
    profile.settle_position(target);
    profile
}

/// Travels a `distance` that lies beyond the place of an immediate stop.
fn onwards(start: &Kinematics, distance: f64, limits: &Limits) -> Profile {
    let straight = without_pause(start, distance, limits);
    // Reversing without a pause keeps to the smaller limit all along, which may take longer.
    if start.velocity < 0.0 && limits.acceleration() != limits.deceleration() {
        let paused = with_pause(start, distance, limits);
        if paused.duration() < straight.duration() {
            return paused;
        }
    }
    straight
}

/// Stops first, then travels the rest.
fn with_pause(start: &Kinematics, distance: f64, limits: &Limits) -> Profile {
    // Each of the two parts has its own limit: slowing down first, then speeding up.
    let stop = to_velocity(start, 0.0, limits);
    let rest = Kinematics::at_rest(0.0);
    stop.followed_by(&without_pause(
        &rest,
        distance - stop.end().position,
        limits,
    ))
}

/// Moves straight to the target.
fn without_pause(start: &Kinematics, distance: f64, limits: &Limits) -> Profile {
    let top_speed = limits.velocity();
    let without_cruise = cruising_for(start, 0.0, limits).end().position;
    // Each second at the velocity limit adds that velocity, so the time follows without a search.
    if without_cruise <= distance {
        return cruising_for(start, (distance - without_cruise) / top_speed, limits);
    }
    let heading = VelocityChange::new(start, top_speed, limits);
    // Bisection, not Newton's method: the distance has bends where the stop changes its form.
    let after = latest(heading.duration(), |after| {
        stopping_after(start, after, limits).end().position <= distance
    });
    stopping_after(start, after, limits)
}

/// Accelerates to the velocity limit, stays there for `cruise` seconds and stops.
fn cruising_for(start: &Kinematics, cruise: f64, limits: &Limits) -> Profile {
    let mut profile = to_velocity(start, limits.velocity(), limits);
    profile.push(0.0, cruise, 0.0);
    stop(&mut profile, limits);
    profile
}

/// Accelerates towards the velocity limit for `after` seconds only and stops.
fn stopping_after(start: &Kinematics, after: f64, limits: &Limits) -> Profile {
    let mut profile = Profile::starting_from(start);
    VelocityChange::new(start, limits.velocity(), limits).append_first(after, &mut profile);
    stop(&mut profile, limits);
    profile
}

fn stop(profile: &mut Profile, limits: &Limits) {
    // From the end as it is, its acceleration included, so that the jerk stays within its limit.
    VelocityChange::new(&profile.end(), 0.0, limits).append_to(profile);
}

/// Returns the greatest number from 0 to `bound` that is `early` enough, where 0 is and `bound` is not.
fn latest(bound: f64, early: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, bound);
    loop {
        // No tolerance: the search ends where no number lies between, after some 55 steps.
        let middle = low + (high - low) / 2.0;
        // Written so that a bound that is not a number ends it, too.
        if !(middle > low && middle < high) {
            return low;
        }
        if early(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}
