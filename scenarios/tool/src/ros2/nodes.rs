//! The side of Coaxle: the nodes that are there, and their frames.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use coaxle_clock::{Instant, Local, Span};
use coaxle_host::client::Watcher;
use coaxle_host::network::transport::{Declared, Transport};
use coaxle_node::keys::NodeName;
use coaxle_os::Machine;
use coaxle_ros::message::JointState;
use coaxle_ros::source::{PublishedValues, SlaveMotion};
use coaxle_ros::trajectory::Address;

use super::followed::{CHANNELS, FollowedNode};
use super::local;

/// Most frames that wait: one without room is dropped, and the next one is newer.
// A second of one node at 1 kHz; the loop takes frames every 10 ms.
const MOST_WAITING: usize = 1024;
/// Most nodes followed: a publisher could invent more.
const MOST_NODES: usize = 1000;

/// A received frame with its node.
struct ReceivedFrame {
    node: usize,
    channel: usize,
    came: Instant<Machine>,
    payload: Vec<u8>,
}

/// The nodes that are followed.
pub(super) struct BridgedNodes {
    watcher: Watcher,
    followed: Vec<FollowedNode>,
    queue: SyncSender<ReceivedFrame>,
    received: Receiver<ReceivedFrame>,
    declared: Vec<Declared>,
    is_full: bool,
}

impl BridgedNodes {
    pub(super) fn new(watcher: Watcher) -> Self {
        let (queue, received) = sync_channel(MOST_WAITING);
        Self {
            watcher,
            followed: Vec::new(),
            queue,
            received,
            declared: Vec::new(),
            is_full: false,
        }
    }

    /// Follows each node that publishes a status, and reads it.
    pub(super) fn refresh(&mut self) {
        for seen in self.watcher.seen() {
            // Without a status there are no names of axes.
            if seen.status.is_none() {
                continue;
            }
            let known = self.followed.iter().position(|node| node.name == seen.name);
            if let Some(node) = known.or_else(|| self.follow(&seen.name)) {
                self.followed[node].refresh(&seen);
            }
        }
    }

    /// Logs that no node is there.
    pub(super) fn log_absence(&self, timeout: Span) {
        if self.followed.is_empty() {
            let place = self.watcher.whereabouts();
            tracing::warn!("no node is there after {timeout}, {place}; it is waited for");
        }
    }

    /// Takes the received frames; waits up to `wait` for the first one.
    pub(super) fn receive(&mut self, wait: Duration) {
        let first = self.received.recv_timeout(wait).ok();
        // Bounded: frames that come faster than they are taken must not keep the loop from its other work.
        let rest = self.received.try_iter().take(MOST_WAITING);
        for received in first.into_iter().chain(rest) {
            let node = &mut self.followed[received.node];
            node.frame(received.channel, local(received.came), &received.payload);
        }
    }

    /// Joint states of all axes received since the last call.
    pub(super) fn joint_states(
        &mut self,
        now: Instant<Local>,
        values: PublishedValues,
        unix: Span,
    ) -> impl Iterator<Item = JointState> {
        let nodes = self.followed.iter_mut();
        nodes.flat_map(move |node| node.joint_states(now, values, unix))
    }

    /// The slaves that take orders.
    pub(super) fn addresses(&self, now: Instant<Local>) -> Vec<Address> {
        let nodes = self.followed.iter();
        nodes.flat_map(|node| node.addresses(now)).collect()
    }

    /// Motion of a slave, if its frames are recent.
    pub(super) fn motion(&self, address: &Address, now: Instant<Local>) -> Option<SlaveMotion> {
        let node = self
            .followed
            .iter()
            .find(|node| node.name == address.node)?;
        node.motion(address.axis_id, now)
    }

    /// Follows a node. Returns its index.
    fn follow(&mut self, name: &NodeName) -> Option<usize> {
        if self.followed.len() == MOST_NODES {
            // Once, as the refresh tries again four times a second.
            if !std::mem::replace(&mut self.is_full, true) {
                tracing::warn!("{name} and others are left out: {MOST_NODES} nodes are followed");
            }
            return None;
        }
        let node = self.followed.len();
        self.followed.push(FollowedNode::new(name));
        match self.subscribe(name, node) {
            Ok(declared) => self.declared.extend(declared),
            // The node stays in the list, so that the attempt is not repeated with each refresh.
            Err(error) => tracing::warn!("{name}: {error:#}"),
        }
        tracing::info!("{name} is there");
        Some(node)
    }

    fn subscribe(&self, name: &NodeName, node: usize) -> anyhow::Result<Vec<Declared>> {
        let transport: &Arc<dyn Transport> = self.watcher.transport();
        let channels = CHANNELS.iter().enumerate();
        let subscribe = |(channel, of): (usize, &coaxle_node::Channel)| {
            let queue = self.queue.clone();
            let on_bytes = move |came, payload: &[u8]| {
                let payload = payload.to_vec();
                // Called on a thread of Zenoh, which must not wait.
                let _ = queue.try_send(ReceivedFrame {
                    node,
                    channel,
                    came,
                    payload,
                });
            };
            transport.subscribe(&name.channel_key(*of), Box::new(on_bytes))
        };
        channels.map(subscribe).collect()
    }
}
