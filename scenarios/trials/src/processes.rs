//! A scenario as real processes over real Zenoh, on this machine.
//!
//! Every node runs as a process of its own (this very program, called with `sender` or `receiver`)
//! and writes its trace. All of them read one monotonic clock, so afterwards each receiver cycle
//! can be compared with the master's true motion.

mod child;
mod death;
mod memory;
mod nodes;
mod orders;
mod traces;

use std::path::Path;
use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_lab::finished::{Finished, Progress};
use coaxle_lab::row::RowSink;
use coaxle_lab::run::NODES_FOLDER;
use coaxle_lab::scenario::Scenario;
use coaxle_lab::stage::Stage;
use coaxle_lab::summary::World;
use coaxle_lab::timeline::{ChangeKind, ChangeTarget, changes_of};
use coaxle_lab::topology::Topology;
use coaxle_os::{Machine, machine};

pub(crate) use child::{Child, NodeOutput};
pub(crate) use death::Death;
pub(crate) use nodes::{NodeProcesses, Protocol};
use orders::OrderSender;

/// Real processes of this machine, in real time.
#[derive(Clone, Copy, Debug)]
pub struct Processes;

impl Stage for Processes {
    fn world(&self) -> World {
        World::Processes
    }

    fn play(
        &self,
        scenario: &Scenario,
        out: &Path,
        mut sink: &mut dyn RowSink,
        progress: &mut dyn Progress,
    ) -> anyhow::Result<Finished> {
        run(scenario, out, &mut sink, progress)
    }
}

/// Runs a checked scenario as processes. Their configs, logs, traces and raw arrivals are left in
/// `out/nodes`.
///
/// A node that a signal kills although the scenario does not order it is no error: it is among the failures of the run.
///
/// # Errors
/// A node that does not start, ends by itself, or whose memory grows while it runs; a trace that cannot be read.
pub fn run(
    scenario: &Scenario,
    out: &Path,
    sink: &mut impl RowSink,
    progress: &mut dyn Progress,
) -> anyhow::Result<Finished> {
    let topology = Topology::of(scenario).map_err(|wrong| wrong.in_file("scenario"))?;
    let folder = out.join(NODES_FOLDER);
    let NodeProcesses {
        mut children,
        endpoints,
        ports: _claimed,
    } = NodeProcesses::prepare(
        scenario,
        &topology,
        &folder,
        Protocol::Tcp,
        NodeOutput::Trace,
    )?;
    let mut orders = OrderSender::prepare(&scenario.events, |node| {
        topology.node(node).map(|node| endpoints[node].clone())
    })?;
    // Traces are complete only after every node has ended, so judging comes last.
    let played = play(scenario, &topology, &mut children, &mut orders, progress)?;
    let finished = traces::evaluate(scenario, &topology, &children, played.begin, sink)?;
    let deaths = played.deaths.iter();
    let deaths = deaths.map(|death| death.verdict(played.begin)).collect();
    let finished = finished.with_commands(orders.finish()).with_deaths(deaths);
    Ok(finished.interrupted_at(played.interrupted_at_s))
}

/// Record of the run of the nodes.
struct ProcessesRun {
    begin: Instant<Machine>,
    /// Time at which it was interrupted, s.
    interrupted_at_s: Option<f64>,
    deaths: Vec<Death>,
}

/// Starts every node but the duplicates, lets the events happen, and ends every node.
fn play(
    scenario: &Scenario,
    topology: &Topology,
    children: &mut [Child],
    orders: &mut OrderSender,
    progress: &mut dyn Progress,
) -> anyhow::Result<ProcessesRun> {
    // Duplicates come last in the list and are started by their events.
    for child in children.iter_mut().take(topology.names().len()) {
        child.start()?;
    }
    let mut changes = changes_of(scenario, topology).into_iter().peekable();
    let begin = machine::now();
    let duration = Span::from_secs_f64(scenario.duration_s.get());
    let (mut interrupted_at_s, mut deaths) = (None, Vec::new());
    loop {
        let passed = machine::now() - begin;
        let share = (passed.as_secs_f64() / duration.as_secs_f64()).min(1.0);
        // Behind the end there is nothing left to interrupt: the run is whole.
        if !progress.at(share) && passed < duration {
            interrupted_at_s = Some(passed.as_secs_f64());
            break;
        }
        while let Some(change) = changes.next_if(|change| change.at <= passed) {
            // Routers exist in virtual time only: here nodes are connected directly.
            let ChangeTarget::Node(node) = change.target else {
                continue;
            };
            let child = &mut children[node];
            match change.what {
                ChangeKind::Kill => deaths.extend(child.kill()?),
                ChangeKind::Start => child.start()?,
                ChangeKind::Stop => child.freeze()?,
                ChangeKind::Resume | ChangeKind::ResumeInPieces => child.resume()?,
                ChangeKind::Command(event) => orders.send(&scenario.events[event])?,
            }
        }
        for child in children.iter_mut() {
            deaths.extend(child.check()?);
        }
        if passed >= duration {
            break;
        }
        wait(LOOK);
    }
    for child in children.iter_mut() {
        // All are asked before any is waited for: otherwise receivers would lose senders that have ended already.
        child.ask_to_end()?;
    }
    for child in children.iter_mut() {
        deaths.extend(child.wait_for_end()?);
    }
    Ok(ProcessesRun {
        begin,
        interrupted_at_s,
        deaths,
    })
}

/// Interval of checks of the nodes.
// Events of a scenario happen up to this much late.
const LOOK: Duration = Duration::from_millis(20);

fn wait(time: Duration) {
    std::thread::park_timeout(time);
}
