//! Applying a plan, which cannot fail.

use coaxle_axis::drive::DriveState;
use coaxle_axis::{AxisStatus, CommandState, CouplingEffect, Job, Origin, Transition};
use coaxle_cam::Tables;
use coaxle_curve::profile::{Kinematics, Profile};

use super::SlaveAxis;
use crate::change::{Change, Effect, TakesOver};
use crate::command::Command;
use crate::couplings::Engagement;
use crate::job::Jobs;
use crate::motion::{Motion, Planned};
use crate::refusal::Refusal;

impl SlaveAxis {
    /// Plans a command and applies it.
    ///
    /// # Errors
    /// [`Refusal`] gives the reason; the axis continues as before.
    pub fn command(&mut self, plates: &mut Tables, command: &Command) -> Result<Job, Refusal> {
        let change = self.plan(plates, command)?;
        Ok(self.apply(plates, change, Origin::Program))
    }

    /// Applies a plan. Motions begin with the next [`update`](Self::update);
    /// [`progress`](Self::progress) returns their state, and [`take_ended`](Self::take_ended) their
    /// end.
    ///
    /// # Panics
    /// If the axis or the plates have changed since the plan: plan and apply belong together.
    pub fn apply(&mut self, plates: &mut Tables, change: Change, origin: Origin) -> Job {
        // An outdated plan would begin in a state that the axis has left: a jump of the set values.
        assert_eq!(
            change.revisions,
            [self.revision, plates.revision()],
            "a change is applied to the axis that it was planned for, before anything else happens"
        );
        self.revision = self.revision.wrapping_add(1);
        let Change {
            command,
            transition,
            effect,
            ..
        } = change;
        // First, because a coupling that only changes keeps motion, offsets and, if it continues, its job.
        if let Effect::Couple(engagement, coupling_effect) = &effect
            && let Some(job) = self.adjust(plates, engagement, *coupling_effect, command, origin)
        {
            return job;
        }
        let takes_over = effect.takes_over();
        let job = match takes_over {
            TakesOver::No => Jobs::at_once(command, origin),
            _ => self.jobs.number(command, origin),
        };
        self.carry_out(plates, effect, job);
        // After the effect and before the state of the job, which depends on both motion and state.
        if let Some(transition) = transition.and_then(|arrow| self.arrow_now(arrow)) {
            self.state.follow(transition);
        }
        match takes_over {
            TakesOver::No | TakesOver::GoesOnBeside => {}
            TakesOver::AndIsDone => self.jobs.replace(job, CommandState::Done),
            TakesOver::AndGoesOn => self.jobs.replace(job, self.job_state()),
        }
        job
    }

    /// Changes the coupling that moves the axis, which continues.
    fn adjust(
        &mut self,
        plates: &mut Tables,
        engagement: &Engagement,
        effect: CouplingEffect,
        command: &'static str,
        origin: Origin,
    ) -> Option<Job> {
        let job = match effect {
            CouplingEffect::Engage => return None,
            CouplingEffect::Adjust => self.jobs.number(command, origin),
            CouplingEffect::Continue => self.jobs.motion().0?,
        };
        self.couplings.apply(plates, engagement, job);
        Some(job)
    }

    fn carry_out(&mut self, plates: &mut Tables, effect: Effect, job: Job) {
        match effect {
            Effect::Power(on) => self.power(plates, on),
            Effect::Reset => self.reset(plates),
            Effect::Home(position) => self.home(plates, position),
            Effect::Run(profile) => self.run(plates, profile),
            Effect::Stop(profile) => {
                self.set_back();
                self.run(plates, profile);
            }
            Effect::Couple(engagement, _) => self.engage(plates, &engagement, job),
            Effect::Phase(profile) => self.phasing.start(profile, job, &mut self.jobs),
            Effect::Superimpose(profile) => {
                self.superimposed.start(profile, job, &mut self.jobs);
            }
            Effect::Release => self.keep_velocity(plates),
            // The plan has checked that these can be done.
            Effect::PlateMode(table, mode) => {
                let _ = plates.set_online_change_mode(table, mode);
            }
            Effect::PlatePoints(table, points) => {
                let _ = plates.write(table, &points);
            }
            Effect::Read(_) => {}
        }
    }

    /// The arrow adjusted to the drive and to the standstill: a drive that does not follow yet
    /// leaves the axis without power, and power is switched off only after a cycle at rest.
    fn arrow_now(&self, transition: Transition) -> Option<Transition> {
        let follows = self.drive.actual().state == DriveState::Following;
        match (self.status(), transition) {
            (AxisStatus::Disabled, Transition::PowerOn) if !follows => None,
            (AxisStatus::ErrorStop, Transition::Reset { powered: true }) if !follows => {
                Some(Transition::Reset { powered: false })
            }
            (AxisStatus::Standstill, Transition::PowerOff) if !self.stands() => {
                Some(Transition::Stop)
            }
            _ => Some(transition),
        }
    }

    fn power(&mut self, plates: &mut Tables, on: bool) {
        self.powered = on;
        let before = self.status();
        if !on {
            // What is shown comes to rest, and not what would be shown later.
            self.set_back();
        }
        // Read before any change: a drive that is still switching on has to be switched off, too.
        let is_off = self.drive.actual().state == DriveState::Off;
        if before == AxisStatus::Disabled && on {
            self.switch_on(plates);
        } else if before == AxisStatus::Standstill && !on && self.stands()
            || before == AxisStatus::Disabled && !is_off
        {
            self.switch_off(plates);
        } else if !on && !matches!(before, AxisStatus::Disabled | AxisStatus::ErrorStop) {
            // As fast as the axis can, regardless of a current stop.
            let brake = self.guard.brake(&self.free());
            self.run(plates, brake);
            self.jobs.set(CommandState::Aborted);
        }
    }

    fn reset(&mut self, plates: &mut Tables) {
        if self.status() != AxisStatus::ErrorStop {
            return;
        }
        // A drive that tripped takes power again only after its own reset.
        if self.is_set_anew_by_reset() {
            self.switch_off(plates);
        }
        if self.powered && self.drive.actual().state == DriveState::Off {
            self.switch_on(plates);
        }
        self.error = None;
        // Only now: the values of the failed coupling could be read until the reset.
        self.couplings.end_all(plates);
    }

    /// True if a reset presets the position to that of the drive.
    pub(super) fn is_set_anew_by_reset(&self) -> bool {
        self.drive.actual().state != DriveState::Following || !self.powered
    }

    fn switch_on(&mut self, plates: &mut Tables) {
        self.drive.power_on(self.drive.actual().position, 0.0);
        self.stand_where_drive_is(plates);
    }

    pub(super) fn switch_off(&mut self, plates: &mut Tables) {
        self.drive.reset();
        self.stand_where_drive_is(plates);
    }

    /// Places the axis at its drive, without passing a software limit if the drive overshot.
    pub(super) fn stand_where_drive_is(&mut self, plates: &mut Tables) {
        self.drive.release();
        let actual = Kinematics::at_rest(self.actual_position());
        // A drive may rest beyond a software limit by its following error.
        let stands = self.guard.confined(self.set.position, &actual);
        self.stand_at(plates, stands.position);
    }

    fn home(&mut self, plates: &mut Tables, position: f64) {
        // The drive goes on counting as before. Only the offset changes, so that homing is no step for it.
        self.drive_zero += position - self.set.position;
        self.homed = true;
        self.stand_at(plates, position);
    }

    fn stand_at(&mut self, plates: &mut Tables, position: f64) {
        self.place(&Kinematics::at_rest(position));
        // A preset is no way: otherwise the axis would seem to move in this cycle.
        self.mean_velocity = 0.0;
        self.set_anew = self.set_anew.wrapping_add(1);
        self.is_preset = true;
        self.move_by(plates, Motion::Own(Planned::rest(position, &self.guard)));
    }

    pub(super) fn run(&mut self, plates: &mut Tables, profile: Profile) {
        // A hold in `Stopping` referred to another motion.
        self.stop_held = false;
        // Before the motion is replaced, from which this state comes.
        let start = self.free();
        self.move_by(plates, Motion::Own(Planned::new(profile).from(start)));
    }

    /// Engages this coupling, even in place of one of its kind.
    fn engage(&mut self, plates: &mut Tables, engagement: &Engagement, job: Job) {
        self.exempt = false;
        self.end_coupling(plates);
        // The coupling was planned from a set position that contains this offset. A phasing stays, as part of the
        // master.
        self.superimposed
            .drop(CommandState::Aborted, &mut self.jobs);
        self.couplings.apply(plates, engagement, job);
        // The coupling was planned from the axis's position.
        self.left_behind = None;
        self.motion = Motion::Coupled(engagement.kind());
    }

    /// Makes this the only motion of the axis.
    pub(super) fn move_by(&mut self, plates: &mut Tables, motion: Motion) {
        self.exempt = false;
        // While the old motion is still known: it says which coupling ends.
        self.end_coupling(plates);
        self.phasing.drop(CommandState::Aborted, &mut self.jobs);
        self.superimposed
            .drop(CommandState::Aborted, &mut self.jobs);
        self.motion = motion;
    }

    fn end_coupling(&mut self, plates: &mut Tables) {
        // Values of a failed coupling stay readable until the error is acknowledged.
        if let Motion::Coupled(kind) = self.motion
            && self.error.is_none()
        {
            self.couplings.end(kind, plates);
        }
    }

    /// Continues without a coupling, at the current velocity.
    fn keep_velocity(&mut self, plates: &mut Tables) {
        let keeps = Planned::keep_velocity(&self.free(), &self.guard);
        self.move_by(plates, Motion::Own(keeps));
    }

    /// Continues after a coupling that has ended by itself.
    pub(super) fn release(&mut self, plates: &mut Tables) {
        self.keep_velocity(plates);
        self.state.follow(self.released());
    }

    /// The arrow after the end of a coupling.
    pub(super) fn released(&self) -> Transition {
        let free = self.free();
        Transition::Released {
            at_rest: free.velocity == 0.0 && free.acceleration == 0.0,
        }
    }
}
