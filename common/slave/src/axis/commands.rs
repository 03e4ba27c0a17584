//! What each command makes of the axis. Whether the state diagram has the arrow is known by then.

use coaxle_axis::drive::DriveState;
use coaxle_axis::guard::check_number;
use coaxle_axis::{AxisStatus, CommandState, Dynamics, Transition};
use coaxle_cam as cam;
use coaxle_curve::profile::{
    Kinematics, Limits, Profile, ProfileExtremes, to_position, to_velocity,
};
use coaxle_gear::{FlyingGear, FlyingGearParameters, LinearGear};

use super::{Accepted, SlaveAxis};
use crate::coupling::Coupling;
use crate::job::JobNumber;
use crate::motion::{Motion, Planned};
use crate::refusal::Refusal;

impl SlaveAxis {
    pub(super) fn power(&mut self, on: bool) {
        self.powered = on;
        let before = self.status();
        let next = self.state.follow(if on {
            Transition::PowerOn
        } else {
            Transition::PowerOff
        });
        if before == AxisStatus::Disabled && on {
            self.switch_on();
        } else if before == AxisStatus::Standstill && !on {
            self.switch_off();
        } else if next == AxisStatus::Stopping && before != next {
            let brake = self.guard.brake(&self.free());
            self.run(brake);
            self.job.set(CommandState::Aborted);
        }
    }

    pub(super) fn reset(&mut self) -> Result<(), Refusal> {
        if self.status() == AxisStatus::ErrorStop {
            if !self.is_at_rest() {
                return Err(Refusal::NotAtRest {
                    velocity: self.set.velocity,
                });
            }
            if self.drive.state() == DriveState::Tripped || !self.powered {
                self.switch_off();
            }
            if self.powered && self.drive.state() == DriveState::Off {
                self.switch_on();
            }
            self.error = None;
            self.cams.end();
        }
        self.state.follow(Transition::Reset {
            powered: self.powered,
        });
        Ok(())
    }

    fn switch_on(&mut self) {
        self.drive.power_on(self.drive.position(), 0.0);
        self.stand_where_drive_is();
    }

    pub(super) fn switch_off(&mut self) {
        self.drive.reset();
        self.stand_where_drive_is();
    }

    /// A drive that overshot does not take the set position beyond a software limit.
    fn stand_where_drive_is(&mut self) {
        let actual = Kinematics::at_rest(self.actual_position());
        let stands = self.guard.confined(self.set.position, &actual);
        self.stand_at(stands.position);
    }

    pub(super) fn home(&mut self, position: f64) -> Result<(), Refusal> {
        self.guard.check_target("position", position)?;
        self.drive_zero += position - self.set.position;
        self.homed = true;
        self.stand_at(position);
        Ok(())
    }

    fn stand_at(&mut self, position: f64) {
        self.set = Kinematics::at_rest(position);
        self.move_by_motion(Motion::Planned(Planned::rest(position, &self.guard)));
    }

    pub(super) fn move_to(
        &mut self,
        field: &'static str,
        target: f64,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<(), Refusal> {
        self.guard.check_target(field, target)?;
        let start = self.free();
        let profile = self.plan(velocity, dynamics, |limits| {
            to_position(&start, target, limits)
        })?;
        self.guard
            .check_way(start.position, &ProfileExtremes::of(&profile))?;
        self.run(profile);
        Ok(())
    }

    pub(super) fn move_by(
        &mut self,
        distance: f64,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<(), Refusal> {
        check_number("distance", distance)?;
        self.move_to("target", self.set.position + distance, velocity, dynamics)
    }

    pub(super) fn move_at(&mut self, velocity: f64, dynamics: &Dynamics) -> Result<(), Refusal> {
        check_number("velocity", velocity)?;
        self.guard.check_speed(velocity)?;
        let start = self.free();
        let profile = self.plan(None, dynamics, |limits| {
            to_velocity(&start, velocity, limits)
        })?;
        self.run(profile);
        Ok(())
    }

    pub(super) fn stop(&mut self, dynamics: &Dynamics) -> Result<(), Refusal> {
        let start = self.free();
        let profile = self.plan(None, dynamics, |limits| to_velocity(&start, 0.0, limits))?;
        self.run(profile);
        Ok(())
    }

    /// A profile with the dynamics of a command, or with the axis's own where those are too slow to
    /// keep the highest velocity and the software limits from here.
    fn plan(
        &self,
        velocity: Option<f64>,
        dynamics: &Dynamics,
        plan: impl Fn(&Limits) -> Profile,
    ) -> Result<Profile, Refusal> {
        let profile = plan(&self.guard.limits_of(velocity, dynamics)?);
        let extremes = ProfileExtremes::of(&profile);
        let keeps = self.guard.keeps_velocity(&extremes)
            && self.guard.check_way(self.set.position, &extremes).is_ok();
        if keeps {
            Ok(profile)
        } else {
            Ok(plan(&self.guard.limits_of(velocity, &Dynamics::default())?))
        }
    }

    pub(super) fn gear_in(&mut self, ratio: f64) -> Result<(), Refusal> {
        let master = self.master.ok_or(Refusal::NoMaster)?;
        let offset = self.set.position - ratio * master.position;
        let gear = LinearGear::new(ratio, offset)?;
        let coupled = ratio * master.velocity;
        self.guard.check_speed(coupled)?;
        let limits = self.guard.limits();
        let allowed = limits.acceleration().min(limits.deceleration()) * self.cycle_time;
        if (coupled - self.set.velocity).abs() > allowed {
            return Err(Refusal::VelocityJump {
                velocity: self.set.velocity,
                coupled,
                allowed,
            });
        }
        self.move_by_motion(Motion::Coupled(Coupling::Linear(gear)));
        Ok(())
    }

    pub(super) fn flying_gear(&mut self, parameters: &FlyingGearParameters) -> Result<(), Refusal> {
        let master = self.master.ok_or(Refusal::NoMaster)?;
        if !self.is_at_rest() {
            return Err(Refusal::NotAtRest {
                velocity: self.set.velocity,
            });
        }
        let gear = FlyingGear::enable(parameters, &master, self.set.position)?;
        self.move_by_motion(Motion::Coupled(Coupling::Flying(gear)));
        Ok(())
    }

    /// A coupling by cam plates, or a change to the one there is.
    pub(super) fn cam(&mut self, command: &cam::Command) -> Result<Accepted, Refusal> {
        let master = self.master.ok_or(Refusal::NoMaster)?;
        let is_coupled = self.is_on_cams();
        let ticket = self.cams.start(is_coupled, command, &master, &self.set)?;
        if is_coupled {
            return Ok(Accepted::Change(ticket));
        }
        self.move_by_motion(Motion::Coupled(Coupling::Cam));
        self.state.follow(Transition::Couple);
        Ok(Accepted::Job(self.job.replace(self.job_state())))
    }

    /// Done as soon as it is said: the velocity is kept, the acceleration removed.
    pub(super) fn gear_out(&mut self) -> JobNumber {
        self.let_go();
        self.job.replace(CommandState::Done)
    }

    /// The axis keeps its velocity, on its own.
    pub(super) fn let_go(&mut self) {
        // A deceleration is still there for a stop in this very cycle.
        self.set = self.free();
        let keeps = Planned::keep_velocity(&self.set, &self.guard);
        self.move_by_motion(Motion::Planned(keeps));
        self.state.follow(Transition::Released {
            at_rest: self.set.velocity == 0.0,
        });
    }
}
