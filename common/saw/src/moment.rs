//! The coupling moment: what is known when a synchronisation is planned.

use coaxle_clock::Seconds;

use super::refusal::SawRefusal;

use coaxle_curve::profile::{Kinematics, Limits};

/// The two axes at the moment of coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CouplingMoment {
    /// The master's set values.
    pub master: Kinematics,
    /// Given if the master is an encoder, whose acceleration is never quite zero.
    pub encoder: Option<EncoderMaster>,
    /// The slave's set values.
    pub slave: Kinematics,
    /// What the slave's axis can do.
    pub axis: SlaveLimits,
}

/// The machine data of the slave's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveLimits {
    /// Its own dynamic limits.
    pub dynamics: Limits,
    /// Lower software limit of its position, u.
    pub min_position: Option<f64>,
    /// Upper software limit of its position, u.
    pub max_position: Option<f64>,
    /// Given if the axis never leaves its limits of position, velocity, acceleration and jerk, whatever
    /// is commanded. A synchronisation that would is refused then, whether the sync mode checks it
    /// or not. The original lets the slave do what it has planned.
    pub guard: Option<LimitGuard>,
}

/// Limits that an axis never leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitGuard {
    /// Which part of velocity, acceleration and deceleration is left to a master that ripples,
    /// where a command names no limit: 0 to less than 1. A slave that needs it already at the
    /// coupling moment keeps it.
    pub reserve: f64,
}

impl SlaveLimits {
    /// A limit of a synchronisation: as the command has it, or the axis's own. `now` is what it
    /// limits, at the coupling moment.
    pub(super) fn in_force(&self, given: Option<f64>, own: f64, now: f64) -> f64 {
        match (given, self.guard) {
            (Some(given), Some(_)) if given > own => own,
            (Some(given), _) => given,
            (None, Some(guard)) => (own * (1.0 - guard.reserve)).max(now.abs().min(own)),
            (None, None) => own,
        }
    }

    /// The same for the jerk, of which a master that ripples is left nothing.
    pub(super) fn jerk_in_force(&self, given: Option<f64>) -> f64 {
        let own = self.dynamics.jerk();
        match (given, self.guard) {
            (Some(given), Some(_)) => given.min(own),
            (given, _) => given.unwrap_or(own),
        }
    }
}

/// An encoder as a master: TS5055 7. Accelerations of less than two increments of position per
/// cycle and cycle are its noise and count as zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderMaster {
    /// User units per increment.
    pub scaling: f64,
    /// The cycle time.
    pub cycle: Seconds,
}

impl EncoderMaster {
    /// The smallest acceleration that counts, u/s².
    #[must_use]
    pub fn acceleration_threshold(&self) -> f64 {
        2.0 * self.scaling.abs() / (self.cycle.0 * self.cycle.0)
    }
}

impl CouplingMoment {
    /// The moment as it is to be planned for: with a velocity that is given of a master that stands, beside a slave that does
    /// too, in this direction. As long as the master stands, the slave has nothing to do: a profile over its position begins when
    /// it goes.
    ///
    /// # Errors
    /// [`SawRefusal::Limit`] for a velocity that is none.
    pub(super) fn going(
        &self,
        master_velocity: Option<f64>,
        direction: f64,
    ) -> Result<Self, SawRefusal> {
        let Some(received) = master_velocity else {
            return Ok(*self);
        };
        if !(received > 0.0 && received.is_finite()) {
            let field = "master-velocity";
            return Err(SawRefusal::Limit { field, received });
        }
        let stands = |axis: &Kinematics| axis.velocity == 0.0 && axis.acceleration == 0.0;
        if !(stands(&self.master) && stands(&self.slave)) || direction == 0.0 {
            return Ok(*self);
        }
        let velocity = received.copysign(direction);
        Ok(Self {
            master: Kinematics {
                velocity,
                ..self.master
            },
            ..*self
        })
    }

    /// The master's acceleration as planning sees it.
    pub(super) fn master_acceleration(&self) -> f64 {
        let acceleration = self.master.acceleration;
        match self.encoder {
            Some(encoder) if acceleration.abs() < encoder.acceleration_threshold() => 0.0,
            _ => acceleration,
        }
    }
}
