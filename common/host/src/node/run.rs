//! Running a node in the real world, from its set-up to its outcome.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use anyhow::{Context, anyhow};
use coaxle_clock::{Instant, Local, Span};
use coaxle_node::Node;
use coaxle_node::config::{ClockConfig, RealTimeConfig, TimingEndpoints, TransportConfig};
use coaxle_node::frame::MAX_AXES;
use coaxle_node::keys::NodeName;
use coaxle_node::lab::LabFields;
use coaxle_node::wiring::{Publication, Subscription, Wiring};
use coaxle_os::EndReason;
use coaxle_os::machine;
use coaxle_os::{EndSignals, Os, System};
use rtrb::RingBuffer;

use crate::files::inputs::inputs;
use crate::machine::real_time;
use crate::network::credentials::{
    Credentials, RENEW_WITHIN, TIMING_KEY_FILE, date, timing_secret,
};
use crate::network::transport::{Declared, Exposure, OverZenoh, Transport, Urgency};
use crate::node::circles::CircleSearch;
use crate::node::commands::commands;
use crate::node::counters::{Counters, read};
use crate::node::cycle::{Cycle, NodeClock};
use crate::node::mailbox::{Inbox, Mailbox, mailbox};
use crate::node::outbox::outbox;
use crate::node::panics::panics;
use crate::node::service::Service;
use crate::node::session::Session;
use crate::node::status::{Identity, Reporter};
use crate::node::telemetry::{Recorder, telemetry};
use crate::node::threads::{
    Wishes, joined, start_beacons, start_cycle, start_publisher, start_server, start_telemetry,
};
use crate::node::timing::TimingChannel;

/// Messages with axes between two scans: two seconds' worth at 1 kHz.
const MAILBOX_MESSAGES: usize = 2048;
/// Axes in these messages: 128 frames of the longest kind, or all messages with few axes each.
// Room for all messages at full length would be 262 144 axes in each subscription.
const MAILBOX_AXES: usize = 128 * MAX_AXES;
/// Requests or responses between two scans: those of a hundred nodes in a second, at ten each.
const MAILBOX_EXCHANGES: usize = 1024;
/// Forty of the longest frames.
const OUTBOX_BYTES: usize = 1 << 20;
/// Arrivals that telemetry may lag behind: nearly a second's worth at the shortest cycle time, and a second's worth in one burst besides.
// The shortest cycle of 100 µs makes 10 000 a second.
const ARRIVAL_RECORDS: usize = 8192 + 1024;

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

/// Starts a service on the transport of a node; it ends when the result is dropped.
pub type TransportService = Box<dyn FnOnce(Arc<dyn Transport>) -> anyhow::Result<Declared> + Send>;

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
/// The node cannot be built, the session cannot be opened, a thread died, or the recorder could
/// not keep what it recorded.
pub fn run<N>(setup: Setup<N>) -> anyhow::Result<Outcome>
where
    N: Node + Send + 'static,
{
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
            "whoever reaches {} can command this node and publish as any other: see docs/SECURE.md",
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

async fn drive<N, T>(
    mut setup: Setup<N>,
    opening: impl Future<Output = anyhow::Result<T>>,
) -> anyhow::Result<Outcome>
where
    N: Node + Send + 'static,
    T: Transport + 'static,
{
    let mut signals = Os::end_signals().context("cannot listen for signals")?;
    if let Some(lab) = &setup.lab {
        tracing::warn!(node = %setup.name, "started with --lab, for an experiment and no machine: {lab}");
    }
    let (panic_watch, mut panics) = panics();
    let epoch = getrandom::u64().context("the system gives no random epoch")?;
    let identity = identity(&setup, epoch);
    let node = (setup.build)(NodeClock::first_cycle(&setup.clock), epoch)
        .with_context(|| format!("cannot build node {}", setup.name))?;
    let clock = NodeClock::new(&setup.clock, setup.seed, Instant::EPOCH)
        .with_context(|| format!("cannot build node {}: clock", setup.name))?;
    let counters = Arc::new(Counters::default());
    let carriers = real_time::carriers(&setup.real_time);
    let raised = real_time::raised(carriers);
    let transport: Arc<dyn Transport> = tokio::select! {
        opened = opening => Arc::new(opened?),
        ended = signals.next() => return Ok(outcome(ended, epoch, &counters)),
    };
    drop(raised);

    let (inboxes, mailboxes) = mailboxes(&setup.wiring.subscriptions, &counters);
    let (mut outbox, frames) = outbox(OUTBOX_BYTES);
    let (arrivals, arrived) = RingBuffer::new(ARRIVAL_RECORDS);
    let (records, mut telemetry) = telemetry(node.snapshot(), node.snapshot_size(), arrived);
    let (inputs, told) = setup.recorder.wants_inputs().then(inputs).unzip();
    telemetry.attach(told);
    let (mut orders, server, mut requests) = commands(&setup.name);
    let circle_names = server.circles();
    let server = start_server(server, &panic_watch)?;
    orders.attach(server.thread().clone());
    requests.attach(server.thread().clone());

    let transport_service = setup.transport_service.take();
    let transport_service = transport_service.map(|start| start(Arc::clone(&transport)));
    let _transport_service = transport_service.transpose()?;
    let rows = transport.publisher(&setup.name.rows_key(), Urgency::Bulk)?;
    setup.recorder.begin(epoch, rows);
    let mut session = Session::open(transport, &setup.name, epoch, panic_watch.clone())?;
    let channels = session.publish(&setup.wiring.publications, setup.seed)?;
    let mut timing = timing_channel(
        &setup.name,
        &setup.timing,
        &setup.wiring.publications,
        &setup.transport,
        setup.seed,
    )?;
    for (subscription, inbox) in setup.wiring.subscriptions.iter().zip(inboxes) {
        if subscription.channel.is_timing() {
            if let Some(timing) = &mut timing {
                timing.receive(subscription, setup.seed, inbox, &counters)?;
            }
            continue;
        }
        session.subscribe(subscription, setup.seed, inbox, Arc::clone(&counters))?;
    }
    session.take_orders(&setup.name, requests)?;
    session.watch_receivers(&setup.name)?;
    if setup.transport.secure.is_none() {
        session.watch_neighbours(&setup.name)?;
    }
    let session = Arc::new(session);
    let (circle_search, circles) = CircleSearch::open(
        &setup.name,
        &setup.wiring.subscriptions,
        circle_names,
        &**session.transport(),
    )?;

    let (beacon_sender, beacon_receiver) = timing.map(TimingChannel::ends).unzip();
    let beacons = beacon_receiver
        .map(|receiver| start_beacons(receiver, carriers, &panic_watch))
        .transpose()?;
    let publisher = start_publisher(
        frames,
        setup.send_stamps,
        channels,
        beacon_sender,
        &counters,
        carriers,
        &panic_watch,
    )?;
    outbox.attach(publisher.thread().clone());
    let granted = Arc::new(real_time::Outcome::new());
    let reporter = Reporter::new(
        identity,
        Arc::clone(&session),
        Arc::clone(&counters),
        Arc::clone(&granted),
        circle_search,
        machine::now(),
    );
    let telemetry_thread = start_telemetry(telemetry, setup.recorder, reporter, &panic_watch)?;
    let counted = Arc::clone(&counters);
    let with_clock = move |clock| Cycle {
        node,
        clock,
        mailboxes,
        orders,
        outbox,
        records,
        arrivals,
        inputs,
        circles,
        counters: counted,
    };
    let wishes = Wishes {
        real_time: setup.real_time,
        clock,
        run_for: setup.run_for,
    };
    let cycle = start_cycle(with_clock, wishes, &panic_watch)?;
    if let Ok(denied) = cycle.running.await {
        for denied in granted.get_or_init(|| denied) {
            tracing::warn!(node = %setup.name, "real-time wish {denied}");
        }
        let endpoints = session.whereabouts();
        tracing::info!(node = %setup.name, role = setup.role, "running, {endpoints}");
    }

    let mut service = Service::ready();
    let why = tokio::select! {
        thread = panics.next() => Err(anyhow!("the {thread} thread panicked")),
        _ = cycle.ended => Ok(EndReason::TimeUp),
        why = signals.next() => Ok(why),
        never = service.notify_watchdog(&counters.cycles) => match never {},
    };
    service.stopping();
    cycle.stop.store(true, Ordering::Relaxed);
    // In the order of the data flow, so that each thread finds all remaining data.
    let cycled = joined("cycle", cycle.thread).await;
    let commanded = joined("command", server).await;
    let published = joined("publish", publisher).await;
    let observed = joined("telemetry", telemetry_thread).await;
    let timed = match beacons {
        Some(beacons) => {
            beacons.stop.store(true, Ordering::Relaxed);
            joined("timing", beacons.thread).await
        }
        None => Ok(()),
    };
    session.close();
    // An error of a thread itself is more specific.
    cycled?;
    commanded?;
    published?;
    timed?;
    observed?.context("the recorder could not keep what it recorded")?;
    let why = why?;
    tracing::info!(node = %setup.name, ended = ?why, "stopped");
    Ok(outcome(why, epoch, &counters))
}

/// The timing channel of the node, if configured and permitted.
fn timing_channel(
    node: &NodeName,
    endpoints: &TimingEndpoints,
    publications: &[Publication],
    transport: &TransportConfig,
    seed: u64,
) -> anyhow::Result<Option<TimingChannel>> {
    // Neither listens nor asks: without a configured endpoint there is no socket at all.
    if endpoints.is_none() {
        return Ok(None);
    }
    let mut secret = None;
    // A plain network has no secret: its beacons carry a check sum, as its frames do.
    if let Some(folder) = &transport.secure {
        secret = timing_secret(folder)?;
        if secret.is_none() {
            tracing::warn!(
                %node,
                "the timing channel stays off: {} has no {TIMING_KEY_FILE} to authenticate beacons with; \
                 `coaxle secure renew` writes one",
                folder.display()
            );
            // A channel without authentication would let any datagram move the clock of a secured node.
            return Ok(None);
        }
    }
    TimingChannel::open(node, endpoints, publications, seed, secret).map(Some)
}

fn identity<N: Node>(setup: &Setup<N>, epoch: u64) -> Identity {
    let heard = setup.wiring.subscriptions.iter();
    let followed = heard.filter(|s| s.channel.carries_axes());
    let axes = setup
        .wiring
        .publications
        .iter()
        // Requests and responses are left out: a node that only asks for the time is followed by nobody.
        .filter(|p| p.channel.carries_axes());
    Identity {
        name: setup.name.clone(),
        role: setup.role,
        epoch,
        sources: followed
            .map(|s| (s.node.clone(), s.node.channel_key(s.channel)))
            .collect(),
        publishes: axes.map(|p| p.node.channel_key(p.channel)).collect(),
        in_secure_network: setup.transport.secure.is_some(),
        lab: setup.lab.as_ref().map(ToString::to_string),
    }
}

/// Creates a mailbox for each subscription: each is filled by one thread only.
fn mailboxes(subscriptions: &[Subscription], counters: &Counters) -> (Vec<Inbox>, Vec<Mailbox>) {
    let mailbox = |subscription: &Subscription| {
        let (messages, axes) = match subscription.reader.axes() {
            // Time requests carry no axes, and come ten times a second instead of a thousand.
            0 => (MAILBOX_EXCHANGES, 0),
            // Few axes: as many places as all messages could fill.
            axes => (MAILBOX_MESSAGES, MAILBOX_AXES.min(MAILBOX_MESSAGES * axes)),
        };
        mailbox(messages, axes, Arc::clone(&counters.mailbox_dropped))
    };
    subscriptions.iter().map(mailbox).unzip()
}

fn outcome(ended: EndReason, epoch: u64, counters: &Counters) -> Outcome {
    Outcome {
        ended,
        epoch,
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
