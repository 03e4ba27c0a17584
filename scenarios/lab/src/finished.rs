//! What a run tells while it lasts, and what it hands back, in either world.

use std::collections::BTreeMap;

use coaxle_sim::RouterTraffic;

use crate::evaluate::Evaluated;
use crate::invariants::InvariantViolation;
use crate::summary::ReceiverSummary;
use crate::verdict::Verdict;

/// Hears how far a run is, and may end it.
pub trait Progress {
    /// This share of the run is done, 0 to 1. Whether to go on: if not, what there is by now is all.
    #[must_use]
    fn at(&mut self, share: f64) -> bool;
}

impl Progress for () {
    fn at(&mut self, _share: f64) -> bool {
        true
    }
}

/// What either world hands back.
#[derive(Debug)]
pub struct Finished {
    /// Each receiver's figures, by its name.
    pub figures: BTreeMap<String, ReceiverSummary>,
    /// Whether the commands to slaves had the answers that were expected.
    pub commands: Vec<Verdict>,
    /// What did not hold in every cycle.
    pub violations: Vec<InvariantViolation>,
    /// Nodes that a signal killed although the scenario did not order it; of processes alone.
    pub deaths: Vec<Verdict>,
    /// What each router did.
    pub routers: Vec<RouterTraffic>,
    /// When it was ended before its time, s after its start.
    pub interrupted_at_s: Option<f64>,
}

impl Finished {
    /// A whole run, of which no more is known than what was evaluated.
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

    /// With when it was ended before its time, s after its start.
    #[must_use]
    pub fn interrupted_at(self, interrupted_at_s: Option<f64>) -> Self {
        Self {
            interrupted_at_s,
            ..self
        }
    }

    /// With what the commands to slaves came to.
    #[must_use]
    pub fn with_commands(self, commands: Vec<Verdict>) -> Self {
        Self { commands, ..self }
    }

    /// With the nodes that a signal killed.
    #[must_use]
    pub fn with_deaths(self, deaths: Vec<Verdict>) -> Self {
        Self { deaths, ..self }
    }

    /// With what each router did.
    #[must_use]
    pub fn with_routers(self, routers: Vec<RouterTraffic>) -> Self {
        Self { routers, ..self }
    }

    /// Each receiver's figures, by its name.
    #[must_use]
    pub const fn figures(&self) -> &BTreeMap<String, ReceiverSummary> {
        &self.figures
    }

    /// What did not hold in every cycle, whether the scenario means it or not.
    #[must_use]
    pub fn violations(&self) -> &[InvariantViolation] {
        &self.violations
    }
}
