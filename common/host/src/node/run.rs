//! Running a node in the real world, from its set-up to its outcome.

mod connect;
mod needs;
mod rings;
mod running;

use std::sync::Arc;

use anyhow::{Context, anyhow};
use coaxle_clock::{Instant, Local, Span};
use coaxle_node::Node;
use coaxle_node::audit::{AuditDoor, AuditEntry, AuditOutcome};
use coaxle_node::config::{ClockConfig, RealTimeConfig, TimingEndpoints, TransportConfig};
use coaxle_node::keys::NodeName;
use coaxle_node::lab::LabFields;
use coaxle_node::wiring::Wiring;
use coaxle_os::EndReason;
use coaxle_os::machine;
use coaxle_os::{EndSignals, Os, System};
use coaxle_topology::PlantNode;

use crate::machine::real_time;
use crate::network::credentials::{Credentials, RENEW_WITHIN, date};
use crate::network::transport::{Declared, Exposure, OverZenoh, Transport, start_accept_thread};
use crate::node::audit::Audit;
use crate::node::counters::{Counters, read};
use crate::node::cycle::NodeClock;
use crate::node::panics::{PanicWatch, panics};
use crate::node::service::Service;
use crate::node::telemetry::Recorder;
use connect::connect;
use rings::{Rings, open_rings};
use running::start;

/// A node and all it needs of the real world.
pub struct Setup<N: Node> {
    /// Name of the node.
    pub name: NodeName,
    /// Role in the status: `sender`, `receiver`.
    pub role: &'static str,
    /// Connection to other nodes.
    pub transport: TransportConfig,
    /// Settings requested from the operating system.
    pub real_time: RealTimeConfig,
    /// Injected clock faults.
    pub clock: ClockConfig,
    /// Seed of all injected randomness.
    pub seed: u64,
    /// Injected faults and simulated inputs, if it was started for an experiment; none on a machine.
    pub lab: Option<LabFields>,
    /// True if frames of axes carry their send delay.
    pub send_stamps: bool,
    /// Publications and subscriptions. The node follows the nodes whose axes it subscribes to.
    pub wiring: Wiring,
    /// Description of the node and its axes, which it publishes, and to which the followed nodes must not contradict.
    pub plant: PlantNode,
    /// Endpoints of the timing channel, if there is one.
    pub timing: TimingEndpoints,
    /// Duration of the run; none: until a signal.
    pub run_for: Option<Span>,
    /// Builds the node, given the ideal start of its first cycle and the epoch of this run.
    pub build: BuildNode<N>,
    /// Recorder of the node's snapshots.
    pub recorder: Box<dyn Recorder<N::Snapshot>>,
    /// Service that runs on the node's transport, if any.
    pub transport_service: Option<TransportService>,
}

/// A service on the transport of a node.
pub struct TransportService {
    /// Descriptors that it opens at most.
    pub files: usize,
    /// Threads that it starts at most.
    pub threads: usize,
    /// Starts it; it ends when the result is dropped.
    pub start: StartService,
}

/// Starts a service on this transport.
pub type StartService = Box<dyn FnOnce(Arc<dyn Transport>) -> anyhow::Result<Declared> + Send>;

/// Builds a node from the ideal start of its first cycle, in its own clock, and the run's epoch.
pub type BuildNode<N> = Box<dyn FnOnce(Instant<Local>, u64) -> anyhow::Result<N>>;

/// Result of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Reason for the end.
    pub ended: EndReason,
    /// The random epoch of this run.
    pub epoch: u64,
    /// Cycles run.
    pub cycles: u64,
    /// Frames handed to the transport.
    pub published: u64,
    /// Frames not handed to the transport: the publisher's ring was full, or the transport refused them.
    pub not_published: u64,
    /// Frames that were accepted on arrival.
    pub received: u64,
    /// Frames of axes that were refused on arrival.
    pub refused: u64,
    /// Time requests and responses refused on arrival.
    pub exchange_refused: u64,
    /// Messages that found the mailbox full.
    pub mailbox_dropped: u64,
    /// Records that found the telemetry ring full.
    pub telemetry_dropped: u64,
    /// Arrivals that found their ring full.
    pub arrivals_dropped: u64,
}

/// Runs a node over Zenoh until its time is up or a Ctrl-C or SIGTERM, and ends it cleanly.
///
/// # Errors
/// The system does not give what the node needs, the node cannot be built, the session cannot be opened, a thread died, or the recorder could
/// not keep what it recorded.
pub fn run<N>(setup: Setup<N>) -> anyhow::Result<Outcome>
where
    N: Node + Send + 'static,
{
    // Before anything is opened, by whatever the start would end otherwise.
    needs::of(&setup)
        .check()
        .with_context(|| format!("cannot start node {}", setup.name))?;
    // Before the session opens: the warning stands above the first failure of a network.
    warn_of_exposure(&setup.name, &setup.transport)?;
    let config = setup.transport.clone();
    let opening = async move { OverZenoh::open(&config).await };
    runtime()?.block_on(drive(setup, opening))
}

/// Runs a node over an existing transport; [`Setup::transport`] is ignored.
///
/// # Errors
/// As [`run`].
pub fn run_over<N>(setup: Setup<N>, transport: impl Transport + 'static) -> anyhow::Result<Outcome>
where
    N: Node + Send + 'static,
{
    runtime()?.block_on(drive(setup, async move { Ok(transport) }))
}

/// Logs one warning per security risk of the transport.
fn warn_of_exposure(node: &NodeName, transport: &TransportConfig) -> anyhow::Result<()> {
    let exposure = Exposure::of(transport)?;
    // Endpoints that it connects to are left out: they let nobody in.
    let open = exposure.without_mutual_tls(&exposure.listens);
    if !open.is_empty() {
        tracing::warn!(
            %node,
            "everybody who reaches {} can command this node and publish as any other: see docs/SECURE.md",
            open.join(", ")
        );
    }
    let Some(folder) = &transport.secure else {
        return Ok(());
    };
    let credentials = Credentials::open(folder)?;
    let now = machine::wall_clock();
    // An error, not an end: the node may run, alone.
    if let Err(fault) = credentials.check(now) {
        tracing::error!(%node, "no other node lets this one in: {fault}");
    } else if credentials.check(now + RENEW_WITHIN).is_err() {
        let end = date(credentials.not_after());
        tracing::warn!(
            %node,
            "the certificate holds until {end} only: renew it with `coaxle secure renew`"
        );
    }
    Ok(())
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    // Zenoh panics on a runtime with one thread only.
    tokio::runtime::Builder::new_multi_thread()
        // Zenoh has threads of its own. The host waits for signals and for the ends of threads only.
        .worker_threads(1)
        .thread_name("host")
        .enable_all()
        .build()
        .context("cannot start the host's runtime")
}

/// Parts of a run that every stage uses.
struct RunContext {
    name: NodeName,
    role: &'static str,
    epoch: u64,
    counters: Arc<Counters>,
    audit: Audit,
    /// Priority of the threads that carry messages.
    carriers: Option<u8>,
    panics: PanicWatch,
}

impl RunContext {
    /// Notes the start or the end of the run in the audit.
    fn note(&self, action: &str, outcome: AuditOutcome, reason: &str) {
        let entry = AuditEntry::new(AuditDoor::Run, Some(self.name.as_str()), action, outcome);
        self.audit.note(entry.because(reason));
    }
}

/// Runs a node in stages: builds it, opens its transport and its rings, connects it, starts its
/// threads; at its end, stops them.
async fn drive<N, T>(
    mut setup: Setup<N>,
    opening: impl Future<Output = anyhow::Result<T>>,
) -> anyhow::Result<Outcome>
where
    N: Node + Send + 'static,
    T: Transport + 'static,
{
    let mut signals = Os::end_signals().context("cannot listen for signals")?;
    let (watch, mut panics) = panics();
    let (node, clock, run) = build(&mut setup, watch)?;
    if setup.transport.secure.is_some() {
        // Before the priority is raised: a flood of connects must not take the processor from frames.
        start_accept_thread();
    }
    let raised = real_time::raised(run.carriers);
    let transport: Arc<dyn Transport> = tokio::select! {
        opened = opening => Arc::new(opened?),
        ended = signals.next() => return Ok(outcome(ended, &run)),
    };
    drop(raised);

    let Rings {
        cycle,
        incoming,
        outgoing,
    } = open_rings(&node, &setup, &run)?;
    let mut connected = connect(&mut setup, &run, transport, incoming)?;
    // It ends when it is dropped, after everything else.
    let _transport_service = connected.service.take();
    let mut running = start(setup, &run, (node, clock), cycle, outgoing, connected)?;
    running.report_start(&run).await;
    run.note(
        "start",
        AuditOutcome::Accepted,
        &format!("version {}", env!("CARGO_PKG_VERSION")),
    );

    let mut service = Service::ready();
    let why = tokio::select! {
        thread = panics.next() => Err(anyhow!("the {thread} thread panicked")),
        () = running.ended() => Ok(EndReason::TimeUp),
        why = signals.next() => Ok(why),
        never = service.notify_watchdog(&run.counters.cycles) => match never {},
    };
    service.stopping();
    let reason = match &why {
        Ok(why) => format!("{why:?}"),
        Err(error) => error.to_string(),
    };
    // Before the telemetry thread ends, which records and publishes it.
    run.note("run", AuditOutcome::Ended, &reason);
    running.stop().await?;
    let why = why?;
    tracing::info!(node = %run.name, ended = ?why, "stopped");
    Ok(outcome(why, &run))
}

/// Builds the node and its clock.
fn build<N: Node>(
    setup: &mut Setup<N>,
    panics: PanicWatch,
) -> anyhow::Result<(N, NodeClock, RunContext)> {
    let name = setup.name.clone();
    if let Some(lab) = &setup.lab {
        tracing::warn!(node = %name, "started with --lab, for an experiment and no machine: {lab}");
    }
    let epoch = getrandom::u64().context("the system gives no random epoch")?;
    let once = Box::new(|_, _| Err(anyhow!("it is built already")));
    let build = std::mem::replace(&mut setup.build, once);
    let node = build(NodeClock::first_cycle(&setup.clock), epoch)
        .with_context(|| format!("cannot build node {name}"))?;
    let clock = NodeClock::new(&setup.clock, setup.seed, Instant::EPOCH)
        .with_context(|| format!("cannot build node {name}: clock"))?;
    let audit = Audit::new(&name, epoch);
    let run = RunContext {
        name,
        role: setup.role,
        epoch,
        counters: Arc::new(Counters::default()),
        audit,
        carriers: real_time::carriers(&setup.real_time),
        panics,
    };
    Ok((node, clock, run))
}

fn outcome(ended: EndReason, run: &RunContext) -> Outcome {
    let counters = &run.counters;
    Outcome {
        ended,
        epoch: run.epoch,
        cycles: read(&counters.cycles),
        published: read(&counters.published),
        // Either way the frame did not leave.
        not_published: read(&counters.publish_dropped) + read(&counters.publish_failed),
        received: read(&counters.received),
        refused: read(&counters.refused),
        exchange_refused: read(&counters.exchange_refused),
        mailbox_dropped: read(&counters.mailbox_dropped),
        telemetry_dropped: read(&counters.telemetry_dropped),
        arrivals_dropped: read(&counters.arrivals_dropped),
    }
}
