//! A node with rows, for tests: a boiler.

#![allow(
    unreachable_pub,
    reason = "the macro declares what a crate shows to others"
)]

use coaxle_node::signal::Instance;
use coaxle_recording::Table;

coaxle_node::signals! {
    /// A boiler.
    pub struct BoilerSignals of Node {
        /// Temperature of the water.
        temperature: f64 ["°C"],
    }
}

pub(crate) fn boiler() -> Table {
    Table {
        name: "boiler".to_owned(),
        role: "boiler".to_owned(),
        instances: vec![Instance::of::<BoilerSignals>("")],
    }
}
