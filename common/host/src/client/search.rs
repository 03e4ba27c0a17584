//! Search for what a node serves: its orders, its audit.

use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_os::machine::{self, Machine};

use crate::network::transport::Client;

/// Longest time to wait for a node to appear.
// Longer than Zenoh's scouting delay (0.5 s) and the first round of its retries (0.25, 0.5 and 1 s).
pub(super) const SEARCH: Span = Span::from_secs(5);

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

/// Waits until a client has a server, for [`SEARCH`] at most. Returns false if it has none.
pub(super) fn is_there(client: &dyn Client, sought: &str, whereabouts: &str) -> bool {
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
