//! A recording between a sender and a receiver that run as processes of this machine.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use coaxle_clock::{Instant, Span};
use coaxle_lab::finished::Progress;
use coaxle_lab::read;
use coaxle_lab::scenario::Scenario;
use coaxle_lab::topology::Topology;
use coaxle_os::{Machine, machine};

use super::busy::Busy;
use super::convert::TimeScale;
use super::raw::{Raw, rows};
use crate::processes::{Child, Death, NodeOutput, NodeProcesses, Protocol};

/// Settings of a recording.
#[derive(Clone, Debug)]
pub(crate) struct RecordingSettings {
    pub(crate) duration: Span,
    pub(crate) cycle_us: f64,
    pub(crate) protocol: Protocol,
    pub(crate) busy: u16,
    pub(crate) real_time: bool,
}

/// Result of a recording.
#[derive(Debug)]
pub(crate) struct RecordingResult {
    pub(crate) raw: Raw,
    pub(crate) scale: TimeScale,
    /// Warnings of the nodes.
    pub(crate) warnings: Vec<String>,
}

/// Nodes have met after this time, or never do.
// Nodes meet within a second; a machine with 256 busy processes takes far longer.
const MEETING_TIMEOUT: Span = Span::from_secs(60);
/// Interval of checks of the nodes.
const CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// Starts the nodes, lets them run, and ends them. Their files lie in `folder`.
///
/// # Errors
/// A node that does not start, does not find the other, or ends badly; a file that cannot be read.
pub(crate) fn record(
    settings: &RecordingSettings,
    folder: &Path,
    progress: &mut dyn Progress,
) -> anyhow::Result<RecordingResult> {
    let scenario = scenario(settings)?;
    let topology = Topology::of(&scenario).map_err(|wrong| wrong.in_file("recording"))?;
    let nodes = NodeProcesses::prepare(
        &scenario,
        &topology,
        folder,
        settings.protocol,
        NodeOutput::Arrivals,
    )?;
    let mut children = nodes.children;
    let busy = Busy::start(settings.busy)?;
    for child in &mut children {
        // Nodes end even if no process is left to end them.
        // Once for the meeting and once for a slow end, so that it never cuts a recording.
        child.end_after(settings.duration + MEETING_TIMEOUT * 2);
        child.start()?;
    }
    run(settings, &mut children, progress)?;
    // The load belongs to the recording only; reading files needs no competition.
    drop(busy);
    let [sender, receiver] = &children[..] else {
        bail!("received {} nodes, expected two", children.len());
    };
    let mut raw = Raw::read(&file_of(receiver)?)?;
    // The nodes run a little longer than asked, until both have ended.
    raw.keep_first(settings.duration.as_nanos());
    Ok(RecordingResult {
        scale: scale(&raw, &file_of(sender)?)?,
        raw,
        warnings: children.iter().flat_map(warnings).collect(),
    })
}

/// A sender, and a receiver that takes all its messages, without any fault injected.
fn scenario(settings: &RecordingSettings) -> anyhow::Result<Scenario> {
    let cycle = settings.cycle_us;
    let real_time = if settings.real_time {
        "real-time = { priority = 80, lock-memory = true }"
    } else {
        ""
    };
    let text = format!(
        r#"
        title = "recording"
        duration-s = 1

        [[sender]]
        name = "sender"
        cycle-time-us = {cycle}
        {real_time}
        [[sender.axis]]
        id = 1
        name = "axis"
        [sender.axis.program]
        start-velocity = 500.0
        limits = {{ velocity = 1000.0, acceleration = 1000.0, jerk = 10000.0 }}

        [[receiver]]
        name = "receiver"
        cycle-time-us = {cycle}
        master = {{ node = "sender" }}
        # Old messages are recorded like all others.
        sync.time-sync = {{ age-of-data-limit = 0, max-cycle-index-difference = 0 }}
        {real_time}
        "#
    );
    let table = coaxle_node::config::parse_table("recording", &text)?;
    Ok(read::scenario("recording", table)?)
}

/// Waits for the first message, then for the end of the recording, and ends the nodes.
fn run(
    settings: &RecordingSettings,
    children: &mut [Child],
    progress: &mut dyn Progress,
) -> anyhow::Result<()> {
    // The receiver is the last one: senders come first.
    let arrivals = children.last().map(file_of).transpose()?;
    let deadline = machine::now() + MEETING_TIMEOUT;
    while !arrivals.as_deref().is_some_and(has_a_row) {
        look_after(children)?;
        if machine::now() > deadline {
            bail!(
                "received no message within {MEETING_TIMEOUT}, expected one: see the nodes' logs"
            );
        }
    }
    let begin = machine::now();
    let share =
        |now: Instant<Machine>| (now - begin).as_secs_f64() / settings.duration.as_secs_f64();
    while share(machine::now()) < 1.0 {
        if !progress.at(share(machine::now())) {
            break;
        }
        look_after(children)?;
    }
    children.iter().try_for_each(Child::ask_to_end)?;
    let mut ends = children.iter_mut().map(Child::wait_for_end);
    ends.try_for_each(|end| none_died(end?))
}

fn look_after(children: &mut [Child]) -> anyhow::Result<()> {
    std::thread::park_timeout(CHECK_INTERVAL);
    children
        .iter_mut()
        .try_for_each(|child| none_died(child.check()?))
}

/// A recording of a node that was killed is none.
fn none_died(death: Option<Death>) -> anyhow::Result<()> {
    match death {
        None => Ok(()),
        Some(death) => bail!("{death}"),
    }
}

/// More than a head line.
fn has_a_row(path: &Path) -> bool {
    std::fs::read_to_string(path).is_ok_and(|text| text.lines().count() > 1)
}

fn file_of(node: &Child) -> anyhow::Result<PathBuf> {
    let newest = node.files().last().context("a node was never started")?;
    Ok(newest.to_owned())
}

/// Scale of one clock: both nodes read the machine's clock, and the sender's trace has its reading at the ideal
/// start of its cycles, so the zero of the time scale is known exactly.
fn scale(raw: &Raw, sender: &Path) -> anyhow::Result<TimeScale> {
    let first = raw.sent_first();
    let known = first_cycle(sender, first.epoch)?;
    // A trace may begin at a later cycle than the arrivals, so both are counted back to cycle 0.
    let start = |count: u64| count as i64 * first.cycle_time_ns;
    let zero_on_machine = known.at_ns - start(known.cycle) + start(first.count);
    let machine_minus_local = first.at_ns - first.cycle_start_ns;
    let one_clock = |(at, local): (i64, i64)| at - local == machine_minus_local;
    let mut clocks = raw.messages.iter().map(|r| (r.at_ns, r.cycle_start_ns));
    // Exact equality: both stamps are of one clock and in whole nanoseconds.
    if !clocks.all(one_clock) {
        bail!("received a receiver whose clock deviates from the machine's, expected the same");
    }
    Ok(TimeScale::of_one_clock(
        zero_on_machine - machine_minus_local,
    ))
}

/// Fields of a cycle in a sender's trace.
#[derive(serde::Deserialize)]
struct SenderCycle {
    at_ns: i64,
    cycle: u64,
    run: u64,
}

/// The first cycle of a run in a sender's trace.
fn first_cycle(trace: &Path, run: u64) -> anyhow::Result<SenderCycle> {
    for cycle in rows::<SenderCycle>(trace)? {
        let cycle = cycle?;
        if cycle.run == run {
            return Ok(cycle);
        }
    }
    let path = trace.display();
    bail!("{path}: received no cycle of the recorded run, expected one")
}

/// Lines of a node's log at the levels of warning and error.
fn warnings(node: &Child) -> Vec<String> {
    let text = std::fs::read_to_string(node.log()).unwrap_or_default();
    let is_warning = |line: &&str| line.contains(" WARN ") || line.contains(" ERROR ");
    text.lines().filter(is_warning).map(str::to_owned).collect()
}
