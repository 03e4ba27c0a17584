//! Facts of a node in its status: counters, sources, real-time priorities, and the recorder's details beside them.

use std::sync::Arc;

use coaxle_clock::Instant;
use coaxle_node::keys::NodeName;
use coaxle_os::machine::Machine;
use coaxle_os::{Os, System};
use serde_json::{Map, Value, json};

use super::Reporter;
use super::health::Health;
use super::unseen::Search;
use crate::machine::real_time;
use crate::network::transport::InvisibilityReason;
use crate::node::counters::read;
use crate::node::reception::Contact;

impl Reporter {
    pub(super) fn facts(&self, now: Instant<Machine>) -> Map<String, Value> {
        let counters = &self.counters;
        let mut facts = Map::new();
        let mut put = |name: &str, value: Value| facts.insert(name.to_owned(), value);
        put("node", json!(self.identity.name.as_str()));
        put("role", json!(self.identity.role));
        if let Some(lab) = &self.identity.lab {
            put("lab", json!(lab));
        }
        put("epoch", json!(format!("{:016x}", self.identity.epoch)));
        put(
            "uptime_s",
            json!((now - self.started).as_nanos() as f64 / 1e9),
        );
        put("namesakes", json!(self.session.namesakes()));
        put("cycles", json!(read(&counters.cycles)));
        put(
            "telemetry_dropped",
            json!(read(&counters.telemetry_dropped)),
        );
        put("exchange_refused", json!(read(&counters.exchange_refused)));
        put("real_time", real_time_of(&self.granted));
        if let Some(refused) = self.session.transport().refused_connections() {
            put("connections_refused", json!(refused.count));
            put("connection_flood", json!(refused.flood_from));
        }
        if !self.identity.publishes.is_empty() {
            put("published", json!(read(&counters.published)));
            put("publish_dropped", json!(read(&counters.publish_dropped)));
            put("publish_failed", json!(read(&counters.publish_failed)));
            put("followed", json!(self.session.has_follower()));
            put("seen_by", json!(self.session.seen_by()));
        }
        if !self.identity.sources.is_empty() {
            let sources = self.identity.sources.iter().zip(self.session.contacts());
            let source = |(((node, _), contact), search): Source<'_>| {
                let age = contact.frame_age(now).map(|age| age.as_micros_f64() * 1e-3);
                let unseen = search.reason().map(InvisibilityReason::reason);
                let seen =
                    json!({ "alive": contact.is_alive(), "frame_age_ms": age, "unseen": unseen });
                (node.to_string(), seen)
            };
            let sources = sources.zip(&self.searches).map(source).collect();
            put("sources", Value::Object(sources));
            put("received", json!(read(&counters.received)));
            put("refused", json!(read(&counters.refused)));
            put("mailbox_dropped", json!(read(&counters.mailbox_dropped)));
            put("arrivals_dropped", json!(read(&counters.arrivals_dropped)));
        }
        facts
    }
}

/// Granted real-time priorities per thread, and denied settings.
fn real_time_of(granted: &real_time::Outcome) -> Value {
    // The cycle thread has not reported yet.
    let Some(denied) = granted.get() else {
        return json!({ "priorities": {}, "denied": [] });
    };
    let denied: Vec<_> = denied.iter().map(ToString::to_string).collect();
    // Read from the system, not from the config: Zenoh's threads inherit theirs.
    let priorities: Map<_, _> = Os::priorities()
        .into_iter()
        .map(|(thread, priority)| (thread, json!(priority)))
        .collect();
    json!({ "priorities": priorities, "denied": denied })
}

/// A source: its node with the key of its frames, its contact, and the search for why it is not visible.
type Source<'a> = ((&'a (NodeName, String), &'a Arc<Contact>), &'a Search);

/// The recorder's details never overwrite the host's facts; its health only softens an "ok".
pub(super) fn merged(
    facts: Map<String, Value>,
    health: Health,
    details: Map<String, Value>,
) -> Map<String, Value> {
    let word = word_for(health, &details);
    let mut status = details;
    // The host's facts come last, so that they win.
    status.extend(facts);
    status.insert("health".to_owned(), json!(word));
    status
}

pub(super) fn word_for(health: Health, details: &Map<String, Value>) -> String {
    match (health, details.get("health").and_then(Value::as_str)) {
        // The node's own word counts only where the network has no worse one.
        (Health::Ok, Some(own)) => own.to_owned(),
        (health, _) => health.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn details(json: Value) -> Map<String, Value> {
        json.as_object().unwrap().clone()
    }

    #[test]
    fn a_recorder_can_worsen_the_health_but_never_better_it() {
        let own = details(json!({ "health": "not-synced", "cycles": 0, "mode": "sync" }));
        let facts = details(json!({ "cycles": 5 }));
        let ok = merged(facts.clone(), Health::Ok, own.clone());
        assert_eq!(ok["health"], "not-synced");
        assert_eq!((&ok["cycles"], &ok["mode"]), (&json!(5), &json!("sync")));

        let hopeful = details(json!({ "health": "ok" }));
        assert_eq!(
            merged(facts.clone(), Health::Waiting, hopeful)["health"],
            "waiting"
        );
        assert_eq!(merged(facts, Health::Ok, Map::new())["health"], "ok");
    }
}
