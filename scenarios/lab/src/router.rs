//! `[[router]]` of a scenario: routers between nodes, in virtual time.

use coaxle_node::config::{FaultMicros, LinkConfig, Positive};
use coaxle_node::keys::NodeName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A router of the simulated network. With one, every node is behind one, and what nodes say to each other goes from router to
/// router, over each hop once for all who subscribe behind it. Beacons of timing channels take another way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct RouterConfig {
    /// Its name, which no node has.
    pub name: NodeName,
    /// The nodes behind it, by their names, in which `*` stands for any part: `hall-1-*`. What `network` does happens on the way
    /// of each of them to the router, and on the way back.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<String>,
    /// The routers that it is connected to; of two of them one says it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub to: Vec<NodeName>,
    /// What the links to those do to messages, in either direction. As `network`, if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<LinkConfig>,
    /// How long it takes for each message that it sends on, one after the other, µs.
    #[serde(default)]
    pub forward_us: FaultMicros,
    /// What passes over each of its links in either direction, Mbit/s: payloads alone. Anything, if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mbit_s: Option<Positive>,
    /// What would have to wait longer than this, to be sent on or to pass over a link, is dropped, µs.
    #[serde(default = "usual_queue")]
    pub queue_us: FaultMicros,
}

impl RouterConfig {
    /// Whether a node of this name is behind it.
    pub(crate) fn is_before(&self, node: &str) -> bool {
        self.nodes.iter().any(|pattern| fits(pattern, node))
    }
}

fn usual_queue() -> FaultMicros {
    FaultMicros::new(10_000.0).unwrap_or_default()
}

/// Whether a name is as a pattern says, in which `*` stands for any part.
pub(crate) fn fits(pattern: &str, name: &str) -> bool {
    let Some((before, rest)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(name) = name.strip_prefix(before) else {
        return false;
    };
    // Each part where it comes first; the last one at the end.
    let mut parts: Vec<&str> = rest.split('*').collect();
    let last = parts.pop().unwrap_or_default();
    let mut left = name;
    for part in parts {
        match left.find(part) {
            Some(at) => left = &left[at + part.len()..],
            None => return false,
        }
    }
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
