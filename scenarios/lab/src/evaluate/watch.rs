//! Invariant checks of a receiver in every cycle: itself, the nodes that it receives, its far axes and its slaves.

mod axis;
mod blending;
mod coupled_stop;
mod far_error;
mod far_node;
mod far_position;
mod found;
mod interpolation_error;
mod motion;
mod node;
mod shown;
mod slave;
mod target;
#[cfg(test)]
mod truth_tests;

use coaxle_receiver::{ReceiverConfig, SignalRow, SlaveConfig};
use coaxle_sim::Shares;

use crate::event::Event;
use crate::invariants::{InvariantViolation, WatchedPart};
use crate::summary::World;
use axis::AxisWatch;
pub(super) use coupled_stop::CoupledStopWatch;
pub(super) use far_error::{FarErrorWatch, wanted_offset};
use far_node::FarNodeWatch;
pub(super) use far_position::FarPositionWatch;
use motion::MotionWatch;
use node::NodeWatch;
use slave::SlaveWatch;

/// Watches a receiver.
#[derive(Debug)]
pub struct ReceiverWatch {
    receiver: String,
    node: NodeWatch,
    far: Vec<FarNodeWatch>,
    slaves: Vec<SlaveWatch>,
    axes: Vec<AxisWatch>,
}

impl ReceiverWatch {
    /// Creates the checks of a receiver.
    ///
    /// `events` are those of the whole scenario: its commands decide which motions are possible.
    #[must_use]
    pub fn new(config: &ReceiverConfig, events: &[Event], world: World) -> Self {
        let cycle_time = config.cycle_time_us.0.as_secs_f64();
        let slave = |slave: &SlaveConfig| SlaveWatch::new(slave, config, events);
        let axis = |((number, far, axis), name)| {
            let motion = MotionWatch::new(far, axis, cycle_time, world);
            AxisWatch::new(name, config.numbers_of(number), motion, cycle_time)
        };
        let heard = config.received_nodes().into_iter();
        let names = config.far_axis_names();
        Self {
            receiver: config.name.to_string(),
            node: NodeWatch::new(world),
            far: heard.map(|heard| FarNodeWatch::new(heard.node)).collect(),
            slaves: config.slaves.iter().map(slave).collect(),
            axes: config.far_axes().zip(names).map(axis).collect(),
        }
    }

    /// Takes the next cycle, whose ideal start is `t_s` after the start of the run, s.
    pub fn push(&mut self, t_s: f64, signals: &SignalRow) {
        // The node first: its cycle numbers say whether the others may compare with the cycle before.
        let cycle = self.node.push(t_s, &signals.node);
        for (watch, far) in self.far.iter_mut().zip(&signals.far) {
            watch.push(&cycle, far);
        }
        for (watch, slave) in self.slaves.iter_mut().zip(&signals.slaves) {
            watch.push(&cycle, slave);
        }
        for (watch, axis) in self.axes.iter_mut().zip(&signals.axes) {
            watch.push(&cycle, signals, axis);
        }
    }

    /// Ends the run.
    pub(super) fn end(&mut self) {
        self.slaves.iter_mut().for_each(SlaveWatch::end);
        self.axes.iter_mut().for_each(AxisWatch::end);
    }

    /// Greatest shares of its limits that the n-th slave's set positions reached; none if there is no such slave.
    pub(super) fn shares(&self, slave: usize) -> Option<Shares> {
        self.slaves.get(slave)?.shares()
    }

    /// Violations found.
    pub fn violations(&self) -> impl Iterator<Item = InvariantViolation> + '_ {
        let node = std::iter::once((None, &self.node.found));
        let far = self.far.iter().map(|far| (Some(&far.name), &far.found));
        let axes = (self.axes.iter()).map(|axis| (Some(&axis.name), &axis.found));
        let slaves = (self.slaves.iter()).map(|slave| (Some(&slave.name), &slave.found));
        let all = node.chain(far).chain(slaves).chain(axes);
        all.flat_map(|(part, found)| {
            found.violations(WatchedPart {
                receiver: self.receiver.clone(),
                part: part.cloned(),
            })
        })
    }
}

#[cfg(test)]
mod tests;
