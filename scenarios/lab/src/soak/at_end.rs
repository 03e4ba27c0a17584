//! Synchronisation of receivers at the end of a schedule.

use coaxle_node::config::{ClockConfig, CycleMicros, JitterConfig};
use coaxle_receiver::config::FarConfig;
use coaxle_receiver::{ContinuityState, FilterMode, ReceiverConfig};

use crate::expect::receiver_of;
use crate::finished::Finished;
use crate::scenario::Scenario;
use crate::summary::ReceiverSummary;

/// Receivers that are not in sync at the end but have to be, a line each.
pub(super) fn out_of_sync(
    scenario: &Scenario,
    finished: &Finished,
) -> impl Iterator<Item = String> {
    let duration = scenario.duration_s.get();
    let receivers = finished.figures().iter();
    receivers
        .filter(move |(_, receiver)| synchronises(receiver.mode) && !is_back(receiver, duration))
        .filter(|(name, _)| is_to_be_in_sync(scenario, name))
        .map(|(name, receiver)| format!("{name} ({}) is not in sync at the end", receiver.mode))
}

/// Least tolerance of a block, in cycles of silence or of difference, for a quiet network of these schedules: with less it
/// may never get in sync.
// 20 cycles of 0.5 ms are 10 ms. Jitter of 200 µs in the mean is beyond them once in e⁵⁰ messages.
const LEAST_TOLERANCE: f64 = 20.0;

/// True if a receiver has to be in sync once the network is quiet: its blocks tolerate the remaining faults, and its master
/// is published.
fn is_to_be_in_sync(scenario: &Scenario, name: &str) -> bool {
    let named = |name: &str| {
        let mut receivers = scenario.receivers.iter();
        receivers.find(|receiver| receiver.name.as_str() == name)
    };
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
        tolerates_the_network(far) && has_beats && is_published && !may_wait
    })
}

/// Cycles shorter than this, s, or than this multiple of the mean jitter of the network, are too short for TS5066: messages arrive a cycle
/// early or late again and again, and it finds no beat. Wide schedule 200135: 0.5 ms and a mean of 128 µs, 27 s without one.
const SHORTEST_CYCLE: f64 = 0.4e-3;
const OF_JITTER: f64 = 5.0;
/// Longest time between two beats with which it learns the drift before a schedule is over, s.
// Three in the 32 s of the quiet phase, of which two give a drift.
const BETWEEN_BEATS: f64 = 10.0;

/// True if a block of TS5066 sees beats from which it can learn the drift.
fn has_beats(scenario: &Scenario, receiver: &ReceiverConfig, far: &FarConfig) -> bool {
    let of = |name: &str, cycle: CycleMicros, clock: &ClockConfig| {
        (name == far.node.as_str()).then(|| (cycle.0.as_secs_f64(), clock.drift_ppm.get()))
    };
    let mut senders = scenario.senders.iter();
    let mut receivers = scenario.receivers.iter();
    let master = senders
        .find_map(|one| of(one.name.as_str(), one.cycle_time_us, &one.clock))
        .or_else(|| receivers.find_map(|one| of(one.name.as_str(), one.cycle_time_us, &one.clock)));
    let Some((cycle, drift)) = master else {
        return true;
    };
    let own = receiver.cycle_time_us.0.as_secs_f64();
    let drift = (drift - receiver.clock.drift_ppm.get()).abs() * 1e-6;
    let shortest = SHORTEST_CYCLE.max(OF_JITTER * mean_jitter(scenario));
    // Two clocks that differ by the drift d are a cycle T apart after T/d. The slower node decides how far a beat is.
    cycle.min(own) >= shortest && cycle.max(own) <= BETWEEN_BEATS * drift
}

/// Mean jitter of the network of these schedules, s.
fn mean_jitter(scenario: &Scenario) -> f64 {
    match &scenario.network.jitter {
        // Schedules draw no other jitter of the network.
        Some(JitterConfig::ExponentialUs(mean)) => mean.get() * 1e-6,
        Some(_) | None => 0.0,
    }
}

fn tolerates_the_network(far: &FarConfig) -> bool {
    let parameters = &far.sync.time_sync;
    let least = f64::from(parameters.age_of_data_limit).min(parameters.max_cycle_index_difference);
    far.mode == FilterMode::Observer || least >= LEAST_TOLERANCE
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
    let (far, axis) = (&receiver.last.far, &receiver.last.axis);
    // A way back is taken at half of the master's velocity at most, and may be as long as the master has gone.
    let is_on_its_way = far.synced && axis.continuity == ContinuityState::Rejoining;
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
    receiver.synced_at_end || is_on_its_way || has_just_begun || waits_for_beats
}

fn synchronises(mode: &str) -> bool {
    matches!(mode, "observer" | "sync" | "time")
}
