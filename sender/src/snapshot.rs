//! Snapshot of a sender after each cycle: its signals.

use std::sync::Arc;

use coaxle_clock::{Instant, Local};
use coaxle_node::signal::{Instance, trace_columns};
use serde::Serialize;

use crate::config::{SHOWN_BY_DEFAULT, SenderConfig};
use crate::followers::FollowerCondition;
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
        // Copied in place: the lengths are equal.
        self.axes.clone_from(&other.axes);
    }
}

impl SenderConfig {
    /// The axes shown in snapshots, status and trace: those named in the config, in its order, or
    /// the first ones by id. An id that does not exist is left out.
    pub fn shown_axes(&self) -> impl Iterator<Item = &AxisConfig> {
        let mut shown: Vec<&AxisConfig> = Vec::new();
        if self.show_axes.is_default() {
            shown.extend(self.axes.iter());
            // By id, because the order of a file is of no meaning for receivers.
            shown.sort_by_key(|axis| axis.id);
            shown.truncate(SHOWN_BY_DEFAULT);
        } else {
            let called = |id| self.axes.iter().find(|axis| axis.id == id);
            shown.extend(self.show_axes.ids().iter().copied().filter_map(called));
        }
        shown.into_iter()
    }

    /// Every part with signals, in the order of a row. An axis has its name, or its name and id
    /// where another one has an equal name.
    #[must_use]
    pub fn instances(&self) -> Vec<Instance> {
        let shown: Vec<_> = self.shown_axes().collect();
        let instance = |axis: &&AxisConfig| {
            // Names are for people and may repeat; a column needs one of its own.
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
    /// Ideal start of the cycle.
    pub ideal_start: Instant<Local>,
    /// Actual start of the cycle.
    pub woke: Instant<Local>,
    /// Signals of the sender.
    pub signals: SenderRow,
    /// Followers of each axis, in the order of the config.
    pub followers: Box<[FollowerCondition]>,
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
            followers: (config.axes.iter())
                .filter_map(|axis| axis.followers.as_ref())
                .flat_map(|followers| &followers.nodes)
                .map(|_| FollowerCondition::default())
                .collect(),
            ids: config.shown_axes().map(|axis| axis.id.get()).collect(),
        }
    }

    /// The axes that are shown, with their ids.
    pub fn axes(&self) -> impl Iterator<Item = (u32, &AxisSignals)> {
        self.ids.iter().copied().zip(&self.signals.axes)
    }

    /// Memory of the snapshot, bytes.
    #[must_use]
    pub fn size(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.signals.axes) + size_of_val(&*self.followers)
    }
}

impl Clone for SenderSnapshot {
    fn clone(&self) -> Self {
        Self {
            signals: self.signals.clone(),
            followers: self.followers.clone(),
            ids: Arc::clone(&self.ids),
            ..*self
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.ideal_start = other.ideal_start;
        self.woke = other.woke;
        // Without the ids, which are equal in snapshots of one config.
        self.signals.clone_from(&other.signals);
        self.followers.clone_from(&other.followers);
    }
}
