//! The coupling moment: what is known when a synchronisation is planned.

use coaxle_clock::Seconds;

use crate::profile::{Kinematics, Limits};

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
    /// The master's acceleration as planning sees it.
    pub(super) fn master_acceleration(&self) -> f64 {
        let acceleration = self.master.acceleration;
        match self.encoder {
            Some(encoder) if acceleration.abs() < encoder.acceleration_threshold() => 0.0,
            _ => acceleration,
        }
    }
}
