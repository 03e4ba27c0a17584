//! The cycle of the axis.

use coaxle_cam::Tables;
use coaxle_clock::Seconds;

use coaxle_axis::drive::{DriveFault, DriveState};
use coaxle_axis::guard::GuardFault;
use coaxle_axis::set_value_guard::{GuardState, Guarded};
use coaxle_axis::{AxisStatus, CommandState, CouplingPhase, Scan, Step, Transition};
use coaxle_curve::profile::{Kinematics, to_velocity};

use super::SlaveAxis;
use crate::circle::CircleState;
use crate::couplings::Kind;
use crate::error::SlaveError;
use crate::job::{JobError, JobState};
use crate::motion::{Motion, Planned};
use crate::parameters::OnMasterLoss;
use crate::refusal::Refusal;
use crate::shift::{minus, plus};

impl SlaveAxis {
    /// The part of the time since the last cycle in which the axis can have moved: from a preset position on it is a cycle. The
    /// preset is of this scan, and so are commands beside it. In wide schedules 606458 and 605685 an axis got power after 70 and
    /// after 142 skipped cycles, and was where a motion of that length had led it, up to 7 u away from its drive.
    pub(super) fn moving_time(&mut self, elapsed: Seconds) -> Seconds {
        match core::mem::take(&mut self.is_preset) {
            true => Seconds(elapsed.0.min(self.cycle_time)),
            false => elapsed,
        }
    }

    /// Advances the motion. Masters have moved for `elapsed`, the axis for the time `moving`.
    pub(super) fn advance(
        &mut self,
        plates: &mut Tables,
        elapsed: Seconds,
        moving: Seconds,
    ) -> Result<(), SlaveError> {
        // Offsets first, so that masters and set values are seen with those of this cycle.
        self.phasing.advance(elapsed, &mut self.jobs);
        self.superimposed.advance(moving, &mut self.jobs);
        let here = self.set;
        let added = self.added();
        match &mut self.motion {
            Motion::Own(planned) => {
                let next = plus(planned.advance(moving), added);
                // Motions with an end were checked as a whole when they were commanded.
                if self.status() == AxisStatus::ContinuousMotion {
                    self.guard.check_stop(here.position, &next)?;
                }
                self.move_to(&self.guard.confined(here.position, &next), moving);
                Ok(())
            }
            // Only a coupled axis returns its set values to itself. A motion of its own opens the circle.
            Motion::Coupled(_) if self.circle == CircleState::Closed => {
                Err(SlaveError::FollowsItself)
            }
            Motion::Coupled(kind) => {
                let kind = *kind;
                self.follow(plates, kind, elapsed, moving)
            }
        }
    }

    /// Runs one cycle of a coupling.
    fn follow(
        &mut self,
        plates: &mut Tables,
        kind: Kind,
        elapsed: Seconds,
        moving: Seconds,
    ) -> Result<(), SlaveError> {
        let masters = self.seen_masters();
        let left_behind = self.left_behind;
        let scan = Scan {
            masters,
            elapsed,
            left_behind,
        };
        match self.couplings.update(kind, plates, &scan) {
            Step::Set(next) => self.go_to(next, moving)?,
            Step::Ended(next) => {
                // Before the release, which goes on from there.
                self.go_to(next, moving)?;
                self.release(plates);
                self.jobs.set(CommandState::Done);
            }
            Step::Stopping { set, instant, over } => {
                self.stop_by_coupling(set, instant, moving)?;
                // Otherwise a superimposed motion under way would lose its velocity at once.
                if over && !self.superimposed.is_under_way() {
                    let rest = Planned::rest(self.set.position, &self.guard);
                    self.move_by(plates, Motion::Own(rest));
                }
            }
            Step::Refused => {
                let refusal = self.couplings.refusal(kind).map(Refusal::Coupling);
                self.go_on_without(
                    plates,
                    refusal.map_or(CommandState::Aborted, failed),
                    moving,
                );
            }
            Step::GivenUp => self.go_on_without(plates, CommandState::Aborted, moving),
            Step::Failed => {
                let fault = self.couplings.fault(kind).map(SlaveError::Coupling);
                // Kinds without faults of their own never fail.
                return Err(fault.unwrap_or(SlaveError::MasterLost));
            }
            Step::MasterLost => return Err(SlaveError::MasterLost),
        }
        Ok(())
    }

    fn go_to(&mut self, next: Kinematics, elapsed: Seconds) -> Result<(), GuardFault> {
        let next = plus(next, self.added());
        self.guard.check_values(&next)?;
        // A cycle that fails leaves no trace: the brake goes on from the last set values that left the axis.
        let before = self.last_stage.history();
        let cycles = self.last_stage.cycles_in(elapsed);
        let guarded = self.last_stage.update(&next, cycles);
        let checked = self.check_guarded(&guarded, &next, elapsed);
        match checked {
            Ok(()) => self.leave(&guarded),
            Err(_) => self.last_stage.go_back(before),
        }
        checked
    }

    fn check_guarded(
        &mut self,
        guarded: &Guarded,
        next: &Kinematics,
        elapsed: Seconds,
    ) -> Result<(), GuardFault> {
        let here = self.set.position;
        let left = self.last_stage.borne_out(&guarded.set);
        // From what has left the axis, and not from what was demanded: a brake would begin there.
        self.guard.check_coupled_stop(here, &left)?;
        // The last stage would hold the axis at a software limit for ever. A coupling that leads beyond it is a
        // fault.
        if guarded.state != GuardState::Tracking {
            self.guard.check_position(here, next.position)?;
        }
        self.check_distance(guarded, elapsed)
    }

    /// Checks the distance left by the limits: a fault if it is too large for too long.
    fn check_distance(&mut self, guarded: &Guarded, elapsed: Seconds) -> Result<(), GuardFault> {
        let left_behind = match guarded.state {
            // Values that pass have a distance only where the policy keeps it.
            GuardState::Tracking => 0.0,
            GuardState::Coasting | GuardState::CatchingUp | GuardState::Cannot => guarded.distance,
        };
        if self.window.trips(left_behind, elapsed) {
            let (distance, window) = (left_behind, self.window.window());
            return Err(GuardFault::LeftBehind { distance, window });
        }
        Ok(())
    }

    /// Passes set values of its own motion through the last stage.
    fn move_to(&mut self, target: &Kinematics, elapsed: Seconds) {
        // A quick stop breaks the jerk limit on purpose, and the last stage would restore it.
        if self.exempt {
            self.place(target);
            return;
        }
        let cycles = self.last_stage.cycles_in(elapsed);
        let guarded = self.last_stage.update(target, cycles);
        self.leave(&guarded);
    }

    fn leave(&mut self, guarded: &Guarded) {
        self.set = guarded.set;
        self.tracking = guarded.state;
        self.distance = guarded.distance;
        // A coupling plans its own part only, and knows no superimposed motion.
        self.left_behind = self.is_left_behind(guarded).then(|| match self.added() {
            Some(added) => minus(&guarded.set, &added),
            None => guarded.set,
        });
    }

    /// True if the axis is farther from its motion than allowed in sync. A distance with which it
    /// passes is one that its policy keeps.
    fn is_left_behind(&self, guarded: &Guarded) -> bool {
        // 32·δ, with the δ = 4ε·|p| by which rounding may move a position (docs/INVARIANTS.md).
        let rounding = 128.0 * f64::EPSILON * guarded.set.position.abs();
        guarded.state != GuardState::Tracking
            && guarded.distance.abs() > self.in_sync_window + rounding
    }

    /// Places the axis here, without limiting the step.
    pub(super) fn place(&mut self, here: &Kinematics) {
        self.last_stage.start(here);
        self.set = *here;
        self.tracking = GuardState::Tracking;
        self.distance = 0.0;
        self.left_behind = None;
        // A preset position is no distance that the axis was left behind.
        self.window.forget();
    }

    /// Handles a reversal of the masters, at which the coupling brings the axis to rest.
    fn stop_by_coupling(
        &mut self,
        next: Kinematics,
        instant: bool,
        elapsed: Seconds,
    ) -> Result<(), GuardFault> {
        // Past the last stage: TS5055's instant stop drops the velocity within a cycle, beyond acceleration and jerk.
        if instant {
            let next = plus(next, self.added());
            self.guard.check_values(&next)?;
            self.guard.check_coupled_stop(self.set.position, &next)?;
            self.place(&next);
        } else {
            self.go_to(next, elapsed)?;
        }
        self.state.follow(Transition::RolledBack);
        self.jobs.roll_back();
        Ok(())
    }

    /// Continues as before, after a coupling was refused when it was due.
    fn go_on_without(&mut self, plates: &mut Tables, state: JobState, elapsed: Seconds) {
        self.release(plates);
        self.jobs.set(state);
        // In the same cycle. Otherwise the axis would stand for it, with a velocity.
        self.run_plan(elapsed);
    }

    pub(super) fn run_plan(&mut self, elapsed: Seconds) {
        let added = self.added();
        if let Motion::Own(planned) = &mut self.motion {
            let next = plus(planned.advance(elapsed), added);
            let confined = self.guard.confined(self.set.position, &next);
            self.move_to(&confined, elapsed);
        }
    }

    /// Goes to error stop, within the limits.
    pub(super) fn fail(&mut self, plates: &mut Tables, error: SlaveError) {
        let quick = error.is_loss_of_master() && self.on_master_loss == OnMasterLoss::QuickStop;
        let limits = if quick {
            self.guard.without_jerk_limit(self.cycle_time)
        } else {
            *self.guard.limits()
        };
        // First of all: what is shown brakes, and not what would be shown later.
        self.set_back();
        // Before anything changes: the brake begins in the state of the failed motion.
        let mut from = self.free();
        if quick {
            from.velocity = self.borne_velocity(from.velocity);
        }
        let brake = to_velocity(&from, 0.0, &limits);
        if let Motion::Coupled(kind) = self.motion {
            // Not ended but failed: values of the coupling remain readable.
            self.couplings.fail(kind, plates, error.code());
        }
        // Before the brake replaces the motion, which would otherwise end the coupling.
        self.error = Some(error);
        let failed = CommandState::Failed(JobError::Failed(error));
        self.phasing.drop(failed, &mut self.jobs);
        self.superimposed.drop(failed, &mut self.jobs);
        self.run(plates, brake);
        // After the start of the brake, which ends the exemption of the motion before.
        self.exempt = quick;
        self.state.follow(Transition::Fault);
        self.jobs.set(failed);
    }

    /// The nearest velocity that the axis can have come to since the middle of its newest cycle, where its positions have the mean: half of
    /// that cycle of its acceleration away. What is stated may be farther, as in the cycle in which a blend begins, and nothing limits
    /// the positions of a quick stop from there.
    fn borne_velocity(&self, stated: f64) -> f64 {
        let limits = self.guard.limits();
        let most = 0.5 * limits.acceleration().max(limits.deceleration()) * self.newest_cycle;
        let mean = self.mean_velocity;
        // Not `clamp`, which panics with a bound that is not a number.
        stated.max(mean - most).min(mean + most)
    }

    /// Handles the end of the motion, and updates the command's state. Power is switched off only
    /// after the output of the axis stands: the position is then preset to that of the drive.
    pub(super) fn finish(&mut self, plates: &mut Tables, stood: bool) {
        if self.own_motion_is_over() && self.status() != AxisStatus::ContinuousMotion {
            self.jobs.set(CommandState::Done);
            let is_held = if self.powered {
                self.stop_held
            } else {
                // At rest in two cycles: the drive has then received a velocity of 0 before it loses power.
                !(stood && self.stands())
            };
            if !is_held {
                self.finished(plates);
            }
        }
        self.jobs.set(self.job_state());
    }

    fn finished(&mut self, plates: &mut Tables) {
        let finished = Transition::Finished {
            powered: self.powered,
        };
        self.state.follow(finished);
        if !self.powered && self.drive.actual().state != DriveState::Off {
            self.switch_off(plates);
        }
    }

    /// State of a command that has not ended.
    pub(super) fn job_state(&self) -> JobState {
        match &self.motion {
            Motion::Own(planned)
                if self.status() == AxisStatus::ContinuousMotion && planned.is_over() =>
            {
                // The velocity is reached and kept: the command goes on until another takes over.
                CommandState::InSync
            }
            Motion::Own(_) => CommandState::Active,
            Motion::Coupled(_) => match self.coupling_phase() {
                None => CommandState::Done,
                Some(CouplingPhase::Waiting | CouplingPhase::Released) => CommandState::Waiting,
                Some(phase) if phase.is_in_sync() => CommandState::InSync,
                Some(_) => CommandState::Active,
            },
        }
    }

    pub(super) fn move_drive(&mut self, plates: &mut Tables, elapsed: Seconds) {
        let set = Kinematics {
            // Homing shifts the axis and not the drive.
            position: self.set.position - self.drive_zero,
            ..self.set
        };
        let stands = self.stands();
        self.drive.step(&set, elapsed, self.hold_back, stands);
        let lost = match (self.status(), self.drive.actual().state) {
            // An axis in error stop reacts already. A second error would hide the first one, which is the cause.
            (AxisStatus::ErrorStop, _) | (_, DriveState::Following) => return,
            (_, DriveState::Tripped) => self.drive.fault(),
            // Without power, or on the way to it, a drive need not follow.
            (AxisStatus::Disabled, DriveState::Off | DriveState::SwitchingOn) => return,
            (_, DriveState::Off | DriveState::SwitchingOn) => DriveFault::PowerLost,
        };
        self.fail(plates, SlaveError::Drive(lost));
    }

    /// Keeps an axis that is to have power at its drive's position, until the drive follows.
    pub(super) fn wait_for_drive(&mut self, plates: &mut Tables) {
        if self.status() != AxisStatus::Disabled || !self.powered {
            return;
        }
        // In each cycle, because an axis without power can be moved.
        self.stand_where_drive_is(plates);
        if self.drive.actual().state == DriveState::Following {
            self.state.follow(Transition::PowerOn);
        }
    }
}

const fn failed(refusal: Refusal) -> JobState {
    CommandState::Failed(JobError::Refused(refusal))
}
