//! Snapshot of a receiver after each cycle: its signals, and its faults in full.

use std::sync::Arc;

use coaxle_axis::Job;

use coaxle_clock::{CycleTime, Instant, Local};
use coaxle_node::signal::{Instance, trace_columns};
use coaxle_remote::{ContinuityState, FilterState};
use coaxle_slave::{Refusal, SlaveError};
use serde::Serialize;

use crate::config::ReceiverConfig;
use crate::health::Health;
use crate::program::BlockedProgram;
use crate::signals::{
    FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals, VirtualAxisSignals,
};

/// The row of a receiver's signals, sized once from its config.
#[derive(Debug, PartialEq, Serialize)]
pub struct SignalRow {
    /// The receiver itself.
    pub node: NodeSignals,
    /// The far nodes, in the order of the config, then their standbys: all nodes received from.
    pub far: Box<[FarNodeSignals]>,
    /// Axes of the far nodes, in that order.
    pub axes: Box<[FarAxisSignals]>,
    /// Virtual axes, in the order of the config.
    pub virtual_axes: Box<[VirtualAxisSignals]>,
    /// The slaves, in the order of the config.
    pub slaves: Box<[SlaveSignals]>,
}

impl SignalRow {
    /// A row before the first cycle.
    #[must_use]
    pub fn new(config: &ReceiverConfig) -> Self {
        Self {
            node: NodeSignals::default(),
            far: config
                .received_nodes()
                .iter()
                .map(|_| FarNodeSignals::default())
                .collect(),
            axes: config
                .far_axes()
                .map(|_| FarAxisSignals::default())
                .collect(),
            virtual_axes: config
                .virtual_axes
                .iter()
                .map(|_| VirtualAxisSignals::default())
                .collect(),
            slaves: config
                .slaves
                .iter()
                .map(|_| SlaveSignals::default())
                .collect(),
        }
    }
}

impl Clone for SignalRow {
    fn clone(&self) -> Self {
        Self {
            node: self.node,
            far: self.far.clone(),
            axes: self.axes.clone(),
            virtual_axes: self.virtual_axes.clone(),
            slaves: self.slaves.clone(),
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.node = other.node;
        // Boxes of the same length are copied in place.
        self.far.clone_from(&other.far);
        self.axes.clone_from(&other.axes);
        self.virtual_axes.clone_from(&other.virtual_axes);
        self.slaves.clone_from(&other.slaves);
    }
}

impl ReceiverConfig {
    /// The columns of a trace: [`trace_columns`] of its instances.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        trace_columns(&self.instances())
    }

    /// Every part with signals, in the order of a row.
    #[must_use]
    pub fn instances(&self) -> Vec<Instance> {
        let heard = self.received_nodes().into_iter();
        let far = heard.map(|heard| Instance::of::<FarNodeSignals>(heard.node.as_str()));
        let axes = self
            .far_axis_names()
            .into_iter()
            .enumerate()
            .map(|(n, name)| Instance::of::<FarAxisSignals>(name).in_unit(self.far_axis_unit(n)));
        let virtual_axes = self.virtual_axes.iter().map(|axis| {
            Instance::of::<VirtualAxisSignals>(axis.name.as_str()).in_unit(axis.unit.clone())
        });
        let slaves = self.slaves.iter().enumerate().map(|(n, slave)| {
            Instance::of::<SlaveSignals>(slave.name.as_str()).in_unit(self.slave_unit(n))
        });
        let node = std::iter::once(Instance::of::<NodeSignals>(""));
        let followed = far.chain(axes).chain(virtual_axes);
        node.chain(followed).chain(slaves).collect()
    }
}

/// A receiver after a cycle. Cloning it into one of the same config does not allocate.
#[derive(Debug, PartialEq)]
pub struct ReceiverSnapshot {
    /// Ideal start of the cycle.
    pub ideal_start: Instant<Local>,
    /// Actual start of the cycle.
    pub woke: Instant<Local>,
    /// Health of the receiver.
    pub health: Health,
    /// Signals of the receiver.
    pub signals: SignalRow,
    /// Health of each node received from: for a far node, that of the one followed among it and its
    /// standbys; for a standby, its own.
    pub far_health: Box<[Health]>,
    /// Nominal cycle times in their frames; none before the first message.
    pub data_cycle_times: Box<[Option<CycleTime>]>,
    /// Faults of each slave.
    pub faults: Box<[SlaveFaults]>,
    /// The first axis of each far node.
    first_axes: Arc<[usize]>,
}

/// Faults of a slave, in full.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlaveFaults {
    /// Error of its error stop.
    pub error: Option<SlaveError>,
    /// The command that was refused last.
    pub refusal: Option<RefusedCommand>,
    /// Blocked program: it waits for an impossible event, or has waited for too long.
    pub blocked: Option<BlockedProgram>,
}

/// A command that was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedCommand {
    /// The refusal.
    pub refusal: Refusal,
    /// Job of the command, if it had been accepted and was refused when it was due.
    pub job: Option<Job>,
}

impl RefusedCommand {
    /// NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        self.refusal.code()
    }

    pub(crate) const fn when_due(refusal: Refusal, job: Job) -> Self {
        let job = Some(job);
        Self { refusal, job }
    }
}

impl From<Refusal> for RefusedCommand {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, job: None }
    }
}

impl ReceiverSnapshot {
    /// A receiver before its first cycle, which is due at `start`.
    #[must_use]
    pub fn new(config: &ReceiverConfig, start: Instant<Local>) -> Self {
        let heard = config.received_nodes().len();
        Self {
            ideal_start: start,
            woke: start,
            health: Health::WaitingForMaster,
            // All lists have their final length from the start, so that copies in the cycle do not allocate.
            signals: SignalRow::new(config),
            far_health: vec![Health::WaitingForMaster; heard].into(),
            data_cycle_times: vec![None; heard].into(),
            faults: config
                .slaves
                .iter()
                .map(|_| SlaveFaults::default())
                .collect(),
            first_axes: (0..config.far.len())
                .map(|far| config.first_axis_of(far))
                .collect(),
        }
    }

    /// Mode that calculated the set values of a far node's first axis, if there is such a node.
    #[must_use]
    pub fn state_of(&self, far: usize) -> Option<FilterState> {
        let first = *self.first_axes.get(far)?;
        self.signals.axes.get(first)?.state
    }

    /// Continuity of a far node's first axis: following its master, braked, or returning.
    #[must_use]
    pub fn continuity_of(&self, far: usize) -> Option<ContinuityState> {
        let first = *self.first_axes.get(far)?;
        Some(self.signals.axes.get(first)?.continuity)
    }

    /// Memory of the snapshot, bytes.
    #[must_use]
    pub fn size(&self) -> usize {
        // Without the first axes, which all snapshots share.
        let signals = &self.signals;
        size_of::<Self>()
            + size_of_val(&*signals.far)
            + size_of_val(&*signals.axes)
            + size_of_val(&*signals.virtual_axes)
            + size_of_val(&*signals.slaves)
            + size_of_val(&*self.far_health)
            + size_of_val(&*self.data_cycle_times)
            + size_of_val(&*self.faults)
    }
}

impl Clone for ReceiverSnapshot {
    fn clone(&self) -> Self {
        Self {
            ideal_start: self.ideal_start,
            woke: self.woke,
            health: self.health,
            signals: self.signals.clone(),
            far_health: self.far_health.clone(),
            data_cycle_times: self.data_cycle_times.clone(),
            faults: self.faults.clone(),
            // Never changes, so that clones share it.
            first_axes: Arc::clone(&self.first_axes),
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.ideal_start = other.ideal_start;
        self.woke = other.woke;
        self.health = other.health;
        self.signals.clone_from(&other.signals);
        self.far_health.clone_from(&other.far_health);
        self.data_cycle_times.clone_from(&other.data_cycle_times);
        self.faults.clone_from(&other.faults);
    }
}
