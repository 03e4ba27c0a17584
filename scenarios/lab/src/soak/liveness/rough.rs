//! A target that goes to and fro faster than an axis with limits can.

use coaxle_curve::profile::Limits;
use coaxle_receiver::signals::FarAxisSignals;

use super::tolerance;

/// Time for which its motion is remembered, s, at most twice as long.
const MEMORY: f64 = 2.5;
/// Part of the jerk with which the guard approaches a rough target.
const JERK_SHARE: f64 = 0.5;

/// Watches the motion of the target of an axis with limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughTarget {
    limits: Limits,
    /// Newest acceleration, u/s².
    newest: Option<f64>,
    /// Time of the newest cycle, and its length, s.
    cycle: (f64, f64),
    now: Course,
    before: Course,
    since: f64,
}

/// Motion of a target in a stretch of time.
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

impl RoughTarget {
    pub(super) const fn new(limits: Limits) -> Self {
        Self {
            limits,
            newest: None,
            cycle: (0.0, 0.0),
            now: Course::NONE,
            before: Course::NONE,
            since: 0.0,
        }
    }

    /// Begins a cycle of the axis, s.
    pub(super) const fn advance(&mut self, t_s: f64) {
        self.cycle = (t_s, t_s - self.cycle.0);
        if t_s - self.since >= MEMORY {
            // Two stretches in turn, so that the newest one is never empty of memory.
            (self.before, self.now, self.since) = (self.now, Course::NONE, t_s);
        }
    }

    /// Takes the next velocity and acceleration; `is_another` where they have nothing to do with those before.
    pub(super) fn push(&mut self, velocity: f64, acceleration: f64, is_another: bool) {
        let before = self.newest.replace(acceleration);
        let (most, jerk) = (self.limits.acceleration(), self.limits.jerk());
        let most = most.max(self.limits.deceleration());
        // However long it held, it changes within a cycle of the axis. In swarm schedule 90328 frames come every other one, and a slave that changes its
        // acceleration by 13 746 u/s³ is followed within 20 192 u/s³.
        let (_, cycle) = self.cycle;
        let has_turned = before.is_some_and(|then| {
            !is_another && cycle > 0.0 && (acceleration - then).abs() > jerk * cycle
        });
        let now = &mut self.now;
        now.slowest = now.slowest.min(velocity);
        now.fastest = now.fastest.max(velocity);
        now.is_beyond |= has_turned || acceleration.abs() > most;
    }

    /// Distance from a target that was beyond the limits lately, with a time of `age` that it goes on unseen, u; none from another one.
    pub(super) fn beside(&self, t_s: f64, age: f64) -> Option<f64> {
        let is_beyond = self.now.is_beyond || self.before.is_beyond;
        let slowest = self.now.slowest.min(self.before.slowest);
        let fastest = self.now.fastest.max(self.before.fastest);
        // The axis goes at any of the velocities that its target has had, and stops relative to another: u·√(u/j) with a share of the jerk.
        let apart = fastest - slowest;
        let stop = apart * (apart / (JERK_SHARE * self.limits.jerk())).sqrt();
        // The target went at these velocities meanwhile.
        (is_beyond && t_s - self.since <= MEMORY).then_some(stop + apart * age)
    }
}

/// Watches the frames of the master of an axis with limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughMaster {
    target: RoughTarget,
    /// Count of the newest frame.
    frame: Option<u64>,
}

impl RoughMaster {
    pub(super) const fn new(limits: Limits) -> Self {
        Self {
            target: RoughTarget::new(limits),
            frame: None,
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
        self.target.advance(t_s);
        let (Some(count), Some(velocity), Some(acceleration)) =
            (count, axis.received_velocity, axis.received_acceleration)
        else {
            return;
        };
        // Repeated frames have no time between them.
        if self.frame.replace(count) == Some(count) && !is_another {
            return;
        }
        self.target.push(velocity, acceleration, is_another);
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
        let age = axis.correction_us.unwrap_or_default() * 1e-6;
        let beside = (corrected - received - velocity * age).abs();
        let limit = self.target.beside(t_s, age.abs());
        limit.is_some_and(|limit| beside <= limit + tolerance(received))
    }
}
