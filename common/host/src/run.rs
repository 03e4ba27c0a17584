//! Running a node in the real world, from its set-up to its outcome.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use anyhow::{Context, anyhow};
use coaxle_clock::{Instant, Local, Span};
use coaxle_node::Node;
use coaxle_node::config::{ClockConfig, RealTimeConfig, TransportConfig};
use coaxle_node::keys::NodeName;
use rtrb::{Producer, RingBuffer};
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::oneshot;
use zenoh::query::Query;

use crate::channels::{Publication, Subscription};
use crate::commands::{Clerk, Desk, commands};
use crate::counters::{Counters, read};
use crate::cycle::{Cycle, Limits, NodeClock};
use crate::link::{Link, described};
use crate::mailbox::{Inbox, Mailbox, mailbox};
use crate::outbox::{Outbox, Outgoings, outbox};
use crate::publisher::{PublishedChannel, publish};
use crate::real_time;
use crate::status::{Identity, Reporter};
use crate::telemetry::{ArrivalRecord, Record, Recorder, Telemetry, observe};

/// Messages with axes between two scans: two seconds' worth at 1 kHz.
const MAILBOX_LETTERS: usize = 2048;
/// Questions or answers between two scans: those of a hundred nodes in a second, at ten each.
const EXCHANGE_LETTERS: usize = 1024;
/// Forty of the longest frames.
const OUTBOX_BYTES: usize = 1 << 20;
/// Cycles that telemetry may lag behind: nearly a second at the shortest cycle time.
const TELEMETRY_RECORDS: usize = 8192;
/// Arrivals that telemetry may lag behind: likewise, and a second's worth in one burst besides.
const ARRIVAL_RECORDS: usize = 8192 + 1024;

/// A node and all it needs of the real world.
pub struct Setup<N: Node> {
    /// Its name.
    pub name: NodeName,
    /// What it is, for its status: `sender`, `receiver`.
    pub role: &'static str,
    /// How it reaches the others.
    pub transport: TransportConfig,
    /// What it asks of the operating system.
    pub real_time: RealTimeConfig,
    /// What is wrong with its clock on purpose.
    pub clock: ClockConfig,
    /// Where all its injected randomness comes from.
    pub seed: u64,
    /// Whether its frames of axes say how late they left.
    pub send_stamps: bool,
    /// What it publishes, one of each channel.
    pub publishes: Vec<Publication>,
    /// What it hears. It follows the node whose axes it hears, if it does.
    pub subscriptions: Vec<Subscription>,
    /// Ends the run after this time; none runs until a signal comes.
    pub run_for: Option<Span>,
    /// Builds the node, given the ideal start of its first cycle and the epoch of this run.
    pub build: BuildNode<N>,
    /// Keeps what the node shows of itself.
    pub recorder: Box<dyn Recorder<N::Snapshot>>,
}

/// Builds a node from the ideal start of its first cycle, in its own clock, and the run's epoch.
pub type BuildNode<N> = Box<dyn FnOnce(Instant<Local>, u64) -> anyhow::Result<N>>;

/// How a run went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Why it ended.
    pub ended: Ended,
    /// The random epoch of this run.
    pub epoch: u64,
    /// Cycles run.
    pub cycles: u64,
    /// Frames handed to Zenoh.
    pub published: u64,
    /// Frames that did not get as far: the publisher's ring was full, or Zenoh refused them.
    pub not_published: u64,
    /// Frames that were accepted on arrival.
    pub received: u64,
    /// Frames that were refused on arrival.
    pub refused: u64,
    /// Messages that found the mailbox full.
    pub mailbox_dropped: u64,
    /// Records that found the telemetry ring full.
    pub telemetry_dropped: u64,
    /// Arrivals that found their ring full.
    pub arrivals_dropped: u64,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Its time was up.
    TimeUp,
    /// Ctrl-C.
    Interrupted,
    /// SIGTERM.
    Terminated,
}

/// Runs a node until its time is up or Ctrl-C or SIGTERM comes, and ends it cleanly.
///
/// # Errors
/// The node cannot be built, the session cannot be opened, a thread died, or the recorder could
/// not keep what it recorded.
pub fn run<N>(setup: Setup<N>) -> anyhow::Result<Outcome>
where
    N: Node + Send + 'static,
{
    // Zenoh panics on a runtime with one thread only.
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name("host")
        .enable_all()
        .build()
        .context("cannot start the host's runtime")?;
    runtime.block_on(drive(setup))
}

async fn drive<N>(setup: Setup<N>) -> anyhow::Result<Outcome>
where
    N: Node + Send + 'static,
{
    let mut signals = Signals::listen()?;
    let epoch = getrandom::u64().context("the system gives no random epoch")?;
    let identity = identity(&setup, epoch);
    let node = (setup.build)(NodeClock::first_cycle(&setup.clock), epoch)
        .with_context(|| format!("cannot build node {}", setup.name))?;
    let counters = Arc::new(Counters::default());
    let (inboxes, mailboxes) = mailboxes(&setup.subscriptions, &counters);
    let (mut outbox, outgoings) = outbox(OUTBOX_BYTES);
    let (telemetry, records) = RingBuffer::new(TELEMETRY_RECORDS);
    let (arrivals, arrived) = RingBuffer::new(ARRIVAL_RECORDS);
    let (mut desk, clerk, counter) = commands();
    let clerk = start_clerk(clerk)?;
    desk.attach(clerk.thread().clone());

    let opening = async {
        let mut link = Link::open(&setup.transport, &setup.name).await?;
        let channels = link.publish(&setup.publishes, setup.seed).await?;
        for (subscription, inbox) in setup.subscriptions.iter().zip(inboxes) {
            link.subscribe(subscription, setup.seed, inbox, Arc::clone(&counters))
                .await?;
        }
        link.take_commands(&setup.name, counter, clerk.thread().clone())
            .await?;
        anyhow::Ok((Arc::new(link), channels))
    };
    let (link, channels) = tokio::select! {
        opened = opening => opened?,
        ended = signals.next() => return Ok(outcome(ended, epoch, &counters)),
    };

    let publisher = start_publisher(outgoings, setup.send_stamps, channels, &counters)?;
    outbox.attach(publisher.thread().clone());
    let reporter = Reporter::new(identity, Arc::clone(&link), Arc::clone(&counters));
    let recorded = Telemetry {
        records,
        arrivals: arrived,
    };
    let observer = start_observer(recorded, setup.recorder, reporter)?;
    let parts = CycleParts {
        node,
        mailboxes,
        desk,
        outbox,
        telemetry,
        arrivals,
        counters: Arc::clone(&counters),
    };
    let wishes = Wishes {
        real_time: setup.real_time,
        clock: setup.clock,
        seed: setup.seed,
        run_for: setup.run_for,
    };
    let cycle = start_cycle(parts, wishes)?;
    if let Ok(denied) = cycle.running.await {
        for real_time::Denied { wish, reason } in denied {
            tracing::warn!(node = %setup.name, "real-time wish {wish} not granted: {reason}");
        }
        let endpoints = described(&setup.transport);
        tracing::info!(node = %setup.name, role = setup.role, "running, {endpoints}");
    }

    let why = tokio::select! {
        _ = cycle.ended => Ended::TimeUp,
        why = signals.next() => why,
    };
    cycle.stop.store(true, Ordering::Relaxed);
    // In the order the data flow, so that each finds all that is left.
    let cycled = joined("cycle", cycle.thread);
    let commanded = joined("command", clerk);
    let published = joined("publish", publisher);
    let observed = joined("telemetry", observer).and_then(|finished| finished);
    link.close().await;
    cycled?;
    commanded?;
    published?;
    observed.context("the recorder could not keep what it recorded")?;
    tracing::info!(node = %setup.name, ended = ?why, "stopped");
    Ok(outcome(why, epoch, &counters))
}

fn identity<N: Node>(setup: &Setup<N>, epoch: u64) -> Identity {
    let followed = setup
        .subscriptions
        .iter()
        .find(|s| s.channel.carries_axes());
    let axes = setup.publishes.iter().filter(|p| p.channel.carries_axes());
    Identity {
        name: setup.name.clone(),
        role: setup.role,
        epoch,
        source: followed.map(|s| (s.node.clone(), s.node.channel_key(s.channel))),
        publishes: axes.map(|p| p.node.channel_key(p.channel)).collect(),
        endpoints: described(&setup.transport),
    }
}

/// A mailbox for each subscription: each has only one thread that fills it.
fn mailboxes(subscriptions: &[Subscription], counters: &Counters) -> (Vec<Inbox>, Vec<Mailbox>) {
    let mailbox = |subscription: &Subscription| {
        let letters = if subscription.channel.carries_axes() {
            MAILBOX_LETTERS
        } else {
            EXCHANGE_LETTERS
        };
        mailbox(letters, Arc::clone(&counters.mailbox_dropped))
    };
    subscriptions.iter().map(mailbox).unzip()
}

fn start_clerk(clerk: Clerk<Query>) -> anyhow::Result<JoinHandle<()>> {
    thread("command", move || clerk.work())
}

fn start_publisher(
    outgoings: Outgoings,
    send_stamps: bool,
    mut channels: Vec<PublishedChannel>,
    counters: &Arc<Counters>,
) -> anyhow::Result<JoinHandle<()>> {
    let counters = Arc::clone(counters);
    thread("publish", move || {
        publish(outgoings, &mut channels, send_stamps, &counters);
    })
}

fn start_observer<S: Send + 'static>(
    telemetry: Telemetry<S>,
    mut recorder: Box<dyn Recorder<S>>,
    mut reporter: Reporter,
) -> anyhow::Result<JoinHandle<anyhow::Result<()>>> {
    thread("telemetry", move || {
        observe(telemetry, recorder.as_mut(), &mut reporter)
    })
}

/// The cycle but for its clock, which starts on the cycle's own thread.
struct CycleParts<N: Node> {
    node: N,
    mailboxes: Vec<Mailbox>,
    desk: Desk,
    outbox: Outbox,
    telemetry: Producer<Record<N::Snapshot>>,
    arrivals: Producer<ArrivalRecord>,
    counters: Arc<Counters>,
}

/// How the cycle is to run.
struct Wishes {
    real_time: RealTimeConfig,
    clock: ClockConfig,
    seed: u64,
    run_for: Option<Span>,
}

/// The cycle thread as the host holds it.
struct RunningCycle {
    thread: JoinHandle<()>,
    stop: Arc<AtomicBool>,
    /// Comes once before the first cycle, with what the operating system did not grant.
    running: oneshot::Receiver<Vec<real_time::Denied>>,
    /// Closes when the thread ends, be it by a panic.
    ended: oneshot::Receiver<()>,
}

fn start_cycle<N>(parts: CycleParts<N>, wishes: Wishes) -> anyhow::Result<RunningCycle>
where
    N: Node + Send + 'static,
{
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    let (now_running, running) = oneshot::channel();
    let (ending, ended) = oneshot::channel();
    let thread = thread("cycle", move || {
        let _ending = ending;
        let denied = real_time::apply(&wishes.real_time);
        // A thread that nobody waits for any more may still run.
        let _ = now_running.send(denied);
        let cycle = Cycle {
            node: parts.node,
            clock: NodeClock::starting_soon(&wishes.clock, wishes.seed),
            mailboxes: parts.mailboxes,
            desk: parts.desk,
            outbox: parts.outbox,
            telemetry: parts.telemetry,
            arrivals: parts.arrivals,
            counters: parts.counters,
        };
        let limits = Limits {
            run_for: wishes.run_for,
            spin: Span::from_micros(i64::from(wishes.real_time.spin_us)),
        };
        cycle.run(&limits, &stopped);
    })?;
    Ok(RunningCycle {
        thread,
        stop,
        running,
        ended,
    })
}

fn outcome(ended: Ended, epoch: u64, counters: &Counters) -> Outcome {
    Outcome {
        ended,
        epoch,
        cycles: read(&counters.cycles),
        published: read(&counters.published),
        not_published: read(&counters.publish_dropped) + read(&counters.publish_failed),
        received: read(&counters.received),
        refused: read(&counters.refused),
        mailbox_dropped: read(&counters.mailbox_dropped),
        telemetry_dropped: read(&counters.telemetry_dropped),
        arrivals_dropped: read(&counters.arrivals_dropped),
    }
}

fn thread<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> T + Send + 'static,
) -> anyhow::Result<JoinHandle<T>> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .with_context(|| format!("cannot start the {name} thread"))
}

fn joined<T>(name: &str, thread: JoinHandle<T>) -> anyhow::Result<T> {
    thread
        .join()
        .map_err(|_| anyhow!("the {name} thread panicked"))
}

/// The signals that end a run.
struct Signals {
    interrupt: Signal,
    terminate: Signal,
}

impl Signals {
    fn listen() -> anyhow::Result<Self> {
        let listen = |kind| signal(kind).context("cannot listen for signals");
        Ok(Self {
            interrupt: listen(SignalKind::interrupt())?,
            terminate: listen(SignalKind::terminate())?,
        })
    }

    async fn next(&mut self) -> Ended {
        tokio::select! {
            _ = self.interrupt.recv() => Ended::Interrupted,
            _ = self.terminate.recv() => Ended::Terminated,
        }
    }
}
