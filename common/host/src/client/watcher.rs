//! Watching nodes from outside: their presence and their status.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::{ANY_ALIVE_KEY, ANY_STATUS_KEY, NodeName};
use coaxle_os::machine::{self, Machine};
use serde_json::{Map, Value};

use crate::client::search::LongWait;
use crate::client::session::session;
use crate::network::transport::{Declared, InvisibilityReason, Transport};

/// Longest status accepted, bytes: that of a node with thousands of axes.
// 4 KiB of JSON for each of 4096 axes.
const LONGEST_STATUS: usize = 16 << 20;
/// Greatest number of nodes kept: a malicious publisher could invent more.
const MOST_NODES: usize = 10_000;

/// Watches nodes and reads their status, without any effect on them.
pub struct Watcher {
    transport: Arc<dyn Transport>,
    /// The watched nodes in words.
    sought: String,
    seen: Arc<Seen>,
    _declared: Vec<Declared>,
}

/// A node seen from outside.
#[derive(Clone, Debug)]
pub struct SeenNode {
    /// Name of the node.
    pub name: NodeName,
    /// True if it has announced itself.
    pub is_alive: bool,
    /// The newest status and its arrival.
    pub status: Option<(Instant<Machine>, Map<String, Value>)>,
}

#[derive(Default)]
struct Seen {
    nodes: Mutex<BTreeMap<NodeName, SeenNode>>,
    changed: Condvar,
}

impl Seen {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<NodeName, SeenNode>> {
        // A map of plain values is whole between two statements: a panic elsewhere leaves it usable.
        self.nodes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Updates the node that a key names.
    fn note(&self, key: &str, what: impl FnOnce(&mut SeenNode)) {
        // A key of another layout is of another program on the network.
        let Some(name) = NodeName::of_key(key) else {
            return;
        };
        let mut nodes = self.lock();
        // Known nodes are still updated when the map is full: only new names are refused.
        if nodes.len() >= MOST_NODES && !nodes.contains_key(&name) {
            return;
        }
        what(nodes.entry(name.clone()).or_insert(SeenNode {
            name,
            is_alive: false,
            status: None,
        }));
        // Unlocked first: a woken thread would otherwise wait for this very lock.
        drop(nodes);
        self.changed.notify_all();
    }
}

impl Watcher {
    /// Joins the network and watches these nodes, or all if none is named.
    ///
    /// # Errors
    /// A wrong transport section, certificates that cannot be read, or a session that cannot be opened, with the
    /// endpoints.
    pub fn open(transport: &TransportConfig, nodes: &[NodeName]) -> anyhow::Result<Self> {
        Self::over(Arc::new(session(transport)?), nodes)
    }

    /// Watches nodes over an existing transport.
    ///
    /// # Errors
    /// The transport refuses.
    pub fn over(transport: Arc<dyn Transport>, nodes: &[NodeName]) -> anyhow::Result<Self> {
        let keys = |node: &NodeName| (node.status_key(), node.alive_key());
        let keys: Vec<_> = match nodes {
            // Subscriptions with a wildcard, since the names are not known.
            [] => vec![(ANY_STATUS_KEY.to_owned(), ANY_ALIVE_KEY.to_owned())],
            nodes => nodes.iter().map(keys).collect(),
        };
        let seen = Arc::new(Seen::default());
        let mut declared = Vec::new();
        for (status, alive) in keys {
            let (heard, present) = (Arc::clone(&seen), Arc::clone(&seen));
            let on_status = move |at, bytes: &[u8]| take_status(&heard, at, bytes);
            declared.push(transport.subscribe(&status, Box::new(on_status))?);
            let on_change =
                move |key: &str, is_alive| present.note(key, |node| node.is_alive = is_alive);
            declared.push(transport.watch(&alive, Box::new(on_change))?);
        }
        Ok(Self {
            transport,
            sought: sought(nodes),
            seen,
            _declared: declared,
        })
    }

    /// The nodes seen since the start, by name.
    #[must_use]
    pub fn seen(&self) -> Vec<SeenNode> {
        self.seen.lock().values().cloned().collect()
    }

    /// Waits until the seen nodes are `enough`, or until the timeout; returns the nodes seen then.
    #[must_use]
    pub fn wait_for(
        &self,
        patience: Span,
        mut enough: impl FnMut(&[SeenNode]) -> bool,
    ) -> Vec<SeenNode> {
        let end = machine::now() + patience;
        let mut long_wait = LongWait::begin();
        let mut nodes = self.seen.lock();
        loop {
            // The condition is checked before each wait: a notification before the first wait is not lost.
            let seen: Vec<_> = nodes.values().cloned().collect();
            let left = end - machine::now();
            // The timeout is checked first, so that a machine without progress still returns.
            if left <= Span::ZERO || enough(&seen) {
                return seen;
            }
            long_wait.say(&self.sought, self.whereabouts());
            // Awake in time for the line.
            let left = long_wait.left().map_or(left, |line| line.min(left));
            let left = Duration::from_nanos(left.as_nanos().unsigned_abs());
            let waited = self.seen.changed.wait_timeout(nodes, left);
            nodes = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Finds out why a node is not visible, by trying to reach it. Takes some seconds.
    #[must_use]
    pub fn invisibility_reason(&self, node: &NodeName) -> Option<InvisibilityReason> {
        self.transport.invisibility_reason(node.as_str())
    }

    /// The transport, for other uses.
    #[must_use]
    pub const fn transport(&self) -> &Arc<dyn Transport> {
        &self.transport
    }

    /// Endpoints of the transport, for messages.
    #[must_use]
    pub fn whereabouts(&self) -> &str {
        self.transport.whereabouts()
    }

    /// Leaves the network.
    pub fn close(self) {
        self.transport.close();
    }
}

/// Takes a status, which names its node. Other data are ignored.
fn sought(nodes: &[NodeName]) -> String {
    let names: Vec<_> = nodes.iter().map(NodeName::as_str).collect();
    match names[..] {
        [] => "any node".to_owned(),
        [node] => format!("node {node}"),
        _ => format!("nodes {}", names.join(", ")),
    }
}

fn take_status(seen: &Seen, at: Instant<Machine>, bytes: &[u8]) {
    // Checked before parsing: JSON of any length would be built up in memory.
    if bytes.len() > LONGEST_STATUS {
        return;
    }
    let Ok(Value::Object(status)) = serde_json::from_slice(bytes) else {
        return;
    };
    // The sender's name is in the payload, because the handler of a wildcard gets no key.
    let named = status.get("node").and_then(Value::as_str);
    let name = named.and_then(|name| NodeName::new(name).ok());
    if let Some(name) = name {
        seen.note(&name.status_key(), |node| node.status = Some((at, status)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::transport::{InProcess, Urgency};

    fn name(name: &str) -> NodeName {
        NodeName::new(name).unwrap()
    }

    fn publish(transport: &InProcess, key: &str, text: &str) {
        let publisher = transport.publisher(key, Urgency::Ordinary).unwrap();
        publisher.publish(text.into()).unwrap();
    }

    #[test]
    fn all_nodes_are_seen_with_what_they_said_last() {
        // A fixed clock: the arrival of the status is known exactly.
        let transport = InProcess::dated_by(|| Instant::from_nanos(5));
        let _early = transport.announce("coaxle/line/alive").unwrap();
        let watcher = Watcher::over(Arc::new(transport.clone()), &[]).unwrap();
        let saw = transport.announce("coaxle/saw/alive").unwrap();
        publish(
            &transport,
            "coaxle/saw/status",
            r#"{ "node": "saw", "cycle": 1 }"#,
        );
        publish(
            &transport,
            "coaxle/saw/status",
            r#"{ "node": "saw", "cycle": 2 }"#,
        );
        let seen = watcher.seen();
        let names: Vec<_> = seen.iter().map(|node| node.name.as_str()).collect();
        assert_eq!(names, ["line", "saw"]);
        // Announced before the watcher opens: presence has a history.
        assert!(seen.iter().all(|node| node.is_alive) && seen[0].status.is_none());
        let (at, status) = seen[1].status.as_ref().unwrap();
        assert_eq!((at.as_nanos(), &status["cycle"]), (5, &2.into()));
        drop(saw);
        assert!(!watcher.seen()[1].is_alive);
    }

    #[test]
    fn of_named_nodes_only_these_are_heard() {
        let transport = InProcess::default();
        let watcher = Watcher::over(Arc::new(transport.clone()), &[name("saw")]).unwrap();
        for node in ["line", "saw"] {
            let text = format!("{{ \"node\": \"{node}\" }}");
            publish(&transport, &format!("coaxle/{node}/status"), &text);
        }
        let seen = watcher.seen();
        assert_eq!(seen.len(), 1);
        assert_eq!(seen[0].name, name("saw"));
    }

    #[test]
    fn what_is_no_status_is_nobodys() {
        let transport = InProcess::default();
        let watcher = Watcher::over(Arc::new(transport.clone()), &[]).unwrap();
        for text in [
            // Empty, broken, no object, no name, a name that is no text, a name that is no part of a key.
            "",
            "{",
            "[]",
            "{}",
            r#"{ "node": 1 }"#,
            r#"{ "node": "a/b" }"#,
        ] {
            publish(&transport, "coaxle/x/status", text);
        }
        assert!(watcher.seen().is_empty());
    }

    #[test]
    fn it_waits_until_it_has_seen_enough_and_no_longer_than_it_may() {
        let transport = InProcess::default();
        let watcher = Watcher::over(Arc::new(transport.clone()), &[]).unwrap();
        let nobody = watcher.wait_for(Span::from_millis(1), |seen| !seen.is_empty());
        assert!(nobody.is_empty());
        let later = std::thread::spawn(move || {
            publish(&transport, "coaxle/saw/status", r#"{ "node": "saw" }"#);
        });
        // A minute is never waited for: the other thread publishes at once.
        let somebody = watcher.wait_for(Span::from_secs(60), |seen| !seen.is_empty());
        assert_eq!(somebody.len(), 1);
        later.join().unwrap();
    }
}
