//! `MC_GearInMultiMaster` as a PLC function block.

use coaxle_axis::{CommandState, Job};
use coaxle_cam::Tables;
use coaxle_gear::GearInMultiMaster;
use coaxle_slave::{Command, JobError, Refusal, SlaveAxis};

use crate::Outputs;

/// `MC_GearInMultiMaster`, `MC_GearInDyn`: a function block with an `Enable` input. The ratios are read
/// in every scan. The falling edge uncouples the axis.
#[doc(alias = "MC_GearInMultiMaster")]
#[doc(alias = "MC_GearInDyn")]
#[doc(alias = "MC_CombineAxes")]
#[derive(Clone, Copy, Debug, Default)]
pub struct EnableMultiMasterGear {
    enabled: bool,
    job: Option<Job>,
    refused: Option<Refusal>,
}

impl EnableMultiMasterGear {
    /// Runs one scan. Refused ratios leave the previous ones in force.
    pub fn scan(
        &mut self,
        enable: bool,
        command: &GearInMultiMaster,
        axis: &mut SlaveAxis,
        plates: &mut Tables,
    ) -> Outputs {
        match (self.enabled, enable) {
            (false, true) => {
                // The refusal of an earlier edge says nothing of this one.
                *self = Self::default();
                match axis.command(plates, &Command::GearInMultiMaster(*command)) {
                    Ok(job) => self.job = Some(job),
                    Err(refusal) => self.refused = Some(refusal),
                }
            }
            // A dynamic gear reads its ratios in each scan; one that was replaced by another command must not take
            // the axis back.
            (true, true) if self.couples(axis) => {
                let again = axis.command(plates, &Command::GearInMultiMaster(*command));
                self.refused = again.err();
            }
            (true, false) => {
                // Asked before the block forgets its job.
                let couples = self.couples(axis);
                *self = Self::default();
                if couples {
                    self.refused = axis.command(plates, &Command::GearOut {}).err();
                }
            }
            _ => {}
        }
        self.enabled = enable;
        let state = match (self.refused, self.job) {
            // Refused ratios are an error although the previous ones still move the axis.
            (Some(refusal), _) => CommandState::Failed(JobError::Refused(refusal)),
            (None, Some(job)) => axis.progress(job),
            (None, None) => CommandState::Idle,
        };
        Outputs::of(&state, JobError::code)
    }

    /// True if its job still moves the axis.
    fn couples(&self, axis: &SlaveAxis) -> bool {
        self.job.is_some() && self.job == axis.job().0 && axis.coupling_phase().is_some()
    }
}

#[cfg(test)]
mod tests {
    use coaxle_axis::{Dynamics, Masters};
    use coaxle_clock::Seconds;
    use coaxle_curve::profile::Kinematics;
    use coaxle_gear::{MultiMasterSync, Ratios};

    use super::*;
    use crate::tests::{PARAMETERS, powered};

    #[test]
    fn an_accepted_gear_shows_no_earlier_refusal() {
        let command = GearInMultiMaster {
            ratios: Ratios::new(&[1.0]).unwrap(),
            dynamics: Dynamics::default(),
            sync_mode: MultiMasterSync::default(),
        };
        let mut axis = powered(&PARAMETERS);
        let masters = Masters::of([Some(Kinematics::at_rest(0.0))]);
        axis.update(&mut Tables::new(0), masters, Seconds(1e-3));
        // As a refused `GearOut` leaves it.
        let mut block = EnableMultiMasterGear {
            refused: axis
                .command(&mut Tables::new(0), &Command::GearOut {})
                .err(),
            ..EnableMultiMasterGear::default()
        };
        let off = block.scan(false, &command, &mut axis, &mut Tables::new(0));
        assert!(off.error && !off.busy);
        let on = block.scan(true, &command, &mut axis, &mut Tables::new(0));
        assert!(on.busy && !on.error, "{on:?}");
    }
}
