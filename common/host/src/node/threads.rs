//! The threads of a node, each with the data it owns.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use coaxle_clock::Span;
use coaxle_node::Node;
use coaxle_node::config::RealTimeConfig;
use coaxle_os::machine;
use tokio::sync::oneshot;

use crate::machine::real_time;
use crate::node::commands::CommandServer;
use crate::node::counters::Counters;
use crate::node::cycle::{Cycle, Limits, NodeClock};
use crate::node::outbox::OutgoingFrames;
use crate::node::panics::PanicWatch;
use crate::node::publisher::{PublishedChannel, publish};
use crate::node::status::Reporter;
use crate::node::telemetry::{Recorder, Telemetry, observe};
use crate::node::timing::{BeaconReceiver, BeaconSender, Socket};

/// Starts the thread that responds to requests.
pub(crate) fn start_server(
    server: CommandServer,
    panics: &PanicWatch,
) -> anyhow::Result<JoinHandle<()>> {
    thread("command", panics, move || server.work())
}

/// Starts the thread that publishes frames.
pub(crate) fn start_publisher(
    frames: OutgoingFrames,
    send_stamps: bool,
    mut channels: Vec<PublishedChannel>,
    beacons: Option<BeaconSender<Socket>>,
    counters: &Arc<Counters>,
    priority: Option<u8>,
    panics: &PanicWatch,
) -> anyhow::Result<JoinHandle<()>> {
    let counters = Arc::clone(counters);
    thread("publish", panics, move || {
        // Above the telemetry and the log, below the cycle.
        real_time::raise(priority);
        publish(frames, &mut channels, beacons, send_stamps, &counters);
    })
}

/// Starts the thread that keeps records and publishes the status.
pub(crate) fn start_telemetry<S: Send + 'static>(
    telemetry: Telemetry<S>,
    mut recorder: Box<dyn Recorder<S>>,
    mut reporter: Reporter,
    panics: &PanicWatch,
) -> anyhow::Result<JoinHandle<anyhow::Result<()>>> {
    thread("telemetry", panics, move || {
        observe(telemetry, recorder.as_mut(), &mut reporter)
    })
}

/// The thread that receives beacons, with its stop flag.
pub(crate) struct RunningBeacons {
    pub(crate) thread: JoinHandle<()>,
    pub(crate) stop: Arc<AtomicBool>,
}

pub(crate) fn start_beacons(
    mut receiver: BeaconReceiver<Socket>,
    priority: Option<u8>,
    panics: &PanicWatch,
) -> anyhow::Result<RunningBeacons> {
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    let thread = thread("timing", panics, move || {
        // Arrival stamps are the kernel's, but a response should be in the next cycle.
        real_time::raise(priority);
        receiver.work(&stopped);
    })?;
    Ok(RunningBeacons { thread, stop })
}

/// Settings for running the cycle.
pub(crate) struct Wishes {
    pub(crate) real_time: RealTimeConfig,
    pub(crate) clock: NodeClock,
    pub(crate) run_for: Option<Span>,
}

/// The cycle thread as the host holds it.
pub(crate) struct RunningCycle {
    pub(crate) thread: JoinHandle<()>,
    pub(crate) stop: Arc<AtomicBool>,
    /// Sent once before the first cycle, with the settings that the operating system did not grant.
    pub(crate) running: oneshot::Receiver<Vec<real_time::Denied>>,
    /// Closes when the thread ends, even by a panic.
    pub(crate) ended: oneshot::Receiver<()>,
}

/// Starts the cycle thread, which builds the cycle with its clock: the clock starts there.
pub(crate) fn start_cycle<N: Node>(
    with_clock: impl FnOnce(NodeClock) -> Cycle<N> + Send + 'static,
    wishes: Wishes,
    panics: &PanicWatch,
) -> anyhow::Result<RunningCycle> {
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    let (now_running, running) = oneshot::channel();
    let (ending, ended) = oneshot::channel();
    let thread = thread("cycle", panics, move || {
        // Dropped by a panic as well: the host learns of either end by the closed channel.
        let _ending = ending;
        // On the thread itself: priority and processor are attributes of a thread.
        let denied = real_time::apply(&wishes.real_time);
        // The receiver may be gone while the thread still runs.
        let _ = now_running.send(denied);
        // As late as possible: cycles that passed while threads started would count as missed.
        let cycle = with_clock(wishes.clock.starting_soon());
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

fn thread<T: Send + 'static>(
    name: &'static str,
    panics: &PanicWatch,
    work: impl FnOnce() -> T + Send + 'static,
) -> anyhow::Result<JoinHandle<T>> {
    let panics = panics.clone();
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(move || {
            // Held to the end of the work, so that a panic is reported under this name.
            let _watched = panics.over(name);
            work()
        })
        .with_context(|| format!("cannot start the {name} thread"))
}

/// Longest time for a thread to end: one that writes to a file without a reader would keep the node
/// from ending.
// Far more than a disk stalls, and less than the 90 s after which systemd kills a service.
const JOIN_TIMEOUT: Span = Span::from_secs(5);
/// Interval between checks for the end.
// Polled, since `join` of the standard library has no timeout.
const JOIN_CHECK_INTERVAL: Duration = Duration::from_millis(2);

/// Waits for a thread that was requested to end, and returns its result.
///
/// # Errors
/// The thread panicked, with its message; or it does not end.
pub(crate) async fn joined<T>(name: &str, thread: JoinHandle<T>) -> anyhow::Result<T> {
    let asked = machine::now();
    while !thread.is_finished() {
        if machine::now() - asked > JOIN_TIMEOUT {
            bail!("the {name} thread did not end within {JOIN_TIMEOUT}");
        }
        tokio::time::sleep(JOIN_CHECK_INTERVAL).await;
    }
    thread
        .join()
        .map_err(|panic| anyhow!("the {name} thread panicked: {}", what_it_said(&*panic)))
}

fn what_it_said(panic: &(dyn Any + Send)) -> &str {
    // `panic!` has a `&str` without arguments, and a `String` with them.
    let text = panic.downcast_ref::<&str>().copied();
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    text.or(owned).unwrap_or("it did not say why")
}
