//! Who hears whom. That somebody subscribes does not mean that anything arrives: where access control drops it,
//! neither end is told. So whoever hears a node says so, under a key of that node.

use std::collections::BTreeMap;

use coaxle_node::keys::NodeName;

use crate::transport::{Declared, Transport};

/// What a node says of those that it hears.
#[derive(Default)]
pub(crate) struct Hearing(BTreeMap<NodeName, Declared>);

impl Hearing {
    /// Says of one that it is heard, as `own`, or is not any more. What the transport refuses is tried again
    /// the next time.
    pub(crate) fn say(
        &mut self,
        source: &NodeName,
        is_heard: bool,
        own: &NodeName,
        transport: &dyn Transport,
    ) {
        if !is_heard {
            self.0.remove(source);
        }
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
