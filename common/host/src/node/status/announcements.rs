//! Announcement of received nodes. A subscription does not mean that frames arrive: where access
//! control drops them, neither end is notified. So each follower announces the nodes that it
//! receives, under a key of that node.

use std::collections::BTreeMap;

use coaxle_node::keys::NodeName;

use crate::network::transport::{Declared, Transport};

/// Announcements of a node about the nodes that it receives.
#[derive(Default)]
pub(crate) struct Announcements(BTreeMap<NodeName, Declared>);

impl Announcements {
    /// Announces as `own` that `source` is received, or withdraws the announcement. If the
    /// transport refuses, it is tried again the next time.
    pub(crate) fn announce(
        &mut self,
        source: &NodeName,
        is_heard: bool,
        own: &NodeName,
        transport: &dyn Transport,
    ) {
        if !is_heard {
            self.0.remove(source);
        }
        // Most calls find nothing to do: no token is declared again four times a second.
        if is_heard == self.0.contains_key(source) {
            return;
        }
        match transport.announce(&source.seen_by_key(own)) {
            Ok(announced) => {
                self.0.insert(source.clone(), announced);
            }
            Err(error) => tracing::debug!(%error, "the transport refused an announcement"),
        }
    }
}
