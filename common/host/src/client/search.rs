//! Search for what a node serves: its orders, its audit.

use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_os::exit::NodeNotFound;
use coaxle_os::machine::{self, Machine};

use crate::network::transport::{Client, Transport};

/// Longest time to wait for a node to appear.
// Longer than Zenoh's scouting delay (0.5 s) and the first round of its retries (0.25, 0.5 and 1 s).
const SEARCH: Span = Span::from_secs(5);

/// Response timeout: nodes respond within a second; the rest is for a slow network.
// Longer than the second within which a command server reports a cycle that hangs.
const ANSWER: Duration = Duration::from_secs(3);

/// Interval between checks for the node.
// A hundredth of a second is not noticed by people, and costs little for five seconds.
const LOOK: Duration = Duration::from_millis(10);

/// Time of waiting after which it is said what for: people take a silent program for a hung one after about a second (Nielsen,
/// "Usability Engineering", 1993, section 5.5).
const SILENCE: Span = Span::from_secs(1);

/// Line about a wait that takes long.
pub(super) struct LongWait {
    due: Option<Instant<Machine>>,
}

impl LongWait {
    pub(super) fn begin() -> Self {
        Self {
            due: Some(machine::now() + SILENCE),
        }
    }

    /// Time until the line; none if it was written.
    pub(super) fn left(&self) -> Option<Span> {
        self.due.map(|due| due - machine::now())
    }

    /// Writes the line, once, when it is due.
    pub(super) fn say(&mut self, sought: &str, whereabouts: &str) {
        if self.left().is_some_and(|left| left <= Span::ZERO) {
            self.due = None;
            tracing::info!("waiting for {sought}, {whereabouts}");
        }
    }
}

/// A request to what nodes serve, and its words in messages.
pub(super) struct NodeRequest<'a> {
    pub(super) node: &'a NodeName,
    /// Key under which the node serves it.
    pub(super) key: &'a str,
    pub(super) json: String,
    /// Node that is not there, in words: `takes no orders`.
    pub(super) absent: &'static str,
}

/// Response to a request, and the place that was asked, for messages.
pub(super) struct NodeResponse {
    /// Absent if the node did not answer.
    pub(super) payload: Option<Vec<u8>>,
    pub(super) place: String,
}

/// Sends a request to a node, and waits for its response. `instead` says what is there instead of a missing node.
///
/// # Errors
/// The transport refuses; [`NodeNotFound`]: the node does not appear within [`SEARCH`].
pub(super) fn ask(
    transport: &dyn Transport,
    request: NodeRequest<'_>,
    instead: impl FnOnce() -> String,
) -> anyhow::Result<NodeResponse> {
    let NodeRequest {
        node,
        key,
        json,
        absent,
    } = request;
    let client = transport.client(key, ANSWER)?;
    let whereabouts = transport.whereabouts();
    let place = format!("asked under {key}, {whereabouts}");
    // A request without a server would wait for the full response timeout and end in the same silence.
    if !is_there(&*client, &format!("node {node}"), whereabouts) {
        let instead = instead();
        let missing =
            format!("node {node} {absent}: it is not there after {SEARCH}, {place}{instead}");
        return Err(NodeNotFound(missing).into());
    }
    let payload = client.request(json)?;
    Ok(NodeResponse { payload, place })
}

/// Text on why a node is not visible; empty if that is not known.
pub(super) fn why_invisible(transport: &dyn Transport, node: &NodeName) -> String {
    let why = transport.invisibility_reason(node.as_str());
    why.map_or_else(String::new, |why| format!("; {}", why.reason()))
}

/// Waits until a client has a server, for [`SEARCH`] at most. Returns false if it has none.
fn is_there(client: &dyn Client, sought: &str, whereabouts: &str) -> bool {
    // The machine's monotonic clock: a step of the wall clock must not end or prolong the search.
    let end = machine::now() + SEARCH;
    let mut long_wait = LongWait::begin();
    loop {
        // Asked before the clock: a busy machine that slept past the end still finds the server.
        if client.has_server() {
            return true;
        }
        if machine::now() >= end {
            return false;
        }
        long_wait.say(sought, whereabouts);
        std::thread::park_timeout(LOOK);
    }
}
