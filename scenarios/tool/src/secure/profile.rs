//! The Zenoh config of one node or operator of a secure network.

use std::fmt::Write;

use coaxle_node::command::MAX_PLATE_ORDER_BYTES;
use coaxle_node::frame::{MAX_AXES, frame_capacity};
use coaxle_node::keys::NodeName;
use serde_json::json;

use super::network::SecureNetwork;
use super::rights::Right;

/// The longest frame that passes: one with all axes that it may have, and some room.
// 128 axes, rounded up to whole pages: 20 KiB.
pub const MAX_FRAME_BYTES: usize = frame_capacity(MAX_AXES).next_multiple_of(4096);
/// Longest message that is reassembled: an order with a cam plate, and its envelope.
// 1 MiB and 4 KiB for Zenoh's header and the key.
pub const MAX_MESSAGE_BYTES: usize = MAX_PLATE_ORDER_BYTES + (1 << 12);
/// Longest response to an order: 4096 points of a plate, of some 150 bytes each.
// 4096 · 150 bytes are 600 kB.
const MAX_ANSWER_BYTES: usize = MAX_PLATE_ORDER_BYTES;

/// Orders per second and operator. An order that follows another one sooner is dropped.
// Ten milliseconds apart: faster than a person or a page, slow enough that a flood costs a node little.
const ORDERS_PER_S: f64 = 100.0;
/// Queries of the audit per second and operator.
// As for orders, but a reply may have half a megabyte.
const AUDIT_QUERIES_PER_S: f64 = 20.0;
/// Time requests per second of each neighbour: some ten are sent.
// Twenty times as often: the network may bunch two requests, and the later one would be dropped.
const TIME_REQUESTS_PER_S: f64 = 200.0;
/// Statuses per second of each node: four are sent.
// 20 ms apart: a node publishes one more when it ends, soon after the one before.
const STATUSES_PER_S: f64 = 50.0;

/// Writes the config; none if no member has that name. Files of certificates are not named: the program that loads it
/// adds those beside it.
#[must_use]
pub fn profile(network: &SecureNetwork, of: &NodeName) -> Option<String> {
    let rights = network.rights(of)?;
    let operator = network.operators().iter().any(|known| known.name == *of);
    // Nodes have their `connect` in their own config; an operator has no config.
    let connect = if operator {
        let commanded = rights.iter().map(|right| &right.of);
        let nodes = network.nodes().iter();
        let nodes = nodes.filter(|node| commanded.clone().any(|name| *name == node.name));
        nodes
            .flat_map(|node| network.addresses().endpoints(node))
            .collect()
    } else {
        Vec::new()
    };
    let lists = Lists {
        limits: limits(),
        rates: rates(of, operator),
        rules: rules(&rights),
        subjects: subjects(&rights),
        policies: policies(&rights),
    };
    Some(text(of, operator, &connect, most_sessions(network), &lists))
}

/// Greatest number of sessions. A certificate allows a session. There are more than members, so that sessions about
/// to close keep no other out.
fn most_sessions(network: &SecureNetwork) -> usize {
    // Twice, for the new session of each member and its old one that is about to close.
    2 * (network.nodes().len() + network.operators().len()) + 8
}

/// Lists of objects, one on a line each.
struct Lists {
    limits: Vec<String>,
    rates: Vec<String>,
    rules: Vec<String>,
    subjects: Vec<String>,
    policies: Vec<String>,
}

fn limits() -> Vec<String> {
    let limit = |id: &str, messages: &[&str], keys: &[&str], bytes: usize| {
        json!({ "id": id, "flows": ["ingress", "egress"], "messages": messages, "key_exprs": keys, "size_limit": bytes })
            .to_string()
    };
    let frames = [
        "coaxle/*/axes",
        "coaxle/*/slaves",
        "coaxle/*/far-axes",
        "coaxle/*/time-requests",
        "coaxle/*/time-responses",
        "coaxle/*/plans",
        "coaxle/*/followers",
    ];
    vec![
        // Statuses and rows are bounded by the size of a message alone.
        limit("frames", &["put"], &frames, MAX_FRAME_BYTES),
        // A node itself bounds orders without a plate.
        limit("orders", &["query"], &["coaxle/**"], MAX_PLATE_ORDER_BYTES),
        limit("answers", &["reply"], &["coaxle/**"], MAX_ANSWER_BYTES),
    ]
}

/// Rates of incoming messages only. A rate is the shortest time between two messages of a neighbour, so it does not suit
/// frames of axes, which the network may bunch.
fn rates(of: &NodeName, operator: bool) -> Vec<String> {
    let rate = |id: &str, message: &str, key: &str, hertz: f64| {
        json!({ "id": id, "flows": ["ingress"], "messages": [message], "rules": [{ "key_expr": key, "freq": hertz }] })
            .to_string()
    };
    // An operator gets no orders and no time requests.
    if operator {
        return vec![rate("statuses", "put", "coaxle/*/status", STATUSES_PER_S)];
    }
    let requests = of.channel_key(coaxle_node::Channel::TimeRequests);
    vec![
        rate("orders", "query", &of.operator_command_keys(), ORDERS_PER_S),
        rate("audit", "query", &of.audit_key(), AUDIT_QUERIES_PER_S),
        rate("time requests", "put", &requests, TIME_REQUESTS_PER_S),
    ]
}

fn rules(rights: &[Right]) -> Vec<String> {
    let rule = |(n, right): (usize, &Right)| {
        json!({
            "id": id(n), "permission": "allow", "flows": [right.flow], "messages": right.messages, "key_exprs": [right.key],
        })
        .to_string()
    };
    rights.iter().enumerate().map(rule).collect()
}

fn id(n: usize) -> String {
    format!("r{}", n + 1)
}

/// Members with any right, without repetition.
fn others(rights: &[Right]) -> Vec<&NodeName> {
    let mut others: Vec<_> = rights.iter().map(|right| &right.of).collect();
    others.sort();
    // Ids of subjects must be unique in Zenoh's config.
    others.dedup();
    others
}

fn subjects(rights: &[Right]) -> Vec<String> {
    let subject = |of: &NodeName| {
        json!({ "id": of, "cert_common_names": [of], "link_protocols": ["tls"] }).to_string()
    };
    others(rights).into_iter().map(subject).collect()
}

fn policies(rights: &[Right]) -> Vec<String> {
    let policy = |of: &NodeName| {
        let own = rights
            .iter()
            .enumerate()
            .filter(|(_, right)| right.of == *of);
        let rules: Vec<_> = own.map(|(n, _)| id(n)).collect();
        json!({ "subjects": [of], "rules": rules }).to_string()
    };
    others(rights).into_iter().map(policy).collect()
}

fn text(
    of: &NodeName,
    operator: bool,
    connect: &[String],
    max_sessions: usize,
    lists: &Lists,
) -> String {
    let role = if operator { "operator" } else { "node" };
    let connect = json!(connect);
    let limits = listed("  ", "low_pass_filter", &lists.limits);
    let rates = listed("  ", "downsampling", &lists.rates);
    let rules = listed("    ", "rules", &lists.rules);
    let subjects = listed("    ", "subjects", &lists.subjects);
    let policies = listed("    ", "policies", &lists.policies);
    format!(
        r#"// The secure profile of the {role} {of}, written by `coaxle secure`: docs/SECURE.md.
// The certificates are the files beside it; where to listen is in the config of the node.
{{
  mode: "peer",
  listen: {{ endpoints: [] }},
  connect: {{ endpoints: {connect}, exit_on_failure: false }},
  transport: {{
    unicast: {{ open_timeout: 3000, accept_timeout: 3000, accept_pending: 20, max_sessions: {max_sessions}, max_links: 1 }},
    link: {{
      // Nothing but TLS, with certificates of both ends.
      protocols: ["tls"],
      tls: {{ enable_mtls: true, verify_name_on_connect: true, close_link_on_expiration: true }},
      // Longer messages are not even put together.
      rx: {{ max_message_size: {MAX_MESSAGE_BYTES} }},
    }},
    shared_memory: {{ enabled: false }},
  }},
  // Access control does not apply to multicast, and no node introduces others.
  scouting: {{ multicast: {{ enabled: false }}, gossip: {{ enabled: false }} }},
  adminspace: {{ enabled: false }},
  // Bytes.
{limits}  // The least time between two messages of a neighbour: 1/freq seconds.
{rates}  // Who may do what, by the name in the certificate of the other end.
  access_control: {{
    enabled: true,
    default_permission: "deny",
{rules}{subjects}{policies}  }},
}}
"#
    )
}

/// A list with an object on each line.
fn listed(indent: &str, name: &str, lines: &[String]) -> String {
    let mut list = format!("{indent}{name}: [\n");
    for line in lines {
        let _ = writeln!(list, "{indent}  {line},");
    }
    let _ = writeln!(list, "{indent}],");
    list
}
