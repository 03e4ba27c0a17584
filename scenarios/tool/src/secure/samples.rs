//! Members to try things with.

use coaxle_node::config::parse;
use coaxle_node::keys::NodeName;
use coaxle_receiver::ReceiverConfig;
use coaxle_sender::config::SenderConfig;

use super::member::{Member, Operator};
use crate::node_config::NodeKind;

pub(super) const LINE: &str = "name = 'line'\ncycle-time-us = 1000\n[[axis]]\nid = 1\nname = 'belt'\n\
    program = { limits = { velocity = 10, acceleration = 10, jerk = 10 } }\n\
    [transport]\nlisten = ['tls/0.0.0.0:7447']";
pub(super) const SAW: &str = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'line' }\n\
    [transport]\nlisten = ['tls/0.0.0.0:7448']\nconnect = ['tls/10.0.0.1:7447']";

pub(super) fn name(text: &str) -> NodeName {
    NodeName::new(text).unwrap()
}

pub(super) fn operator(text: &str) -> Operator {
    text.parse().unwrap()
}

pub(super) fn member(text: &str) -> Member {
    if text.contains("[[axis]]") {
        let config: SenderConfig = parse("sender.toml", text).unwrap();
        return Member::of(&NodeKind::Sender(Box::new(config)).into());
    }
    let config: ReceiverConfig = parse("receiver.toml", text).unwrap();
    Member::of(&NodeKind::Receiver(Box::new(config)).into())
}
