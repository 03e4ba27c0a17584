//! The contract of a unit: its variables, its start, and its steps.

use std::fmt;

use coaxle_clock::CycleTime;

use crate::variable::{UnitValue, Variables};

/// A unit by its resources: its variables, and how it starts.
pub trait Model: fmt::Debug {
    /// Title for the description of the unit, one line.
    fn title(&self) -> String;

    /// The variables.
    fn variables(&self) -> &Variables;

    /// The fixed step. A communication step is one cycle or several.
    fn cycle_time(&self) -> CycleTime;

    /// Starts it with its parameters. Values are in the order of the value references.
    ///
    /// # Errors
    /// Parameters that cannot be used, with the field, the value received and the one expected.
    fn start(&self, values: &[UnitValue]) -> anyhow::Result<Box<dyn CoSimulation>>;
}

/// A unit under way. Nothing but its parameters and its steps decides on its outputs.
pub trait CoSimulation {
    /// Runs a number of cycles with the inputs among the values, which are those of their beginning. Returns what the log is to say,
    /// as of a refused command.
    ///
    /// # Errors
    /// A node that breaks its contract. The unit cannot be used any more.
    fn step(&mut self, values: &[UnitValue], cycles: u32) -> anyhow::Result<Option<String>>;

    /// Writes the outputs to their places among the values.
    fn show(&self, values: &mut [UnitValue]);
}
