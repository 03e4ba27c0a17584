//! What a command comes to, planned and not yet carried out.

use coaxle_axis::{Awaits, Manner, SyncPositions, Transition};
use coaxle_cam::{OnlineChangeMode, TableId};
use coaxle_curve::profile::Profile;
use coaxle_saw::SawPlan;

use super::cam_points::CamPoints;
use super::couplings::Engagement;

/// What a command comes to: [`SlaveAxis::plan`](super::SlaveAxis::plan) makes it,
/// [`SlaveAxis::apply`](super::SlaveAxis::apply) carries it out. One that is dropped was a dry run.
#[derive(Clone, Copy, Debug)]
#[must_use = "nothing changes before it is applied"]
pub struct Change {
    /// The command, by its PLC name.
    pub(super) command: &'static str,
    /// Its arrow in the state diagram; none if it concerns something beside the axis.
    pub(super) transition: Option<Transition>,
    pub(super) effect: Effect,
    pub(super) awaits: Awaits,
    /// That of the axis it was planned for.
    pub(super) revision: u32,
}

/// What is done.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives on the stack: nothing is allocated on the cycle path"
)]
pub(super) enum Effect {
    /// Power is given or taken away.
    Power(bool),
    /// An error is acknowledged.
    Reset,
    /// The axis stands here.
    Home(f64),
    /// A motion of its own.
    Run(Profile),
    /// A coupling is engaged, or the one there is changes.
    Couple(Engagement, Manner),
    /// The master as the coupling sees it is shifted.
    Phase(Profile),
    /// A motion is added to the one there is.
    Superimpose(Profile),
    /// The coupling ends.
    Release,
    /// When points of a plate take effect.
    PlateMode(TableId, OnlineChangeMode),
    /// Points of a plate.
    PlatePoints(TableId, CamPoints),
    /// Something was asked for.
    Read(SawPlan),
}

/// Whether an effect takes the axis over from what moved it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TakesOver {
    /// It happens beside it, at once.
    No,
    /// It goes on beside it.
    GoesOnBeside,
    /// And is done with that.
    AndIsDone,
    /// And is the axis's job from now on.
    AndGoesOn,
}

impl Effect {
    pub(super) const fn takes_over(&self) -> TakesOver {
        match self {
            Self::Home(_) | Self::Run(_) | Self::Couple(..) => TakesOver::AndGoesOn,
            Self::Phase(_) | Self::Superimpose(_) => TakesOver::GoesOnBeside,
            Self::Release => TakesOver::AndIsDone,
            Self::Power(_)
            | Self::Reset
            | Self::PlateMode(..)
            | Self::PlatePoints(..)
            | Self::Read(_) => TakesOver::No,
        }
    }
}

impl Change {
    /// What is checked again when it is due, if it is queued: it can still be refused then.
    #[must_use]
    pub const fn awaits(&self) -> Awaits {
        self.awaits
    }

    /// Its arrow in the state diagram; none if it concerns something beside the axis.
    #[must_use]
    pub const fn transition(&self) -> Option<Transition> {
        self.transition
    }

    /// Whether it is done as soon as it is applied, with nothing to follow.
    #[must_use]
    pub const fn is_done_at_once(&self) -> bool {
        matches!(self.effect.takes_over(), TakesOver::No)
    }

    /// Where master and slave are synchronous then, if it leads to such a pair of positions.
    #[must_use]
    pub const fn sync_positions(&self) -> Option<SyncPositions> {
        match &self.effect {
            Effect::Couple(Engagement::Saw(saw), _) => Some(saw.plan().line().sync_positions()),
            Effect::Couple(Engagement::FlyingGear(gear), _) => Some(gear.sync_positions()),
            _ => None,
        }
    }

    /// The flying saw that it is about, if it is.
    #[must_use]
    pub const fn saw_plan(&self) -> Option<&SawPlan> {
        match &self.effect {
            Effect::Couple(Engagement::Saw(saw), _) => Some(saw.plan()),
            Effect::Read(plan) => Some(plan),
            _ => None,
        }
    }
}
