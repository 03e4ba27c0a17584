//! A profile: consecutive phases of constant jerk.

use coaxle_clock::Seconds;

/// The state of an axis: position, velocity and acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinematics {
    /// Position, u.
    pub position: f64,
    /// Velocity, u/s.
    pub velocity: f64,
    /// Acceleration, u/s².
    pub acceleration: f64,
}

impl Kinematics {
    /// Returns the state of standing still at a position.
    #[must_use]
    pub const fn at_rest(position: f64) -> Self {
        Self {
            position,
            velocity: 0.0,
            acceleration: 0.0,
        }
    }

    /// Returns the state after `duration` seconds of constant jerk, u/s³; before it if that is negative.
    #[must_use]
    pub fn after(&self, duration: f64, jerk: f64) -> Self {
        let Self {
            position,
            velocity,
            acceleration,
        } = *self;
        let t = duration;
        Self {
            // Nested, so that small terms are added up before they meet the large position.
            position: position + t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0)),
            velocity: velocity + t * (acceleration + t * jerk / 2.0),
            acceleration: acceleration + t * jerk,
        }
    }

    /// Returns the motion mirrored.
    #[must_use]
    pub(super) fn mirrored(&self) -> Self {
        Self {
            position: -self.position,
            velocity: -self.velocity,
            acceleration: -self.acceleration,
        }
    }
}

/// Reverse (3), speed up or slow down (3), cruise (1), stop (3).
const MAX_PHASES: usize = 10;

/// A motion planned ahead, evaluated by [`Profile::at`].
///
/// It stores its few phases inline and is plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    phases: [JerkPhase; MAX_PHASES],
    len: usize,
    end: Kinematics,
    duration: f64,
}

/// A phase of constant jerk, from the state at its begin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct JerkPhase {
    begin: f64,
    from: Kinematics,
    jerk: f64,
}

impl Profile {
    /// Returns the state `since_start` after the start. Before it, the state at the start; after the end,
    /// the motion continues at its final velocity.
    #[must_use]
    #[inline]
    pub fn at(&self, since_start: Seconds) -> Kinematics {
        // NaN becomes 0 by `max`, so it is a state of the profile as well.
        let t = since_start.0.max(0.0);
        if t >= self.duration {
            // From the settled end, not from the last phase: beyond it rounding would grow with the time.
            return self.end.after(t - self.duration, 0.0);
        }
        let phase = self.phase_at(t);
        phase.from.after(t - phase.begin, phase.jerk)
    }

    /// Returns the jerk `since_start` after the start, u/s³: zero before it and from the end on.
    #[must_use]
    pub fn jerk_at(&self, since_start: Seconds) -> f64 {
        let t = since_start.0;
        if (0.0..self.duration).contains(&t) {
            self.phase_at(t).jerk
        } else {
            0.0
        }
    }

    /// Returns the duration of the motion to its target.
    #[must_use]
    pub const fn duration(&self) -> Seconds {
        Seconds(self.duration)
    }

    /// Returns the state at the end.
    #[must_use]
    pub const fn end(&self) -> Kinematics {
        self.end
    }

    /// Begins of the phases, in seconds since the start: between two of them (and the end) the jerk is
    /// constant.
    pub fn phase_begins(&self) -> impl Iterator<Item = Seconds> + '_ {
        self.phases[..self.len]
            .iter()
            .map(|phase| Seconds(phase.begin))
    }

    /// Returns the phase in progress at `t`, which lies before the end: then there is at least one phase.
    #[inline]
    fn phase_at(&self, t: f64) -> &JerkPhase {
        let phases = &self.phases[..self.len];
        // A begin belongs to the phase that begins there: at a jump of the jerk the later value counts.
        let next = phases.partition_point(|phase| phase.begin <= t);
        &phases[next.saturating_sub(1)]
    }

    /// Makes a profile without phases, at its end from the start.
    #[inline]
    pub(super) fn starting_from(start: &Kinematics) -> Self {
        Self {
            phases: [JerkPhase::default(); MAX_PHASES],
            len: 0,
            end: *start,
            duration: 0.0,
        }
    }

    /// Appends a phase unless its duration is zero. `acceleration` is its end value, known more exactly
    /// than the sum of rounded steps.
    #[inline]
    pub(super) fn push(&mut self, jerk: f64, duration: f64, acceleration: f64) {
        // A phase of no length would only take one of the places.
        if duration > 0.0 {
            self.phases[self.len] = JerkPhase {
                begin: self.duration,
                from: self.end,
                jerk,
            };
            self.len += 1;
            self.end = self.end.after(duration, jerk);
            self.duration += duration;
        }
        self.end.acceleration = acceleration;
    }

    /// Sets the end velocity of the last phase, known more exactly than the sum of rounded steps.
    pub(super) fn settle_velocity(&mut self, velocity: f64) {
        self.end.velocity = velocity;
    }

    /// Sets the end position of the motion, known more exactly than the sum of rounded steps.
    pub(super) fn settle_position(&mut self, position: f64) {
        self.end.position = position;
    }

    /// Appends a motion whose positions are relative to the end of this one.
    pub(super) fn followed_by(mut self, next: &Self) -> Self {
        // The next motion is planned from 0, where its positions have all their digits.
        let next = next.shifted(self.end.position);
        for phase in &next.phases[..next.len] {
            self.phases[self.len] = JerkPhase {
                begin: self.duration + phase.begin,
                ..*phase
            };
            self.len += 1;
        }
        self.end = next.end;
        self.duration += next.duration;
        self
    }

    /// Returns the motion mirrored.
    pub(super) fn mirrored(mut self) -> Self {
        for phase in &mut self.phases[..self.len] {
            phase.from = phase.from.mirrored();
            phase.jerk = -phase.jerk;
        }
        self.end = self.end.mirrored();
        self
    }

    /// Moves the whole motion along the axis.
    pub(super) fn shifted(mut self, by: f64) -> Self {
        for phase in &mut self.phases[..self.len] {
            phase.from.position += by;
        }
        self.end.position += by;
        self
    }
}
