//! Running a node by hand.

use coaxle_node::Node;
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::keys::NodeName;

/// Runs some cycles of a node, each on time, and checks that its frames are valid and their numbers finite.
pub(crate) fn scan(node: &mut impl Node, name: &NodeName, cycles: usize) {
    let mut sealed = Vec::new();
    for _ in 0..cycles {
        let now = node.next_cycle();
        node.cycle(now);
        while let Some(outgoing) = node.transmit() {
            if outgoing.channel.carries_axes() {
                let key = name.channel_key(outgoing.channel);
                KeySeal::new(&key).seal(outgoing.body, None, &mut sealed);
                check(&key, name, &sealed);
            }
        }
        // Drained as by a host, or the node's queue of them would only grow.
        while node.arrival().is_some() {}
    }
}

fn check(key: &str, name: &NodeName, frame: &[u8]) {
    let opened = KeySeal::new(key).open(frame, |axis| {
        let numbers = [
            axis.set_position,
            axis.set_velocity,
            axis.set_acceleration,
            axis.actual_position,
        ];
        assert!(numbers.iter().all(|number| number.is_finite()), "{axis:?}");
    });
    let header = opened.expect("what a node sends is a frame");
    assert_eq!(header.sender, sender_id(name));
}
