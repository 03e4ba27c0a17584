//! What happens in a cycle.

use coaxle_clock::Seconds;

use coaxle_axis::drive::DriveState;
use coaxle_axis::{AxisStatus, CommandState, CouplingPhase, Transition};
use coaxle_curve::profile::to_velocity;
use coaxle_saw::{RollbackReaction, SawFault};

use super::SlaveAxis;
use crate::coupling::Coupling;
use crate::error::SlaveError;
use crate::motion::Motion;
use crate::parameters::OnMasterLoss;

impl SlaveAxis {
    pub(super) fn advance(&mut self, elapsed: Seconds) -> Result<(), SlaveError> {
        let here = self.set;
        match &mut self.motion {
            Motion::Planned(planned) => {
                let next = planned.advance(elapsed);
                // Motions with an end were checked as a whole when they were commanded.
                if self.status() == AxisStatus::ContinuousMotion {
                    self.guard.check_stop(here.position, &next)?;
                }
                self.set = self.guard.confined(here.position, &next);
            }
            Motion::RollingBack(stop) => {
                let next = stop.advance(elapsed);
                self.guard.check_step(&here, &next, elapsed.0)?;
                self.guard.check_coupled_stop(here.position, &next)?;
                self.set = next;
            }
            Motion::Coupled(_) => self.follow(elapsed)?,
        }
        Ok(())
    }

    /// One cycle of a coupling.
    fn follow(&mut self, elapsed: Seconds) -> Result<(), SlaveError> {
        let here = self.set;
        let Motion::Coupled(coupling) = &mut self.motion else {
            return Ok(());
        };
        let master = self.master.ok_or(SlaveError::MasterLost)?;
        let waited = coupling.phase(&self.cams) == Some(CouplingPhase::Waiting);
        let next = match coupling.update(&mut self.cams, &master, elapsed) {
            Err(refused @ SlaveError::Saw(SawFault::Refused(_))) => {
                self.go_on_without(CommandState::Failed(refused), elapsed);
                return Ok(());
            }
            updated => updated?,
        };
        if waited && matches!(coupling, Coupling::Cam) && self.cams.phase().is_none() {
            let state = match self.cams.failure() {
                Some(error) => CommandState::Failed(SlaveError::Cam(error)),
                None => CommandState::Aborted,
            };
            self.go_on_without(state, elapsed);
            return Ok(());
        }
        let rollback = coupling.rollback();
        match &rollback {
            Some((RollbackReaction::Instant, _)) => {
                self.guard.check_instant_step(&here, &next, elapsed.0)?;
            }
            _ => self.guard.check_step(&here, &next, elapsed.0)?,
        }
        self.guard.check_coupled_stop(here.position, &next)?;
        self.set = next;
        if let Some((_, stop)) = rollback {
            self.move_by_motion(Motion::RollingBack(stop));
            self.state.follow(Transition::RolledBack);
            self.job.set(CommandState::Aborted);
        }
        Ok(())
    }

    /// A coupling was refused when it was due: the axis goes on as before.
    fn go_on_without(&mut self, state: CommandState<SlaveError>, elapsed: Seconds) {
        self.let_go();
        self.job.set(state);
        self.run_plan(elapsed);
    }

    pub(super) fn run_plan(&mut self, elapsed: Seconds) {
        if let Motion::Planned(planned) = &mut self.motion {
            let next = planned.advance(elapsed);
            self.set = self.guard.confined(self.set.position, &next);
        }
    }

    /// To error stop, within the limits.
    pub(super) fn fail(&mut self, error: SlaveError) {
        let limits = match (error, self.on_master_loss) {
            (SlaveError::MasterLost, OnMasterLoss::QuickStop) => {
                self.guard.without_jerk_limit(self.cycle_time)
            }
            _ => *self.guard.limits(),
        };
        let brake = to_velocity(&self.free(), 0.0, &limits);
        self.cams.break_off(error.code());
        self.error = Some(error);
        self.run(brake);
        self.stop_held = false;
        self.state.follow(Transition::Fault);
        self.job.set(CommandState::Failed(error));
    }

    /// What follows from the motion having come to its end, and how far the command is.
    pub(super) fn finish(&mut self) {
        if self.is_on_cams() && self.cams.phase().is_none() {
            self.let_go();
            self.job.set(CommandState::Done);
        }
        let over = match &self.motion {
            Motion::Planned(planned) => planned.is_over(),
            Motion::RollingBack(stop) => stop.is_over(),
            Motion::Coupled(_) => false,
        };
        if over && self.status() != AxisStatus::ContinuousMotion {
            self.job.set(CommandState::Done);
            if !(self.stop_held && self.powered) {
                self.finished();
            }
        }
        self.job.set(self.job_state());
    }

    fn finished(&mut self) {
        let finished = Transition::Finished {
            powered: self.powered,
        };
        self.state.follow(finished);
        let unpowered = !self.powered && self.is_at_rest();
        if unpowered && self.drive.state() != DriveState::Off {
            self.switch_off();
        }
    }

    /// How far a command that has not ended is.
    pub(super) fn job_state(&self) -> CommandState<SlaveError> {
        match &self.motion {
            Motion::Planned(planned)
                if self.status() == AxisStatus::ContinuousMotion && planned.is_over() =>
            {
                CommandState::InSync
            }
            Motion::Planned(_) | Motion::RollingBack(_) => CommandState::Active,
            Motion::Coupled(coupling) => match coupling.phase(&self.cams) {
                None => CommandState::Done,
                Some(CouplingPhase::Waiting | CouplingPhase::Released) => CommandState::Waiting,
                Some(CouplingPhase::Synchronizing | CouplingPhase::Releasing) => {
                    CommandState::Active
                }
                Some(CouplingPhase::InSync) => CommandState::InSync,
            },
        }
    }

    pub(super) fn move_drive(&mut self, elapsed: Seconds) {
        self.drive
            .step(self.set.position - self.drive_zero, elapsed.0);
        let tripped = self.drive.state() == DriveState::Tripped;
        if tripped && self.status() != AxisStatus::ErrorStop {
            self.fail(SlaveError::FollowingError {
                following_error: self.drive.following_error(),
            });
        }
    }
}
