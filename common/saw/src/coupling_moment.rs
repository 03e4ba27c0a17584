//! The coupling moment: the state of the axes when a synchronisation is planned.

use coaxle_clock::Seconds;

use super::refusal::SawRefusal;

use coaxle_curve::profile::{Kinematics, Limits};

/// State of the two axes at the moment of coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CouplingMoment {
    /// The master's set values.
    pub master: Kinematics,
    /// Set if the master is an encoder, whose acceleration is never exactly zero.
    pub encoder: Option<EncoderNoise>,
    /// The slave's set values.
    pub slave: Kinematics,
    /// Limits of the slave's axis.
    pub axis: SlaveLimits,
}

/// Machine data of the slave's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveLimits {
    /// Dynamic limits of the axis.
    pub dynamics: Limits,
    /// Lower software limit of its position, u.
    pub min_position: Option<f64>,
    /// Upper software limit of its position, u.
    pub max_position: Option<f64>,
    /// Set if the axis never leaves its limits of position, velocity, acceleration and jerk. A
    /// synchronisation that would is refused then, whether the sync mode checks it or not. The original
    /// lets the slave follow its plan.
    pub guard: Option<LimitGuard>,
}

/// Limits that an axis never leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitGuard {
    /// Part of velocity, acceleration and deceleration that is reserved for the ripple of a master, where
    /// a command names no limit: 0 to less than 1. A slave that already uses the reserve at the coupling
    /// moment keeps it.
    pub reserve: f64,
}

impl SlaveLimits {
    /// Returns a limit of a synchronisation: the command's or the axis's own. `now` is the limited
    /// quantity at the coupling moment.
    pub(super) fn in_force(&self, given: Option<f64>, own: f64, now: f64) -> f64 {
        match (given, self.guard) {
            // A guarded axis keeps its own limit in any case:
            // a plan above it would be held back on the way.
            (Some(given), Some(_)) if given > own => own,
            (Some(given), _) => given,
            // A slave that already moves in the reserve would otherwise be refused for its present motion.
            (None, Some(guard)) => (own * (1.0 - guard.reserve)).max(now.abs().min(own)),
            (None, None) => own,
        }
    }

    /// Returns the limit of the jerk, without a reserve for the ripple of the master.
    pub(super) fn jerk_in_force(&self, given: Option<f64>) -> f64 {
        // No reserve: a ripple of 1 % of the velocity has its
        // own jerk, which grows with its frequency squared.
        let own = self.dynamics.jerk();
        match (given, self.guard) {
            (Some(given), Some(_)) => given.min(own),
            (given, _) => given.unwrap_or(own),
        }
    }
}

/// Encoder as a master: TS5055 7. Accelerations of less than two increments of position per cycle and
/// cycle are its noise and count as zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderNoise {
    /// Scaling, user units per increment.
    pub scaling: f64,
    /// The cycle time.
    pub cycle: Seconds,
}

impl EncoderNoise {
    /// Returns the smallest acceleration that counts, u/s².
    #[must_use]
    pub fn acceleration_threshold(&self) -> f64 {
        // A single position that is off by an increment has a second difference of two.
        2.0 * self.scaling.abs() / (self.cycle.0 * self.cycle.0)
    }
}

impl CouplingMoment {
    /// Returns the moment to plan for: with the configured velocity, in this direction, if master and
    /// slave both stand still. As long as the master stands, the slave has nothing to do: a profile over
    /// its position begins when it moves.
    ///
    /// # Errors
    /// [`SawRefusal::Limit`] for an invalid velocity.
    pub(super) fn with_expected_velocity(
        &self,
        master_velocity: Option<f64>,
        direction: f64,
    ) -> Result<Self, SawRefusal> {
        let Some(received) = master_velocity else {
            return Ok(*self);
        };
        // Written so that NaN is refused, too.
        if !(received > 0.0 && received.is_finite()) {
            let field = "master-velocity";
            return Err(SawRefusal::Limit { field, received });
        }
        let stands = |axis: &Kinematics| axis.velocity == 0.0 && axis.acceleration == 0.0;
        if !(stands(&self.master) && stands(&self.slave)) || direction == 0.0 {
            return Ok(*self);
        }
        // Only its magnitude is configured. The direction follows from the positions of the command.
        let velocity = received.copysign(direction);
        Ok(Self {
            master: Kinematics {
                velocity,
                ..self.master
            },
            ..*self
        })
    }

    /// Returns the acceleration of the master, as used for planning.
    pub(super) fn master_acceleration(&self) -> f64 {
        let acceleration = self.master.acceleration;
        match self.encoder {
            // Otherwise the profiles that need a master without
            // acceleration would never be used behind an encoder.
            Some(encoder) if acceleration.abs() < encoder.acceleration_threshold() => 0.0,
            _ => acceleration,
        }
    }
}
