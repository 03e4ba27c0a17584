//! `[[router]]` of a scenario: routers between nodes, in virtual time.

use coaxle_node::config::{FaultMicros, LinkConfig, Positive};
use coaxle_node::keys::NodeName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A router of the simulated network. With one, every node is behind a router, and messages between nodes go from router to
/// router, over each hop once for all subscribers behind it. Beacons of timing channels take another way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct RouterConfig {
    /// Name, which no node has.
    pub name: NodeName,
    /// The nodes behind it, by their names, in which `*` stands for any part: `hall-1-*`. The faults of `network` apply on the way
    /// of each of them to the router, and on the way back.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<String>,
    /// The routers that it is connected to; only one of two names the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub to: Vec<NodeName>,
    /// Faults of the links to those, in either direction. As `network`, if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<LinkConfig>,
    /// Time to forward a message, one after the other, µs.
    #[serde(default)]
    pub forward_us: FaultMicros,
    /// Bandwidth of each of its links in either direction, Mbit/s: payloads alone. Unlimited, if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mbit_s: Option<Positive>,
    /// Longest wait for being sent on or passing over a link, µs; messages that would wait longer are dropped.
    #[serde(default = "usual_queue")]
    pub queue_us: FaultMicros,
}

impl RouterConfig {
    /// True if a node of this name is behind it.
    pub(crate) fn is_before(&self, node: &str) -> bool {
        self.nodes.iter().any(|pattern| fits(pattern, node))
    }
}

fn usual_queue() -> FaultMicros {
    FaultMicros::new(10_000.0).unwrap_or_default()
}

/// True if a name matches a pattern, in which `*` stands for any part.
pub(crate) fn fits(pattern: &str, name: &str) -> bool {
    let Some((before, rest)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(name) = name.strip_prefix(before) else {
        return false;
    };
    // Each part at its first place; the last one at the end.
    let mut parts: Vec<&str> = rest.split('*').collect();
    let last = parts.pop().unwrap_or_default();
    let mut left = name;
    for part in parts {
        match left.find(part) {
            Some(at) => left = &left[at + part.len()..],
            None => return false,
        }
    }
    // The first place of each part leaves the most for the others, so that no other choice can fit where this one does not.
    left.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_is_any_part_of_a_name() {
        for (pattern, name, expected) in [
            ("belt", "belt", true),
            ("belt", "belt-1", false),
            ("hall-1-*", "hall-1-belt", true),
            ("hall-1-*", "hall-12-belt", false),
            ("*", "", true),
            ("*-belt", "hall-1-belt", true),
            ("*-belt", "hall-1-belt-2", false),
            ("a*b*b", "ab", false),
            ("a*b*b", "abb", true),
            ("a*a", "a", false),
        ] {
            assert_eq!(fits(pattern, name), expected, "{pattern} {name}");
        }
    }
}
