//! The curves of all receivers of a run.

use super::Curves;
use crate::followed::JudgedAxis;
use crate::row::{Row, RowSink};
use crate::scenario::Scenario;
use crate::topology::{Topology, View};

/// Draws every row that it takes.
#[derive(Debug)]
pub(crate) struct Drawn(Vec<Curves>);

impl Drawn {
    /// No curves yet, of each receiver by each of its axes.
    pub(crate) fn new(scenario: &Scenario, topology: &Topology) -> Self {
        let curves = |view: &View| {
            let config = &scenario.receivers[view.receiver];
            let followed = JudgedAxis::of(config, view);
            let slaves = view.slaves.iter();
            let slaves = slaves.map(|n| (config.slaves[*n].name.as_str(), config.slave_unit(*n)));
            // Windows are cycles of the receiver whose event opens them.
            let cycle_s = config.cycle_time_us.0.as_secs_f64();
            Curves::new(&view.name, followed.mode, followed.unit, cycle_s, slaves)
        };
        Self(topology.views().iter().map(curves).collect())
    }

    /// Curves of all receivers.
    pub(crate) fn into_curves(self) -> Vec<Curves> {
        self.0
    }
}

impl RowSink for Drawn {
    fn row(&mut self, view: usize, row: &Row) {
        // An event at one receiver opens a window for all.
        if let Some(window) = self.0[view].push(row) {
            let all = self.0.iter_mut();
            all.for_each(|curves| curves.keep(window.from_s, window.to_s));
        }
    }
}
