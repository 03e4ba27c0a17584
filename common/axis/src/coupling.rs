//! Couplings of a slave to its masters, of every kind.

use core::convert::Infallible;
use core::fmt;

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use crate::awaits::Awaits;
use crate::command_state::CommandState;
use crate::coupling_phase::CouplingPhase;
use crate::guard::{Guard, GuardRefusal};
use crate::job::Job;
use crate::master_demands::MasterDemands;
use crate::masters::Masters;
use crate::state::StateWord;

/// State of a coupling of a slave to its masters, of any kind.
///
/// An instance lives as long as its slave and is engaged repeatedly, so that its last results can
/// still be read afterwards, as in a PLC block.
pub trait Coupling: Send {
    /// Phase of the coupling; none unless it is engaged.
    fn phase(&self) -> Option<CouplingPhase>;

    /// Slave units per unit of its first master, as far as that is constant.
    fn gain(&self) -> Option<f64> {
        None
    }

    /// Position of rest, u, while the slave is being brought to rest.
    fn target(&self) -> Option<f64> {
        None
    }

    /// Positions of master and slave at which they are synchronous, at the latest, if it leads to
    /// such a pair.
    fn sync_positions(&self) -> Option<SyncPositions> {
        None
    }

    /// The next job that has ended, of those that changed the coupling while it was engaged.
    fn ended(&mut self) -> Option<Job> {
        None
    }
}

/// Positions of master and slave on their axes at the synchronous point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SyncPositions {
    /// The first master, as the coupling sees it, u of the master.
    #[doc(alias = "MasterSyncPosition")]
    pub master: f64,
    /// The slave, u.
    #[doc(alias = "SlaveSyncPosition")]
    pub slave: f64,
}

/// Work of a coupling: planned, applied, then run in each cycle; the masters' set values in, the
/// slave's out.
///
/// The coupling computes the wanted position of the slave; the axis decides whether it is possible.
pub trait Engage: Coupling {
    /// Commands of the coupling.
    type Command;
    /// Planned change.
    type Change: Clone + Copy + fmt::Debug;
    /// Reason for a refusal.
    type Refusal;
    /// Fault of the coupling.
    type Fault;
    /// Store that the couplings of several axes use, always the same one: the cam plates of a node.
    /// `()` for a coupling that needs none.
    type Shared;

    /// Plans a command.
    ///
    /// # Errors
    /// [`NotPlanned`].
    fn plan(
        &self,
        shared: &Self::Shared,
        command: &Self::Command,
        inputs: &PlanInputs,
    ) -> Result<Planned<Self::Change>, NotPlanned<Self::Refusal>>;

    /// Applies a change that was planned against the same state.
    fn apply(&mut self, shared: &mut Self::Shared, change: &Self::Change, job: Job);

    /// Runs one cycle. Called only while it is engaged, or brings the slave to rest.
    fn update(&mut self, shared: &mut Self::Shared, scan: &Scan) -> Step;

    /// Ends the coupling: another motion moves the slave from now on. Idempotent.
    fn end(&mut self, shared: &mut Self::Shared);

    /// Error stop of the axis, with this NC code: pending changes are dropped, readable values are
    /// kept until [`end`](Self::end).
    fn fail(&mut self, shared: &mut Self::Shared, code: u32) {
        let _ = code;
        self.end(shared);
    }

    /// The bits of `nStateDWord` for its pending changes.
    fn queued(&self, shared: &Self::Shared) -> StateWord {
        let _ = shared;
        StateWord::empty()
    }

    /// Scaling of its master positions; 1 without one.
    fn master_scaling(&self, shared: &Self::Shared) -> f64 {
        let _ = shared;
        1.0
    }

    /// Greatest demands on the slave by a master, by its number from 0, for as long as nothing is commanded; none while the
    /// slave is led to it or away from it.
    fn demands_of(&self, shared: &Self::Shared, master: usize) -> MasterDemands {
        let _ = shared;
        let gain = self.gain().filter(|_| master == 0);
        MasterDemands::of_ratio(gain.unwrap_or(0.0))
    }

    /// Reason why it was [`Refused`](Step::Refused) when due; none for a kind that never waits.
    fn refusal(&self) -> Option<Self::Refusal> {
        None
    }

    /// Reason why it has [`Failed`](Step::Failed); none for a kind that never fails by itself.
    fn fault(&self) -> Option<Self::Fault> {
        None
    }

    /// State of a job that changes it while it is engaged; idle for an unknown number.
    fn state_of(&self, job: Job) -> CommandState<Self::Refusal> {
        let _ = job;
        CommandState::Idle
    }
}

/// Inputs of a coupling in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Scan {
    /// Masters of the slave.
    pub masters: Masters,
    /// Time since the last cycle.
    pub elapsed: Seconds,
    /// The axis in the last cycle, if its limits had left it away from the coupling's set values by
    /// more than the window of "in sync"; none while it is at the coupling's position.
    pub left_behind: Option<Kinematics>,
}

/// Result of a coupling's cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// The slave's set values.
    Set(Kinematics),
    /// The slave's set values, and the end of the coupling: the slave keeps its velocity.
    Ended(Kinematics),
    /// Masters reversed: from now on the coupling brings the slave to rest by itself.
    Stopping {
        /// The slave's set values.
        set: Kinematics,
        /// True if the velocity may change at once.
        instant: bool,
        /// True if the slave has come to rest.
        over: bool,
    },
    /// Refused start when due: the slave continues without it.
    Refused,
    /// Cancelled start: the slave continues without it.
    GivenUp,
    /// Failed coupling.
    Failed,
    /// Master lost or in error that the coupling needs.
    MasterLost,
}

/// Inputs for planning a coupling.
#[derive(Clone, Copy, Debug)]
pub struct PlanInputs {
    /// The masters of the last cycle.
    pub masters: Masters,
    /// The slave's set values of the same instant.
    pub slave: Kinematics,
    /// Guard with the slave's limits.
    pub guard: Guard,
    /// Cycle time of the slave.
    pub cycle: Seconds,
    /// True if this coupling moves the slave.
    pub is_engaged: bool,
}

impl PlanInputs {
    /// Returns the first master.
    ///
    /// # Errors
    /// [`NotPlanned::NoMaster`].
    pub fn master<R>(&self) -> Result<&Kinematics, NotPlanned<R>> {
        self.masters.first().ok_or(NotPlanned::NoMaster)
    }

    /// Checks that the slave is at rest.
    ///
    /// # Errors
    /// [`NotPlanned::NotAtRest`].
    pub fn check_rest<R>(&self) -> Result<(), NotPlanned<R>> {
        let velocity = self.slave.velocity;
        // Both: an axis that reverses has no velocity for an instant.
        if velocity == 0.0 && self.slave.acceleration == 0.0 {
            Ok(())
        } else {
            Err(NotPlanned::NotAtRest { velocity })
        }
    }
}

/// Plan of a command to a coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planned<C> {
    /// Change of the coupling.
    pub change: C,
    /// Checks repeated when it is due.
    pub awaits: Awaits,
    /// Effect on the current coupling.
    pub effect: CouplingEffect,
}

/// Effect of a command on the coupling that moves the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CouplingEffect {
    /// Replaces it, even by one of the same kind.
    Engage,
    /// Changes it, as a job in addition to the one that engaged it.
    Adjust,
    /// Changes it, and its job continues.
    Continue,
}

/// Reason why a command to a coupling cannot be planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotPlanned<R> {
    /// Master lost, in error, or missing.
    NoMaster,
    /// Slave not at rest.
    NotAtRest {
        /// Set velocity, u/s.
        velocity: f64,
    },
    /// Slave limits exceeded.
    Guard(GuardRefusal),
    /// Reason of this kind of coupling.
    Own(R),
}

impl<R> NotPlanned<R> {
    /// Converts the reason of this kind of coupling.
    pub fn map<S>(self, of: impl FnOnce(R) -> S) -> NotPlanned<S> {
        match self {
            Self::NoMaster => NotPlanned::NoMaster,
            Self::NotAtRest { velocity } => NotPlanned::NotAtRest { velocity },
            Self::Guard(refusal) => NotPlanned::Guard(refusal),
            Self::Own(refusal) => NotPlanned::Own(of(refusal)),
        }
    }
}

impl<R> From<GuardRefusal> for NotPlanned<R> {
    fn from(refusal: GuardRefusal) -> Self {
        Self::Guard(refusal)
    }
}

/// The fault of a coupling that never fails by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoFault(Infallible);

impl NoFault {
    /// NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self.0 {}
    }
}

impl fmt::Display for NoFault {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {}
    }
}
