//! What a run tells while it lasts, and what it hands back, in either world.

use std::collections::BTreeMap;

use crate::curves::Curves;
use crate::summary::ReceiverSummary;
use crate::verdict::Verdict;

/// Hears how far a run is.
pub trait Progress {
    /// This share of the run is done, 0 to 1.
    fn at(&mut self, share: f64);
}

impl Progress for () {
    fn at(&mut self, _share: f64) {}
}

/// What either world hands back.
#[derive(Debug)]
pub struct Finished {
    pub(crate) figures: BTreeMap<String, ReceiverSummary>,
    pub(crate) curves: Vec<Curves>,
    /// Whether the commands to slaves had the answers that were expected.
    pub(crate) commands: Vec<Verdict>,
}

impl Finished {
    pub(crate) fn new(receivers: Vec<(String, ReceiverSummary, Curves)>) -> Self {
        let mut figures = BTreeMap::new();
        let mut curves = Vec::new();
        for (name, summary, drawn) in receivers {
            figures.insert(name, summary);
            curves.push(drawn);
        }
        Self {
            figures,
            curves,
            commands: Vec::new(),
        }
    }

    pub(crate) fn with_commands(self, commands: Vec<Verdict>) -> Self {
        Self { commands, ..self }
    }

    pub(crate) fn into_figures(self) -> Vec<(String, ReceiverSummary)> {
        self.figures.into_iter().collect()
    }
}
