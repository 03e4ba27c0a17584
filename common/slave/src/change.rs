//! Planned change of a command, before it is applied.

use coaxle_axis::{Awaits, CouplingEffect, SyncPositions, Transition};
use coaxle_cam::{OnlineChangeMode, TableId};
use coaxle_curve::profile::Profile;
use coaxle_saw::SawPlan;

use super::cam_points::CamPoints;
use super::couplings::Engagement;

/// Planned change of a command: created by [`SlaveAxis::plan`](super::SlaveAxis::plan), applied by
/// [`SlaveAxis::apply`](super::SlaveAxis::apply). A discarded one was a dry run.
#[derive(Clone, Copy, Debug)]
#[must_use = "nothing changes before it is applied"]
pub struct Change {
    /// The command, by its PLC name.
    pub(super) command: &'static str,
    /// Arrow in the state diagram; none for a command that does not concern the axis itself.
    pub(super) transition: Option<Transition>,
    pub(super) effect: Effect,
    pub(super) awaits: Awaits,
    /// Revisions of the axis and of the plates it was planned for.
    pub(super) revisions: [u32; 2],
}

/// Effect of a command.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives on the stack: nothing is allocated on the cycle path"
)]
pub(super) enum Effect {
    /// Switching power on or off.
    Power(bool),
    /// Acknowledging an error.
    Reset,
    /// Setting the position.
    Home(f64),
    /// Own motion.
    Run(Profile),
    /// Own motion to rest, from what the drive is shown.
    Stop(Profile),
    /// Engaging or changing a coupling.
    Couple(Engagement, CouplingEffect),
    /// Shifting the master as the coupling sees it.
    Phase(Profile),
    /// Superimposing a motion.
    Superimpose(Profile),
    /// Ending the coupling.
    Release,
    /// Activation mode of plate points.
    PlateMode(TableId, OnlineChangeMode),
    /// Writing plate points.
    PlatePoints(TableId, CamPoints),
    /// Reading values.
    Read(SawPlan),
}

/// Relation of an effect to the current motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TakesOver {
    /// Independent of it, done at once.
    No,
    /// Continuing in parallel with it.
    GoesOnBeside,
    /// Taking over, done at once.
    AndIsDone,
    /// Taking over, as the axis's job from now on.
    AndGoesOn,
}

impl Effect {
    pub(super) const fn takes_over(&self) -> TakesOver {
        match self {
            // Homing takes over as well, so that its job ends like that of a motion.
            Self::Home(_) | Self::Run(_) | Self::Stop(_) | Self::Couple(..) => TakesOver::AndGoesOn,
            Self::Phase(_) | Self::Superimpose(_) => TakesOver::GoesOnBeside,
            // The axis is released at once. The velocity that it keeps is no part of the command.
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
    /// Checks repeated when it is due, if it is queued: it can still be refused then.
    #[must_use]
    pub const fn awaits(&self) -> Awaits {
        self.awaits
    }

    /// Arrow in the state diagram; none for a command that does not concern the axis itself.
    #[must_use]
    pub const fn transition(&self) -> Option<Transition> {
        self.transition
    }

    /// True if it is completed on application, with no job to follow.
    #[must_use]
    pub const fn is_done_at_once(&self) -> bool {
        // A release is done at once, too, but it ends the job before it and has a number of its own.
        matches!(self.effect.takes_over(), TakesOver::No)
    }

    /// True if it moves the axis, or switches its power; others leave the motion as it is.
    #[must_use]
    pub const fn decides_motion(&self) -> bool {
        match self.effect.takes_over() {
            TakesOver::No => matches!(self.effect, Effect::Power(_)),
            TakesOver::GoesOnBeside | TakesOver::AndIsDone | TakesOver::AndGoesOn => true,
        }
    }

    /// Positions of master and slave at which they will be synchronous, if it leads to such a pair.
    #[must_use]
    pub const fn sync_positions(&self) -> Option<SyncPositions> {
        match &self.effect {
            Effect::Couple(Engagement::Saw(saw), _) => Some(saw.plan().line().sync_positions()),
            Effect::Couple(Engagement::FlyingGear(gear), _) => Some(gear.sync_positions()),
            _ => None,
        }
    }

    /// The plan of its flying saw, if it is one.
    #[must_use]
    pub const fn saw_plan(&self) -> Option<&SawPlan> {
        match &self.effect {
            Effect::Couple(Engagement::Saw(saw), _) => Some(saw.plan()),
            Effect::Read(plan) => Some(plan),
            _ => None,
        }
    }
}
