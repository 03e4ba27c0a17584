//! A node for tests: a boiler with two valves.

#![allow(
    unreachable_pub,
    reason = "the macro declares what a crate shows to others"
)]

use coaxle_node::config::Unit;
use coaxle_node::signal::Instance;
use serde::{Deserialize, Serialize};

use crate::table::Table;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Flame {
    #[default]
    Off,
    BurnsWell,
}

coaxle_node::signals! {
    /// The boiler itself.
    pub struct BoilerSignals of Node {
        /// Temperature of the water.
        temperature: Option<f64> ["°C"],
        /// Times the flame went off.
        offs: u64 [""],
        /// The flame.
        flame: Flame [""],
    }
}

coaxle_node::signals! {
    /// A valve.
    pub struct ValveSignals of Axis {
        /// Position of the valve.
        position: f64 ["u"],
        /// Steps of its motor, in either direction.
        steps: Option<i32> [""],
        /// The valve is open.
        open: Option<bool> [""],
        /// Part of the flame at the valve.
        flame: Option<Flame> [""],
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct BoilerRow {
    pub(crate) node: BoilerSignals,
    pub(crate) valves: Vec<ValveSignals>,
}

pub(crate) fn boiler() -> Table {
    let valve = |name: &str| Instance::of::<ValveSignals>(name).in_unit(Unit::default());
    Table {
        name: "boiler".to_owned(),
        role: "boiler".to_owned(),
        instances: vec![
            Instance::of::<BoilerSignals>(""),
            valve("hot"),
            valve("cold"),
        ],
    }
}

/// Returns the n-th row, with values of every kind.
pub(crate) fn row(n: u64) -> BoilerRow {
    let valve = |k: u64| ValveSignals {
        position: n as f64 * 0.1 + k as f64,
        steps: (k > 0).then_some(-(n as i32)),
        open: n.is_multiple_of(2).then_some(k == 0),
        flame: n.is_multiple_of(3).then_some(Flame::BurnsWell),
    };
    BoilerRow {
        node: BoilerSignals {
            temperature: (n > 1).then_some(20.0 + n as f64 / 7.0),
            offs: n,
            flame: Flame::Off,
        },
        valves: vec![valve(0), valve(1)],
    }
}
