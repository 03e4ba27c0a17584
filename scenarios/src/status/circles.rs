//! Circles over running nodes, by what they say of themselves.

use coaxle_host::SeenNode;
use coaxle_node::Channel;
use coaxle_node::circles::{AxisAddress, Circle, Follower, circles};

use super::reading;
use super::reading::Reading;

/// The circles among the axes of these nodes.
pub(super) fn among(seen: &[SeenNode]) -> Vec<Circle> {
    let alive = seen.iter().filter(|node| node.is_alive);
    let followers: Vec<_> = alive.flat_map(followers_of).collect();
    circles(&followers)
}

fn followers_of(node: &SeenNode) -> Vec<Follower> {
    let Some(status) = reading(node) else {
        return Vec::new();
    };
    let follower = |channel, id: f64, axis: Reading<'_>| Follower {
        axis: AxisAddress {
            node: node.name.clone(),
            channel,
            id: id as u32,
        },
        masters: axis
            .texts("follows")
            .filter_map(AxisAddress::read)
            .collect(),
    };
    let slaves = status.parts("slaves").filter_map(|(_, slave)| {
        let id = slave.number("id")?;
        Some(follower(Channel::Slaves, id, slave))
    });
    let axes = status.parts("axes").filter_map(|(_, axis)| {
        let id = axis.number("published_id")?;
        Some(follower(Channel::FarAxes, id, axis))
    });
    slaves.chain(axes).collect()
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
