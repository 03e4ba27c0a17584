//! Keys of the timing channels of each node.

use coaxle_host::network::credentials::RevocationList;
use coaxle_node::beacon::{PairKeys, TimingSecret};
use coaxle_node::keys::NodeName;

use super::member::Member;
use super::network::SecureNetwork;

/// Writes the keys of a node: one for each other node that it follows or is followed by, and none of any other pair.
pub(super) fn keys_of(
    network: &SecureNetwork,
    node: &Member,
    secret: &TimingSecret,
    revoked: &RevocationList,
) -> String {
    let generation = |name: &NodeName| {
        let before = revoked.before.get(name.as_str());
        before.copied().unwrap_or_default()
    };
    let mut text =
        "# Keys of timing channels, one for each pair of nodes: docs/SECURE.md\n".to_owned();
    let others = network.nodes().iter();
    for other in others.filter(|other| follows(node, other) || follows(other, node)) {
        // After a revocation another key: that of before may be known to a thief.
        let generation = generation(&node.name).max(generation(&other.name));
        let key = secret.pair(&node.name, &other.name, generation);
        text += &PairKeys::line(&other.name, generation, &key);
    }
    text
}

fn follows(follower: &Member, followed: &Member) -> bool {
    let mut subscribed = follower.wiring.subscriptions.iter();
    follower.name != followed.name && subscribed.any(|it| it.node == followed.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secure::samples::{LINE, SAW, member, name};

    #[test]
    fn a_node_has_the_keys_of_its_pairs_and_no_other() {
        let drill = SAW.replace("saw", "drill");
        let nodes = [LINE, SAW, &drill].map(member).to_vec();
        let network = SecureNetwork::new(nodes, Vec::new(), &[]).unwrap();
        let secret = TimingSecret::new([1; 32]);
        let keys = |at: usize, revoked: &RevocationList| {
            let text = keys_of(&network, &network.nodes()[at], &secret, revoked);
            let lines = text.lines().filter(|line| !line.starts_with('#'));
            lines.map(str::to_owned).collect::<Vec<_>>()
        };
        let none = RevocationList::default();
        let (line, saw, drill) = (keys(0, &none), keys(1, &none), keys(2, &none));
        assert_eq!((line.len(), saw.len(), drill.len()), (2, 1, 1));
        let key = |line: &str| line.rsplit(' ').next().unwrap().to_owned();
        assert!(line[0].starts_with("saw 0 ") && key(&line[0]) == key(&saw[0]));
        assert!(line[1].starts_with("drill 0 ") && key(&line[1]) == key(&drill[0]));
        assert_ne!(key(&saw[0]), key(&drill[0]));
        // A revoked name gets another key with each other node.
        let revoked = RevocationList {
            number: 1,
            before: [("saw".to_owned(), 7)].into(),
        };
        let renewed = keys(0, &revoked);
        assert!(renewed[0].starts_with("saw 7 ") && key(&renewed[0]) != key(&line[0]));
        assert_eq!(renewed[0].replacen("saw", "line", 1), keys(1, &revoked)[0]);
        assert_eq!(renewed[1], line[1]);
        assert_eq!(name("saw").as_str(), "saw");
    }
}
