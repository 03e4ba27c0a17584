//! The nodes of the network: their statuses and rows into the address space.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_host::client::Watcher;
use coaxle_host::network::transport::Declared;
use coaxle_node::keys::NodeName;
use coaxle_os::Interrupt;
use coaxle_os::machine::{self, Machine};
use opcua::types::{ByteString, DataValue, LocalizedText, NodeId, ObjectTypeId, UAString};

use super::certificates::prune_rejected;
use super::followed::ShownNode;
use super::server::RunningServer;
use super::space::{AddedNodes, SpaceWriter};
use crate::config::OpcuaConfig;
use crate::occurrence::Occurrence;
use crate::rows::newest_cycle;

/// Most pieces that wait: one without room is dropped, and the next one is newer.
const MOST_WAITING: usize = 256;
/// Most nodes shown: a publisher could invent more.
const MOST_NODES: usize = 1000;
/// Interval of reading statuses, which nodes publish at this interval.
const REFRESH_PERIOD: Span = Span::from_millis(250);
/// Longest wait between checks for the end.
const LONGEST_WAIT: Duration = Duration::from_millis(20);
/// Time after which missing nodes are logged.
const ABSENCE_TIMEOUT: Span = Span::from_secs(5);

/// Node by its place, and a piece of its rows.
type QueuedPiece = (usize, Vec<u8>);

/// The nodes that clients see.
pub(super) struct ShownNodes {
    watcher: Watcher,
    /// The nodes to show; all if empty.
    wanted: Vec<NodeName>,
    server: RunningServer,
    space: SpaceWriter,
    followed: Vec<ShownNode>,
    /// Ids in the address space of each of them.
    added: Vec<Vec<NodeId>>,
    queue: SyncSender<QueuedPiece>,
    pieces: Receiver<QueuedPiece>,
    declared: Vec<Declared>,
    /// Number of events, for their ids.
    events: u64,
    /// Folder of the certificates, if there is one.
    certificates: Option<PathBuf>,
}

impl ShownNodes {
    pub(super) fn new(watcher: Watcher, config: &OpcuaConfig, server: RunningServer) -> Self {
        let (queue, pieces) = sync_channel(MOST_WAITING);
        let space = SpaceWriter::new(server.namespace());
        space.add_root(&mut server.objects().address_space().write());
        Self {
            watcher,
            wanted: config.nodes.clone(),
            server,
            space,
            followed: Vec::new(),
            added: Vec::new(),
            queue,
            pieces,
            declared: Vec::new(),
            events: 0,
            certificates: config.endpoint.certificates.clone(),
        }
    }

    /// Shows the nodes until the interrupt, or for a time.
    pub(super) fn run(&mut self, interrupt: &Interrupt, run_for: Option<Span>) {
        let began = machine::now();
        let mut next_refresh = began;
        let mut is_absence_logged = false;
        while !interrupt.is_received() {
            let now = machine::now();
            if run_for.is_some_and(|span| now - began >= span) {
                return;
            }
            if now >= next_refresh {
                next_refresh = now + REFRESH_PERIOD;
                self.refresh(now);
            }
            if !is_absence_logged && now - began > ABSENCE_TIMEOUT {
                is_absence_logged = true;
                self.log_absence();
            }
            self.take_pieces();
        }
    }

    fn refresh(&mut self, now: Instant<Machine>) {
        let unix_ns = machine::wall_clock_offset_ns();
        for seen in self.watcher.seen() {
            if !self.wanted.is_empty() && !self.wanted.contains(&seen.name) {
                continue;
            }
            let known = self.followed.iter().position(|node| node.name == seen.name);
            let Some(node) = known.or_else(|| self.follow(&seen.name)) else {
                continue;
            };
            let space = &self.space;
            let (values, events) =
                self.followed[node].take_status(&seen, unix_ns, |path| space.id(path));
            self.publish(&values);
            for event in events {
                self.publish_event(&event);
            }
        }
        if let Some(folder) = &self.certificates {
            prune_rejected(folder);
        }
        for node in 0..self.followed.len() {
            let old = self.followed[node].grow_old(now);
            self.publish(&old);
        }
    }

    fn take_pieces(&mut self) {
        let first = self.pieces.recv_timeout(LONGEST_WAIT).ok();
        // Bounded: pieces that come faster than they are taken must not keep the loop from its other work.
        let rest: Vec<_> = self.pieces.try_iter().take(MOST_WAITING).collect();
        for (node, piece) in first.into_iter().chain(rest) {
            let Some(cycle) = newest_cycle(&piece) else {
                continue;
            };
            if !self.followed[node].has_table(&cycle.table) {
                self.show(node, |followed| followed.take_table(cycle.table.clone()));
            }
            let space = &self.space;
            let now = machine::now();
            let values = self.followed[node].take_values(now, &cycle, |path| space.id(path));
            self.publish(&values);
        }
    }

    /// Shows and subscribes to a node. Returns its place.
    fn follow(&mut self, name: &NodeName) -> Option<usize> {
        if self.followed.len() == MOST_NODES {
            return None;
        }
        let node = self.followed.len();
        self.followed.push(ShownNode::new(name.clone()));
        self.added.push(Vec::new());
        self.show(node, |_| ());
        let queue = self.queue.clone();
        let on_piece = move |_, piece: &[u8]| {
            // Called on a thread of Zenoh, which must not wait.
            let _ = queue.try_send((node, piece.to_vec()));
        };
        let transport = Arc::clone(self.watcher.transport());
        match transport.subscribe(&name.rows_key(), Box::new(on_piece)) {
            Ok(declared) => self.declared.push(declared),
            Err(error) => tracing::warn!("{name}: {error:#}"),
        }
        tracing::info!("{name} is there");
        Some(node)
    }

    /// Changes the objects of a node: those that it has no longer go.
    fn show(&mut self, node: usize, change: impl FnOnce(&mut ShownNode)) {
        let followed = &mut self.followed[node];
        change(followed);
        let objects = self.server.objects();
        let mut space = objects.address_space().write();
        let mut targets = objects.inner().targets.write();
        for id in std::mem::take(&mut self.added[node]) {
            targets.remove(&id);
            space.delete(&id, true);
        }
        let mut added = AddedNodes::default();
        for part in followed.parts() {
            (self.space).add(&mut space, &followed.name, part, &mut added);
        }
        targets.extend(added.targets);
        self.added[node] = added.ids;
    }

    fn publish(&self, values: &[(NodeId, DataValue)]) {
        if values.is_empty() {
            return;
        }
        let values = values.iter();
        let values = values.map(|(id, value)| (id, None, value.clone()));
        let set = (self.server.objects()).set_values(self.server.subscriptions(), values);
        if let Err(status) = set {
            tracing::debug!("values are not shown: {status}");
        }
    }

    fn publish_event(&mut self, event: &Occurrence) {
        self.events += 1;
        tracing::info!("{}", event.message);
        let source = self.space.id(&event.path);
        let message = LocalizedText::from(event.message.as_str());
        let id = ByteString::from(self.events.to_be_bytes().to_vec());
        let base = opcua::nodes::BaseEventType::new_now(ObjectTypeId::BaseEventType, id, message)
            .set_source_node(source.clone())
            .set_source_name(UAString::from(event.path.as_str()))
            .set_severity(event.severity);
        let event: &dyn opcua::nodes::Event = &base;
        // The library passes it on to who listens at the server.
        let events = std::iter::once((event, &source));
        self.server.subscriptions().notify_events(events);
    }

    /// Logs that no node is there.
    fn log_absence(&self) {
        if self.followed.is_empty() {
            let place = self.watcher.whereabouts();
            tracing::warn!("no node is there after {ABSENCE_TIMEOUT}, {place}; it is waited for");
        }
    }
}
