//! What ties a slave axis to its master.

use coaxle_clock::Seconds;

use coaxle_axis::{CommandState, CouplingPhase};
use coaxle_curve::profile::Kinematics;
use coaxle_gear::{FlyingGear, LinearGear};
use coaxle_saw::{RollbackReaction, SawCoupling};

use super::error::SlaveError;
use super::rolling_back::RollingBack;
use coaxle_cam::Cams;

/// A coupling of a slave axis, of whatever kind. It says where the slave should be; whether the
/// slave can be there is the axis's own business.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives in place: nothing is allocated on the cycle path"
)]
pub(super) enum Coupling {
    /// A constant ratio.
    Linear(LinearGear),
    /// A gear that is engaged and released on the fly.
    Flying(FlyingGear),
    /// Cam plates: those of the axis.
    Cam,
    /// A flying saw.
    Saw(SawCoupling),
}

impl Coupling {
    /// The slave's set values for the master's, `elapsed` after the last ones.
    pub(super) fn update(
        &mut self,
        cams: &mut Cams,
        master: &Kinematics,
        elapsed: Seconds,
    ) -> Result<Kinematics, SlaveError> {
        Ok(match self {
            Self::Linear(gear) => gear.slave_of(master),
            Self::Flying(gear) => gear.update(master),
            Self::Cam => cams.update(master).map_err(SlaveError::Cam)?,
            Self::Saw(saw) => {
                let slave = saw.update(master, elapsed);
                match *saw.state() {
                    CommandState::Failed(fault) => return Err(SlaveError::Saw(fault)),
                    _ => slave,
                }
            }
        })
    }

    /// How its slave is stopped, and how far that is, once its master has run back.
    pub(super) fn rollback(&self) -> Option<(RollbackReaction, RollingBack)> {
        let Self::Saw(saw) = self else {
            return None;
        };
        let (stop, since) = saw.rollback_stop()?;
        Some((saw.rollback()?, RollingBack::new(stop, since)))
    }

    /// How far it is; none once it has ended by itself.
    pub(super) fn phase(&self, cams: &Cams) -> Option<CouplingPhase> {
        match self {
            Self::Linear(_) => Some(CouplingPhase::InSync),
            Self::Flying(gear) => Some(gear.phase().into()),
            Self::Cam => cams.phase(),
            Self::Saw(saw) => match saw.state() {
                CommandState::Waiting => Some(CouplingPhase::Waiting),
                CommandState::Active => Some(CouplingPhase::Synchronizing),
                CommandState::InSync => Some(CouplingPhase::InSync),
                _ => None,
            },
        }
    }
}
