//! A master that goes to and fro faster than an axis with limits can.

use coaxle_curve::profile::Limits;
use coaxle_receiver::signals::FarAxisSignals;

use super::tolerance;

/// Time for which its motion is remembered, s, at most twice as long.
const MEMORY: f64 = 2.5;
/// Part of the jerk with which the guard approaches a rough target.
const JERK_SHARE: f64 = 0.5;

/// Watches the frames of the master of an axis with limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughMaster {
    limits: Limits,
    /// Count, velocity and acceleration of the newest frame, and its time, s.
    frame: Option<(u64, [f64; 2], f64)>,
    now: Course,
    before: Course,
    since: f64,
}

/// Motion of a master in a stretch of time.
#[derive(Clone, Copy, Debug)]
struct Course {
    /// Least and greatest velocity, u/s.
    slowest: f64,
    fastest: f64,
    /// True if its acceleration changed faster than the jerk limit of the axis, or was beyond its limit.
    is_beyond: bool,
}

impl Course {
    const NONE: Self = Self {
        slowest: f64::INFINITY,
        fastest: f64::NEG_INFINITY,
        is_beyond: false,
    };
}

impl RoughMaster {
    pub(super) const fn new(limits: Limits) -> Self {
        Self {
            limits,
            frame: None,
            now: Course::NONE,
            before: Course::NONE,
            since: 0.0,
        }
    }

    /// Takes the frame of a cycle; `is_another` for one of another run.
    pub(super) fn push(
        &mut self,
        t_s: f64,
        count: Option<u64>,
        axis: &FarAxisSignals,
        is_another: bool,
    ) {
        if t_s - self.since >= MEMORY {
            // Two stretches in turn, so that the newest one is never empty of memory.
            (self.before, self.now, self.since) = (self.now, Course::NONE, t_s);
        }
        let (Some(count), Some(velocity), Some(acceleration)) =
            (count, axis.received_velocity, axis.received_acceleration)
        else {
            return;
        };
        let before = self.frame.filter(|_| !is_another);
        // Repeated frames have no time between them.
        if before.is_some_and(|(newest, ..)| newest == count) {
            return;
        }
        self.frame = Some((count, [velocity, acceleration], t_s));
        let (most, jerk) = (self.limits.acceleration(), self.limits.jerk());
        let most = most.max(self.limits.deceleration());
        let has_turned = before.is_some_and(|(_, [_, then], at)| {
            t_s > at && (acceleration - then).abs() > jerk * (t_s - at)
        });
        let now = &mut self.now;
        now.slowest = now.slowest.min(velocity);
        now.fastest = now.fastest.max(velocity);
        now.is_beyond |= has_turned || acceleration.abs() > most;
    }

    /// True if its master was beyond its limits lately, and the axis is beside it by no more than that explains.
    pub(super) fn is_beside(&self, t_s: f64, axis: &FarAxisSignals) -> bool {
        let (Some(received), Some(velocity), Some(corrected)) = (
            axis.received_position,
            axis.received_velocity,
            axis.corrected_position,
        ) else {
            return false;
        };
        let is_beyond = self.now.is_beyond || self.before.is_beyond;
        let slowest = self.now.slowest.min(self.before.slowest);
        let fastest = self.now.fastest.max(self.before.fastest);
        // The axis goes at any of the velocities that its master has had, and stops relative to another: u·√(u/j) with a share of the jerk.
        let apart = fastest - slowest;
        let stop = apart * (apart / (JERK_SHARE * self.limits.jerk())).sqrt();
        let age = axis.correction_us.unwrap_or_default() * 1e-6;
        let beside = (corrected - received - velocity * age).abs();
        // The master went at these velocities while its frame was under way.
        let limit = stop + apart * age.abs() + tolerance(received);
        is_beyond && t_s - self.since <= MEMORY && beside <= limit
    }
}
