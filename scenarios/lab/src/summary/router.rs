//! Figures of the traffic of routers.

use std::collections::BTreeMap;

use coaxle_sim::{Load, RouterTraffic};
use schemars::JsonSchema;
use serde::Serialize;

/// Figures of a router over the whole run. Bytes are those of payloads: a transport adds its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct RouterSummary {
    /// Messages that came to it, 1/s.
    pub received_per_s: f64,
    /// Bytes of these messages, 1/s.
    pub received_bytes_per_s: f64,
    /// Messages that it sent to nodes behind it, 1/s.
    pub to_nodes_per_s: f64,
    /// Bytes of these messages, 1/s.
    pub to_nodes_bytes_per_s: f64,
    /// Messages that it sent to other routers, 1/s.
    pub to_routers_per_s: f64,
    /// Bytes of these messages, 1/s.
    pub to_routers_bytes_per_s: f64,
    /// Messages that it or its links had no room for, or that came while it was dead.
    pub dropped: u64,
    /// Traffic to each router that it is connected to.
    pub links: BTreeMap<String, RouterLinkSummary>,
}

/// Figures of a link from one router to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct RouterLinkSummary {
    /// Messages, 1/s.
    pub messages_per_s: f64,
    /// Bytes of these messages, 1/s.
    pub bytes_per_s: f64,
}

impl RouterSummary {
    /// Figures of a run of this length, s.
    pub(crate) fn of(traffic: &RouterTraffic, seconds: f64) -> Self {
        let rates = |load: Load| {
            let rate = |count: u64| {
                // A run may be ended before its first second.
                if seconds > 0.0 {
                    count as f64 / seconds
                } else {
                    0.0
                }
            };
            (rate(load.messages), rate(load.bytes))
        };
        let (received_per_s, received_bytes_per_s) = rates(traffic.received);
        let (to_nodes_per_s, to_nodes_bytes_per_s) = rates(traffic.to_nodes);
        let mut to_routers = Load::default();
        let links = traffic.to_routers.iter().map(|(to, load)| {
            to_routers.messages += load.messages;
            to_routers.bytes += load.bytes;
            let (messages_per_s, bytes_per_s) = rates(*load);
            let link = RouterLinkSummary {
                messages_per_s,
                bytes_per_s,
            };
            (to.clone(), link)
        });
        // Collected before the sum is read, which the iterator adds up.
        let links = links.collect();
        let (to_routers_per_s, to_routers_bytes_per_s) = rates(to_routers);
        Self {
            received_per_s,
            received_bytes_per_s,
            to_nodes_per_s,
            to_nodes_bytes_per_s,
            to_routers_per_s,
            to_routers_bytes_per_s,
            dropped: traffic.dropped,
            links,
        }
    }
}
