//! Bare loops over the network, without a node: a lower bound for every node.

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context, anyhow};
use coaxle_clock::{Instant, Span};
use coaxle_host::machine::real_time;
use coaxle_host::network::transport::{OverZenoh, Transport, Urgency};
use coaxle_node::config::{RealTimeConfig, TransportConfig};
use coaxle_os::{Interrupt, Machine, machine};

use super::report_ready;
use crate::bench::plan::{AgeSample, LoopPace, MessageArrival, PeerReport};

const KEY: &str = "coaxle/bench/raw";

/// Longest wait for a datagram, or for the end, between checks.
// An end is noticed within it; shorter ones would wake a thread that only waits, beside the measured ones.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// The longest datagram.
// The length field of UDP has 16 bits.
const MOST_BYTES: usize = 65_536;

/// Sends to a socket that may not be there yet.
pub(super) fn send_datagrams(
    to: SocketAddr,
    pace: &LoopPace,
    limit: Span,
) -> anyhow::Result<PeerReport> {
    let any = if to.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
    let socket = UdpSocket::bind(any).context("cannot open a socket")?;
    run_loop(pace, limit, |bytes| match socket.send_to(bytes, to) {
        // No receiver listens there yet, or the network is full.
        Err(error) if is_passing(error.kind()) => Ok(()),
        sent => sent.map(drop).context("cannot send a datagram"),
    })
}

fn is_passing(error: ErrorKind) -> bool {
    matches!(
        error,
        ErrorKind::ConnectionRefused | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

/// Publishes as a node does, but from the loop itself.
pub(super) fn publish(
    transport: &TransportConfig,
    pace: &LoopPace,
    limit: Span,
) -> anyhow::Result<PeerReport> {
    let session = open(transport, &pace.real_time)?;
    // The quality of service of a node's frames, or the comparison would be of two priorities.
    let publisher = session.publisher(KEY, Urgency::RealTime)?;
    let report = run_loop(pace, limit, |bytes| publisher.publish(bytes.to_vec()));
    session.close();
    report
}

/// A loop of its own cycle that sends a message each time, until it is ended.
fn run_loop(
    pace: &LoopPace,
    limit: Span,
    mut send: impl FnMut(&[u8]) -> anyhow::Result<()>,
) -> anyhow::Result<PeerReport> {
    let until = EndCondition::after(limit)?;
    report_ready()?;
    let denied = real_time::apply(&pace.real_time);
    let (cycle, spin) = (Span::from_nanos(pace.cycle_ns), spin(&pace.real_time));
    let mut message = vec![0; pace.bytes.max(MessageArrival::BYTES)];
    let mut due = machine::now();
    let mut count = 0;
    while !until.is_over() {
        due += cycle;
        machine::sleep_then_spin_until(due, spin);
        let woke = machine::now();
        // Skips missed cycles, as a node does.
        due += cycle * (woke - due).div_floor(cycle);
        count += 1;
        // Before the send, because the stamp travels in the message.
        let left = machine::now();
        MessageArrival::write(count, woke.as_nanos(), left.as_nanos(), &mut message);
        send(&message)?;
    }
    Ok(PeerReport {
        denied: denied.iter().map(ToString::to_string).collect(),
        ..PeerReport::default()
    })
}

fn spin(real_time: &RealTimeConfig) -> Span {
    Span::from_micros(i64::from(real_time.spin_us))
}

/// Receives on a thread of its own. A loop beside it samples the newest message's age, if requested.
pub(super) fn receive_datagrams(
    at: SocketAddr,
    looks: Option<&LoopPace>,
    limit: Span,
) -> anyhow::Result<PeerReport> {
    let until = EndCondition::after(limit)?;
    let socket = UdpSocket::bind(at).with_context(|| format!("cannot listen on {at}"))?;
    socket
        .set_read_timeout(Some(POLL_INTERVAL))
        .context("cannot listen")?;
    let seen = Arc::new(BenchInbox::default());
    let (stop, into) = (Arc::new(AtomicBool::new(false)), Arc::clone(&seen));
    let stopped = Arc::clone(&stop);
    let receiving = move || -> anyhow::Result<()> {
        let mut bytes = vec![0; MOST_BYTES];
        while !stopped.load(Ordering::Relaxed) {
            match socket.recv(&mut bytes) {
                Ok(length) => into.take(machine::now(), &bytes[..length]),
                // A read that timed out is `WouldBlock` on Linux and `TimedOut` elsewhere.
                Err(error) if is_passing(error.kind()) || error.kind() == ErrorKind::TimedOut => {}
                Err(error) => return Err(error).context("cannot receive datagrams"),
            }
        }
        Ok(())
    };
    let thread = std::thread::Builder::new().name("receive".to_owned());
    let thread = thread
        .spawn(receiving)
        .context("cannot start the receiving thread")?;
    report_ready()?;
    let ages = sample_ages(looks, &seen, &until);
    stop.store(true, Ordering::Relaxed);
    let received = thread.join();
    received.map_err(|_| anyhow!("the receiving thread panicked"))??;
    Ok(report_of(&seen, ages))
}

/// Receives messages of a Zenoh session likewise.
pub(super) fn subscribe(
    transport: &TransportConfig,
    real_time: &RealTimeConfig,
    looks: Option<&LoopPace>,
    limit: Span,
) -> anyhow::Result<PeerReport> {
    let until = EndCondition::after(limit)?;
    let session = open(transport, real_time)?;
    let seen = Arc::new(BenchInbox::default());
    let into = Arc::clone(&seen);
    let subscribed = session.subscribe(KEY, Box::new(move |at, bytes| into.take(at, bytes)))?;
    report_ready()?;
    let ages = sample_ages(looks, &seen, &until);
    drop(subscribed);
    session.close();
    Ok(report_of(&seen, ages))
}

/// A session with a node's priority, which its threads inherit.
fn open(transport: &TransportConfig, wishes: &RealTimeConfig) -> anyhow::Result<OverZenoh> {
    let (transport, carriers) = (transport.clone(), real_time::carriers(wishes));
    let opening = move || {
        let wishes = RealTimeConfig {
            priority: carriers,
            ..RealTimeConfig::default()
        };
        // The loop itself reports denied requests.
        let _ = real_time::apply(&wishes);
        OverZenoh::open_and_wait(&transport)
    };
    // On a thread of its own, since the priority would stay with the calling thread.
    let opened = std::thread::spawn(opening).join();
    opened.map_err(|_| anyhow!("the Zenoh session panicked"))?
}

/// Received messages.
#[derive(Default)]
struct BenchInbox {
    messages: Mutex<Vec<MessageArrival>>,
    /// Wake-up of the loop that sent the newest; 0 before the first.
    newest: AtomicI64,
}

impl BenchInbox {
    fn take(&self, arrived: Instant<Machine>, bytes: &[u8]) {
        let Some(message) = MessageArrival::read(arrived.as_nanos(), bytes) else {
            return;
        };
        // The maximum: a message that was overtaken makes the data no older.
        self.newest.fetch_max(message.woke, Ordering::Relaxed);
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages.push(message);
    }
}

fn report_of(seen: &BenchInbox, looks: Vec<AgeSample>) -> PeerReport {
    let mut messages = seen.messages.lock().unwrap_or_else(PoisonError::into_inner);
    PeerReport {
        messages: std::mem::take(&mut *messages),
        looks,
        ..PeerReport::default()
    }
}

/// Waits for the end. Samples the newest message's age once a cycle meanwhile, if requested.
fn sample_ages(pace: Option<&LoopPace>, seen: &BenchInbox, until: &EndCondition) -> Vec<AgeSample> {
    let mut looks = Vec::new();
    let Some(pace) = pace else {
        while !until.is_over() {
            std::thread::park_timeout(POLL_INTERVAL);
        }
        return looks;
    };
    // The sender reports denied requests.
    // A loop that samples late would see older messages than a node's cycle does.
    let _ = real_time::apply(&pace.real_time);
    let cycle = Span::from_nanos(pace.cycle_ns);
    let mut due = machine::now();
    while !until.is_over() {
        due += cycle;
        machine::sleep_until(due);
        let at = machine::now().as_nanos();
        let newest = seen.newest.load(Ordering::Relaxed);
        // Before the first message there is no age: 0 would read as the age of the machine.
        if newest > 0 {
            let age = at - newest;
            looks.push(AgeSample { at, age });
        }
    }
    looks
}

/// End of a process.
struct EndCondition {
    interrupt: Interrupt,
    limit: Instant<Machine>,
}

impl EndCondition {
    fn after(limit: Span) -> anyhow::Result<Self> {
        Ok(Self {
            interrupt: Interrupt::listen()?,
            limit: machine::now() + limit,
        })
    }

    fn is_over(&self) -> bool {
        self.interrupt.is_received() || machine::now() >= self.limit
    }
}
