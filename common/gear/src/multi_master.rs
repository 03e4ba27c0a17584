//! `MC_GearInMultiMaster`: the sum of several masters, each by a ratio that may change at any time.

use coaxle_axis::guard::GuardRefusal;
use coaxle_axis::set_value_guard::{GuardState, SetValueGuard};
use coaxle_axis::{
    Awaits, Coupling, CouplingEffect, CouplingPhase, Dynamics, Engage, Job, MasterDemands, Masters,
    NoFault, NotPlanned, PlanInputs, Planned, Scan, Step,
};
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_curve::ramp::Ramp;

use super::ramp_limits::ramp_limits;

/// `MC_GearInMultiMaster`: couples the slave to the sum of up to four masters.
///
/// The slave's velocity is the sum of the masters', each multiplied by its ratio. A ratio of 0 leaves a
/// master out, which may be missing then. The slave is led to that velocity by a ramp; in sync it follows
/// the masters' positions.
///
/// Commanded again to a slave that it couples, it changes the ratios: from cycle to cycle if need be.
/// Motion beyond the dynamics is done later. `MC_GearInDyn` is the case of one master, `MC_CombineAxes`
/// that of two with ratios of equal sign (added) or opposite sign (subtracted).
#[doc(alias = "MC_GearInMultiMaster")]
#[doc(alias = "MC_GearInDyn")]
#[doc(alias = "MC_CombineAxes")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct GearInMultiMaster {
    /// Slave units per unit of each master, in the order of the slave's masters.
    #[doc(alias = "GearRatio1")]
    pub ratios: Ratios,
    /// The dynamics of the ramps.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "super::is_default")
    )]
    pub dynamics: Dynamics,
    /// Handling of the distance left behind by a change of the ratios.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "super::is_default")
    )]
    pub sync_mode: MultiMasterSync,
}

/// Handling of the distance that a slave is behind its masters after a change of their ratios, the
/// coupling itself included: the dynamics do not let it follow at once.
///
/// Distances left behind by limits are handled by the axis for any coupling: its
/// [`DistancePolicy`](coaxle_axis::set_value_guard::DistancePolicy).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum MultiMasterSync {
    /// Kept: the slave follows the masters' positions from where it reaches their velocity.
    #[doc(alias = "VELOSYNC")]
    #[doc(alias = "POSSYNC1")]
    #[default]
    PosSync1,
    /// Made up: in sync, the slave has travelled as far as if it had followed at once.
    #[doc(alias = "POSSYNC2")]
    PosSync2,
}

/// Ratios of one to four masters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(inline, extend("minItems" = 1, "maxItems" = Masters::MOST))
)]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "alloc::vec::Vec<f64>", into = "alloc::vec::Vec<f64>")
)]
pub struct Ratios {
    /// 0 for missing ones.
    all: [f64; Masters::MOST],
    given: usize,
}

/// An invalid set of ratios.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WrongRatios {
    /// No ratios, or more than a slave has masters.
    #[error("0x421b: received {received} ratios, expected 1 to {}", Masters::MOST)]
    Count {
        /// Number of ratios received.
        received: usize,
    },
    /// A ratio that is not finite.
    #[error("0x421b: ratio of master {master}: received {received}, expected a finite number")]
    NotFinite {
        /// Number of the master, from 1.
        master: usize,
        /// The ratio received.
        received: f64,
    },
}

impl Ratios {
    /// Makes a set of ratios.
    ///
    /// # Errors
    /// [`WrongRatios`] for none, more than four, or one that is not finite.
    pub fn new(ratios: &[f64]) -> Result<Self, WrongRatios> {
        let given = ratios.len();
        if !(1..=Masters::MOST).contains(&given) {
            return Err(WrongRatios::Count { received: given });
        }
        let mut all = [0.0; Masters::MOST];
        all[..given].copy_from_slice(ratios);
        let ratios = Self { all, given };
        ratios.check()?;
        Ok(ratios)
    }

    fn check(&self) -> Result<(), WrongRatios> {
        // Zero is valid here, unlike in `GearIn`: it leaves a master out.
        match self.all.iter().position(|ratio| !ratio.is_finite()) {
            None => Ok(()),
            Some(place) => Err(WrongRatios::NotFinite {
                master: place + 1,
                received: self.all[place],
            }),
        }
    }

    /// Returns the ratios.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.all[..self.given]
    }

    /// Returns the distance of the slave for the masters' motion since `before`; none if a master with a
    /// ratio is missing.
    fn displacement(&self, masters: &Masters, before: &[f64; Masters::MOST]) -> Option<f64> {
        let mut displacement = 0.0;
        for ((number, ratio), before) in self.all.iter().enumerate().zip(before) {
            if *ratio != 0.0 {
                // Distances since the last cycle: a ratio applies to the motion from now on only.
                // With positions, a change of the ratio by Δ would be a jump by Δ·position.
                displacement += ratio * (masters.get(number)?.position - before);
            }
        }
        Some(displacement)
    }

    /// Returns the sum of the masters; none if a master with a ratio is missing.
    fn sum(&self, masters: &Masters) -> Option<Kinematics> {
        let mut sum = Kinematics::default();
        for (number, ratio) in self.all.iter().enumerate() {
            if *ratio != 0.0 {
                // Only masters with a ratio are needed, so one that is left out may be missing or in error.
                let master = masters.get(number)?;
                sum.position += ratio * master.position;
                sum.velocity += ratio * master.velocity;
                sum.acceleration += ratio * master.acceleration;
            }
        }
        Some(sum)
    }
}

#[cfg(feature = "serde")]
impl TryFrom<alloc::vec::Vec<f64>> for Ratios {
    type Error = WrongRatios;

    fn try_from(ratios: alloc::vec::Vec<f64>) -> Result<Self, WrongRatios> {
        Self::new(&ratios)
    }
}

#[cfg(feature = "serde")]
impl From<Ratios> for alloc::vec::Vec<f64> {
    fn from(ratios: Ratios) -> Self {
        ratios.as_slice().to_vec()
    }
}

impl WrongRatios {
    /// Returns the NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        0x421b
    }
}

/// The coupling by [`GearInMultiMaster`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MultiMasterGear {
    engaged: Option<Engaged>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Engaged {
    ratios: Ratios,
    approach: Approach,
}

impl MultiMasterGear {
    /// Returns true if it follows the master of this number, from 0: one with a ratio other than 0.
    #[must_use]
    pub fn follows(&self, number: usize) -> bool {
        let ratios = self.engaged.as_ref().map(|engaged| engaged.ratios.all);
        ratios.is_some_and(|all| all.get(number).is_some_and(|ratio| *ratio != 0.0))
    }
}

/// Motion of the slave to the masters.
#[expect(clippy::large_enum_variant, reason = "nothing is allocated in a cycle")]
#[derive(Clone, Copy, Debug, PartialEq)]
enum Approach {
    /// Motion to their velocity.
    Velocity(ToVelocity),
    /// Motion to their velocity and to their position.
    Position(ToPosition),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct ToVelocity {
    ramp: Ramp,
    /// The slave's position less that of the masters' sum, once in sync.
    offset: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct ToPosition {
    /// Position of a slave that had followed every ratio at once.
    target: f64,
    /// The masters in the previous cycle; missing ones at their last position.
    masters: [f64; Masters::MOST],
    guard: SetValueGuard,
    /// Greatest distance from the target at which it stays in sync, u.
    window: f64,
    in_sync: bool,
}

/// Change by a [`GearInMultiMaster`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiMasterChange {
    ratios: Ratios,
    limits: Limits,
    /// Motion of the slave to the masters, from its state and theirs at the same moment.
    approach: Approach,
}

impl Engage for MultiMasterGear {
    type Command = GearInMultiMaster;
    type Change = MultiMasterChange;
    type Refusal = WrongRatios;
    type Fault = NoFault;
    type Shared = ();

    fn plan(
        &self,
        (): &(),
        command: &GearInMultiMaster,
        inputs: &PlanInputs,
    ) -> Result<Planned<MultiMasterChange>, NotPlanned<WrongRatios>> {
        let ratios = command.ratios;
        // The sum is checked, not each master: two fast ones of opposite ratios make a slow slave.
        let masters = ratios.sum(&inputs.masters).ok_or(NotPlanned::NoMaster)?;
        inputs.guard.check_speed(masters.velocity)?;
        let limits = ramp_limits(&command.dynamics, inputs)?;
        let approach = match command.sync_mode {
            MultiMasterSync::PosSync1 => Approach::Velocity(ToVelocity {
                // Slave and masters are of the same cycle. Otherwise
                // the ramp would see a jump of its target.
                ramp: Ramp::new(&inputs.slave, masters.velocity, limits),
                offset: None,
            }),
            MultiMasterSync::PosSync2 => Approach::Position(ToPosition::new(inputs, limits)?),
        };
        Ok(Planned {
            change: MultiMasterChange {
                ratios,
                limits,
                approach,
            },
            awaits: Awaits::empty(),
            effect: if inputs.is_engaged {
                CouplingEffect::Continue
            } else {
                CouplingEffect::Engage
            },
        })
    }

    fn apply(&mut self, (): &mut (), change: &MultiMasterChange, _: Job) {
        let MultiMasterChange {
            ratios,
            limits,
            approach,
        } = *change;
        let approach = match self.engaged {
            None => approach,
            Some(engaged) => engaged
                .approach
                // An engaged gear continues from its own state: a new one would
                // forget its offset, or the distance that it has to make up.
                .with(approach, limits, ratios == engaged.ratios),
        };
        self.engaged = Some(Engaged { ratios, approach });
    }

    fn update(&mut self, (): &mut (), scan: &Scan) -> Step {
        let Some(engaged) = &mut self.engaged else {
            return Step::Failed;
        };
        engaged.update(scan).map_or(Step::MasterLost, Step::Set)
    }

    fn demands_of(&self, (): &(), master: usize) -> MasterDemands {
        let ratio = |engaged: &Engaged| engaged.ratios.all.get(master).copied();
        let ratio = self.engaged.as_ref().and_then(ratio);
        MasterDemands::of_ratio(ratio.unwrap_or(0.0))
    }

    fn end(&mut self, (): &mut ()) {
        self.engaged = None;
    }
}

impl Approach {
    /// Returns the motion of the next command, from the slave's state in this one.
    fn with(self, next: Self, limits: Limits, same_ratios: bool) -> Self {
        match (self, next) {
            (Self::Velocity(approach), Self::Velocity(_)) => {
                let mut ramp = approach.ramp;
                ramp.limit(limits);
                // Other ratios have another sum: with the old offset the slave would jump to its new place.
                let offset = approach.offset.filter(|_| same_ratios);
                Self::Velocity(ToVelocity { ramp, offset })
            }
            (Self::Position(mut approach), Self::Position(_)) => {
                // The target stays as it is: a distance left by earlier ratios is still to be made up.
                approach.guard.set_limits(&limits);
                // Changed ratios leave a distance behind, so sync is to be reached once
                // more; a command that changes only the dynamics does not interrupt it.
                approach.in_sync &= same_ratios;
                Self::Position(approach)
            }
            // Between the modes nothing can be carried over: one has a
            // constant offset, the other a target that counts distances.
            _ => next,
        }
    }

    const fn is_in_sync(&self) -> bool {
        match self {
            Self::Velocity(approach) => approach.offset.is_some(),
            Self::Position(approach) => approach.in_sync,
        }
    }
}

impl Engaged {
    /// Computes one cycle; none if a master with a ratio is missing.
    fn update(&mut self, scan: &Scan) -> Option<Kinematics> {
        let sum = self.ratios.sum(&scan.masters)?;
        match &mut self.approach {
            Approach::Velocity(approach) => Some(approach.update(sum, scan.elapsed.0)),
            Approach::Position(approach) => approach.update(&self.ratios, &sum, scan),
        }
    }
}

impl ToVelocity {
    fn update(&mut self, masters: Kinematics, dt: f64) -> Kinematics {
        if let Some(offset) = self.offset {
            let led = Kinematics {
                position: masters.position + offset,
                ..masters
            };
            // In sync the ramp copies the motion, so that a later
            // change of the ratios starts from the present motion.
            self.ramp.follow(&led, dt);
            return led;
        }
        self.ramp.step(masters.velocity, masters.acceleration, dt);
        let slave = *self.ramp.slave();
        // An exact comparison of velocities: the last step of a ramp copies the target's.
        if self.ramp.is_there() {
            // From here positions lead. Leading by velocity would add the masters' rounding up to a drift.
            self.offset = Some(slave.position - masters.position);
        }
        slave
    }
}

impl ToPosition {
    fn new(inputs: &PlanInputs, limits: Limits) -> Result<Self, GuardRefusal> {
        let slave = &inputs.slave;
        // No position limits: the guard of the axis, which comes after every coupling, has those.
        let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
        let guard = SetValueGuard::new(&limits, min, max, inputs.cycle, slave)?;
        let mut approach = Self {
            target: slave.position,
            masters: [0.0; Masters::MOST],
            guard,
            window: CouplingPhase::in_sync_window(&limits, inputs.cycle),
            in_sync: false,
        };
        // Without positions to count from, the first distance would be the whole position of the master.
        approach.remember(&inputs.masters);
        Ok(approach)
    }

    fn update(&mut self, ratios: &Ratios, sum: &Kinematics, scan: &Scan) -> Option<Kinematics> {
        // Before the masters are remembered, which makes their distance zero.
        self.target += ratios.displacement(&scan.masters, &self.masters)?;
        self.remember(&scan.masters);
        let target = Kinematics {
            position: self.target,
            ..*sum
        };
        // The guard works in whole cycles, so a late scan counts as several of them.
        let cycles = self.guard.cycles_in(scan.elapsed);
        let guarded = self.guard.update(&target, cycles);
        let is_near = guarded.distance.abs() <= self.window;
        // Sync begins where the slave lands on its target, and ends outside the window. Without
        // this hysteresis a target right at its limits would change it with every rounding.
        self.in_sync = guarded.state == GuardState::Tracking || self.in_sync && is_near;
        Some(guarded.set)
    }

    fn remember(&mut self, masters: &Masters) {
        for (number, seen) in self.masters.iter_mut().enumerate() {
            if let Some(master) = masters.get(number) {
                *seen = master.position;
            }
        }
    }
}

impl Coupling for MultiMasterGear {
    fn phase(&self) -> Option<CouplingPhase> {
        Some(if self.engaged?.approach.is_in_sync() {
            CouplingPhase::InSync
        } else {
            CouplingPhase::Synchronizing
        })
    }

    fn gain(&self) -> Option<f64> {
        Some(self.engaged?.ratios.all[0])
    }
}
