//! Lines drawn after all others, for nodes that are known by then: followers that an axis reacts to, motions that are promised, dead
//! times of drives, delays that followers decide, and cycles that are locked.

use coaxle_node::Channel;
use coaxle_node::circles::AxisAddress;
use coaxle_node::faults::{Random, seed_of};
use coaxle_receiver::{FilterMode, ReceiverConfig};
use coaxle_sender::config::SenderConfig;
use coaxle_source::config::SourceConfig;

use super::draw::Draw as _;
use crate::read;
use crate::scenario::Scenario;

/// End of such lines: without them a schedule is what it was before ([`before_followers`]).
const OF_FOLLOWERS: &str = "# followers";
/// End of lines that came after those: without them it is what it was before ([`before_dead_times`]).
const OF_DEAD_TIMES: &str = "# a dead time";
/// End of lines that came after those ([`before_locks`]).
const OF_LOCKS: &str = "# a lock";

/// The schedule that its seed gave before followers and promises were drawn: seeds that failed earlier are kept as they failed.
#[must_use]
pub fn before_followers(schedule: &str) -> String {
    without(&before_dead_times(schedule), OF_FOLLOWERS)
}

/// The schedule that its seed gave before dead times were drawn.
#[must_use]
pub fn before_dead_times(schedule: &str) -> String {
    without(&before_locks(schedule), OF_DEAD_TIMES)
}

/// The schedule that its seed gave before cycles were locked, and delays left to followers.
#[must_use]
pub fn before_locks(schedule: &str) -> String {
    without(schedule, OF_LOCKS)
}

/// A schedule without the lines that end like this.
pub(super) fn without(schedule: &str, end: &str) -> String {
    let lines = schedule.split_inclusive('\n');
    lines
        .filter(|line| !line.trim_end().ends_with(end))
        .collect()
}

/// Adds followers and promises to a schedule, dead times, and locks.
pub(super) fn with_followers(seed: u64, schedule: String) -> String {
    // It is read once more for that: who follows whom is drawn in many places.
    let table = toml::from_str(&schedule);
    let Some(scenario) = table.ok().and_then(|table| read::scenario("", table).ok()) else {
        return schedule;
    };
    let mut random = Random::new(seed_of(seed, "followers"));
    let mut locks = Random::new(seed_of(seed, "locks"));
    let mut added = Vec::new();
    for sender in &scenario.senders {
        let mut axes = Vec::new();
        for axis in 0..sender.axes.len() {
            axes.push(lines(&mut random, &scenario, sender, axis));
        }
        add_led_delay(&mut locks, sender, &mut axes);
        added.push(axes);
    }
    let mut dead_times = Random::new(seed_of(seed, "dead times"));
    let mut receivers = scenario.receivers.iter();
    let mut added = added.into_iter();
    let (mut text, mut axes) = (
        String::with_capacity(schedule.len()),
        Vec::new().into_iter(),
    );
    for line in schedule.split_inclusive('\n') {
        text += line;
        match line.trim_end() {
            "[[sender]]" => axes = added.next().unwrap_or_default().into_iter(),
            "[[sender.axis]]" => text += &axes.next().unwrap_or_default(),
            "[[receiver]]" => {
                let lock = receivers.next().map(|it| lock_cycle(&mut locks, it));
                text += &lock.unwrap_or_default();
            }
            "[[receiver.slave]]" => text += &dead_time(&mut dead_times),
            _ => {}
        }
    }
    text
}

/// Lines of an axis; mostly none.
fn lines(random: &mut Random, scenario: &Scenario, sender: &SenderConfig, axis: usize) -> String {
    let (has_followers, is_promised) = (random.chance(0.25), random.chance(0.25));
    let config = &sender.axes[axis];
    if !matches!(config.source, SourceConfig::Program(_)) {
        return String::new();
    }
    let mut lines = String::new();
    let followers = match has_followers {
        true => followers(random, scenario, sender, config.id.get()),
        false => Vec::new(),
    };
    if !followers.is_empty() {
        // Mostly a halt: an axis that has stopped for good shows nothing any more.
        let on_failure = random.one_of(&["halt", "halt", "halt", "ignore", "stop"]);
        let keeps_limits = random.chance(0.4);
        let age_limit = random.decades(100.0, 2_000.0);
        lines += &format!(
            "followers = {{ nodes = {followers:?}, on-failure = '{on_failure}', keep-limits = {keeps_limits}, \
             age-limit-ms = {age_limit:.0} }} {OF_FOLLOWERS}\n"
        );
    }
    if is_promised && config.lead_ms.is_none() {
        lines += &format!(
            "lead-ms = {:.3} {OF_FOLLOWERS}\n",
            random.decades(0.5, 500.0)
        );
    }
    lines
}

/// Lets the followers of a sender decide the delay of its axes, if it has some and no delay; mostly not.
fn add_led_delay(random: &mut Random, sender: &SenderConfig, axes: &mut [String]) {
    let has_followers = axes.iter().any(|lines| lines.contains("followers = {"));
    let is_led = random.chance(0.4);
    if !is_led || !has_followers || sender.axes.present_after().is_some() {
        return;
    }
    let most = random.decades(20.0, 500.0);
    let limits = format!("present-after-limits = {{ at-most-ms = {most:.1} }}");
    for lines in axes {
        *lines += &format!("present-after-ms = 'auto' {OF_LOCKS}\n{limits} {OF_LOCKS}\n");
    }
}

/// Line of a receiver whose cycle is locked to that of a node that it observes; mostly none.
fn lock_cycle(random: &mut Random, receiver: &ReceiverConfig) -> String {
    let is_locked = random.chance(0.25);
    let far = receiver.far.iter();
    let observed: Vec<_> = far.filter(|far| far.mode == FilterMode::Observer).collect();
    if !is_locked || observed.is_empty() {
        return String::new();
    }
    let to = random.one_of(&observed).node.as_str();
    let cycle = receiver.cycle_time_us.0.span().as_micros_f64();
    let offset = random.between(0.0, 0.999 * cycle);
    format!("lock-cycle = {{ to = '{to}', offset-us = {offset:.1} }} {OF_LOCKS}\n")
}

/// Lines of a slave whose drive has a dead time; mostly none.
fn dead_time(random: &mut Random) -> String {
    if !random.chance(0.15) {
        return String::new();
    }
    // From less than a cycle to more than most hold-backs.
    let time = random.decades(50.0, 30_000.0);
    let drive = match random.chance(0.7) {
        true => format!("drive = {{ dead-time-us = {time:.1} }} {OF_DEAD_TIMES}\n"),
        false => String::new(),
    };
    format!("dead-time-us = {time:.1} {OF_DEAD_TIMES}\n{drive}")
}

/// Some of the receivers with a slave of an axis; none of an axis with a standby, which does not stop with it.
fn followers(
    random: &mut Random,
    scenario: &Scenario,
    sender: &SenderConfig,
    id: u32,
) -> Vec<String> {
    let axis = AxisAddress {
        node: sender.name.clone(),
        channel: Channel::Axes,
        id,
    };
    let far = scenario.receivers.iter().flat_map(|receiver| &receiver.far);
    let mut with_standby = far.filter(|far| !far.standby.is_empty());
    if with_standby.any(|far| far.nodes().any(|node| *node == sender.name)) {
        return Vec::new();
    }
    let receivers = scenario.receivers.iter().filter(|receiver| {
        let mut slaves = 0..receiver.slaves.len();
        slaves.any(|slave| receiver.far_masters_of_slave(slave).contains(&axis))
    });
    receivers
        .filter(|_| random.chance(0.8))
        .map(|receiver| receiver.name.to_string())
        .collect()
}
