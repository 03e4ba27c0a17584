//! `MC_GearInMultiMaster`: the sum of several masters, each by a ratio that may change all the time.

use coaxle_axis::{
    Awaits, Coupling, CouplingPhase, Dynamics, Engage, Job, Manner, Masters, NoFault, NotPlanned,
    PlanInputs, Planned, Scan, Step,
};
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_curve::ramp::Ramp;

use super::ramp_limits::ramp_limits;

/// `MC_GearInMultiMaster`: couples the slave to the sum of up to four masters.
///
/// The slave's velocity is the sum of the masters', each multiplied by its ratio. A ratio of 0 leaves
/// a master out, which may be missing then. The slave is led to that velocity by a ramp; once it is
/// there it follows the masters' positions.
///
/// Given again to a slave that it couples, it changes the ratios: from cycle to cycle if need be. What
/// they ask for beyond the dynamics the slave does later. `MC_GearInDyn` is the case of one master,
/// `MC_CombineAxes` that of two with ratios of the same sign (added) or of opposite ones (subtracted).
#[doc(alias = "MC_GearInMultiMaster")]
#[doc(alias = "MC_GearInDyn")]
#[doc(alias = "MC_CombineAxes")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
}

/// One to four ratios.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "alloc::vec::Vec<f64>", into = "alloc::vec::Vec<f64>")
)]
pub struct Ratios {
    /// 0 where there is none.
    all: [f64; Masters::MOST],
    given: usize,
}

/// A set of ratios that couples nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WrongRatios {
    /// None, or more than a slave has masters.
    #[error("0x421b: received {received} ratios, expected 1 to {}", Masters::MOST)]
    Count {
        /// How many were given.
        received: usize,
    },
    /// One that is no number.
    #[error("0x421b: ratio of master {master}: received {received}, expected a finite number")]
    NotFinite {
        /// Which, from 1.
        master: usize,
        /// The ratio.
        received: f64,
    },
}

impl Ratios {
    /// Takes the ratios.
    ///
    /// # Errors
    /// [`WrongRatios`] with none, more than four, or one that is not finite.
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
        match self.all.iter().position(|ratio| !ratio.is_finite()) {
            None => Ok(()),
            Some(place) => Err(WrongRatios::NotFinite {
                master: place + 1,
                received: self.all[place],
            }),
        }
    }

    /// The ratios.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.all[..self.given]
    }

    /// The sum of the masters; none if one that counts is missing.
    fn sum(&self, masters: &Masters) -> Option<Kinematics> {
        let mut sum = Kinematics::default();
        for (number, ratio) in self.all.iter().enumerate() {
            if *ratio != 0.0 {
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
    /// NC error code.
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
    ramp: Ramp,
    /// The slave's position less that of the masters' sum, once it is there.
    offset: Option<f64>,
}

/// What [`GearInMultiMaster`] comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiMasterChange {
    ratios: Ratios,
    limits: Limits,
    /// The sum of the masters by these ratios, and the slave, at the same moment.
    masters: Kinematics,
    slave: Kinematics,
}

impl Engage for MultiMasterGear {
    type Command = GearInMultiMaster;
    type Change = MultiMasterChange;
    type Refusal = WrongRatios;
    type Fault = NoFault;

    fn plan(
        &self,
        command: &GearInMultiMaster,
        inputs: &PlanInputs,
    ) -> Result<Planned<MultiMasterChange>, NotPlanned<WrongRatios>> {
        let ratios = command.ratios;
        ratios.check().map_err(NotPlanned::Own)?;
        let masters = ratios.sum(&inputs.masters).ok_or(NotPlanned::NoMaster)?;
        inputs.guard.check_speed(masters.velocity)?;
        let limits = ramp_limits(&command.dynamics, inputs)?;
        Ok(Planned {
            change: MultiMasterChange {
                ratios,
                limits,
                masters,
                slave: inputs.slave,
            },
            awaits: Awaits::empty(),
            manner: if inputs.is_engaged {
                Manner::Continue
            } else {
                Manner::Engage
            },
        })
    }

    fn apply(&mut self, change: &MultiMasterChange, _: Job) {
        let MultiMasterChange {
            ratios,
            limits,
            masters,
            slave,
        } = *change;
        let fresh = Engaged {
            ratios,
            ramp: Ramp::new(&slave, masters.velocity, limits),
            offset: None,
        };
        self.engaged = Some(match self.engaged {
            None => fresh,
            Some(engaged) => engaged.with(ratios, limits),
        });
    }
}

impl Engaged {
    /// With other ratios, from where it is.
    fn with(self, ratios: Ratios, limits: Limits) -> Self {
        let mut ramp = self.ramp;
        ramp.limit(limits);
        Self {
            ratios,
            ramp,
            offset: self.offset.filter(|_| ratios == self.ratios),
        }
    }

    fn update(&mut self, masters: Kinematics, dt: f64) -> Kinematics {
        if let Some(offset) = self.offset {
            let led = Kinematics {
                position: masters.position + offset,
                ..masters
            };
            self.ramp.follow(&led, dt);
            return led;
        }
        self.ramp.step(masters.velocity, masters.acceleration, dt);
        let slave = *self.ramp.slave();
        if self.ramp.is_there() {
            self.offset = Some(slave.position - masters.position);
        }
        slave
    }
}

impl Coupling for MultiMasterGear {
    fn update(&mut self, scan: &Scan) -> Step {
        let Some(engaged) = &mut self.engaged else {
            return Step::Failed;
        };
        match engaged.ratios.sum(&scan.masters) {
            None => Step::MasterLost,
            Some(masters) => Step::Set(engaged.update(masters, scan.elapsed.0)),
        }
    }

    fn phase(&self) -> Option<CouplingPhase> {
        Some(match self.engaged?.offset {
            Some(_) => CouplingPhase::InSync,
            None => CouplingPhase::Synchronizing,
        })
    }

    fn end(&mut self) {
        self.engaged = None;
    }

    fn gain(&self) -> Option<f64> {
        Some(self.engaged?.ratios.all[0])
    }
}
