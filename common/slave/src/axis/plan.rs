//! Planning commands, without changes.

use coaxle_axis::guard::{ROUNDING, check_number};
use coaxle_axis::{Awaits, AxisStatus, Dynamics, NotPlanned, PlanInputs, Planned, Transition};
use coaxle_cam::Tables;
use coaxle_clock::Seconds;
use coaxle_curve::profile::{
    Kinematics, Limits, Profile, ProfileExtremes, to_position, to_velocity,
};
use coaxle_saw::SawCommand;

use super::SlaveAxis;
use crate::change::{Change, Effect};
use crate::command::Command;
use crate::couplings::{CouplingRefusal, Engagement, Kind};
use crate::motion::Motion;
use crate::refusal::Refusal;

impl SlaveAxis {
    /// Plans a command. A coupling relates the set values to the masters of the last
    /// [`update`](Self::update), which are of the same instant.
    ///
    /// # Errors
    /// [`Refusal`] gives the reason.
    pub fn plan(&self, plates: &Tables, command: &Command) -> Result<Change, Refusal> {
        let transition = command.transition(self.powered);
        if let Some(transition) = transition {
            // First of all checks: no value of a command matters to an axis that may not execute it.
            self.check_state(command.name(), transition)?;
            // All other commands are allowed in a circle, or nothing could open it.
            if transition == Transition::Couple {
                self.check_circle(command.name())?;
            }
        }
        self.check_sync_positions(command)?;
        let (effect, awaits) = self.effect_of(plates, &self.placed_now(command)?)?;
        // The state of a released axis depends on its velocity.
        let transition = match effect {
            Effect::Release => Some(self.released()),
            _ => transition,
        };
        Ok(Change {
            command: command.name(),
            transition,
            effect,
            awaits,
            revisions: [self.revision, plates.revision()],
        })
    }

    fn effect_of(&self, plates: &Tables, command: &Command) -> Result<(Effect, Awaits), Refusal> {
        let couplings = &self.couplings;
        let gear = |command| couplings.gear(plates, command, &self.plan_inputs(Kind::Gear));
        let sum = |command| {
            couplings.multi_master_gear(plates, command, &self.plan_inputs(Kind::MultiMasterGear))
        };
        let cam = |command| couplings.cam(plates, &command, &self.plan_inputs(Kind::Cam));
        let saw = |command| self.plan_saw(plates, &command, &self.plan_inputs(Kind::Saw));
        match *command {
            Command::Power(on) => Ok(Effect::Power(on)),
            Command::Reset {} => self.plan_reset(),
            Command::Home { position } => self.plan_home(position),
            Command::MoveAbsolute {
                position,
                velocity,
                ref dynamics,
            } => self.plan_move("position", position, velocity, dynamics),
            Command::MoveRelative {
                distance,
                velocity,
                ref dynamics,
            } => self.plan_distance(distance, velocity, dynamics),
            Command::MoveVelocity {
                velocity,
                ref dynamics,
            } => self.plan_velocity(velocity, dynamics),
            Command::Halt { ref dynamics } => {
                let (start, here) = (self.free(), self.set.position);
                self.plan_halt(&start, here, dynamics).map(Effect::Run)
            }
            Command::Stop { ref dynamics } => self.plan_stop(dynamics),
            Command::PhasingAbsolute {
                shift,
                velocity,
                ref dynamics,
            } => self.plan_phasing(shift, velocity, dynamics),
            Command::PhasingRelative {
                shift,
                velocity,
                ref dynamics,
                // From the end of a shift under way, so that several commands in a row add up.
            } => self.plan_phasing(self.phasing.end().position + shift, velocity, dynamics),
            Command::MoveSuperimposed {
                distance,
                velocity,
                ref dynamics,
            } => self.plan_superimposed(distance, velocity, dynamics),
            Command::GearOut {} | Command::CamOut {} => Ok(Effect::Release),
            Command::ReadFlyingSawCharacteristics {} => self.plan_reading(),
            Command::SetCamOnlineChangeMode { table, mode } => {
                plates
                    .plan_online_change_mode(table, &mode)
                    .map_err(CouplingRefusal::Cam)?;
                Ok(Effect::PlateMode(table, mode))
            }
            Command::WriteMotionFunction { table, points } => {
                plates
                    .plan_write(table, &points)
                    .map_err(CouplingRefusal::Cam)?;
                Ok(Effect::PlatePoints(table, points))
            }
            Command::GearIn(ref command) => return coupled(gear(command)),
            Command::FlyingGear(ref command) => return self.plan_flying_gear(plates, command),
            Command::GearInMultiMaster(ref command) => return coupled(sum(command)),
            Command::GearInPos(ref command) => return self.plan_gear_in_pos(plates, command),
            Command::GearInVelo(command) => return coupled(saw(SawCommand::GearInVelo(command))),
            Command::CamIn(command) => return coupled(cam(command.into())),
            Command::CamScaling(command) => return coupled(cam(command.into())),
            Command::CamInV2(command) => return coupled(cam(command.into())),
            Command::CamAdd(command) => return coupled(cam(command.into())),
            Command::CamExchange(command) => return coupled(cam(command.into())),
            Command::CamRemove(command) => return coupled(cam(command.into())),
            Command::CamScalingV2(command) => return coupled(cam(command.into())),
        }
        .map(|effect| (effect, Awaits::empty()))
    }

    /// Inputs for planning a coupling of this kind.
    pub(super) fn plan_inputs(&self, kind: Kind) -> PlanInputs {
        PlanInputs {
            masters: self.seen_masters(),
            slave: self.free(),
            guard: self.guard,
            cycle: Seconds(self.cycle_time),
            // A coupling changes its own plan only while it leads the axis.
            is_engaged: matches!(self.motion, Motion::Coupled(engaged) if engaged == kind),
        }
    }

    fn plan_reset(&self) -> Result<Effect, Refusal> {
        let set = &self.set;
        let is_at_rest = [set.velocity, set.acceleration] == [0.0; 2];
        // A preset to the drive's position is not a step of a motion: the axis must have stood for
        // a cycle.
        let may_go_on = match self.is_set_anew_by_reset() {
            true => self.stands(),
            false => is_at_rest,
        };
        if self.status() == AxisStatus::ErrorStop && !may_go_on {
            // The set values rest, but the positions of the last cycle differ: their mean says how much.
            let velocity = if is_at_rest {
                self.mean_velocity
            } else {
                set.velocity
            };
            return Err(Refusal::NotAtRest { velocity });
        }
        Ok(Effect::Reset)
    }

    fn plan_home(&self, position: f64) -> Result<Effect, Refusal> {
        self.guard.check_target("position", position)?;
        Ok(Effect::Home(position))
    }

    fn plan_reading(&self) -> Result<Effect, Refusal> {
        let plan = self.saw_plan().ok_or(Refusal::NoCharacteristics)?;
        Ok(Effect::Read(*plan))
    }

    fn plan_distance(
        &self,
        distance: f64,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<Effect, Refusal> {
        check_number("distance", distance)?;
        self.plan_move("target", self.set.position + distance, velocity, dynamics)
    }

    fn plan_move(
        &self,
        field: &'static str,
        target: f64,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<Effect, Refusal> {
        self.guard.check_target(field, target)?;
        let start = self.free();
        let profile = self.profile(self.set.position, velocity, dynamics, |limits| {
            to_position(&start, target, limits)
        })?;
        self.guard
            // The target is within the limits, but a fast axis may overshoot it first.
            .check_way(start.position, &ProfileExtremes::of(&profile))?;
        Ok(Effect::Run(profile))
    }

    fn plan_velocity(&self, velocity: f64, dynamics: &Dynamics) -> Result<Effect, Refusal> {
        check_number("velocity", velocity)?;
        self.guard.check_speed(velocity)?;
        let start = self.free();
        let profile = self.profile(self.set.position, None, dynamics, |limits| {
            to_velocity(&start, velocity, limits)
        })?;
        Ok(Effect::Run(profile))
    }

    fn plan_halt(
        &self,
        start: &Kinematics,
        here: f64,
        dynamics: &Dynamics,
    ) -> Result<Profile, Refusal> {
        self.profile(here, None, dynamics, |limits| {
            to_velocity(start, 0.0, limits)
        })
    }

    /// Plans a stop. While the axis stops, only a stop that ends earlier can take over.
    fn plan_stop(&self, dynamics: &Dynamics) -> Result<Effect, Refusal> {
        let profile = self.plan_halt(&self.stoppable(), self.due().position, dynamics)?;
        match &self.motion {
            Motion::Own(stop) if self.status() == AxisStatus::Stopping => {
                let (received, left) = (profile.duration().0, stop.left());
                // An equal stop that is planned again differs in rounding only, and ends no earlier.
                if received >= left * (1.0 - ROUNDING) {
                    return Err(Refusal::WeakerStop { received, left });
                }
            }
            _ => {}
        }
        Ok(Effect::Stop(profile))
    }

    /// A profile with the dynamics of a command, or with the axis's own if those are too slow to
    /// keep the highest velocity and the software limits from here.
    fn profile(
        &self,
        here: f64,
        velocity: Option<f64>,
        dynamics: &Dynamics,
        plan: impl Fn(&Limits) -> Profile,
    ) -> Result<Profile, Refusal> {
        let profile = plan(&self.guard.limits_of(velocity, dynamics)?);
        let extremes = ProfileExtremes::of(&profile);
        let keeps =
            self.guard.keeps_velocity(&extremes) && self.guard.check_way(here, &extremes).is_ok();
        if keeps {
            Ok(profile)
        } else {
            // The commanded velocity stays. Only the dynamics give way to the limits.
            Ok(plan(&self.guard.limits_of(velocity, &Dynamics::default())?))
        }
    }
}

/// Effect of engaging or changing a coupling.
pub(super) fn coupled(
    planned: Result<Planned<Engagement>, NotPlanned<CouplingRefusal>>,
) -> Result<(Effect, Awaits), Refusal> {
    let planned = planned?;
    let effect = Effect::Couple(planned.change, planned.effect);
    Ok((effect, planned.awaits))
}
