//! Circles across nodes: published axes that follow each other, so that each finally follows itself.
//!
//! No frame names the origin of its motion, so a circle is found where all followers are known:
//! from the configs of several nodes, or from the statuses of running ones ([`CircleWatch`]).

mod reading;
mod watch;

pub use coaxle_slave::{CIRCLE_CODE, CircleState};
pub use coaxle_wire::CircleChange;
pub use reading::followers_of;
pub use watch::{CircleFinding, CircleWatch};

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use coaxle_wire::Channel;
use coaxle_wire::keys::NodeName;

/// Address of an axis in the network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AxisAddress {
    /// The node that publishes it.
    pub node: NodeName,
    /// Channel of the frame with the axis.
    pub channel: Channel,
    /// Axis id in that frame.
    pub id: u32,
}

impl AxisAddress {
    /// Parses an address, `press/slaves/1`; none if the text is invalid.
    #[must_use]
    pub fn read(text: &str) -> Option<Self> {
        let mut parts = text.split('/');
        let (node, channel, id) = (parts.next()?, parts.next()?, parts.next()?);
        // A fourth part would be another kind of key.
        if parts.next().is_some() {
            return None;
        }
        // By name, as in the keys: numbers of channels are no part of a text that travels.
        let channel = Channel::ALL
            .into_iter()
            .find(|known| known.name() == channel);
        Some(Self {
            node: NodeName::new(node).ok()?,
            channel: channel?,
            id: id.parse().ok()?,
        })
    }

    // A key for maps: the types themselves have no order.
    fn key(&self) -> (&str, &str, u32) {
        (self.node.as_str(), self.channel.name(), self.id)
    }
}

impl fmt::Display for AxisAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (node, channel, id) = self.key();
        write!(f, "{node}/{channel}/{id}")
    }
}

/// A published axis with all axes that it follows, or can be commanded to follow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Follower {
    /// The axis.
    pub axis: AxisAddress,
    /// Masters on other nodes, and their standbys.
    pub masters: Vec<AxisAddress>,
    /// True if it is coupled to them now; for an axis from a config, if it can be.
    pub is_coupled: bool,
}

/// A circle: each axis follows the next one, and the last one the first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Circle(Vec<AxisAddress>);

impl Circle {
    /// The axes of the circle.
    #[must_use]
    pub fn axes(&self) -> &[AxisAddress] {
        &self.0
    }
}

impl fmt::Display for Circle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for axis in &self.0 {
            write!(f, "{axis} follows ")?;
        }
        // The first axis again: a circle reads as one only when it closes.
        match self.0.first() {
            Some(first) => first.fmt(f),
            None => Ok(()),
        }
    }
}

/// The circles among these axes: for each axis in a circle the shortest one, without duplicates.
///
/// An empty result means that there is no circle: each axis in a circle is on a shortest one.
#[must_use]
pub fn circles(followers: &[Follower]) -> Vec<Circle> {
    circles_through(followers, followers.len())
}

/// The circles through the first `count` of these axes: for each the shortest, without duplicates.
fn circles_through(followers: &[Follower], count: usize) -> Vec<Circle> {
    // By number from here on: a search over names would compare texts at each step.
    let numbers: BTreeMap<_, _> = (followers.iter().enumerate())
        .map(|(n, follower)| (follower.axis.key(), n))
        .collect();
    let masters: Vec<Vec<usize>> = (followers.iter())
        .map(|follower| {
            let masters = follower.masters.iter();
            masters
                // Axes that nobody described lead nowhere: senders, and nodes without a status.
                .filter_map(|master| numbers.get(&master.key()).copied())
                .collect()
        })
        .collect();
    let mut is_told = vec![false; followers.len()];
    let mut found = Vec::new();
    for first in 0..count {
        // An axis that is in a circle already has been shown: a second circle through it would be the same news.
        if is_told[first] {
            continue;
        }
        let Some(circle) = shortest_through(first, &masters) else {
            continue;
        };
        circle.iter().for_each(|n| is_told[*n] = true);
        let axes = circle.iter().map(|n| followers[*n].axis.clone());
        found.push(Circle(axes.collect()));
    }
    found
}

/// The shortest path from an axis over its masters back to itself.
fn shortest_through(first: usize, masters: &[Vec<usize>]) -> Option<Vec<usize>> {
    let mut reached_from = vec![None; masters.len()];
    // Breadth first: the first way back to the start is a shortest one.
    let mut due = VecDeque::from([first]);
    while let Some(axis) = due.pop_front() {
        for master in &masters[axis] {
            // Back at the start: the way that led here is the circle.
            if *master == first {
                let mut circle = vec![axis];
                let mut at = axis;
                while let Some(before) = reached_from[at] {
                    circle.push(before);
                    at = before;
                }
                // Collected from the end.
                circle.reverse();
                return Some(circle);
            }
            // Reached before on a way that is no longer.
            if reached_from[*master].is_none() {
                reached_from[*master] = Some(axis);
                due.push_back(*master);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(name: &str) -> AxisAddress {
        AxisAddress {
            node: NodeName::new(name).unwrap(),
            channel: Channel::Slaves,
            id: 1,
        }
    }

    fn texts(followers: &[(&str, &[&str])]) -> Vec<String> {
        let follower = |(of, masters): &(&str, &[&str])| Follower {
            axis: axis(of),
            masters: masters.iter().map(|master| axis(master)).collect(),
            is_coupled: true,
        };
        let followers: Vec<_> = followers.iter().map(follower).collect();
        circles(&followers).iter().map(Circle::to_string).collect()
    }

    #[test]
    fn an_address_is_read_as_it_is_written() {
        let address = axis("press.2");
        assert_eq!(AxisAddress::read(&address.to_string()), Some(address));
        for wrong in [
            "",
            "press",
            "press/slaves",
            "press/slaves/x",
            "press/gears/1",
            "a/slaves/1/2",
        ] {
            assert_eq!(AxisAddress::read(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn lines_and_trees_have_no_circle() {
        // Every axis is followed on several ways: a way that meets itself is no circle.
        let tree: [(&str, &[&str]); 4] = [
            ("a", &["line"]),
            ("b", &["a", "line"]),
            ("c", &["a", "b"]),
            ("d", &["c", "b", "a"]),
        ];
        assert_eq!(texts(&tree), [""; 0]);
    }

    #[test]
    fn each_circle_is_found_once_however_long_it_is() {
        let two: [(&str, &[&str]); 2] = [("a", &["b"]), ("b", &["a"])];
        let text = "a/slaves/1 follows b/slaves/1 follows a/slaves/1";
        assert_eq!(texts(&two), [text]);
        assert_eq!(
            texts(&[("a", &["line", "a"])]),
            ["a/slaves/1 follows a/slaves/1"]
        );
        // A tail that leads into a circle of three is not part of a circle.
        let three: [(&str, &[&str]); 5] = [
            ("tail", &["c"]),
            ("c", &["line", "d"]),
            ("d", &["e"]),
            ("e", &["c"]),
            ("other", &["line"]),
        ];
        let text = "c/slaves/1 follows d/slaves/1 follows e/slaves/1 follows c/slaves/1";
        assert_eq!(texts(&three), [text]);
    }
}
