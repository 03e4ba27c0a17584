//! Places of a scenario's nodes among its routers.

use std::collections::BTreeSet;

use coaxle_node::config::{Wrong, did_you_mean};
use coaxle_node::faults::check_link;

use crate::router::fits;
use crate::scenario::Scenario;
use crate::topology::Topology;

/// Most routers of a scenario.
const MOST_ROUTERS: usize = 128;

/// Router of each node, and connections between routers.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct ScenarioLayout {
    /// The router of each node, by their numbers; none at all without routers.
    pub(crate) behind: Vec<usize>,
    /// The routers that are connected, each pair with the declaring one first.
    pub(crate) connected: Vec<[usize; 2]>,
}

impl ScenarioLayout {
    /// The layout, with every node behind one router, if there are any.
    ///
    /// # Errors
    /// [`Wrong`] names the field.
    pub(crate) fn of(scenario: &Scenario, topology: &Topology) -> Result<Self, Wrong> {
        let routers = &scenario.routers;
        if routers.is_empty() {
            return Ok(Self::default());
        }
        if routers.len() > MOST_ROUTERS {
            let expected = format!("at most {MOST_ROUTERS}");
            return Err(Wrong::of("router", routers.len(), expected));
        }
        check_names(scenario, topology)?;
        check_links(scenario)?;
        Ok(Self {
            behind: behind(scenario, topology)?,
            connected: connected(scenario)?,
        })
    }

    /// Number of links on the way from one node to another, by their numbers: one where there are no routers. None between routers that are not
    /// connected.
    pub(crate) fn links_between(&self, from: usize, to: usize) -> Option<usize> {
        let home = |node: usize| self.behind.get(node).copied();
        let Some((from, to)) = home(from).zip(home(to)) else {
            return Some(1);
        };
        let mut reached = BTreeSet::from([from]);
        for hops in 0..MOST_ROUTERS {
            if reached.contains(&to) {
                // Beside the hops, the links from one node up to its router, and from the other router down to its node.
                return Some(hops + 2);
            }
            let ends = self.connected.iter().flat_map(|&[a, b]| [(a, b), (b, a)]);
            let next: Vec<usize> = ends
                .filter_map(|(near, far)| reached.contains(&near).then_some(far))
                .collect();
            reached.extend(next);
        }
        None
    }
}

fn check_names(scenario: &Scenario, topology: &Topology) -> Result<(), Wrong> {
    let routers = &scenario.routers;
    for (n, router) in routers.iter().enumerate() {
        let name = &router.name;
        let is_taken = routers[..n].iter().any(|other| other.name == *name);
        if is_taken || topology.node(name).is_some() {
            let received = format!("{:?} twice", name.as_str());
            let expected = "a name that no node and no other router has";
            return Err(Wrong::of(format!("router[{n}].name"), received, expected));
        }
        let nodes = topology.names();
        for (place, pattern) in router.nodes.iter().enumerate() {
            if !nodes.iter().any(|node| fits(pattern, node.as_str())) {
                let meant = did_you_mean(pattern, nodes.iter().map(|node| node.as_str()));
                let field = format!("router[{n}].nodes[{place}]");
                let expected = format!("the name of a node, or a pattern that one fits{meant}");
                return Err(Wrong::of(field, format_args!("{pattern:?}"), expected));
            }
        }
    }
    Ok(())
}

/// Refuses faults of content on a hop, which knows no key and does not read messages.
fn check_links(scenario: &Scenario) -> Result<(), Wrong> {
    for (n, router) in scenario.routers.iter().enumerate() {
        let Some(link) = &router.link else {
            continue;
        };
        let field = format!("router[{n}].link");
        if link.corruption.get() > 0.0 || !link.forgeries.is_empty() {
            let expected = "those in network, or in the faults of a receiver";
            return Err(Wrong::of(field, "corruption or forgeries", expected));
        }
        check_link(link).map_err(|wrong| wrong.within(field))?;
    }
    Ok(())
}

fn behind(scenario: &Scenario, topology: &Topology) -> Result<Vec<usize>, Wrong> {
    let home_of = |node: &str| {
        let routers = scenario.routers.iter().enumerate();
        // Two are asked for, as a second one is as wrong as none.
        let mut homes = routers.filter(|(_, router)| router.is_before(node));
        match (homes.next(), homes.next()) {
            (Some((home, _)), None) => Ok(home),
            (None, _) => {
                let received = format!("none with {node:?} among its nodes");
                Err(Wrong::of("router", received, "every node behind a router"))
            }
            (Some((_, first)), Some((second, _))) => {
                let field = format!("router[{second}].nodes");
                let received = format!("{node:?}, which is behind {} already", first.name);
                Err(Wrong::of(field, received, "a node behind one router"))
            }
        }
    };
    let names = topology.names().iter();
    names.map(|node| home_of(node.as_str())).collect()
}

fn connected(scenario: &Scenario) -> Result<Vec<[usize; 2]>, Wrong> {
    let routers = &scenario.routers;
    let mut pairs = Vec::new();
    for (n, router) in routers.iter().enumerate() {
        for (place, to) in router.to.iter().enumerate() {
            let wrong = |expected: &str| {
                let known = routers.iter().map(|router| router.name.as_str());
                let meant = did_you_mean(to.as_str(), known);
                let field = format!("router[{n}].to[{place}]");
                let received = format!("{:?}", to.as_str());
                Wrong::of(field, received, format_args!("{expected}{meant}"))
            };
            let other = routers.iter().position(|router| router.name == *to);
            let other = other.ok_or_else(|| wrong("a router of this scenario"))?;
            // Either end may name a connection, but only once.
            if other == n || pairs.contains(&[n, other]) || pairs.contains(&[other, n]) {
                return Err(wrong("another router, which it is not connected to yet"));
            }
            pairs.push([n, other]);
        }
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read;

    const PLANT: &str = "title = 't'\nduration-s = 1\n\
        [[router]]\nname = 'middle'\n\
        [[group]]\ncount = 2\n[[group.router]]\nname = 'hall-{n}'\nnodes = ['h{n}-*']\nto = ['middle']\n\
        [[group.sender]]\nname = 'h{n}-belt'\ncycle-time-us = 1000\n[[group.sender.axis]]\nid = 1\nname = 'x'\n\
        [group.sender.axis.program]\nlimits = { velocity = 1, acceleration = 1, jerk = 1 }\n\
        [[group.receiver]]\nname = 'h{n}-saw'\ncycle-time-us = 1000\nfar = [{ node = 'h{n}-belt', axes = [1] }]\n";

    fn read(text: &str) -> Result<Scenario, String> {
        let table = text.parse().unwrap();
        let read = read::scenario("s.toml", table);
        read.map_err(|error| error.in_text("s.toml", text).to_string())
    }

    #[test]
    fn every_node_is_behind_one_router() {
        let scenario = read(PLANT).unwrap();
        let topology = Topology::of(&scenario).unwrap();
        let layout = ScenarioLayout::of(&scenario, &topology).unwrap();
        // Senders first; the router in the middle has no node of its own.
        assert_eq!(layout.behind, [1, 2, 1, 2]);
        assert_eq!(layout.connected, [[1, 0], [2, 0]]);
        // Up to the hall, on to the middle, the other hall, and down.
        assert_eq!(layout.links_between(0, 3), Some(4));
        assert_eq!(layout.links_between(0, 2), Some(2));
        assert_eq!(ScenarioLayout::default().links_between(0, 3), Some(1));
        let apart = ScenarioLayout {
            connected: vec![[1, 0]],
            ..layout
        };
        assert_eq!(apart.links_between(0, 3), None);
    }

    #[test]
    fn what_is_wrong_with_routers_is_told_with_its_line() {
        for (from, to, expected) in [
            (
                "to = ['middle']",
                "to = ['midle']",
                "s.toml:10:7: group[0].router \"hall-{n}\".to[0]: received \"midle\"",
            ),
            (
                "to = ['middle']",
                "to = ['hall-{n}']",
                "expected another router",
            ),
            (
                "['h{n}-*']",
                "['h{n}-belt']",
                "received none with \"h1-saw\" among its nodes",
            ),
            ("['h{n}-*']", "['h*']", "behind hall-1 already"),
            (
                "['h{n}-*']",
                "['h{n}-*', 'x']",
                "received \"x\", expected the name of a node",
            ),
            (
                "name = 'middle'",
                "name = 'h1-saw'",
                "expected a name that no node",
            ),
            (
                "name = 'middle'",
                "name = 'middle'\nlink = { corruption = 0.1 }",
                "received corruption",
            ),
            (
                "name = 'middle'",
                "name = 'middle'\nlatency = 1",
                "router \"middle\".latency: unknown field",
            ),
            (
                "cycle-time-us = 1000\n[[g",
                "cycle-time-us = 1\n[[g",
                "group[0].sender \"h{n}-belt\".cycle-time-us: received 1,",
            ),
        ] {
            let text = PLANT.replacen(from, to, 1);
            assert_ne!(text, PLANT);
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error}");
            assert!(error.matches("received").count() <= 1, "told once: {error}");
        }
    }
}
