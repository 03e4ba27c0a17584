//! State of a gateway after each cycle: its signals.

use serde::Serialize;

use crate::config::GatewayConfig;
use crate::signals::{GatewaySignals, PlcAxisSignals};

/// The row of a gateway's signals, sized once from its config.
#[derive(Debug, PartialEq, Serialize)]
pub struct GatewayRow {
    /// The gateway itself.
    pub node: GatewaySignals,
    /// The axes of the PLC.
    pub axes: Box<[PlcAxisSignals]>,
}

/// A gateway after a cycle. Cloning it into one of the same config does not allocate.
#[derive(Debug, PartialEq)]
pub struct GatewaySnapshot {
    /// Signals of the gateway.
    pub signals: GatewayRow,
}

impl GatewaySnapshot {
    /// Makes a gateway before its first cycle.
    #[must_use]
    pub fn new(config: &GatewayConfig) -> Self {
        let axes = vec![PlcAxisSignals::default(); config.axes.len()];
        Self {
            signals: GatewayRow {
                node: GatewaySignals::default(),
                axes: axes.into(),
            },
        }
    }

    /// Returns its memory size, bytes.
    #[must_use]
    pub fn size(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.signals.axes)
    }
}

impl Clone for GatewayRow {
    fn clone(&self) -> Self {
        Self {
            node: self.node,
            axes: self.axes.clone(),
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.node = other.node;
        // In place: the numbers are equal.
        self.axes.clone_from(&other.axes);
    }
}

impl Clone for GatewaySnapshot {
    fn clone(&self) -> Self {
        Self {
            signals: self.signals.clone(),
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.signals.clone_from(&other.signals);
    }
}
