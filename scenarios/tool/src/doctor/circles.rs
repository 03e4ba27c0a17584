//! Circles over the nodes whose configs are given together.

use coaxle_node::circles::{Circle, circles};
use coaxle_receiver::ReceiverConfig;

use crate::node_config::{NodeConfig, NodeKind};

/// The circles among the axes of these nodes. A gateway's axes come from a PLC, a sender's from its programs: only
/// receivers follow.
pub(super) fn among(configs: &[NodeConfig]) -> Vec<Circle> {
    let receivers = configs.iter().filter_map(|config| match &config.kind {
        NodeKind::Receiver(config) => Some(config.as_ref()),
        NodeKind::Sender(_) | NodeKind::Gateway(_) => None,
    });
    // All together: a receiver is refused by itself only if it follows itself.
    let followers: Vec<_> = receivers.flat_map(ReceiverConfig::followers).collect();
    circles(&followers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn configs_given_together_show_a_circle_that_none_shows_alone() {
        let folder = tempfile::tempdir().unwrap();
        let load = |name: &str, other: &str| {
            let file = folder.path().join(format!("{name}.toml"));
            let text = format!(
                "name = '{name}'\ncycle-time-us = 2000\n\
                 master = {{ node = '{other}', channel = 'slaves', axis = 1 }}\n"
            );
            std::fs::write(&file, text).unwrap();
            NodeConfig::load(&file).unwrap()
        };
        let (a, b) = (load("a", "b"), load("b", "a"));
        assert_eq!(among(std::slice::from_ref(&a)), []);
        assert_eq!(among(std::slice::from_ref(&b)), []);
        let found: Vec<_> = among(&[a, b]).iter().map(Circle::to_string).collect();
        assert_eq!(found, ["a/slaves/1 follows b/slaves/1 follows a/slaves/1"]);
    }
}
