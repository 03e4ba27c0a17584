//! Liveness at the end of a schedule whose masters have come to rest, or to a slow and steady motion: each far axis follows its
//! master, and each coupled slave is where its coupling has it, unless the way there is longer than the time that it had.

mod axis;
mod rough;
mod slave;
mod way;

use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::config::FarChannel;
use coaxle_source::config::{AxisConfig, Repeat, SourceConfig};

use crate::row::{Row, RowSink};
use crate::scenario::Scenario;
use crate::topology::{ReceiverAxis, Topology, View};
use axis::AxisLiveness;
use slave::{SlaveLiveness, TargetMotion};

/// Greatest distance of a relation that holds, u: a micrometre, …
const TOLERANCE: f64 = 1e-3;
/// … and the rounding errors of the sums behind a position, relative to it.
const ROUNDING: f64 = 1e-11;

/// Greatest distance of a relation that holds at this position, u.
fn tolerance(position: f64) -> f64 {
    TOLERANCE + ROUNDING * position.abs()
}

/// Watches the axes and slaves of a schedule up to its end.
#[derive(Debug)]
pub(super) struct Liveness {
    /// By the numbers of the views; none where masters do not come to a steady motion.
    views: Vec<ViewLiveness>,
}

/// An axis of a receiver, and the slaves that follow it.
#[derive(Debug)]
struct ViewLiveness {
    receiver: String,
    /// Absent for a virtual axis, which has no way to its master.
    axis: Option<AxisLiveness>,
    /// The slave that the axis is, as its view and its place there: it is published while that has set values.
    upstream: Option<(usize, usize)>,
    /// True if the axis comes from the node at its root, or is one of the receiver's own.
    is_direct: bool,
    slaves: Vec<SlaveLiveness>,
}

impl Liveness {
    /// Watches a scenario.
    pub(super) fn new(scenario: &Scenario, topology: &Topology) -> Self {
        if !is_steady_at_the_end(scenario) {
            return Self { views: Vec::new() };
        }
        let view = |view: &View| {
            let config = &scenario.receivers[view.receiver];
            let slaves = view.slaves.iter();
            ViewLiveness {
                receiver: config.name.to_string(),
                axis: AxisLiveness::new(config, view),
                upstream: upstream_of(scenario, topology, config, view),
                is_direct: view.root.source == view.root.node,
                slaves: slaves
                    .map(|n| SlaveLiveness::new(&config.slaves[*n], config.master_of(*n).ok()))
                    .collect(),
            }
        };
        Self {
            views: topology.views().iter().map(view).collect(),
        }
    }

    /// Relations that do not hold although there was time enough, a line each.
    pub(super) fn broken(&self) -> impl Iterator<Item = String> {
        self.views.iter().flat_map(|view| {
            let axis = view.axis.as_ref().filter(|_| self.is_published(view));
            let of_axis = axis.and_then(|axis| Some((axis.name.as_str(), axis.broken()?)));
            let of_slaves = view.slaves.iter();
            // Upstream an axis may be brought back, and its followers with it; values that are shown as they come go in beats.
            let is_even = view.axis.as_ref().is_none_or(AxisLiveness::is_even);
            let shows_beats = view.axis.as_ref().is_some_and(AxisLiveness::shows_beats);
            let motion = match (is_even, view.is_direct) {
                (true, true) => TargetMotion::Even,
                // Brought back, too: in swarm schedule 81281 the axis does not catch up with a relayed one in beats, and goes to and fro as it does.
                (_, false) if !shows_beats => TargetMotion::Relayed,
                _ => TargetMotion::Beats,
            };
            let of_slaves = of_slaves
                .filter_map(move |slave| Some((slave.name.as_str(), slave.broken(motion)?)));
            let broken = of_axis.into_iter().chain(of_slaves);
            broken.map(|(name, what)| format!("{}.{name} {what}", view.receiver))
        })
    }

    /// Slaves that still wait at the end, with their reasons, a line each.
    pub(super) fn waits(&self) -> impl Iterator<Item = String> {
        self.views.iter().flat_map(|view| {
            let waits = view.slaves.iter();
            let waits = waits.filter_map(|slave| Some((slave, slave.waits_for()?)));
            waits.map(|(slave, what)| format!("{}.{} {what}", view.receiver, slave.name))
        })
    }

    /// True if the axis comes from a sender, or from a slave with set values: a slave that was coupled from the start, and not
    /// switched on since, has none to publish.
    fn is_published(&self, view: &ViewLiveness) -> bool {
        let upstream = view
            .upstream
            .and_then(|(view, slave)| self.views.get(view)?.slaves.get(slave));
        upstream.is_none_or(SlaveLiveness::has_set_values)
    }
}

impl RowSink for Liveness {
    fn row(&mut self, view: usize, row: &Row) {
        let Some(view) = self.views.get_mut(view) else {
            return;
        };
        if let Some(axis) = &mut view.axis {
            axis.push(row);
        }
        for (watch, slave) in view.slaves.iter_mut().zip(&row.record.slaves) {
            watch.push(row.t_s, row.record.node.run, slave);
        }
    }
}

/// True if the motion of every master ends in a steady one.
fn is_steady_at_the_end(scenario: &Scenario) -> bool {
    let senders = scenario
        .senders
        .iter()
        .flat_map(|sender| sender.axes.iter());
    let receivers = scenario.receivers.iter();
    let own = receivers.flat_map(|receiver| receiver.virtual_axes.iter());
    let ends = |axis: &AxisConfig| match &axis.source {
        SourceConfig::Program(program) => program.repeat != Repeat::Forever,
        // Increments of a steady motion are none, and a recorded motion is unknown.
        SourceConfig::Encoder(_) | SourceConfig::Replay(_) => false,
    };
    senders.chain(own).all(ends)
}

/// The slave that a far axis is.
fn upstream_of(
    scenario: &Scenario,
    topology: &Topology,
    config: &ReceiverConfig,
    view: &View,
) -> Option<(usize, usize)> {
    let ReceiverAxis::Far { axis, .. } = view.of else {
        return None;
    };
    let (_, far, axis) = config.far_axes().nth(axis)?;
    if far.channel != FarChannel::Slaves {
        return None;
    }
    let mut receivers = scenario.receivers.iter();
    let receiver = receivers.position(|receiver| receiver.name == far.node)?;
    let slave = scenario.receivers[receiver].slave_with_id(axis.id)?;
    let mut views = topology.views().iter().enumerate();
    views.find_map(|(n, view)| {
        let mut slaves = view.slaves.iter();
        let place = slaves.position(|other| *other == slave)?;
        (view.receiver == receiver).then_some((n, place))
    })
}

#[cfg(test)]
mod tests;
