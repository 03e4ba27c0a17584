//! Changes with which a refused synchronisation would be accepted.

use super::command::{GearInPos, GearInVelo};
use super::coupling_moment::CouplingMoment;
use super::running::starts;
use super::{SawCommand, SyncMask, SyncStrategy};

/// Factor between successive tries.
// Acceptance may come and go between two tries: a window narrower than 2 % is not found.
const STEP: f64 = 1.02;
/// Number of tries: the last is a thousand times as far (or a thousandth).
const TRIES: usize = 350;
/// Halvings of the step in which acceptance changes.
// 2 % halved 24 times is 1e-9 of the value.
const HALVINGS: usize = 24;
/// Flags that add a profile to those tried. Flags that ignore an acceleration are left out: they would
/// make the slave's acceleration step.
const FLAGS: [SyncMask; 4] = [
    SyncMask::PREFER_CONST_VELO,
    SyncMask::OVERSHOOT_VELO,
    SyncMask::UNDERSHOOT_VELO,
    SyncMask::MAX_VELO,
];
/// Strategies, first those that keep the synchronisation positions.
const STRATEGIES: [SyncStrategy; 3] = [SyncStrategy::Slow, SyncStrategy::Late, SyncStrategy::Early];

/// Single changes that would be accepted, all else unchanged. Found by trial: planning again with other
/// values, and halving the step in which acceptance changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub struct SawRemedy {
    /// Distance of the master before its synchronisation position at the coupling moment, u: the smallest
    /// accepted distance beyond the given one, or, if there is none, the largest below it. None if no
    /// distance helps, or if none was searched for.
    pub master_distance: Option<f64>,
    /// Greatest accepted speed of the master below the given one, u/s. None if no speed helps.
    pub master_speed: Option<f64>,
    /// Flags of the sync mode; any one of them, added, makes it pass.
    pub flags: SyncMask,
    /// The first strategy of slow, late and early that makes it pass. None if none does, or if the
    /// command takes no strategy.
    pub strategy: Option<SyncStrategy>,
}

impl SawRemedy {
    /// True if no remedy was found.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl SawCommand {
    /// Finds the remedy for a refused command; empty if there is no search. Plans some hundred times: not
    /// for the cycle.
    #[must_use]
    pub fn remedy(&self, moment: &CouplingMoment) -> SawRemedy {
        match self {
            _ if !self.looks_for_a_remedy() => SawRemedy::default(),
            Self::GearInPos(command) => command.remedy(moment),
            Self::GearInVelo(command) => command.remedy(moment),
        }
    }

    /// True if a remedy is searched for: not for a position that is not finite.
    #[must_use]
    pub const fn looks_for_a_remedy(&self) -> bool {
        match self {
            Self::GearInPos(command) => command.master_sync_position.is_finite(),
            Self::GearInVelo(_) => true,
        }
    }
}

impl GearInPos {
    /// Finds the remedy for a refused command. Plans some hundred times: not for the cycle.
    #[must_use]
    pub fn remedy(&self, moment: &CouplingMoment) -> SawRemedy {
        // As the coupling would start, a wait for the start distance or the last moment included.
        let starts = |command: Self| starts(&SawCommand::GearInPos(command), moment);
        let with_flag = |flag: SyncMask| {
            let mut command = *self;
            command.sync_mode.mask |= flag;
            starts(command)
        };
        // With a strategy, the strategy selects the profile.
        let flags = FLAGS.into_iter().filter(|flag| {
            self.strategy.is_none() && !self.sync_mode.mask.contains(*flag) && with_flag(*flag)
        });
        let with_strategy = |strategy: &SyncStrategy| {
            let strategy = Some(*strategy);
            self.strategy != strategy && starts(Self { strategy, ..*self })
        };
        SawRemedy {
            flags: flags.collect(),
            strategy: STRATEGIES.into_iter().find(with_strategy),
            ..self.other_motion_of_the_master(moment)
        }
    }

    /// Finds distance and speed of the master. Not if the slave would wait for a start distance: distance
    /// and speed of the master then belong to a later moment.
    fn other_motion_of_the_master(&self, moment: &CouplingMoment) -> SawRemedy {
        if self.master_start_distance.is_some() {
            return SawRemedy::default();
        }
        let master = moment.master.position;
        let distance = self.master_sync_position - master;
        let at_distance = |distance: f64| {
            let command = Self {
                master_sync_position: master + distance,
                ..*self
            };
            command.plan(moment).is_ok()
        };
        let first = first_distance(self, moment);
        SawRemedy {
            master_distance: nearest(first, STEP, at_distance)
                .or_else(|| nearest(distance, 1.0 / STEP, at_distance))
                .map(f64::abs),
            master_speed: speed(moment, |moment| self.plan(moment).is_ok()),
            ..SawRemedy::default()
        }
    }
}

impl GearInVelo {
    /// Finds the remedy for a refused command. Plans some hundred times: not for the cycle.
    #[must_use]
    pub fn remedy(&self, moment: &CouplingMoment) -> SawRemedy {
        SawRemedy {
            master_speed: speed(moment, |moment| self.plan(moment).is_ok()),
            ..SawRemedy::default()
        }
    }
}

/// Returns the given distance, or, if that is not ahead of the master, a thousandth of the slave's
/// distance.
fn first_distance(command: &GearInPos, moment: &CouplingMoment) -> f64 {
    let velocity = moment.master.velocity;
    let distance = command.master_sync_position - moment.master.position;
    if distance * velocity > 0.0 || velocity == 0.0 {
        return distance;
    }
    let distance = command.slave_sync_position - moment.slave.position;
    // A position behind the master has no distance to start
    // from, so the slave's gives the order of magnitude.
    (distance * 1e-3).abs().copysign(velocity)
}

fn speed(moment: &CouplingMoment, passes: impl Fn(&CouplingMoment) -> bool) -> Option<f64> {
    let at_velocity = |velocity: f64| {
        let mut moment = *moment;
        moment.master.velocity = velocity;
        passes(&moment)
    };
    nearest(moment.master.velocity, 1.0 / STEP, at_velocity).map(f64::abs)
}

/// Finds the value nearest to `from`, in steps by `factor`, that passes.
fn nearest(from: f64, factor: f64, passes: impl Fn(f64) -> bool) -> Option<f64> {
    // No factor leads away from 0.
    if from == 0.0 {
        return None;
    }
    let mut tries = core::iter::successors(Some(from), |value| Some(value * factor)).take(TRIES);
    let mut passed = tries.find(|&value| passes(value))?;
    let mut failed = if passed == from {
        from
    } else {
        // The try before the first that passes has failed, so acceptance changes between.
        passed / factor
    };
    for _ in 0..HALVINGS {
        let middle = failed + (passed - failed) / 2.0;
        if passes(middle) {
            passed = middle;
        } else {
            failed = middle;
        }
    }
    Some(passed)
}
