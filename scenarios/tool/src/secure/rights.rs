//! Rights of each member at each other. A message without a right is denied.

use coaxle_node::Channel;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{Publication, Subscription};
use serde::Serialize;

use super::member::{Member, Operator};
use super::network::SecureNetwork;

/// Direction of a message, as seen from the session that checks it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MessageDirection {
    /// From the other member.
    Ingress,
    /// To the other member.
    Egress,
}

/// Messages that one session lets pass from or to one other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Right {
    /// The other member: the common name of its certificate.
    pub of: NodeName,
    /// Direction of the messages.
    pub flow: MessageDirection,
    /// Kinds of messages, as Zenoh calls them.
    pub messages: &'static [&'static str],
    /// Under these keys.
    pub key: String,
}

/// Published data: a subscriber declares itself, and receives it.
const SUBSCRIBE: &[&str] = &["declare_subscriber"];
const PUBLISH: &[&str] = &["put"];
/// Liveliness: a watcher subscribes or queries, and is notified.
const WATCH: &[&str] = &["declare_liveliness_subscriber", "liveliness_query"];
const ANNOUNCE: &[&str] = &["liveliness_token"];
/// Orders: a receiver of orders declares itself; they are queries, and get replies.
const SERVE: &[&str] = &["declare_queryable"];
const ORDER: &[&str] = &["query"];
const REPLY: &[&str] = &["reply"];

impl SecureNetwork {
    /// Rights that a node or an operator grants and needs; none if no member has that name.
    #[must_use]
    pub fn rights(&self, of: &NodeName) -> Option<Vec<Right>> {
        if let Some(node) = self.nodes.iter().find(|node| node.name == *of) {
            // Nodes first: names are unique, so an operator cannot have a node's.
            return Some(self.rights_at_node(node));
        }
        let operator = self.operators.iter().find(|known| known.name == *of)?;
        let nodes = self.nodes.iter();
        let commanded = nodes.filter(|node| operator.commands(&node.name));
        let rights =
            commanded.flat_map(|node| operator_rights(node, operator, MessageDirection::Egress));
        Some(rights.collect())
    }

    fn rights_at_node(&self, node: &Member) -> Vec<Right> {
        let mut rights = run_token_rights(node);
        // Both ways for each pair: frames go one way, declarations of subscribers the other.
        for other in self.nodes.iter().filter(|other| other.name != node.name) {
            rights.extend(subscription_rights(
                other,
                node,
                &other.name,
                MessageDirection::Ingress,
            ));
            rights.extend(subscription_rights(
                node,
                other,
                &other.name,
                MessageDirection::Egress,
            ));
        }
        let operators = self.operators.iter();
        let commanding = operators.filter(|operator| operator.commands(&node.name));
        rights.extend(
            commanding
                .flat_map(|operator| operator_rights(node, operator, MessageDirection::Ingress)),
        );
        rights
    }
}

/// Rights for the messages from one node to another, seen from the end where they come in or go out.
fn subscription_rights(
    publisher: &Member,
    subscriber: &Member,
    of: &NodeName,
    flow: MessageDirection,
) -> Vec<Right> {
    let mut rights = Vec::new();
    // A subscriber declares itself against the direction of the data.
    let back = opposite(flow);
    // Beacons of timing channels do not pass through the transport.
    let subscribed = subscriber.wiring.subscriptions.iter();
    for subscribed in subscribed.filter(|subscribed| !subscribed.channel.is_timing()) {
        if !publisher
            .wiring
            .publications
            .iter()
            // Only what the publisher really has: a wish in a follower's config grants nothing.
            .any(|published| is_same(published, subscribed))
        {
            continue;
        }
        let key = subscribed.node.channel_key(subscribed.channel);
        rights.push(right(of, flow, PUBLISH, &key));
        rights.push(right(of, back, SUBSCRIBE, &key));
        if subscribed.channel.carries_axes() {
            let key = subscribed.node.alive_key();
            rights.push(right(of, flow, ANNOUNCE, &key));
            rights.push(right(of, back, WATCH, &key));
            // What the node says of its axes, for the unit and the modulo period.
            let key = subscribed.node.about_key();
            rights.push(right(of, flow, PUBLISH, &key));
            rights.push(right(of, back, SUBSCRIBE, &key));
            // A node that follows others may follow its follower: circles are found by its status.
            if subscribed.channel != Channel::Axes {
                let key = subscribed.node.status_key();
                rights.push(right(of, flow, PUBLISH, &key));
                rights.push(right(of, back, SUBSCRIBE, &key));
            }
            let seen_by = subscribed.node.seen_by_key(&subscriber.name);
            rights.push(right(of, back, ANNOUNCE, &seen_by));
            // With a wildcard, as a node watches all its followers by one subscription.
            rights.push(right(of, flow, WATCH, &subscribed.node.seen_by_keys()));
        }
    }
    rights
}

/// Orders, and an operator's view of a node; `orders` is the direction of the orders.
fn operator_rights(node: &Member, operator: &Operator, orders: MessageDirection) -> Vec<Right> {
    let of = match orders {
        MessageDirection::Ingress => &operator.name,
        MessageDirection::Egress => &node.name,
    };
    let answers = opposite(orders);
    let own = node.name.operator_command_key(&operator.name);
    let (status, alive) = (node.name.status_key(), node.name.alive_key());
    let (rows, audit) = (node.name.rows_key(), node.name.audit_key());
    let about = node.name.about_key();
    let mut rights = vec![
        // The operator's own name is part of the key, so nobody sends orders in the name of another.
        right(of, orders, ORDER, &own),
        right(of, answers, REPLY, &own),
        // The node declares one queryable for all operators; orders themselves are of one name.
        right(of, answers, SERVE, &node.name.operator_command_keys()),
        right(of, orders, SUBSCRIBE, &status),
        right(of, answers, PUBLISH, &status),
        right(of, orders, SUBSCRIBE, &rows),
        right(of, answers, PUBLISH, &rows),
        // Records as they are made, and queries of the newest ones: for operators, and nobody else.
        right(of, orders, SUBSCRIBE, &audit),
        right(of, answers, PUBLISH, &audit),
        right(of, orders, ORDER, &audit),
        right(of, answers, REPLY, &audit),
        right(of, answers, SERVE, &audit),
        right(of, orders, ORDER, &about),
        right(of, answers, REPLY, &about),
        right(of, answers, SERVE, &about),
        right(of, orders, WATCH, &alive),
        right(of, answers, ANNOUNCE, &alive),
    ];
    // What it has promised, and the frames that confirm it.
    let published = &node.wiring.publications;
    if published.iter().any(|own| own.channel == Channel::Plans) {
        for channel in [Channel::Axes, Channel::Plans] {
            let key = node.name.channel_key(channel);
            rights.push(right(of, orders, SUBSCRIBE, &key));
            rights.push(right(of, answers, PUBLISH, &key));
        }
    }
    rights
}

/// Rights of the tokens by which two runs of a node detect each other.
fn run_token_rights(node: &Member) -> Vec<Right> {
    let key = node.name.runs_key();
    // Both ways: the other run has the same certificate, and either end may have been first.
    let each_way = |flow| {
        [
            right(&node.name, flow, ANNOUNCE, &key),
            right(&node.name, flow, WATCH, &key),
        ]
    };
    [MessageDirection::Ingress, MessageDirection::Egress]
        .into_iter()
        .flat_map(each_way)
        .collect()
}

fn right(
    of: &NodeName,
    flow: MessageDirection,
    messages: &'static [&'static str],
    key: &str,
) -> Right {
    Right {
        of: of.clone(),
        flow,
        messages,
        key: key.to_owned(),
    }
}

const fn opposite(flow: MessageDirection) -> MessageDirection {
    match flow {
        MessageDirection::Ingress => MessageDirection::Egress,
        MessageDirection::Egress => MessageDirection::Ingress,
    }
}

fn is_same(published: &Publication, subscribed: &Subscription) -> bool {
    published.node == subscribed.node && published.channel == subscribed.channel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secure::samples::{LINE, SAW, member, name, operator};

    fn network() -> SecureNetwork {
        let nodes = vec![member(LINE), member(SAW)];
        SecureNetwork::new(nodes, vec![operator("anna"), operator("bert=line")], &[]).unwrap()
    }

    /// The rights of one at another as `flow message key`.
    fn listed(at: &str, of: &str) -> Vec<String> {
        let rights = network().rights(&name(at)).unwrap();
        let own = rights.iter().filter(|right| right.of.as_str() == of);
        own.flat_map(|right| {
            let line = |message: &&str| format!("{:?} {message} {}", right.flow, right.key);
            right.messages.iter().map(line).collect::<Vec<_>>()
        })
        .collect()
    }

    #[test]
    fn who_follows_a_node_hears_it_asks_it_and_no_more() {
        let mut at_line = listed("line", "saw");
        at_line.sort();
        assert_eq!(
            at_line,
            [
                "Egress declare_liveliness_subscriber coaxle/line/seen-by/*",
                "Egress declare_subscriber coaxle/line/time-requests",
                "Egress liveliness_query coaxle/line/seen-by/*",
                "Egress liveliness_token coaxle/line/alive",
                "Egress put coaxle/line/about",
                "Egress put coaxle/line/axes",
                "Egress put coaxle/line/time-responses",
                "Ingress declare_liveliness_subscriber coaxle/line/alive",
                "Ingress declare_subscriber coaxle/line/about",
                "Ingress declare_subscriber coaxle/line/axes",
                "Ingress declare_subscriber coaxle/line/time-responses",
                "Ingress liveliness_query coaxle/line/alive",
                "Ingress liveliness_token coaxle/line/seen-by/saw",
                "Ingress put coaxle/line/time-requests",
            ]
        );
        // A message that one end lets out, the other lets in.
        let mirrored = |right: String| match right.split_once(' ') {
            Some(("Ingress", rest)) => format!("Egress {rest}"),
            Some((_, rest)) => format!("Ingress {rest}"),
            None => right,
        };
        let mut at_saw: Vec<_> = listed("saw", "line").into_iter().map(mirrored).collect();
        at_saw.sort();
        assert_eq!(at_saw, at_line);
    }

    #[test]
    fn who_follows_a_follower_hears_its_status() {
        let relay = "name = 'relay'\ncycle-time-us = 1000\n\
                     master = { node = 'saw', channel = 'slaves', axis = 1 }\n\
                     [transport]\nconnect = ['tls/10.0.0.2:7448']";
        let nodes = vec![member(LINE), member(SAW), member(relay)];
        let network = SecureNetwork::new(nodes, Vec::new(), &[]).unwrap();
        let subscribed = |at: &str, of: &str, flow, key: &str| {
            let rights = network.rights(&name(at)).unwrap();
            let is_it =
                |right: &&Right| right.of.as_str() == of && right.key == key && right.flow == flow;
            rights
                .iter()
                .filter(is_it)
                .flat_map(|right| right.messages)
                .copied()
                .collect::<Vec<_>>()
        };
        let status = "coaxle/saw/status";
        assert_eq!(
            subscribed("relay", "saw", MessageDirection::Ingress, status),
            PUBLISH
        );
        assert_eq!(
            subscribed("relay", "saw", MessageDirection::Egress, status),
            SUBSCRIBE
        );
        assert_eq!(
            subscribed("saw", "relay", MessageDirection::Egress, status),
            PUBLISH
        );
        assert_eq!(
            subscribed("saw", "relay", MessageDirection::Ingress, status),
            SUBSCRIBE
        );
        // A sender follows no node.
        assert_eq!(
            subscribed(
                "saw",
                "line",
                MessageDirection::Ingress,
                "coaxle/line/status"
            ),
            [""; 0]
        );
    }

    #[test]
    fn an_operator_commands_under_its_own_name_where_it_may() {
        assert_eq!(
            listed("saw", "anna"),
            [
                "Ingress query coaxle/saw/command/anna",
                "Egress reply coaxle/saw/command/anna",
                "Egress declare_queryable coaxle/saw/command/*",
                "Ingress declare_subscriber coaxle/saw/status",
                "Egress put coaxle/saw/status",
                "Ingress declare_subscriber coaxle/saw/rows",
                "Egress put coaxle/saw/rows",
                "Ingress declare_subscriber coaxle/saw/audit",
                "Egress put coaxle/saw/audit",
                "Ingress query coaxle/saw/audit",
                "Egress reply coaxle/saw/audit",
                "Egress declare_queryable coaxle/saw/audit",
                "Ingress query coaxle/saw/about",
                "Egress reply coaxle/saw/about",
                "Egress declare_queryable coaxle/saw/about",
                "Ingress declare_liveliness_subscriber coaxle/saw/alive",
                "Ingress liveliness_query coaxle/saw/alive",
                "Egress liveliness_token coaxle/saw/alive",
            ]
        );
        assert!(listed("saw", "bert").is_empty());
        assert!(listed("bert", "saw").is_empty());
        assert!(!listed("line", "bert").is_empty() && !listed("bert", "line").is_empty());
    }

    #[test]
    fn an_operator_receives_what_a_node_has_promised() {
        let promised = LINE.replace("[transport]", "lead-ms = 100\n[transport]");
        let network = SecureNetwork::new(vec![member(&promised)], vec![operator("anna")], &[]);
        let rights = network.unwrap().rights(&name("anna")).unwrap();
        for channel in ["axes", "plans"] {
            let key = format!("coaxle/line/{channel}");
            let of_key = rights.iter().filter(|right| right.key == key);
            let flows: Vec<_> = of_key.map(|right| (right.flow, right.messages)).collect();
            let expected = [
                (MessageDirection::Egress, SUBSCRIBE),
                (MessageDirection::Ingress, PUBLISH),
            ];
            assert_eq!(flows, expected, "{key}");
        }
        let at_a_node_without = listed("anna", "line");
        assert!(
            !at_a_node_without
                .iter()
                .any(|right| right.ends_with("/axes"))
        );
    }

    #[test]
    fn nobody_may_anything_that_another_one_says() {
        let network = network();
        for at in ["line", "saw", "anna", "bert"] {
            for right in network.rights(&name(at)).unwrap() {
                let own = |of: &str| right.key.starts_with(&format!("coaxle/{of}/"));
                let (incoming, of) = (right.flow == MessageDirection::Ingress, right.of.as_str());
                let says = ["put", "reply", "liveliness_token", "declare_queryable"];
                if incoming && says.contains(&right.messages[0]) {
                    let asks = right.key == format!("coaxle/{at}/time-requests");
                    let sees = right.key == format!("coaxle/{at}/seen-by/{of}");
                    assert!(own(of) || asks || sees, "at {at}: {right:?}");
                }
                assert!(!right.key.ends_with("/command"), "{right:?}");
            }
        }
        assert!(network.rights(&name("mallory")).is_none());
    }
}
