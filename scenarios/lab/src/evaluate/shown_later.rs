//! The truth of an axis that is shown later: its master as it was, by the clock of the node that generated it.

use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_receiver::FilterState;
use coaxle_receiver::config::{FarConfig, Present};
use coaxle_sim::{Oracle, Truth};
use coaxle_source::config::SourceConfig;

use crate::record::ReceiverCycle;
use crate::row::Reference;
use crate::scenario::Scenario;
use crate::topology::Root;

/// Presentation delay of an axis of the receiver `receiver` with this root, by the configs; zero where it is shown now.
pub(super) fn delay_of(scenario: &Scenario, receiver: usize, root: &Root) -> Span {
    let Some((publisher, delay)) = published(scenario, receiver, root) else {
        return Span::ZERO;
    };
    // Behind a relay the first receiver decides.
    let first = match root.source.checked_sub(scenario.senders.len()) {
        Some(relay) => relay,
        None => receiver,
    };
    let far = scenario.receivers[first].far.iter();
    let mut of_publisher =
        far.filter(|far| far.node == *publisher || far.standby.contains(publisher));
    let shows = |far: &FarConfig| {
        let mut axes = far.axes.iter().filter(|axis| axis.id == root.axis);
        far.present == Present::Auto && axes.all(|axis| axis.encoder.is_none())
    };
    match of_publisher.all(shows) {
        true => delay,
        false => Span::ZERO,
    }
}

/// The node at the root, and the delay that its frames state.
fn published<'a>(
    scenario: &'a Scenario,
    receiver: usize,
    root: &Root,
) -> Option<(&'a NodeName, Span)> {
    let senders = scenario.senders.len();
    if let Some(sender) = scenario.senders.get(root.node) {
        let range = sender.axes.present_after()?;
        return Some((&sender.name, range.most));
    }
    let own = root.node - senders;
    // Its own slaves are calculated at once, and only their drives are later.
    let config = scenario.receivers.get(own).filter(|_| own != receiver)?;
    // Beside far axes that lead slaves the hold-back depends on those. Others have no say.
    let is_own = !config.far_axes_that_lead().contains(&true);
    let mut axes = config.virtual_axes.iter().filter(|_| is_own);
    let axis = axes.find(|axis| axis.id.get() == root.axis)?;
    let cycle = config.cycle_time_us.0.span();
    let cycles = axis.present_after()?.most.div_floor(cycle);
    Some((&config.name, cycle * cycles))
}

/// True if followers decide the delay of the axis at the root.
pub(super) fn is_led(scenario: &Scenario, root: &Root) -> bool {
    let range = (scenario.senders.get(root.node)).and_then(|sender| sender.axes.present_after());
    range.is_some_and(|range| range.is_led())
}

/// Greatest jerk of the axis at the root, u/s³; unknown for a recorded motion.
pub(super) fn jerk_of(scenario: &Scenario, root: &Root) -> Option<f64> {
    let sender = scenario.senders.get(root.node)?;
    let axis = (sender.axes.iter()).find(|axis| axis.id.get() == root.axis)?;
    match &axis.source {
        SourceConfig::Program(program) => Some(program.limits.jerk.get()),
        SourceConfig::Encoder(_) | SourceConfig::Replay(_) => None,
    }
}

/// Delay of the instant that the axis of a cycle shows, by the clock at the root, which runs at this `pace` by that of the receiver: only modes
/// that know a clock show an axis later, and what its drives wait for is still to pass. `delay` is that of what is to be shown a time later. Frames that are shown as they come state what is left.
pub(super) fn delay_in(
    cycle: &ReceiverCycle,
    delay: impl FnOnce(Span) -> Span,
    is_relayed: bool,
    pace: impl FnOnce() -> f64,
) -> Span {
    let state = cycle.axis.state;
    let is_by_clock = matches!(
        state,
        Some(FilterState::Sync | FilterState::Time | FilterState::Observer)
    );
    if !(is_by_clock || is_relayed) {
        return Span::ZERO;
    }
    let left_us = match cycle.far.presentation_lag_us {
        Some(_) if cycle.node.hold_back_us > 0.0 => cycle.node.hold_back_us * pace(),
        Some(_) => 0.0,
        None => cycle.far.present_after_us.unwrap_or_default(),
    };
    let left = Span::from_micros_f64(left_us);
    (delay(left) - left).max(Span::ZERO)
}

/// Delay by which the drives of a cycle show its axis, by the clock at the root, which runs at this `pace` by that of the receiver; none where it is shown now.
pub(super) fn shown_in(cycle: &ReceiverCycle, pace: f64) -> Option<Span> {
    let lag = cycle.far.presentation_lag_us?;
    Some(Span::from_micros_f64(lag + cycle.node.hold_back_us * pace))
}

/// Pace of a receiver's own clock, by its cycles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OwnPace {
    /// A cycle and its time by the reference clock, ns, and the one that comes next.
    since: Option<(u64, i64)>,
    next: Option<(u64, i64)>,
}

impl OwnPace {
    /// Least time that the pace is taken over, ns.
    // Cycles begin at whole nanoseconds: over a second they tell 1e-9, of a hold-back of a second 1 ns.
    const LEAST: i64 = 1_000_000_000;

    /// Takes a cycle of the receiver.
    pub(super) fn take(&mut self, cycle: u64, at_ns: i64) {
        let is_next = self
            .next
            .is_none_or(|(_, next)| at_ns - next >= Self::LEAST);
        if is_next {
            self.since = self.next.replace((cycle, at_ns));
        }
    }

    /// Seconds of the reference clock per second of the own one, up to a cycle; 1 before it is known.
    pub(super) fn at(&self, cycle: u64, at_ns: i64, cycle_time: Span) -> f64 {
        match self.since {
            Some((since, from)) if cycle > since => {
                let own = cycle_time.as_nanos() as f64 * (cycle - since) as f64;
                (at_ns - from) as f64 / own
            }
            _ => 1.0,
        }
    }
}

/// Lag of the axis of a cycle behind the generation of its frames.
pub(super) fn lag_in(cycle: &ReceiverCycle) -> Span {
    Span::from_micros_f64(cycle.far.presentation_lag_us.unwrap_or_default())
}

/// The master as it was `later` before `at`, by its own clock.
pub(super) fn at(oracle: &Oracle<Reference>, at: Instant<Reference>, later: Span) -> Option<Truth> {
    if later == Span::ZERO {
        return oracle.at(at);
    }
    let guess = at - later;
    let then = oracle.at(guess)?;
    let of_run = |at| oracle.at(at).filter(|truth| truth.epoch == then.epoch);
    // Its clock drifts by less than a thousandth, so that one step leaves a millionth of a millionth of the delay.
    let passed = match of_run(at) {
        Some(now) => now.seconds_since(&then),
        // After its last cycle, and into another run, its clock has the pace of before. In the last cycle of swarm schedule 5125 a drift of
        // 342 ppm over 293 ms was taken for an error of 0.1 ms.
        None => then.seconds_since(&of_run(guess - later)?),
    };
    let off = passed.to_span() - later;
    oracle.at(guess + off)
}
