//! A slave that runs with its master: synchronising, synchronous, stopped by a rollback.

mod coupling;
mod early;
mod over_time;
mod pursuit;
mod settings;
mod watch;

use coaxle_clock::Seconds;

use coaxle_axis::{AxisState, CommandState, TravelDirection};
use coaxle_curve::profile::{Kinematics, Limits, Profile, to_velocity};
use coaxle_curve::ramp::Ramp;

use self::pursuit::Pursuit;
use self::settings::{limits, prephase, waits};
use self::watch::Watch;
use super::SyncMask;
use super::moment::{CouplingMoment, EncoderMaster, SlaveLimits};
use super::plan::{SawPlan, SyncLine};
use super::refusal::SawRefusal;
use super::rollback::{RollbackReaction, RollbackStop, stop_from};
use super::task::NEGLIGIBLE;

pub use self::coupling::Saw;
pub(super) use self::settings::starts;
pub use self::settings::{SawCommand, SawFault, SawTolerances};

/// Which part of what the limits let the acceleration change by in a cycle counts as none.
const HARDLY: f64 = 0.05;

/// A slave coupled by the universal flying saw.
///
/// It is given the master's set values once per cycle and says what the slave's are. Once it is
/// broken off, by `MC_GearOut`, by a rollback or by a fault, it never couples again; its slave
/// keeps its velocity or is stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawCoupling {
    command: SawCommand,
    watch: Watch,
    encoder: Option<EncoderMaster>,
    axis: SlaveLimits,
    /// Of the synchronisation; the velocity is the highest that is tolerated while coupled.
    limits: Limits,
    plan: SawPlan,
    /// Which way the master runs: 1 or −1, or 0 if that does not matter.
    direction: f64,
    /// Which way its increments say that the master goes; none where its positions are exact.
    travel: Option<TravelDirection>,
    /// How far the master may run back, along its direction.
    farthest_back: f64,
    noise: f64,
    line: SyncLine,
    phase: Phase,
    state: CommandState<SawFault>,
    rollback: Option<RollbackReaction>,
    master_position: f64,
    slave: Kinematics,
}

/// What the slave is led by.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Itself, at its velocity, until the master has come near, so far into it.
    Prephase { profile: Profile, since: f64 },
    /// The profile over the master's position.
    OverMaster,
    /// The profile over time, so far into it.
    OverTime { profile: Profile, since: f64 },
    /// A profile over time onto the line, planned anew wherever the master does not do what was expected.
    Early(Pursuit),
    /// The ramp to the velocity of a master that has another one than the profile was planned for.
    Chasing(Ramp),
    /// The line.
    Synchronous,
    /// The stop after a rollback, so far into it.
    RollbackStop { stop: RollbackStop, since: f64 },
    /// A stop within the axis's own limits, so far into it.
    Brake { profile: Profile, since: f64 },
    /// Nothing: it keeps its velocity, so far into it.
    Free { profile: Profile, since: f64 },
}

impl SawCoupling {
    /// Couples the slave.
    ///
    /// # Errors
    /// [`SawRefusal`] says why nothing has been coupled.
    pub fn start(
        command: SawCommand,
        moment: &CouplingMoment,
        tolerances: SawTolerances,
    ) -> Result<Self, SawRefusal> {
        let prephase = prephase(&command, moment)?;
        let plan = command.plan(prephase.as_ref().unwrap_or(moment))?;
        let mut coupling = Self {
            command,
            watch: Watch::new(&moment.axis, &tolerances),
            encoder: moment.encoder,
            axis: moment.axis,
            limits: limits(&command, &moment.axis, &tolerances)?,
            plan,
            direction: command.direction(moment),
            travel: None,
            farthest_back: f64::MIN,
            noise: tolerances.master_noise,
            line: *plan.line(),
            phase: Phase::Prephase {
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

    /// Says which way the increments of a measured master have it go, for the cycles to come: one that goes on is
    /// not running back, wherever its position seems to be. None where the positions are exact.
    pub const fn set_master_travel(&mut self, travel: Option<TravelDirection>) {
        self.travel = travel;
    }

    /// The limits of the axis have left it here, away from where the saw had it in the last cycle. One with a
    /// [strategy](crate::SyncStrategy) that is on its way to its master goes on from here: what it had planned is not
    /// what the axis does. On the line the axis catches up by itself.
    pub fn resume_from(&mut self, axis: &Kinematics) {
        if self.command.strategic_sync_position().is_none() {
            return;
        }
        match &mut self.phase {
            Phase::OverMaster => self.phase = Phase::Early(self.pursuit_from(axis)),
            Phase::Early(pursuit) => pursuit.plan_again(),
            _ => return,
        }
        self.slave = *axis;
    }

    /// One cycle of `elapsed`: the master's set values in, the slave's out.
    pub fn update(&mut self, master: &Kinematics, elapsed: Seconds) -> Kinematics {
        let dt = elapsed.0;
        let before = self.master_position;
        self.master_position = master.position;
        match &mut self.phase {
            Phase::Synchronous => self.synchronous(master, before, dt),
            Phase::OverMaster => self.over_master(master, before, dt),
            Phase::OverTime { .. } => self.over_time(master, before, dt),
            Phase::Early(_) => self.pursue(master, before, dt),
            Phase::Chasing(ramp) => {
                let ramp = *ramp;
                self.chase(ramp, master, before, dt);
            }
            Phase::Prephase { .. } => self.wait(master, dt),
            Phase::RollbackStop { stop, since } => {
                *since += dt;
                self.slave = stop.at(Seconds(*since));
            }
            Phase::Brake { profile, since } | Phase::Free { profile, since } => {
                *since += dt;
                self.slave = profile.at(Seconds(*since));
            }
        }
        self.slave
    }

    /// `MC_GearOut`: the slave goes on at its velocity, its acceleration is led to zero within its
    /// axis's jerk. What was stopping already goes on doing so.
    #[doc(alias = "MC_GearOut")]
    pub fn gear_out(&mut self) -> Kinematics {
        if self.is_coupled() {
            self.phase = Phase::Free {
                profile: keeping_velocity(&self.slave, &self.axis),
                since: 0.0,
            };
            self.state = CommandState::Aborted;
        }
        self.slave
    }

    /// Whether the master has passed its synchronisation position, where the command has a strategy.
    #[must_use]
    pub fn is_past_sync_position(&self) -> Option<bool> {
        let position = self.command.strategic_sync_position()?;
        Some((self.master_position - position) * self.direction >= 0.0)
    }

    /// What has become of the command. In sync means that the slave's set values are those of the
    /// gear in this cycle.
    #[must_use]
    pub const fn state(&self) -> &CommandState<SawFault> {
        &self.state
    }

    /// `StartSync`: the synchronisation has begun.
    #[doc(alias = "StartSync")]
    #[must_use]
    pub const fn has_started_sync(&self) -> bool {
        matches!(self.state, CommandState::Active | CommandState::InSync)
    }

    /// Whether the slave is still coupled to its master.
    #[must_use]
    pub const fn is_coupled(&self) -> bool {
        matches!(
            self.phase,
            Phase::Prephase { .. }
                | Phase::OverMaster
                | Phase::OverTime { .. }
                | Phase::Early(_)
                | Phase::Chasing(_)
                | Phase::Synchronous
        )
    }

    /// `nAxisState`: 11, 12 and 13 while coupled, a master's states afterwards.
    #[doc(alias = "nAxisState")]
    #[must_use]
    pub fn axis_state(&self) -> AxisState {
        match self.phase {
            Phase::Prephase { .. } => AxisState::SlavePrephase,
            Phase::OverMaster | Phase::OverTime { .. } | Phase::Early(_) | Phase::Chasing(_) => {
                AxisState::SlaveSynchronizing
            }
            Phase::Synchronous => AxisState::SlaveSynchronous,
            _ if self.slave.velocity == 0.0 => AxisState::Inactive,
            Phase::RollbackStop { .. } | Phase::Brake { .. } => AxisState::Decelerating,
            Phase::Free { .. } => AxisState::ConstantVelocity,
        }
    }

    /// How it was stopped, if the master ran back past the coupling position. That aborts the
    /// command, as TS5055 8 has it, and is no error: 0x4289 (illegal reversal) is never answered.
    #[must_use]
    pub const fn rollback(&self) -> Option<RollbackReaction> {
        self.rollback
    }

    /// The stop after that, and how far into it the slave is, while it lasts.
    #[must_use]
    pub const fn rollback_stop(&self) -> Option<(RollbackStop, Seconds)> {
        match self.phase {
            Phase::RollbackStop { stop, since } => Some((stop, Seconds(since))),
            _ => None,
        }
    }

    /// The plan in force; in the preliminary phase the one foreseen.
    #[must_use]
    pub const fn plan(&self) -> &SawPlan {
        &self.plan
    }

    /// The slave's set values of the last cycle.
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
            // Wherever the master goes, the slave comes along.
            self.farthest_back = f64::MIN;
            return self.set_out(&plan);
        }
        self.direction = match plan.master_end() - plan.master_start() {
            0.0 => sign(plan.master_velocity()),
            distance => sign(distance),
        };
        self.farthest_back = self.direction * plan.master_start() - self.noise;
        self.phase = match plan.time_profile() {
            Some(profile) => Phase::OverTime {
                profile: *profile,
                since: 0.0,
            },
            None => Phase::OverMaster,
        };
        if plan.is_synchronous() {
            self.become_synchronous();
        }
    }

    /// From here on the slave's set values are the gear's.
    fn become_synchronous(&mut self) {
        self.phase = Phase::Synchronous;
        self.state = CommandState::InSync;
    }

    #[inline]
    fn synchronous(&mut self, master: &Kinematics, before: f64, dt: f64) {
        if self.is_behind_start(master) {
            let reaction = RollbackReaction::of(self.command.mask(), true);
            if reaction != RollbackReaction::Follow {
                let line = self.line;
                return self.roll_back(reaction, master, before, dt, |at, _| line.slave_of(at));
            }
        }
        self.lead_to(self.line.slave_of(master), master, dt);
    }

    fn over_master(&mut self, master: &Kinematics, before: f64, dt: f64) {
        let position = master.position;
        if (position - self.plan.joins_line_at()) * self.direction >= 0.0 {
            self.become_synchronous();
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
        self.lead_to(slave, master, dt);
    }

    /// Until the master is near, the slave goes on as it does.
    fn wait(&mut self, master: &Kinematics, dt: f64) {
        let Phase::Prephase { profile, since } = &mut self.phase else {
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
            Ok(false) => self.command.plan(&moment),
            Err(refusal) => Err(refusal),
        }
        .map(|plan| self.follow(plan))
        .unwrap_or_else(|refusal| {
            self.slave = before;
            self.break_off(SawFault::Refused(refusal), dt);
        });
    }

    /// Whether the slave's set values are the gear's, up to rounding.
    fn is_in_sync(&self, slave: &Kinematics, master: &Kinematics) -> bool {
        let gear = self.line.slave_of(master);
        let near = |a: f64, b: f64| (a - b).abs() <= NEGLIGIBLE * a.abs().max(b.abs());
        near(slave.position, gear.position) && near(slave.velocity, gear.velocity)
    }

    /// Whether the master has run back past the coupling position.
    #[inline]
    fn is_behind_start(&self, master: &Kinematics) -> bool {
        master.position * self.direction < self.farthest_back && !self.goes_on()
    }

    /// Whether the increments of the master say that it still goes the way it went.
    fn goes_on(&self) -> bool {
        let forward = |travel: TravelDirection| travel.sign() * self.direction > 0.0;
        self.travel.is_some_and(forward)
    }

    /// Stops the slave from the place where its master passed the coupling position within this
    /// cycle; `slave_of` says where the slave was then, from the master and the part of the cycle.
    #[cold]
    fn roll_back(
        &mut self,
        reaction: RollbackReaction,
        master: &Kinematics,
        before: f64,
        dt: f64,
        slave_of: impl FnOnce(&Kinematics, f64) -> Kinematics,
    ) {
        let limit = self.direction * self.farthest_back;
        let part = ((limit - before) / (master.position - before)).clamp(0.0, 1.0);
        let master_at_limit = Kinematics {
            position: limit,
            ..*master
        };
        let mut slave = slave_of(&master_at_limit, part);
        // A master that jumps back can drag the slave faster to that place than it may go.
        if !self.watch.lets_pass(&slave) {
            return self.refuse_to_lead(&slave, master, dt);
        }
        if reaction == RollbackReaction::Instant {
            slave = Kinematics::at_rest(slave.position);
        }
        let accelerates = |slave: &Kinematics| {
            slave.acceleration.abs() > HARDLY * self.limits.binding_in_cycles(dt).jerk() * dt
        };
        let (stop, since) = if accelerates(&slave) {
            // When exactly the master passed, its mean velocity does not tell then.
            let stop = RollbackStop::from_acceleration(&self.slave, &self.limits);
            (stop, dt)
        } else {
            let (deceleration, jerk) = (self.limits.deceleration(), self.limits.jerk());
            let stop = RollbackStop::plan(&slave, deceleration, jerk);
            (stop, (1.0 - part) * dt)
        };
        let next = stop.at(Seconds(since));
        if !self.watch.lets_step(&self.slave, &next, dt) {
            return self.refuse_to_lead(&next, master, dt);
        }
        self.slave = next;
        self.phase = Phase::RollbackStop { stop, since };
        self.state = CommandState::Aborted;
        self.rollback = Some(reaction);
    }

    /// Takes over the slave's next set values, unless they break a limit of its axis.
    #[inline]
    fn lead_to(&mut self, slave: Kinematics, master: &Kinematics, dt: f64) {
        if self.watch.lets_pass(&slave) && self.watch.lets_step(&self.slave, &slave, dt) {
            self.slave = slave;
        } else {
            self.refuse_to_lead(&slave, master, dt);
        }
    }

    /// The set values break a limit of the slave's axis.
    #[cold]
    fn refuse_to_lead(&mut self, slave: &Kinematics, master: &Kinematics, dt: f64) {
        let detailed = self.command.mask().contains(SyncMask::DETAILED_ERROR_CODES);
        let fault = self.watch.fault(&self.slave, slave, master, dt, detailed);
        self.break_off(fault, dt);
    }

    /// Stops the slave within its axis's limits, from its set values of the last cycle.
    #[cold]
    fn break_off(&mut self, fault: SawFault, dt: f64) {
        let profile = stop_from(&self.slave, &self.axis.dynamics);
        self.state = CommandState::Failed(fault);
        self.slave = profile.at(Seconds(dt));
        self.phase = Phase::Brake { profile, since: dt };
    }
}

/// A slave on its own that keeps its velocity: an acceleration is led to zero within the jerk, and what
/// the velocity changes meanwhile is made up for.
fn keeping_velocity(slave: &Kinematics, axis: &SlaveLimits) -> Profile {
    to_velocity(slave, slave.velocity, &axis.dynamics)
}

/// 1, −1, or 0 for nothing.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

#[cfg(test)]
mod tests;
