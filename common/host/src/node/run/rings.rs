//! The rings between the cycle thread and the others, which are all sized at the start.

use std::sync::Arc;
use std::thread::JoinHandle;

use coaxle_node::Node;
use coaxle_node::frame::MAX_AXES;
use coaxle_node::wiring::Subscription;
use rtrb::{Producer, RingBuffer};

use super::{RunContext, Setup};
use crate::files::inputs::{InputTap, inputs};
use crate::node::circles::CircleNames;
use crate::node::commands::{OrderQueue, RequestSender, commands};
use crate::node::counters::Counters;
use crate::node::mailbox::{Inbox, Mailbox, mailbox, mailbox_bytes};
use crate::node::outbox::{Outbox, OutgoingFrames, outbox};
use crate::node::telemetry::{ArrivalRecord, Records, Telemetry, telemetry};
use crate::node::threads::start_server;

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

/// The rings of a node, by who holds their ends.
pub(super) struct Rings<S> {
    pub(super) cycle: CycleEnds<S>,
    pub(super) incoming: IncomingEnds,
    pub(super) outgoing: OutgoingEnds<S>,
}

/// The ends of the cycle thread.
pub(super) struct CycleEnds<S> {
    pub(super) mailboxes: Vec<Mailbox>,
    pub(super) orders: OrderQueue,
    pub(super) outbox: Outbox,
    pub(super) records: Records<S>,
    pub(super) arrivals: Producer<ArrivalRecord>,
    pub(super) inputs: Option<InputTap>,
}

/// The ends that messages are put into.
pub(super) struct IncomingEnds {
    pub(super) inboxes: Vec<Inbox>,
    pub(super) requests: RequestSender,
    pub(super) circle_names: CircleNames,
}

/// The ends of the threads that take from the cycle thread; the command server runs already.
pub(super) struct OutgoingEnds<S> {
    pub(super) server: JoinHandle<()>,
    pub(super) frames: OutgoingFrames,
    pub(super) telemetry: Telemetry<S>,
}

/// Creates the rings, and starts the command server between two of them.
pub(super) fn open_rings<N: Node>(
    node: &N,
    setup: &Setup<N>,
    run: &RunContext,
) -> anyhow::Result<Rings<N::Snapshot>> {
    let (inboxes, mailboxes) = mailboxes(&setup.wiring.subscriptions, &run.counters);
    let (outbox, frames) = outbox(OUTBOX_BYTES);
    let (arrivals, arrived) = RingBuffer::new(ARRIVAL_RECORDS);
    // Sized by the snapshot: a node of many axes keeps fewer records in the same memory.
    let (records, mut telemetry) = telemetry(node.snapshot(), node.snapshot_size(), arrived);
    // Copies of all messages cost memory and time: only a recording has a use for them.
    let (inputs, recorded) = setup.recorder.wants_inputs().then(inputs).unzip();
    telemetry.attach(recorded);
    let (mut orders, server, mut requests) = commands(&setup.name, &run.audit);
    let circle_names = server.circles();
    // Started before the rings have both ends: the others wake this thread by its handle.
    let server = start_server(server, &run.panics)?;
    orders.attach(server.thread().clone());
    requests.attach(server.thread().clone());
    Ok(Rings {
        cycle: CycleEnds {
            mailboxes,
            orders,
            outbox,
            records,
            arrivals,
            inputs,
        },
        incoming: IncomingEnds {
            inboxes,
            requests,
            circle_names,
        },
        outgoing: OutgoingEnds {
            server,
            frames,
            telemetry,
        },
    })
}

/// Memory of the rings, bytes.
pub(super) fn memory_of(subscriptions: &[Subscription]) -> usize {
    let mailboxes = subscriptions.iter().map(|subscription| {
        let (messages, axes) = places(subscription);
        mailbox_bytes(messages, axes)
    });
    OUTBOX_BYTES + mailboxes.sum::<usize>()
}

/// Creates a mailbox for each subscription: each is filled by one thread only.
fn mailboxes(subscriptions: &[Subscription], counters: &Counters) -> (Vec<Inbox>, Vec<Mailbox>) {
    let mailbox = |subscription: &Subscription| {
        let (messages, axes) = places(subscription);
        mailbox(messages, axes, Arc::clone(&counters.mailbox_dropped))
    };
    subscriptions.iter().map(mailbox).unzip()
}

/// Places of the messages of a subscription, and of the axes in them.
fn places(subscription: &Subscription) -> (usize, usize) {
    match subscription.reader.axes() {
        // Time requests carry no axes, and come ten times a second instead of a thousand.
        0 => (MAILBOX_EXCHANGES, 0),
        // Few axes: as many places as all messages could fill.
        axes => (MAILBOX_MESSAGES, MAILBOX_AXES.min(MAILBOX_MESSAGES * axes)),
    }
}
