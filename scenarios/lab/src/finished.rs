//! Progress and result of a run, in either world.

use std::collections::BTreeMap;

use coaxle_sim::RouterTraffic;

use crate::evaluate::Evaluated;
use crate::invariants::InvariantViolation;
use crate::summary::ReceiverSummary;
use crate::verdict::Verdict;

/// Observer of a run's progress, which may end it.
pub trait Progress {
    /// Reports this share of the run as done, 0 to 1. False ends the run: its results up to now remain.
    #[must_use]
    fn at(&mut self, share: f64) -> bool;
}

impl Progress for () {
    fn at(&mut self, _share: f64) -> bool {
        true
    }
}

/// Result of a run in either world.
#[derive(Debug)]
pub struct Finished {
    /// Figures of each receiver, by its name.
    pub figures: BTreeMap<String, ReceiverSummary>,
    /// Outcomes of the commands to slaves, against the expected ones.
    pub commands: Vec<Verdict>,
    /// Violations of invariants.
    pub violations: Vec<InvariantViolation>,
    /// Nodes that a signal killed although the scenario did not order it; of processes alone.
    pub deaths: Vec<Verdict>,
    /// Traffic of each router.
    pub routers: Vec<RouterTraffic>,
    /// Time of an early end, s after its start.
    pub interrupted_at_s: Option<f64>,
}

impl Finished {
    /// The result of a whole run, with its evaluation only.
    #[must_use]
    pub fn new(evaluated: Evaluated) -> Self {
        Self {
            figures: evaluated.receivers.into_iter().collect(),
            commands: Vec::new(),
            violations: evaluated.violations,
            deaths: Vec::new(),
            routers: Vec::new(),
            interrupted_at_s: None,
        }
    }

    /// Adds the time of an early end, s after its start.
    #[must_use]
    pub fn interrupted_at(self, interrupted_at_s: Option<f64>) -> Self {
        Self {
            interrupted_at_s,
            ..self
        }
    }

    /// Adds the outcomes of commands to slaves.
    #[must_use]
    pub fn with_commands(self, commands: Vec<Verdict>) -> Self {
        Self { commands, ..self }
    }

    /// Adds the nodes that a signal killed.
    #[must_use]
    pub fn with_deaths(self, deaths: Vec<Verdict>) -> Self {
        Self { deaths, ..self }
    }

    /// Adds the traffic of each router.
    #[must_use]
    pub fn with_routers(self, routers: Vec<RouterTraffic>) -> Self {
        Self { routers, ..self }
    }

    /// Figures of each receiver, by its name.
    #[must_use]
    pub const fn figures(&self) -> &BTreeMap<String, ReceiverSummary> {
        &self.figures
    }

    /// Violations of invariants, including those that the scenario excepts.
    #[must_use]
    pub fn violations(&self) -> &[InvariantViolation] {
        &self.violations
    }
}
