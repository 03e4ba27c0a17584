//! Variables of a slave, and their places.

use std::ops::Range;

use coaxle_node::config::Wrong;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_saw::SawCommand;

use super::file::{SlaveCoupling, SlaveFile};
use crate::link::MASTER;
use crate::signal_values::{SignalVariables, write};
use crate::variable::{Causality, UnitValue, Variable, Variables};

/// Signals of a slave that the axis itself has; the others are of a node's programs, tools and drives.
const SIGNALS: &[&str] = &[
    "position",
    "velocity",
    "acceleration",
    "master_position",
    "slave_sync_position",
    "master_sync_position",
    "guard",
    "distance",
    "set_anew",
    "state",
    "phase",
    "cam_table",
    "cam_master_position",
    "cam_slave_position",
    "error",
    "refusal",
];

/// Variables of a slave: parameters, commands, the master, and its signals.
#[derive(Clone, Debug)]
pub(super) struct SlaveLayout {
    pub(super) variables: Variables,
    signals: Range<usize>,
}

impl SlaveLayout {
    /// # Errors
    /// [`Wrong`]: names that are used twice.
    pub(super) fn new(file: &SlaveFile) -> Result<Self, Wrong> {
        let mut list = parameters(file);
        list.extend(inputs(file));
        list.push(Variable {
            name: "command.state".to_owned(),
            description: "State of the coupling as a command: idle, waiting, active, in-sync, done, aborted or failed.".to_owned(),
            unit: String::new(),
            causality: Causality::Output,
            start: UnitValue::String(String::new()),
        });
        let signals = SignalVariables {
            prefix: "",
            causality: Causality::Output,
            unit: &file.unit,
            master_unit: &file.master_unit,
        };
        let from = list.len() + 1;
        list.extend(signals.of::<SlaveSignals>(SIGNALS));
        Ok(Self {
            signals: from..list.len() + 1,
            variables: Variables::new(list)?,
        })
    }

    /// A number among the values; none if the unit has no such variable.
    pub(super) fn number(&self, values: &[UnitValue], name: &str) -> Option<f64> {
        match values[self.variables.reference(name)? as usize] {
            UnitValue::Float64(number) => Some(number),
            _ => None,
        }
    }

    /// A flag among the values.
    pub(super) fn flag(&self, values: &[UnitValue], name: &str) -> bool {
        values[self.variables.place(name)] == UnitValue::Boolean(true)
    }

    /// Places of the motion of the master.
    pub(super) fn master(&self) -> [usize; 3] {
        MASTER.map(|name| self.variables.place(name))
    }

    /// Writes the outputs.
    pub(super) fn show(&self, state: &str, signals: &SlaveSignals, values: &mut [UnitValue]) {
        values[self.variables.place("command.state")] = UnitValue::String(state.to_owned());
        write(signals, SIGNALS, &mut values[self.signals.clone()]);
    }
}

fn parameters(file: &SlaveFile) -> Vec<Variable> {
    let unit = |of: &str| file.unit.in_place_of_u(of);
    let limits = &file.limits;
    let deceleration = limits.deceleration.unwrap_or(limits.acceleration);
    let always = [
        (
            "start.position",
            "u",
            file.position,
            "Position before the first command.",
        ),
        (
            "start.velocity",
            "u/s",
            file.velocity,
            "Velocity until the first command; 0: at rest.",
        ),
        ("limits.velocity", "u/s", limits.velocity, "Highest speed."),
        (
            "limits.acceleration",
            "u/s²",
            limits.acceleration,
            "Highest acceleration.",
        ),
        (
            "limits.deceleration",
            "u/s²",
            deceleration,
            "Highest deceleration.",
        ),
        ("limits.jerk", "u/s³", limits.jerk, "Highest jerk."),
    ];
    let software = [
        (
            "limits.min_position",
            limits.min_position,
            "Lower software limit.",
        ),
        (
            "limits.max_position",
            limits.max_position,
            "Upper software limit.",
        ),
    ];
    let software = software.into_iter().filter_map(|(name, limit, meaning)| {
        // Only where the file has one: no number stands for none.
        Some((name, "u", limit?, meaning))
    });
    let all = always.into_iter().chain(software);
    all.map(|(name, of, start, meaning)| {
        number(name, &unit(of), Causality::Parameter, start, meaning)
    })
    .collect()
}

fn inputs(file: &SlaveFile) -> Vec<Variable> {
    let master = |of: &str| file.master_unit.in_place_of_u(of);
    let input =
        |name, unit: &str, start, meaning| number(name, unit, Causality::Input, start, meaning);
    let [position, velocity, acceleration] = MASTER;
    let mut list = vec![
        input(position, &master("u"), 0.0, "Position of the master."),
        input(velocity, &master("u/s"), 0.0, "Velocity of the master."),
        input(
            acceleration,
            &master("u/s²"),
            0.0,
            "Acceleration of the master.",
        ),
        flag(
            "master.is_there",
            true,
            "False if the master is lost or in error.",
        ),
        flag("command.power", true, "Power (MC_Power)."),
        flag(
            "command.execute",
            false,
            "A rising edge couples the slave by the file, as soon as it has power.",
        ),
        flag(
            "command.release",
            false,
            "A rising edge releases the slave (MC_GearOut, MC_CamOut).",
        ),
        flag(
            "command.move_to_start",
            false,
            "A rising edge moves the slave to its start position (MC_MoveAbsolute).",
        ),
        flag(
            "command.reset",
            false,
            "A rising edge acknowledges an error (MC_Reset).",
        ),
    ];
    let (master, slave) = (master("u"), file.unit.in_place_of_u("u"));
    match &file.coupling {
        SlaveCoupling::Saw(SawCommand::GearInPos(saw)) => list.extend([
            input(SYNC[0], &master, saw.master_sync_position, SYNC_MEANINGS[0]),
            input(SYNC[1], &slave, saw.slave_sync_position, SYNC_MEANINGS[1]),
        ]),
        SlaveCoupling::Saw(SawCommand::GearInVelo(_)) => {}
        SlaveCoupling::Gear(gear) => list.extend([
            input(
                SYNC[0],
                &master,
                gear.master_sync_position,
                SYNC_MEANINGS[0],
            ),
            input(SYNC[1], &slave, gear.slave_sync_position, SYNC_MEANINGS[1]),
        ]),
        SlaveCoupling::Cam(cam, _) => list.extend([
            input(
                CAM[0],
                &master,
                cam.master_offset,
                "Offset of the master, for the next coupling.",
            ),
            input(
                CAM[1],
                &slave,
                cam.slave_offset,
                "Offset of the slave, for the next coupling.",
            ),
            input(
                CAM[2],
                "",
                cam.master_scaling,
                "Scaling of the master, for the next coupling.",
            ),
            input(
                CAM[3],
                "",
                cam.slave_scaling,
                "Scaling of the slave, for the next coupling.",
            ),
        ]),
    }
    list
}

/// Positions of the next coupling.
pub(super) const SYNC: [&str; 2] = [
    "command.master_sync_position",
    "command.slave_sync_position",
];
const SYNC_MEANINGS: [&str; 2] = [
    "Position of the master at which the slave is synchronous, for the next coupling.",
    "Position of the slave there, for the next coupling.",
];
/// Offsets and scalings of the next coupling to a plate.
pub(super) const CAM: [&str; 4] = [
    "command.master_offset",
    "command.slave_offset",
    "command.master_scaling",
    "command.slave_scaling",
];

fn number(name: &str, unit: &str, causality: Causality, start: f64, meaning: &str) -> Variable {
    Variable {
        name: name.to_owned(),
        description: meaning.to_owned(),
        unit: unit.to_owned(),
        causality,
        start: UnitValue::Float64(start),
    }
}

fn flag(name: &str, start: bool, meaning: &str) -> Variable {
    Variable {
        name: name.to_owned(),
        description: meaning.to_owned(),
        unit: String::new(),
        causality: Causality::Input,
        start: UnitValue::Boolean(start),
    }
}
