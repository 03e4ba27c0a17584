//! What ties a slave to its masters, whatever kind it is.

use core::convert::Infallible;
use core::fmt;

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use crate::awaits::Awaits;
use crate::command_state::CommandState;
use crate::coupling_phase::CouplingPhase;
use crate::guard::{Guard, GuardRefusal};
use crate::job::Job;
use crate::masters::Masters;
use crate::state::StateWord;

/// What ties a slave to its masters: their set values in, the slave's out.
///
/// An instance lives as long as its slave and is engaged again and again, so that what it was can
/// still be asked about afterwards, as in a PLC block. It says where the slave should be; whether the
/// slave can be there is the axis's own business.
pub trait Coupling: Send {
    /// One cycle. Called only while it is engaged, or brings the slave to rest.
    fn update(&mut self, scan: &Scan) -> Step;

    /// How far it is; none unless it is engaged.
    fn phase(&self) -> Option<CouplingPhase>;

    /// Something else moves the slave from now on. Twice is as good as once.
    fn end(&mut self);

    /// The axis is in error stop, by this NC code: what waits is dropped, what can be read is kept
    /// until [`end`](Self::end).
    fn fail(&mut self, code: u32) {
        let _ = code;
        self.end();
    }

    /// The bits of `nStateDWord` for what waits in it.
    fn queued(&self) -> StateWord {
        StateWord::empty()
    }

    /// Slave units per unit of its first master, as far as that is constant.
    fn gain(&self) -> Option<f64> {
        None
    }

    /// What its positions of the master are scaled by; 1 where nothing is.
    fn master_scaling(&self) -> f64 {
        1.0
    }

    /// Where the slave comes to rest, u, if it is being brought to rest.
    fn target(&self) -> Option<f64> {
        None
    }

    /// Where master and slave are synchronous, at the latest, if it leads to such a pair of positions.
    fn sync_positions(&self) -> Option<SyncPositions> {
        None
    }

    /// The next job, of those that changed it while it was engaged, that has come to its end.
    fn ended(&mut self) -> Option<Job> {
        None
    }
}

/// Where master and slave are when they are synchronous, on their axes.
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

/// How a coupling is engaged, and changed while it is: plan, then apply.
pub trait Engage: Coupling {
    /// What can be commanded.
    type Command;
    /// What a command comes to.
    type Change: Clone + Copy + fmt::Debug;
    /// Why it may be refused.
    type Refusal;
    /// Why it may break off.
    type Fault;

    /// What a command would come to.
    ///
    /// # Errors
    /// [`NotPlanned`].
    fn plan(
        &self,
        command: &Self::Command,
        inputs: &PlanInputs,
    ) -> Result<Planned<Self::Change>, NotPlanned<Self::Refusal>>;

    /// Carries out what was planned against the very same state.
    fn apply(&mut self, change: &Self::Change, job: Job);

    /// Why it was [`Refused`](Step::Refused) when due; none of a kind that never waits.
    fn refusal(&self) -> Option<Self::Refusal> {
        None
    }

    /// Why it has [`Failed`](Step::Failed); none of a kind that never breaks off by itself.
    fn fault(&self) -> Option<Self::Fault> {
        None
    }

    /// How far a job is that changes it while it is engaged; idle if it knows none of that number.
    fn state_of(&self, job: Job) -> CommandState<Self::Refusal> {
        let _ = job;
        CommandState::Idle
    }
}

/// What a coupling is told in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Scan {
    /// Its masters.
    pub masters: Masters,
    /// Since the last cycle.
    pub elapsed: Seconds,
    /// The axis in the last cycle, where its limits had left it away from what the coupling asked for, by more than
    /// the window of "in sync"; none while it is where the coupling had it.
    pub left_behind: Option<Kinematics>,
}

/// What comes of a cycle of a coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// The slave's set values.
    Set(Kinematics),
    /// The slave's set values, and the end of the coupling: the slave keeps its velocity.
    Ended(Kinematics),
    /// The masters have turned back: from now on it brings the slave to rest by itself.
    Stopping {
        /// The slave's set values.
        set: Kinematics,
        /// Whether it may change the velocity at once.
        instant: bool,
        /// Whether the slave has come to rest.
        over: bool,
    },
    /// What it was to begin with is not possible now that it is due: the slave goes on without it.
    Refused,
    /// What it was to begin with has been given up: the slave goes on without it.
    GivenUp,
    /// It breaks off.
    Failed,
    /// A master that it needs is lost or in error.
    MasterLost,
}

/// What a coupling is planned from.
#[derive(Clone, Copy, Debug)]
pub struct PlanInputs {
    /// The masters, as the last cycle had them.
    pub masters: Masters,
    /// The slave's set values of the same moment.
    pub slave: Kinematics,
    /// What the slave can do and may do.
    pub guard: Guard,
    /// How long its cycles are.
    pub cycle: Seconds,
    /// Whether the coupling is the one that moves the slave.
    pub is_engaged: bool,
}

impl PlanInputs {
    /// The first master.
    ///
    /// # Errors
    /// [`NotPlanned::NoMaster`].
    pub fn master<R>(&self) -> Result<&Kinematics, NotPlanned<R>> {
        self.masters.first().ok_or(NotPlanned::NoMaster)
    }

    /// A slave at rest.
    ///
    /// # Errors
    /// [`NotPlanned::NotAtRest`].
    pub fn check_rest<R>(&self) -> Result<(), NotPlanned<R>> {
        let velocity = self.slave.velocity;
        if velocity == 0.0 && self.slave.acceleration == 0.0 {
            Ok(())
        } else {
            Err(NotPlanned::NotAtRest { velocity })
        }
    }
}

/// What a command to a coupling comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planned<C> {
    /// How the coupling changes.
    pub change: C,
    /// What is checked again when it is due.
    pub awaits: Awaits,
    /// What becomes of the coupling that there is.
    pub manner: Manner,
}

/// What a command does to the coupling that moves the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Manner {
    /// It takes its place, even if that is of the same kind.
    Engage,
    /// It changes it, as a job beside the one that engaged it.
    Adjust,
    /// It changes it, and its job goes on.
    Continue,
}

/// Why a command to a coupling comes to nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotPlanned<R> {
    /// A master is lost, in error, or there is none.
    NoMaster,
    /// The slave has to be at rest first.
    NotAtRest {
        /// Its set velocity, u/s.
        velocity: f64,
    },
    /// The slave cannot, or may not, do that much.
    Guard(GuardRefusal),
    /// For a reason of this kind of coupling.
    Own(R),
}

impl<R> NotPlanned<R> {
    /// The same, with a reason of another kind.
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

/// The fault of a coupling that never breaks off by itself.
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
