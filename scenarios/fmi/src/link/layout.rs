//! Variables of a link, and their places.

use std::ops::Range;

use coaxle_curve::profile::Kinematics;
use coaxle_lab::record::ReceiverCycle;
use coaxle_lab::scenario::Scenario;
use coaxle_lab::topology::View;
use coaxle_node::config::{Unit, Wrong};
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals};

use super::kinematics_of;
use crate::signal_values::{SignalVariables, write};
use crate::variable::{Causality, UnitValue, Variable, Variables};

/// Variables of a link: parameters, the master, and the signals of the receiver by the names of its trace.
#[derive(Clone, Debug)]
pub(super) struct LinkLayout {
    pub(super) variables: Variables,
    pub(super) view: View,
    /// Places of the parameters.
    pub(super) seed: usize,
    pub(super) set: usize,
    pub(super) from_scenario: usize,
    /// Places of the inputs: position, velocity, acceleration.
    master: [usize; 3],
    /// Places of the instants of the cycle, and of the acceleration of the far axis.
    at_ns: usize,
    woke_ns: usize,
    acceleration: usize,
    /// Places of the signals.
    node: Range<usize>,
    far: Range<usize>,
    axis: Range<usize>,
    slaves: Vec<Range<usize>>,
}

impl LinkLayout {
    /// The variables of a scenario with one sender and one receiver.
    ///
    /// # Errors
    /// [`Wrong`]: a slave whose signals have the names of others.
    pub(super) fn new(scenario: &Scenario, view: View) -> Result<Self, Wrong> {
        let unit = &scenario.senders[0].axes[0].unit;
        let receiver = &scenario.receivers[0];
        let mut list = own_variables(scenario, unit);
        let mut add = |more: Vec<Variable>| {
            // Behind time, which is the first.
            let from = list.len() + 1;
            list.extend(more);
            from..list.len() + 1
        };
        let axis = add(signals("axis.", Causality::Output, unit, unit).of::<FarAxisSignals>(&[]));
        let slaves = view.slaves.iter().map(|number| {
            let prefix = format!("{}.", receiver.slaves[*number].name);
            let own = receiver.slave_unit(*number);
            add(signals(&prefix, Causality::Output, &own, unit).of::<SlaveSignals>(&[]))
        });
        let slaves = slaves.collect();
        let node = add(signals("", Causality::Local, unit, unit).of::<NodeSignals>(&[]));
        let far = add(signals("far.", Causality::Local, unit, unit).of::<FarNodeSignals>(&[]));
        let variables = Variables::new(list)?;
        let place = |name| variables.place(name);
        Ok(Self {
            seed: place("seed"),
            set: place("set"),
            from_scenario: place("master.from_scenario"),
            master: MASTER.map(place),
            at_ns: place("at_ns"),
            woke_ns: place("woke_ns"),
            acceleration: place("axis.corrected_acceleration"),
            variables,
            view,
            node,
            far,
            axis,
            slaves,
        })
    }

    /// Motion of the master, by its inputs.
    pub(super) fn master(&self, values: &[UnitValue]) -> Kinematics {
        kinematics_of(values, self.master)
    }

    /// Writes a cycle of the receiver.
    pub(super) fn show(
        &self,
        record: &ReceiverCycle,
        acceleration: Option<f64>,
        values: &mut [UnitValue],
    ) {
        values[self.at_ns] = UnitValue::Int64(record.at_ns);
        values[self.woke_ns] = UnitValue::Int64(record.woke_ns);
        values[self.acceleration] = UnitValue::Float64(acceleration.unwrap_or(f64::NAN));
        write(&record.axis, &[], &mut values[self.axis.clone()]);
        write(&record.node, &[], &mut values[self.node.clone()]);
        write(&record.far, &[], &mut values[self.far.clone()]);
        for (places, slave) in self.slaves.iter().zip(&record.slaves) {
            write(slave, &[], &mut values[places.clone()]);
        }
    }
}

const fn signals<'a>(
    prefix: &'a str,
    causality: Causality,
    unit: &'a Unit,
    master_unit: &'a Unit,
) -> SignalVariables<'a> {
    SignalVariables {
        prefix,
        causality,
        unit,
        master_unit,
    }
}

/// Inputs of all units: the motion of the master.
pub(crate) const MASTER: [&str; 3] = ["master.position", "master.velocity", "master.acceleration"];

/// Variables that are no signals.
fn own_variables(scenario: &Scenario, unit: &Unit) -> Vec<Variable> {
    let variable = |name: &str, causality, unit: &str, start, description: &str| Variable {
        name: name.to_owned(),
        description: description.to_owned(),
        unit: unit.to_owned(),
        causality,
        start,
    };
    use Causality::{Input, Local, Output, Parameter};
    let [position, velocity, acceleration] = MASTER;
    let of_axis = |of: &str| unit.in_place_of_u(of);
    let zero = || UnitValue::Float64(0.0);
    vec![
        variable(
            "seed",
            Parameter,
            "",
            UnitValue::UInt64(scenario.seed),
            "Seed of everything random: the same seed gives the same run.",
        ),
        variable(
            "set",
            Parameter,
            "",
            UnitValue::String(String::new()),
            "Fields of the scenario to be set, each path.to.field=value, a line for each.",
        ),
        variable(
            "master.from_scenario",
            Parameter,
            "",
            UnitValue::Boolean(false),
            "True if the master moves by the scenario, and not by the inputs.",
        ),
        variable(
            position,
            Input,
            &of_axis("u"),
            zero(),
            "Position of the master.",
        ),
        variable(
            velocity,
            Input,
            &of_axis("u/s"),
            zero(),
            "Velocity of the master.",
        ),
        variable(
            acceleration,
            Input,
            &of_axis("u/s²"),
            zero(),
            "Acceleration of the master.",
        ),
        variable(
            "axis.corrected_acceleration",
            Output,
            &of_axis("u/s²"),
            UnitValue::Float64(f64::NAN),
            "Corrected set acceleration.",
        ),
        variable(
            "at_ns",
            Local,
            "",
            UnitValue::Int64(0),
            "IdealDrive start of the newest cycle of the receiver.",
        ),
        variable(
            "woke_ns",
            Local,
            "",
            UnitValue::Int64(0),
            "Actual beginning of the newest cycle of the receiver, ns.",
        ),
    ]
}
