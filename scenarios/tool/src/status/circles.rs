//! Circles over running nodes, by their statuses.

use coaxle_host::client::SeenNode;
use coaxle_node::circles::{self, Circle, Follower};

/// The circles among the axes of these nodes.
pub(super) fn among(seen: &[SeenNode]) -> Vec<Circle> {
    // The last status of a node that is gone may name axes that nobody follows any more.
    let alive = seen.iter().filter(|node| node.is_alive);
    let followers: Vec<_> = alive.flat_map(followers_of).collect();
    circles::circles(&followers)
}

fn followers_of(node: &SeenNode) -> Vec<Follower> {
    let status = node.status.as_ref();
    status.map_or_else(Vec::new, |(_, status)| {
        circles::followers_of(&node.name, status)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::samples::object;
    use coaxle_clock::Instant;
    use coaxle_node::keys::NodeName;

    fn node(name: &str, follows: &str, is_alive: bool) -> SeenNode {
        let status = format!(
            r#"{{ "slaves": {{ "loop": {{ "id": 1, "follows": ["{follows}"] }}, "other": {{ "id": 2, "follows": [] }} }} }}"#
        );
        SeenNode {
            name: NodeName::new(name).unwrap(),
            is_alive,
            status: Some((Instant::EPOCH, object(&status))),
        }
    }

    #[test]
    fn running_nodes_that_follow_each_other_are_a_circle() {
        let found = |nodes: &[SeenNode]| {
            let circles = among(nodes);
            circles.iter().map(Circle::to_string).collect::<Vec<_>>()
        };
        let a = || node("a", "b/slaves/1", true);
        let text = "a/slaves/1 follows b/slaves/1 follows a/slaves/1";
        assert_eq!(found(&[a(), node("b", "a/slaves/1", true)]), [text]);
        assert_eq!(found(&[a(), node("b", "a/slaves/2", true)]), [""; 0]);
        assert_eq!(found(&[a(), node("b", "a/slaves/1", false)]), [""; 0]);
    }
}
