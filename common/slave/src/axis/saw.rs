//! The axis as a flying saw.

use coaxle_clock::Seconds;

use coaxle_saw::{
    CouplingMoment, EncoderMaster, LimitGuard, SawCommand, SawCoupling, SawPlan, SawRefusal,
    SawTolerances, SlaveLimits,
};

use super::SlaveAxis;
use crate::coupling::Coupling;
use crate::motion::Motion;
use crate::refusal::Refusal;
use coaxle_axis::guard::ROUNDING;

/// What a synchronisation leaves of velocity, acceleration and deceleration to a master that
/// ripples, where its command names no limit. The axis keeps its limits with both together, or is
/// in error stop.
const RESERVE: f64 = 0.01;

impl SlaveAxis {
    /// The plan of the flying saw that couples the axis; while it waits, the plan foreseen. Without
    /// one, that of the last.
    #[must_use]
    pub const fn saw_plan(&self) -> Option<&SawPlan> {
        match &self.motion {
            Motion::Coupled(Coupling::Saw(saw)) => Some(saw.plan()),
            _ => self.last_saw.as_ref(),
        }
    }

    /// What a flying saw would be planned from now; none without a master. Of a command that is
    /// refused, it tells what would have passed: [`SawCommand::remedy`].
    #[must_use]
    pub fn coupling_moment(&self) -> Option<CouplingMoment> {
        let (min_position, max_position) = self.guard.software_limits();
        let encoder = |scaling| EncoderMaster {
            scaling,
            cycle: Seconds(self.cycle_time),
        };
        Some(CouplingMoment {
            master: self.master?,
            encoder: self.master_traits.increment.map(encoder),
            slave: self.set,
            axis: SlaveLimits {
                dynamics: *self.guard.limits(),
                min_position,
                max_position,
                guard: Some(LimitGuard { reserve: RESERVE }),
            },
        })
    }

    /// The synchronisation that a command to a flying saw would come to now, whatever the state of
    /// the axis.
    ///
    /// # Errors
    /// [`Refusal`]: there is no master, or no such synchronisation.
    pub fn foresee(&self, command: SawCommand) -> Result<SawPlan, Refusal> {
        Ok(*self.saw_coupling(command)?.plan())
    }

    pub(super) fn saw(&mut self, command: SawCommand) -> Result<(), Refusal> {
        let coupling = self.saw_coupling(command)?;
        self.move_by_motion(Motion::Coupled(Coupling::Saw(coupling)));
        Ok(())
    }

    fn saw_coupling(&self, command: SawCommand) -> Result<SawCoupling, Refusal> {
        let moment = self.coupling_moment().ok_or(Refusal::NoMaster)?;
        if let Some(table) = self.saw_table_in_use {
            return Err(SawRefusal::TableInUse { table }.into());
        }
        // The axis watches its limits itself.
        let tolerances = SawTolerances {
            master_noise: self.master_traits.noise,
            velocity_margin: ROUNDING,
        };
        Ok(SawCoupling::start(command, &moment, tolerances)?)
    }
}
