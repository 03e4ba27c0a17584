//! What a sender shows of itself after each cycle: its signals.

use std::sync::Arc;

use coaxle_clock::{Instant, Local};
use coaxle_node::signal::{Instance, trace_columns};
use serde::Serialize;

use crate::config::{SHOWN_BY_DEFAULT, SenderConfig};
use crate::signals::{AxisSignals, SenderSignals};
use coaxle_source::config::AxisConfig;

/// The row of a sender's signals, sized once from its config.
#[derive(Debug, PartialEq, Serialize)]
pub struct SenderRow {
    /// The sender itself.
    pub node: SenderSignals,
    /// The axes that the config shows: [`SenderConfig::shown_axes`].
    pub axes: Box<[AxisSignals]>,
}

impl SenderRow {
    /// A row before the first cycle: the axes are at rest at 0.
    #[must_use]
    pub fn new(config: &SenderConfig) -> Self {
        let axes = config.shown_axes();
        Self {
            node: SenderSignals::default(),
            axes: axes.map(|_| AxisSignals::default()).collect(),
        }
    }
}

impl Clone for SenderRow {
    fn clone(&self) -> Self {
        Self {
            node: self.node,
            axes: self.axes.clone(),
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.node = other.node;
        // In place: they are as many.
        self.axes.clone_from(&other.axes);
    }
}

impl SenderConfig {
    /// The axes whose motion snapshots, status and trace show: those that the config names, in its order,
    /// or the first ones by id. An id that does not exist is left out.
    pub fn shown_axes(&self) -> impl Iterator<Item = &AxisConfig> {
        let mut shown: Vec<&AxisConfig> = Vec::new();
        if self.show_axes.is_default() {
            shown.extend(self.axes.iter());
            shown.sort_by_key(|axis| axis.id);
            shown.truncate(SHOWN_BY_DEFAULT);
        } else {
            let called = |id| self.axes.iter().find(|axis| axis.id == id);
            shown.extend(self.show_axes.ids().iter().copied().filter_map(called));
        }
        shown.into_iter()
    }

    /// Everything that has signals, in the order of a row. An axis is called by its name, or by that and its
    /// id where another one has the same.
    #[must_use]
    pub fn instances(&self) -> Vec<Instance> {
        let shown: Vec<_> = self.shown_axes().collect();
        let instance = |axis: &&AxisConfig| {
            let same = shown.iter().filter(|other| other.name == axis.name);
            let name = match same.count() {
                1 => axis.name.clone(),
                _ => format!("{}.{}", axis.name, axis.id),
            };
            Instance::of::<AxisSignals>(name).in_unit(axis.unit.clone())
        };
        let node = std::iter::once(Instance::of::<SenderSignals>(""));
        node.chain(shown.iter().map(instance)).collect()
    }

    /// The columns of a trace: [`trace_columns`] of its instances.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        trace_columns(&self.instances())
    }
}

/// A sender after a cycle. Cloning it into one of the same config does not allocate.
#[derive(Debug, PartialEq)]
pub struct SenderSnapshot {
    /// When the cycle should have begun.
    pub ideal_start: Instant<Local>,
    /// When it began.
    pub woke: Instant<Local>,
    /// Its signals.
    pub signals: SenderRow,
    /// The ids of the axes that are shown.
    ids: Arc<[u32]>,
}

impl SenderSnapshot {
    /// A sender before its first cycle, which is due at `start`.
    #[must_use]
    pub fn new(config: &SenderConfig, start: Instant<Local>) -> Self {
        Self {
            ideal_start: start,
            woke: start,
            signals: SenderRow::new(config),
            ids: config.shown_axes().map(|axis| axis.id.get()).collect(),
        }
    }

    /// The axes that are shown, with their ids.
    pub fn axes(&self) -> impl Iterator<Item = (u32, &AxisSignals)> {
        self.ids.iter().copied().zip(&self.signals.axes)
    }

    /// Bytes of memory that it takes.
    #[must_use]
    pub fn size(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.signals.axes)
    }
}

impl Clone for SenderSnapshot {
    fn clone(&self) -> Self {
        Self {
            signals: self.signals.clone(),
            ids: Arc::clone(&self.ids),
            ..*self
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.ideal_start = other.ideal_start;
        self.woke = other.woke;
        self.signals.clone_from(&other.signals);
    }
}
