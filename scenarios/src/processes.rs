//! A scenario as real processes over real Zenoh, on this machine.
//!
//! Every node runs as a process of its own (this very program, called with `sender` or `receiver`)
//! and writes its trace. All of them read one monotonic clock, so afterwards each receiver cycle
//! can be compared with what the master really did.

mod child;
mod orders;
mod traces;

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use coaxle_clock::Span;
use coaxle_host::machine;
use coaxle_node::config::TransportConfig;
use serde::Serialize;

use crate::evaluate::RowSink;
use crate::run::{Finished, Progress};
use crate::scenario::Scenario;
use crate::timeline::{What, changes_of};
use crate::topology::Topology;
use child::{Child, Role};
use orders::Orders;

/// The folder, among the results of a run, of the files that nodes leave.
pub const FOLDER: &str = "nodes";

/// Runs a checked scenario as processes. Their configs, logs, traces and raw arrivals are left in
/// `out/nodes`.
///
/// # Errors
/// A node that does not start or ends badly; a trace that cannot be read.
pub fn run(
    scenario: &Scenario,
    out: &Path,
    sink: &mut impl RowSink,
    progress: &mut dyn Progress,
) -> anyhow::Result<Finished> {
    let topology = Topology::of(scenario).map_err(|wrong| wrong.in_file("scenario"))?;
    let folder = out.join(FOLDER);
    if folder.exists() {
        // Traces of an earlier run must not be taken for this one's.
        std::fs::remove_dir_all(&folder)
            .with_context(|| format!("cannot empty {}", folder.display()))?;
    }
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let endpoints = endpoints(topology.names().len())?;
    let mut children = write_configs(scenario, &topology, &folder, &endpoints)?;
    let mut orders = Orders::prepare(&scenario.events, |node| {
        topology.node(node).map(|node| endpoints[node].clone())
    })?;
    play(scenario, &topology, &mut children, &mut orders, progress)?;
    let finished = traces::evaluate(scenario, &topology, &children, sink)?;
    Ok(finished.with_commands(orders.finish()))
}

fn write_configs(
    scenario: &Scenario,
    topology: &Topology,
    folder: &Path,
    endpoints: &[String],
) -> anyhow::Result<Vec<Child>> {
    let endpoint = |node: usize| endpoints[node].clone();
    let mut children = Vec::new();
    for (n, config) in scenario.senders.iter().enumerate() {
        let mut config = config.clone();
        config.seed = scenario.seed_of(&config.name);
        config.transport = local(&config.transport, endpoint(n), None);
        let path = write_toml(folder, config.name.as_str(), &config)?;
        children.push(Child::new(Role::Sender, config.name.as_str(), path));
    }
    for (n, config) in scenario.receivers.iter().enumerate() {
        let mut config = config.clone();
        let this = scenario.senders.len() + n;
        config.seed = scenario.seed_of(&config.name);
        let source = endpoint(topology.root(n).source);
        config.transport = local(&config.transport, endpoint(this), Some(source));
        let path = write_toml(folder, config.name.as_str(), &config)?;
        children.push(Child::new(Role::Receiver, config.name.as_str(), path));
    }
    Ok(children)
}

/// The node's own Zenoh settings, on endpoints of this machine.
fn local(config: &TransportConfig, listen: String, connect: Option<String>) -> TransportConfig {
    TransportConfig {
        listen: vec![listen],
        connect: connect.into_iter().collect(),
        ..config.clone()
    }
}

fn write_toml(folder: &Path, name: &str, config: &impl Serialize) -> anyhow::Result<PathBuf> {
    let path = folder.join(format!("{name}.toml"));
    let text = toml::to_string(config).with_context(|| format!("cannot write {name} as TOML"))?;
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}

/// Endpoints that nobody uses now. All are held until the last is found, so that they differ.
fn endpoints(count: usize) -> anyhow::Result<Vec<String>> {
    let held = (0..count)
        .map(|_| TcpListener::bind(("127.0.0.1", 0)))
        .collect::<Result<Vec<_>, _>>()
        .context("cannot find free ports")?;
    held.iter()
        .map(|listener| Ok(format!("tcp/{}", listener.local_addr()?)))
        .collect()
}

/// Starts every node, lets the events happen, and ends every node.
fn play(
    scenario: &Scenario,
    topology: &Topology,
    children: &mut [Child],
    orders: &mut Orders,
    progress: &mut dyn Progress,
) -> anyhow::Result<()> {
    for child in children.iter_mut() {
        child.start()?;
    }
    let mut changes = changes_of(scenario, topology).into_iter().peekable();
    let begin = machine::now();
    let duration = Span::from_secs_f64(scenario.duration_s.get());
    loop {
        let passed = machine::now() - begin;
        progress.at((passed.as_secs_f64() / duration.as_secs_f64()).min(1.0));
        while let Some(change) = changes.next_if(|change| change.at <= passed) {
            let child = &mut children[change.node];
            match change.what {
                What::Kill => child.kill()?,
                What::Start => child.start()?,
                What::Stop => child.freeze()?,
                What::Resume => child.resume()?,
                What::Command(event) => orders.send(&scenario.events[event])?,
            }
        }
        for child in children.iter_mut() {
            child.check()?;
        }
        if passed >= duration {
            break;
        }
        wait(LOOK);
    }
    for child in children.iter_mut() {
        child.ask_to_end()?;
    }
    children.iter_mut().try_for_each(Child::wait_for_end)
}

/// How often the runner looks after its nodes.
const LOOK: Duration = Duration::from_millis(20);

fn wait(time: Duration) {
    std::thread::park_timeout(time);
}
