//! A receiver's cycle as it is judged: by one axis at a time.

use coaxle_clock::{Instant, Remote};
use coaxle_receiver::SignalRow;
use coaxle_receiver::signals::{
    FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals, VirtualAxisSignals,
};
use serde::Serialize;

use crate::topology::{ReceiverAxis, View, followed_of};

/// Signals of a receiver in a cycle, with those of one of the axes that lead its slaves. Instants are
/// nanoseconds of the world's reference clock: true time in the simulation, the machine's monotonic
/// clock in the real world.
#[derive(Debug, Default, PartialEq, Serialize)]
pub struct ReceiverCycle {
    /// Ideal start of the cycle, ns.
    pub at_ns: i64,
    /// Actual beginning of the scan, ns.
    pub woke_ns: i64,
    /// The receiver itself.
    pub node: NodeSignals,
    /// Index of that node among the far node and its standbys.
    #[serde(skip)]
    pub place: usize,
    /// The node that the axis is read from; default values for the receiver's own axes. Its health is that of the far node.
    pub far: FarNodeSignals,
    /// The axis.
    pub axis: FarAxisSignals,
    /// The slaves that follow it in the end, in the order of the config.
    pub slaves: Vec<SlaveSignals>,
}

impl Clone for ReceiverCycle {
    fn clone(&self) -> Self {
        Self {
            slaves: self.slaves.clone(),
            ..*self
        }
    }

    /// Reuses the buffer.
    fn clone_from(&mut self, other: &Self) {
        self.slaves.clone_from(&other.slaves);
        self.at_ns = other.at_ns;
        self.woke_ns = other.woke_ns;
        self.node = other.node;
        self.place = other.place;
        self.far = other.far;
        self.axis = other.axis;
    }
}

/// Signals of a virtual axis as of a far axis without correction: its slaves follow its set values.
fn as_far_axis(axis: &VirtualAxisSignals) -> FarAxisSignals {
    FarAxisSignals {
        // A virtual axis has no far clock that could be unknown.
        synced: true,
        received_error: axis.error,
        received_position: Some(axis.position),
        received_velocity: Some(axis.velocity),
        received_acceleration: Some(axis.acceleration),
        corrected_position: Some(axis.position),
        corrected_velocity: Some(axis.velocity),
        ..FarAxisSignals::default()
    }
}

impl ReceiverCycle {
    /// Replaces the record by a cycle.
    pub fn fill(&mut self, at_ns: i64, woke_ns: i64, signals: &SignalRow, view: &View) {
        self.at_ns = at_ns;
        self.woke_ns = woke_ns;
        self.node = signals.node;
        (self.far, self.axis) = match view.of {
            ReceiverAxis::Far { far, axis } => {
                self.place = followed_of(&view.nodes, signals);
                let far = FarNodeSignals {
                    health: signals.far[far].health,
                    ..signals.far[view.nodes[self.place]]
                };
                (far, signals.axes[axis])
            }
            ReceiverAxis::Virtual(axis) => {
                let axis = as_far_axis(&signals.virtual_axes[axis]);
                (FarNodeSignals::default(), axis)
            }
        };
        // Cleared and not replaced, so that the buffer of the record is used again.
        self.slaves.clear();
        self.slaves
            .extend(view.slaves.iter().map(|n| signals.slaves[*n]));
    }

    /// The first slave.
    #[must_use]
    pub fn slave(&self) -> Option<&SlaveSignals> {
        self.slaves.first()
    }

    /// Set position of the first slave.
    #[must_use]
    pub fn slave_position(&self) -> Option<f64> {
        self.slave()?.position
    }

    /// The far instant of the set values, typed.
    #[must_use]
    pub fn far_time(&self) -> Option<Instant<Remote>> {
        self.axis.far_time_ns.map(Instant::from_nanos)
    }
}
