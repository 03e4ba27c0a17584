//! Synchronisation of receivers at the end of a schedule.

use std::collections::BTreeMap;

use coaxle_node::config::{ClockConfig, CycleMicros, JitterConfig};
use coaxle_node::keys::NodeName;
use coaxle_receiver::config::{FarChannel, FarConfig};
use coaxle_receiver::{ContinuityState, FilterMode, ReceiverConfig};

use crate::expect::receiver_of;
use crate::finished::Finished;
use crate::layout::ScenarioLayout;
use crate::scenario::Scenario;
use crate::summary::ReceiverSummary;
use crate::topology::Topology;

/// Receivers that are not in sync at the end but have to be, a line each.
pub(super) fn out_of_sync(
    scenario: &Scenario,
    finished: &Finished,
) -> impl Iterator<Item = String> {
    let duration = scenario.duration_s.get();
    let figures = finished.figures();
    let receivers = figures.iter();
    receivers
        .filter(move |(_, receiver)| synchronises(receiver.mode) && !is_back(receiver, duration))
        .filter(|(name, _)| is_to_be_in_sync(scenario, name))
        .filter(|(name, receiver)| !waits_for_its_master(scenario, figures, name, receiver))
        .filter(|(name, _)| !is_unpublished(scenario, figures, name))
        .map(|(name, receiver)| format!("{name} ({}) is not in sync at the end", receiver.mode))
}

fn receiver_named<'a>(scenario: &'a Scenario, name: &str) -> Option<&'a ReceiverConfig> {
    let mut receivers = scenario.receivers.iter();
    receivers.find(|receiver| receiver.name.as_str() == name)
}

/// Least tolerance of a block, in cycles of silence or of difference, for a quiet network of these schedules: with less it
/// may never get in sync.
// 20 cycles of 0.5 ms are 10 ms. Jitter of 200 µs in the mean is beyond them once in e⁵⁰ messages.
const LEAST_TOLERANCE: f64 = 20.0;

/// True if a receiver has to be in sync once the network is quiet: its blocks tolerate the remaining faults, and its master
/// is published.
fn is_to_be_in_sync(scenario: &Scenario, name: &str) -> bool {
    let named = |name: &str| receiver_named(scenario, name);
    let receiver = named(receiver_of(name));
    let mut far = receiver.into_iter().flat_map(|receiver| &receiver.far);
    far.all(|far| {
        // Slaves of an axis that cannot keep up with its master wait for it with their power off, for any time.
        let master = named(far.node.as_str());
        let may_wait = master.is_some_and(has_limits);
        let is_published =
            master.is_none_or(|master| is_to_be_in_sync(scenario, master.name.as_str()));
        // The observer follows the phase of the messages, and needs no beat.
        let has_beats = far.mode == FilterMode::Observer
            || receiver.is_some_and(|receiver| has_beats(scenario, receiver, far));
        // A receiver is as good as its master: slaves that are not published cannot be followed.
        let tolerates = receiver.is_some_and(|receiver| tolerates(scenario, receiver, far));
        tolerates && has_beats && is_published && !may_wait
    })
}

/// True if a receiver has never received its axis, and the receiver that publishes it is itself on the way to its master: until then
/// its slaves have no power, and are not published. Wide schedule 300571: a sender that was restarted is 5 m ahead.
fn waits_for_its_master(
    scenario: &Scenario,
    figures: &BTreeMap<String, ReceiverSummary>,
    name: &str,
    receiver: &ReceiverSummary,
) -> bool {
    let config = receiver_named(scenario, receiver_of(name));
    let mut far = config.into_iter().flat_map(|config| &config.far);
    let is_master_on_its_way = |master: &str| {
        let mut of_master = figures.iter();
        of_master.any(|(name, master_figures)| {
            receiver_of(name) == master && is_on_its_way(master_figures)
        })
    };
    receiver.last.far.expected == 0 && far.any(|far| is_master_on_its_way(far.node.as_str()))
}

/// True if a far axis is a slave that has no position yet: coupled from the start, it waits for a master that never has power, and is not published. Swarm
/// schedule 40054: beside another slave of its node, whose frames come.
fn is_unpublished(
    scenario: &Scenario,
    figures: &BTreeMap<String, ReceiverSummary>,
    name: &str,
) -> bool {
    let named = |name: &str| receiver_named(scenario, name);
    let Some(config) = named(receiver_of(name)) else {
        return false;
    };
    let is_it = |axis: &str| name == receiver_of(name) || name.ends_with(&format!("/{axis}"));
    config.far_axes().any(|(_, far, axis)| {
        let slave = |master: &ReceiverConfig| {
            let slave = master.slave_with_id(axis.id)?;
            Some(master.slaves[slave].name.to_string())
        };
        let is_slave = far.channel == FarChannel::Slaves && is_it(&far.axis_name(axis));
        let slave = named(far.node.as_str())
            .filter(|_| is_slave)
            .and_then(slave);
        let mut of_master = figures
            .iter()
            .filter(|(name, _)| receiver_of(name) == far.node.as_str());
        slave.is_some_and(|slave| {
            of_master.any(|(_, master)| {
                let slave = master.slaves.get(&slave);
                slave.is_some_and(|slave| slave.last.position.is_none())
            })
        })
    })
}

/// Cycles shorter than this, s, or than this multiple of the mean jitter of messages, are too short for TS5066: they arrive a cycle early or late
/// again and again, and it finds no beat. Wide schedule 200135: 0.5 ms and a mean of 128 µs, 27 s without one. Swarm schedule 61166: 1 ms and means of
/// 196 µs on the network and 47 µs at the sender, 45 s.
const SHORTEST_CYCLE: f64 = 0.4e-3;
const OF_JITTER: f64 = 5.0;
/// Longest time between two beats with which it learns the drift before a schedule is over, s.
// Three in the 32 s of the quiet phase, of which two give a drift.
const BETWEEN_BEATS: f64 = 10.0;

/// True if a block of TS5066 sees beats from which it can learn the drift.
fn has_beats(scenario: &Scenario, receiver: &ReceiverConfig, far: &FarConfig) -> bool {
    let Some((cycle, clock)) = master_of(scenario, far) else {
        return true;
    };
    let own = receiver.cycle_time_us.0.as_secs_f64();
    let drift = (clock.drift_ppm.get() - receiver.clock.drift_ppm.get()).abs() * 1e-6;
    // A message is late by its sender, too. That of the receiver does not count: it scans what had come by its ideal start.
    let jitter = mean_jitter(scenario, receiver, far) + mean_of(clock.jitter.as_ref());
    let shortest = SHORTEST_CYCLE.max(OF_JITTER * jitter);
    // Two clocks that differ by the drift d are a cycle T apart after T/d. The slower node decides how far a beat is.
    cycle.min(own) >= shortest && cycle.max(own) <= BETWEEN_BEATS * drift
}

/// The cycle time, s, and the clock of the node that publishes a far axis.
fn master_of<'a>(scenario: &'a Scenario, far: &FarConfig) -> Option<(f64, &'a ClockConfig)> {
    let of = |name: &str, cycle: CycleMicros, clock: &'a ClockConfig| {
        (name == far.node.as_str()).then(|| (cycle.0.as_secs_f64(), clock))
    };
    let mut senders = scenario.senders.iter();
    let mut receivers = scenario.receivers.iter();
    senders
        .find_map(|one| of(one.name.as_str(), one.cycle_time_us, &one.clock))
        .or_else(|| receivers.find_map(|one| of(one.name.as_str(), one.cycle_time_us, &one.clock)))
}

/// Mean jitter of the way from a far node, s: that of each link between the routers of these schedules. Swarm schedules 81098 and 81751: 1 ms, and two
/// links with 188 µs each; 1.25 ms, and three with 200 µs.
fn mean_jitter(scenario: &Scenario, receiver: &ReceiverConfig, far: &FarConfig) -> f64 {
    let links = links_between(scenario, &far.node, &receiver.name).unwrap_or(1);
    links as f64 * mean_of(scenario.network.jitter.as_ref())
}

fn links_between(scenario: &Scenario, from: &NodeName, to: &NodeName) -> Option<usize> {
    let topology = Topology::of(scenario).ok()?;
    let layout = ScenarioLayout::of(scenario, &topology).ok()?;
    layout.links_between(topology.node(from)?, topology.node(to)?)
}

fn mean_of(jitter: Option<&JitterConfig>) -> f64 {
    match jitter {
        // Schedules draw no other jitter of the network.
        Some(JitterConfig::ExponentialUs(mean)) => mean.get() * 1e-6,
        Some(_) | None => 0.0,
    }
}

/// Longest delay that the sum of all exponential jitters is expected to reach near the end, in their means: a network that keeps the order holds
/// back everything behind a message that is late by `L`, `exp(-L/mean)/T` times a second, here at most 1e-5 of the ends. Wide schedule
/// 300217 tolerates 1 ms at a mean of 219 µs, and is without data for a moment every few seconds.
const LONGEST_OF_JITTER: f64 = 20.0;

/// True if what remains of the faults is no error for the blocks of a far node: a silence for all of them, for those of TS5066 also a
/// difference of the cycle indices.
fn tolerates(scenario: &Scenario, receiver: &ReceiverConfig, far: &FarConfig) -> bool {
    let parameters = &far.sync.time_sync;
    let own = receiver.cycle_time_us.0.span();
    let age = far.sync.age_limit(far.mode, own);
    let age = f64::from(age.unwrap_or_default());
    if far.mode != FilterMode::Observer {
        return age.min(parameters.max_cycle_index_difference) >= LEAST_TOLERANCE;
    }
    let Some((cycle, clock)) = master_of(scenario, far) else {
        return true;
    };
    let jitter = mean_jitter(scenario, receiver, far)
        + mean_of(clock.jitter.as_ref())
        + mean_of(receiver.clock.jitter.as_ref());
    age * receiver.cycle_time_us.0.as_secs_f64() >= cycle + LONGEST_OF_JITTER * jitter
}

fn has_limits(receiver: &ReceiverConfig) -> bool {
    let mut axes = receiver.far.iter().flat_map(|far| far.axes.iter());
    axes.any(|axis| axis.limits.is_some())
}

/// Time that an observer may take to lock, s. A follower of another receiver starts once that is back itself.
const STARTING_UP: f64 = 30.0;
/// TS5066 learns the drift from one beat to the next.
const BEATS: u64 = 2;

/// True if a receiver is in sync after this time, or cannot be yet; or if its clock is and the axis is on its way, which
/// takes as long as the way is.
fn is_back(receiver: &ReceiverSummary, duration: f64) -> bool {
    let far = &receiver.last.far;
    let heard_for = match far.last_relock_s {
        // Only new runs made it restart: it is received since then.
        Some(since) if u64::from(far.relocks) <= far.restarts => duration - since,
        // With a single run, all messages that it expects came since it was first received.
        _ if far.restarts == 0 => {
            far.cycle_time_us.unwrap_or_default() * 1e-6 * far.expected as f64
        }
        // With several runs nothing says when the present one was first received.
        _ => f64::INFINITY,
    };
    let has_just_begun = far.expected > 0 && heard_for < STARTING_UP;
    // Clocks that differ little may not have had two beats since the last restart.
    let waits_for_beats =
        receiver.mode != "observer" && far.error == 0 && u64::from(far.beats) < BEATS;
    receiver.synced_at_end || is_on_its_way(receiver) || has_just_begun || waits_for_beats
}

/// True if the clock of an axis is in sync, and the axis is being brought back.
fn is_on_its_way(receiver: &ReceiverSummary) -> bool {
    let (far, axis) = (&receiver.last.far, &receiver.last.axis);
    // A way back is taken at half of the master's velocity at most, and may be as long as the master has gone.
    far.synced && axis.continuity == ContinuityState::Rejoining
}

fn synchronises(mode: &str) -> bool {
    matches!(mode, "observer" | "sync" | "time")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Source;

    /// An observer of messages every 250 µs, with means of jitter of 143, 30 and 46 µs.
    fn is_expected(age_limit: u32) -> bool {
        let text = format!(
            "title = 'short'\nduration-s = 1\n[network]\nlatency-us = 200\njitter = {{ exponential-us = 143 }}\n\
             [[sender]]\nname = 'a'\ncycle-time-us = 250\nclock = {{ jitter = {{ exponential-us = 30 }} }}\n\
             [[sender.axis]]\nid = 1\nname = 'x'\nprogram.start-velocity = 1.0\n\
             program.limits = {{ velocity = 2.0, acceleration = 3.0, jerk = 4.0 }}\n\
             [[receiver]]\nname = 'b'\ncycle-time-us = 250\nmode = 'observer'\nmaster = {{ node = 'a', axis = 1 }}\n\
             clock = {{ jitter = {{ exponential-us = 46 }} }}\nsync.time-sync = {{ age-of-data-limit = {age_limit} }}\n"
        );
        let source = Source {
            name: "schedule".to_owned(),
            file: "schedule.toml".to_owned(),
            text,
        };
        let scenario = source.read(&[]).unwrap_or_else(|error| panic!("{error:#}"));
        is_to_be_in_sync(&scenario, "b")
    }

    #[test]
    fn an_observer_has_to_be_in_sync_where_it_tolerates_the_silences_of_the_network() {
        assert!(!is_expected(4), "1 ms, wide schedule 300217");
        assert!(!is_expected(18));
        assert!(is_expected(19), "4.75 ms: a cycle, and 20 × 219 µs");
        assert!(is_expected(500));
    }
}
