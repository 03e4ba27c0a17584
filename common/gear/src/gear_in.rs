//! `MC_GearIn`: a constant ratio, on a ramp from the slave's present motion.

use coaxle_axis::{
    Awaits, Coupling, CouplingEffect, CouplingPhase, Dynamics, Engage, Job, NoFault, NotPlanned,
    PlanInputs, Planned, Scan, Step,
};
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_curve::ramp::Ramp;

use super::linear::{LinearGear, RatioZero};
use super::ramp_limits::ramp_limits;

/// Part of the slave's limits per cycle that counts as none: the guard of the axis accepts it.
// A step of the velocity by 5 % of j·T² is a jerk of 5 % of the limit in the differences of the positions.
const NEGLIGIBLE_PART: f64 = 0.05;

/// `MC_GearIn`: couples the slave by a constant ratio.
///
/// The slave is led to the velocity of the gear by a ramp, from its present velocity and acceleration,
/// and coupled at the position where they meet. If it already moves with the gear, it is coupled at once.
#[doc(alias = "MC_GearIn")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct GearIn {
    /// Slave units per master unit, not 0.
    #[doc(alias = "RatioNumerator")]
    pub ratio: f64,
    /// The dynamics of the ramp.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "super::is_default")
    )]
    pub dynamics: Dynamics,
}

impl GearIn {
    /// Makes a gear with the dynamics of the axis.
    #[must_use]
    pub const fn of(ratio: f64) -> Self {
        Self {
            ratio,
            dynamics: Dynamics {
                acceleration: None,
                deceleration: None,
                jerk: None,
            },
        }
    }
}

/// The coupling by [`GearIn`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gear {
    state: GearState,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum GearState {
    #[default]
    Idle,
    Ramping(Ramping),
    Rigid(LinearGear),
}

/// Ramp to the velocity of the gear.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ramping {
    ratio: f64,
    /// Ramp of the slave alone, independent of the master's positions.
    ramp: Ramp,
    /// The master in the previous cycle.
    master: Kinematics,
}

/// Change by a [`GearIn`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearChange {
    state: GearState,
}

impl From<LinearGear> for GearChange {
    /// Couples at once: the slave is in its position of the gear.
    fn from(gear: LinearGear) -> Self {
        let state = GearState::Rigid(gear);
        Self { state }
    }
}

impl Engage for Gear {
    type Command = GearIn;
    type Change = GearChange;
    type Refusal = RatioZero;
    type Fault = NoFault;
    type Shared = ();

    fn plan(
        &self,
        (): &(),
        command: &GearIn,
        inputs: &PlanInputs,
    ) -> Result<Planned<GearChange>, NotPlanned<RatioZero>> {
        let (master, slave) = (inputs.master()?, &inputs.slave);
        let ratio = command.ratio;
        let offset = slave.position - ratio * master.position;
        let gear = LinearGear::new(ratio, offset).map_err(NotPlanned::Own)?;
        // A master that is too fast is refused at once: the ramp ends at the
        // slave's highest velocity, so it would never reach that of the gear.
        let coupled = ratio * master.velocity;
        inputs.guard.check_speed(coupled)?;
        let ramp = ramp_limits(&command.dynamics, inputs)?;
        let state = if moves_like(slave, &gear.slave_of(master), inputs) {
            GearState::Rigid(gear)
        } else {
            GearState::Ramping(Ramping::new(ratio, ramp, slave, master))
        };
        Ok(Planned {
            change: GearChange { state },
            awaits: Awaits::empty(),
            effect: CouplingEffect::Engage,
        })
    }

    fn apply(&mut self, (): &mut (), change: &GearChange, _: Job) {
        self.state = change.state;
    }

    fn update(&mut self, (): &mut (), scan: &Scan) -> Step {
        let Some(master) = scan.masters.first() else {
            return Step::MasterLost;
        };
        match &mut self.state {
            GearState::Idle => Step::Failed,
            GearState::Rigid(gear) => Step::Set(gear.slave_of(master)),
            GearState::Ramping(ramping) => {
                // Elapsed time, not the cycle time: after cycles
                // without a scan the ramp takes one longer step.
                let set = ramping.update(master, scan.elapsed.0);
                if ramping.ramp.is_there() {
                    // The set values of this cycle stay the ramp's. The gear leads
                    // through them, so the next cycle continues without a jump.
                    self.state = GearState::Rigid(ramping.gear());
                }
                Step::Set(set)
            }
        }
    }

    fn end(&mut self, (): &mut ()) {
        self.state = GearState::Idle;
    }
}

/// True if the slave moves with its gear, but for a small part of its limits per cycle: of its jerk, and
/// of its acceleration where the jerk is not the limit.
fn moves_like(slave: &Kinematics, gear: &Kinematics, inputs: &PlanInputs) -> bool {
    let cycle = inputs.cycle.0;
    let jerk = NEGLIGIBLE_PART * inputs.guard.limits().binding_in_cycles(cycle).jerk();
    (gear.velocity - slave.velocity).abs() <= jerk * cycle * cycle
        && (gear.acceleration - slave.acceleration).abs() <= jerk * cycle
}

impl Coupling for Gear {
    fn phase(&self) -> Option<CouplingPhase> {
        match self.state {
            GearState::Idle => None,
            GearState::Ramping(_) => Some(CouplingPhase::Synchronizing),
            GearState::Rigid(_) => Some(CouplingPhase::InSync),
        }
    }

    fn gain(&self) -> Option<f64> {
        match self.state {
            GearState::Idle => None,
            // Velocities are in that ratio at the end of the ramp, so it is the gain of the motion to come.
            GearState::Ramping(ramping) => Some(ramping.ratio),
            GearState::Rigid(gear) => Some(gear.ratio()),
        }
    }
}

impl Ramping {
    const fn new(ratio: f64, limits: Limits, slave: &Kinematics, master: &Kinematics) -> Self {
        Self {
            ratio,
            ramp: Ramp::new(slave, ratio * master.velocity, limits),
            master: *master,
        }
    }

    fn update(&mut self, master: &Kinematics, dt: f64) -> Kinematics {
        let ratio = self.ratio;
        self.ramp
            .step(ratio * master.velocity, ratio * master.acceleration, dt);
        // Kept until the ramp ends: the gear needs positions of slave and master of one and the same cycle.
        self.master = *master;
        *self.ramp.slave()
    }

    /// Returns the gear through the present position of the slave.
    fn gear(&self) -> LinearGear {
        LinearGear::through(self.ratio, self.ramp.slave().position, self.master.position)
    }
}
