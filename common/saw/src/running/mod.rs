//! A slave that runs with its master: synchronising, synchronous, stopped by a rollback.

mod coupling;
mod limit_monitor;
mod over_time;
mod pursue;
mod pursuit;
mod rolled_back;
mod settings;

use coaxle_clock::Seconds;

use coaxle_axis::{AxisState, CommandState, TravelDirection};
use coaxle_curve::profile::{Kinematics, Limits, Profile, to_velocity};
use coaxle_curve::ramp::Ramp;

use self::limit_monitor::LimitMonitor;
use self::pursuit::LinePursuit;
use self::settings::{limits, prephase, waits};
use super::SyncMask;
use super::coupling_moment::{CouplingMoment, EncoderNoise, SlaveLimits};
use super::plan::{SawPlan, SyncLine};
use super::refusal::SawRefusal;
use super::rollback::{RollbackReaction, RollbackStop, stop_from};
use super::task::NEGLIGIBLE;

pub use self::coupling::Saw;
pub(super) use self::settings::starts;
pub use self::settings::{SawCommand, SawFault, SawTolerances};

/// A slave coupled by the universal flying saw.
///
/// Takes the master's set values once per cycle and returns the slave's. Once it is disengaged, by
/// `MC_GearOut`, by a rollback or by a fault, it never couples again; its slave keeps its velocity or is
/// stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawCoupling {
    command: SawCommand,
    limit_monitor: LimitMonitor,
    encoder: Option<EncoderNoise>,
    axis: SlaveLimits,
    /// Limits of the synchronisation; the velocity is the greatest that is tolerated while coupled.
    limits: Limits,
    plan: SawPlan,
    /// Direction of the master: 1 or −1, or 0 if that does not matter.
    direction: f64,
    /// Direction of the master by its increments; none if its positions are exact.
    travel: Option<TravelDirection>,
    /// Farthest position back for the master, along its direction.
    farthest_back: f64,
    noise: f64,
    line: SyncLine,
    phase: SawPhase,
    state: CommandState<SawFault>,
    rollback: Option<RollbackReaction>,
    master_position: f64,
    slave: Kinematics,
}

/// Source of the slave's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SawPhase {
    /// Velocity of its own, until the master has come near; `since` is the time in this phase.
    Prephase { profile: Profile, since: f64 },
    /// The profile over the master's position.
    OverMaster,
    /// The profile over time; `since` is the time in this phase.
    OverTime { profile: Profile, since: f64 },
    /// A profile over time onto the line, planned again when the master deviates from the prediction.
    Early(LinePursuit),
    /// The ramp to the velocity of a master that differs from the one planned for.
    Chasing(Ramp),
    /// The line.
    Synchronous,
    /// The stop after a rollback; `since` is the time in this phase.
    RollbackStop { stop: RollbackStop, since: f64 },
    /// A stop within the axis's own limits; `since` is the time in this phase.
    Brake { profile: Profile, since: f64 },
    /// No master: it keeps its velocity; `since` is the time in this phase.
    Free { profile: Profile, since: f64 },
}

impl SawCoupling {
    /// Couples the slave.
    ///
    /// # Errors
    /// [`SawRefusal`], if nothing has been coupled.
    pub fn start(
        command: SawCommand,
        moment: &CouplingMoment,
        tolerances: SawTolerances,
    ) -> Result<Self, SawRefusal> {
        let prephase = prephase(&command, moment)?;
        // A command that waits is planned for the predicted
        // moment, so that it is refused now, not when it is due.
        let plan = command.plan(prephase.as_ref().unwrap_or(moment))?;
        let mut coupling = Self {
            command,
            limit_monitor: LimitMonitor::new(&moment.axis, &tolerances),
            encoder: moment.encoder,
            axis: moment.axis,
            limits: limits(&command, &moment.axis, &tolerances)?,
            plan,
            direction: command.direction(moment),
            travel: None,
            // No rollback before the synchronisation has begun.
            farthest_back: f64::MIN,
            noise: tolerances.master_noise,
            line: *plan.line(),
            phase: SawPhase::Prephase {
                profile: keeping_velocity(&moment.slave, &moment.axis),
                since: 0.0,
            },
            state: CommandState::Waiting,
            rollback: None,
            master_position: moment.master.position,
            slave: moment.slave,
        };
        if prephase.is_none() {
            coupling.follow(plan);
        }
        Ok(coupling)
    }

    /// Sets the direction of a measured master by its increments, for the cycles to come. A master whose
    /// increments continue in its direction is not running back, wherever its position seems to be. None if the
    /// positions are exact.
    pub const fn set_master_travel(&mut self, travel: Option<TravelDirection>) {
        self.travel = travel;
    }

    /// Continues from the position at which the limits of the axis have left it, away from the saw's set
    /// values of the last cycle. A saw with a [strategy](crate::SyncStrategy) that is not yet on the line
    /// plans again from here, since the axis does not follow its plan. On the line the axis catches up by
    /// itself.
    pub fn resume_from(&mut self, axis: &Kinematics) {
        if self.command.strategic_sync_position().is_none() {
            return;
        }
        match &mut self.phase {
            SawPhase::OverMaster => self.phase = SawPhase::Early(self.pursuit_from(axis)),
            // The profile belongs to another position; from the next cycle on it starts at the axis.
            SawPhase::Early(pursuit) => pursuit.plan_again(),
            _ => return,
        }
        self.slave = *axis;
    }

    /// Computes one cycle of `elapsed`: the master's set values in, the slave's out.
    pub fn update(&mut self, master: &Kinematics, elapsed: Seconds) -> Kinematics {
        let dt = elapsed.0;
        let before = self.master_position;
        self.master_position = master.position;
        match &mut self.phase {
            SawPhase::Synchronous => self.synchronous(master, before, dt),
            SawPhase::OverMaster => self.over_master(master, before, dt),
            SawPhase::OverTime { .. } => self.over_time(master, before, dt),
            SawPhase::Early(_) => self.follow_line(master, before, dt),
            SawPhase::Chasing(ramp) => {
                let ramp = *ramp;
                self.chase(ramp, master, before, dt);
            }
            SawPhase::Prephase { .. } => self.wait(master, dt),
            SawPhase::RollbackStop { stop, since } => {
                *since += dt;
                self.slave = stop.at(Seconds(*since));
            }
            SawPhase::Brake { profile, since } | SawPhase::Free { profile, since } => {
                *since += dt;
                self.slave = profile.at(Seconds(*since));
            }
        }
        self.slave
    }

    /// `MC_GearOut`: the slave keeps its velocity, and its acceleration is led to zero within its axis's
    /// jerk. A stop in progress continues.
    #[doc(alias = "MC_GearOut")]
    pub fn gear_out(&mut self) -> Kinematics {
        // A stop under way is not replaced by a constant velocity.
        if self.is_coupled() {
            self.phase = SawPhase::Free {
                profile: keeping_velocity(&self.slave, &self.axis),
                since: 0.0,
            };
            self.state = CommandState::Aborted;
        }
        self.slave
    }

    /// True if the master has passed its synchronisation position, for a command with a strategy.
    #[must_use]
    pub fn is_past_sync_position(&self) -> Option<bool> {
        let position = self.command.strategic_sync_position()?;
        Some((self.master_position - position) * self.direction >= 0.0)
    }

    /// Returns the state of the command. In sync means that the slave's set values are those of the gear
    /// in this cycle.
    #[must_use]
    pub const fn state(&self) -> &CommandState<SawFault> {
        &self.state
    }

    /// `StartSync`: true once the synchronisation has begun.
    #[doc(alias = "StartSync")]
    #[must_use]
    pub const fn has_started_sync(&self) -> bool {
        matches!(self.state, CommandState::Active | CommandState::InSync)
    }

    /// True while the slave is coupled to its master.
    #[must_use]
    pub const fn is_coupled(&self) -> bool {
        matches!(
            self.phase,
            SawPhase::Prephase { .. }
                | SawPhase::OverMaster
                | SawPhase::OverTime { .. }
                | SawPhase::Early(_)
                | SawPhase::Chasing(_)
                | SawPhase::Synchronous
        )
    }

    /// `nAxisState`: 11, 12 and 13 while coupled, a master's states afterwards.
    #[doc(alias = "nAxisState")]
    #[must_use]
    pub fn axis_state(&self) -> AxisState {
        match self.phase {
            SawPhase::Prephase { .. } => AxisState::SlavePrephase,
            SawPhase::OverMaster
            | SawPhase::OverTime { .. }
            | SawPhase::Early(_)
            | SawPhase::Chasing(_) => AxisState::SlaveSynchronizing,
            SawPhase::Synchronous => AxisState::SlaveSynchronous,
            _ if self.slave.velocity == 0.0 => AxisState::Inactive,
            SawPhase::RollbackStop { .. } | SawPhase::Brake { .. } => AxisState::Decelerating,
            SawPhase::Free { .. } => AxisState::ConstantVelocity,
        }
    }

    /// Returns the reaction to a master that ran back past the coupling position. That aborts the
    /// command, as TS5055 8 has it, and is no error: 0x4289 (illegal reversal) is never reported.
    #[must_use]
    pub const fn rollback(&self) -> Option<RollbackReaction> {
        self.rollback
    }

    /// Returns the stop after that, and the time since its begin, while it lasts.
    #[must_use]
    pub const fn rollback_stop(&self) -> Option<(RollbackStop, Seconds)> {
        match self.phase {
            SawPhase::RollbackStop { stop, since } => Some((stop, Seconds(since))),
            _ => None,
        }
    }

    /// Returns the plan in force; in the preliminary phase the predicted one.
    #[must_use]
    pub const fn plan(&self) -> &SawPlan {
        &self.plan
    }

    /// Returns the slave's set values of the last cycle.
    #[must_use]
    pub const fn slave(&self) -> &Kinematics {
        &self.slave
    }

    /// Begins the synchronisation phase.
    fn follow(&mut self, plan: SawPlan) {
        self.plan = plan;
        self.line = *plan.line();
        self.state = CommandState::Active;
        if let Some((master, slave)) = self.command.early_positions() {
            let ratio = self.line.ratio;
            self.line = SyncLine {
                ratio,
                master,
                slave,
            };
            // The slave follows the master anywhere.
            self.farthest_back = f64::MIN;
            return self.start_pursuit(&plan);
        }
        self.direction = match plan.master_end() - plan.master_start() {
            // A plan without a distance, of a slave in sync at once, has the direction of its master.
            0.0 => sign(plan.master_velocity()),
            distance => sign(distance),
        };
        // Along the direction, so that one comparison serves both.
        self.farthest_back = self.direction * plan.master_start() - self.noise;
        self.phase = match plan.time_profile() {
            Some(profile) => SawPhase::OverTime {
                profile: *profile,
                since: 0.0,
            },
            None => SawPhase::OverMaster,
        };
        if plan.is_synchronous() {
            self.become_synchronous();
        }
    }

    /// Begins the synchronous phase: from here on the slave's set values are the gear's.
    fn become_synchronous(&mut self) {
        self.phase = SawPhase::Synchronous;
        self.state = CommandState::InSync;
    }

    #[inline]
    fn synchronous(&mut self, master: &Kinematics, before: f64, dt: f64) {
        if self.is_behind_start(master) {
            let reaction = RollbackReaction::of(self.command.mask(), true);
            if reaction != RollbackReaction::Follow {
                // A synchronous slave passes the place on its line, one on its way on its profile.
                let line = self.line;
                return self.roll_back(reaction, master, before, dt, |at, _| line.slave_of(at));
            }
        }
        self.apply_set_values(self.line.slave_of(master), master, dt);
    }

    fn over_master(&mut self, master: &Kinematics, before: f64, dt: f64) {
        let position = master.position;
        if (position - self.plan.joins_line_at()) * self.direction >= 0.0 {
            self.become_synchronous();
            // In this very cycle the line leads: another step of the profile would be beside it.
            return self.synchronous(master, before, dt);
        }
        if self.is_behind_start(master) {
            let reaction = RollbackReaction::of(self.command.mask(), false);
            let plan = self.plan;
            return self.roll_back(reaction, master, before, dt, |at, _| plan.slave_of(at));
        }
        let slave = self.plan.slave_of(master);
        self.state = if self.is_in_sync(&slave, master) {
            CommandState::InSync
        } else {
            CommandState::Active
        };
        self.apply_set_values(slave, master, dt);
    }

    /// Keeps the motion of the slave until the master is near.
    fn wait(&mut self, master: &Kinematics, dt: f64) {
        let SawPhase::Prephase { profile, since } = &mut self.phase else {
            return;
        };
        let before = self.slave;
        *since += dt;
        self.slave = profile.at(Seconds(*since));
        let moment = CouplingMoment {
            master: *master,
            encoder: self.encoder,
            slave: self.slave,
            axis: self.axis,
        };
        match waits(&self.command, &moment, self.direction, dt) {
            Ok(true) => return,
            // Planned again from the actual motions: the prediction assumed that both keep their velocity.
            Ok(false) => self.command.plan(&moment),
            Err(refusal) => Err(refusal),
        }
        .map(|plan| self.follow(plan))
        .unwrap_or_else(|refusal| {
            // The step of this cycle is the brake's, from the set values of the last one.
            self.slave = before;
            self.brake_with_fault(SawFault::Refused(refusal), dt);
        });
    }

    /// True if the slave's set values are the gear's, up to rounding.
    fn is_in_sync(&self, slave: &Kinematics, master: &Kinematics) -> bool {
        let gear = self.line.slave_of(master);
        let near = |a: f64, b: f64| (a - b).abs() <= NEGLIGIBLE * a.abs().max(b.abs());
        // By position and velocity: a profile may cross the line on its way.
        near(slave.position, gear.position) && near(slave.velocity, gear.velocity)
    }

    /// Takes over the slave's next set values, unless they break a limit of its axis.
    #[inline]
    fn apply_set_values(&mut self, slave: Kinematics, master: &Kinematics, dt: f64) {
        if self.limit_monitor.is_within_limits(&slave)
            && self
                .limit_monitor
                .is_step_within_limits(&self.slave, &slave, dt)
        {
            self.slave = slave;
        } else {
            self.fail_at_limit(&slave, master, dt);
        }
    }

    /// Ends the coupling with a fault: the set values break a limit of the slave's axis.
    #[cold]
    fn fail_at_limit(&mut self, slave: &Kinematics, master: &Kinematics, dt: f64) {
        let detailed = self.command.mask().contains(SyncMask::DETAILED_ERROR_CODES);
        let fault = self
            .limit_monitor
            .fault(&self.slave, slave, master, dt, detailed);
        self.brake_with_fault(fault, dt);
    }

    /// Stops the slave within its axis's limits, from its set values of the last cycle.
    #[cold]
    fn brake_with_fault(&mut self, fault: SawFault, dt: f64) {
        // By the limits of the axis: those of the command only shape its synchronisation.
        let profile = stop_from(&self.slave, &self.axis.dynamics);
        self.state = CommandState::Failed(fault);
        self.slave = profile.at(Seconds(dt));
        self.phase = SawPhase::Brake { profile, since: dt };
    }
}

/// Returns the motion of a free slave that keeps its velocity: an acceleration is led to zero within the
/// jerk, and the change of velocity meanwhile is compensated.
fn keeping_velocity(slave: &Kinematics, axis: &SlaveLimits) -> Profile {
    to_velocity(slave, slave.velocity, &axis.dynamics)
}

/// Returns 1, −1, or 0 for zero.
fn sign(value: f64) -> f64 {
    // `signum` of 0.0 is 1.
    if value == 0.0 { 0.0 } else { value.signum() }
}

#[cfg(test)]
mod tests;
