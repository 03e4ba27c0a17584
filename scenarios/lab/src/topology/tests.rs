use std::collections::BTreeSet;

use super::*;
use crate::read;

const SENDER: &str = "title = 't'\nduration-s = 1\n\
    [[sender]]\nname = 'line'\ncycle-time-us = 1000\n[[sender.axis]]\nid = 1\nname = 'x'\n\
    [sender.axis.program]\nlimits = { velocity = 1, acceleration = 1, jerk = 1 }\n";

/// A receiver with slaves, each of which follows a slave of another receiver or the sender.
fn receiver(name: &str, follows: &[(&str, u32)]) -> String {
    let mut text = format!("[[receiver]]\nname = '{name}'\ncycle-time-us = 1000\n");
    let nodes: BTreeSet<_> = follows.iter().map(|(node, _)| *node).collect();
    for node in nodes {
        let of_node = (1..).zip(follows).filter(|(_, (of, _))| *of == node);
        let axes: Vec<_> = of_node
            .map(|(n, (_, axis))| format!("{{ id = {axis}, name = 'far-{n}' }}"))
            .collect();
        let channel = if node == "line" { "axes" } else { "slaves" };
        text += &format!(
            "[[receiver.far]]\nnode = '{node}'\nchannel = '{channel}'\naxes = [{}]\n",
            axes.join(", ")
        );
    }
    for n in 1..=follows.len() {
        text += &format!(
            "[[receiver.slave]]\nname = 's{n}'\nid = {n}\nmaster = 'far-{n}'\ncouple = 'off'\n"
        );
    }
    text
}

fn read(receivers: &[String]) -> Result<Topology, String> {
    let text = SENDER.to_owned() + &receivers.concat();
    let read = read::scenario("s.toml", text.parse().unwrap());
    let scenario = read.map_err(|error| error.to_string())?;
    Topology::of(&scenario).map_err(|wrong| wrong.to_string())
}

#[test]
fn receivers_that_follow_each_other_are_refused_though_nothing_is_coupled() {
    let nodes = [
        receiver("a", &[("b", 1)]),
        receiver("b", &[("c", 1)]),
        receiver("c", &[("a", 1)]),
    ];
    let error = read(&nodes).unwrap_err();
    let circle = "0x816f: received a circle: a/slaves/1 follows b/slaves/1 follows c/slaves/1 follows a/slaves/1";
    assert!(error.contains(circle), "{error}");
    assert!(error.contains("far[0].node"), "{error}");
}

#[test]
fn a_way_that_passes_a_receiver_twice_is_no_circle() {
    let nodes = [
        receiver("a", &[("line", 1), ("b", 1)]),
        receiver("b", &[("a", 1), ("a", 2)]),
        receiver("c", &[("b", 2)]),
    ];
    // From c over b/2, a/2, b/1 and a/1 to the line: the nodes come twice, and no axis does.
    let topology = read(&nodes).unwrap();
    let last = topology.views().last().unwrap();
    assert_eq!((last.name.as_str(), last.root.node), ("c", 0));
}
