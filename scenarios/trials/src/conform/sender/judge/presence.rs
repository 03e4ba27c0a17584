//! Liveliness tokens of a node, and the delivery of its frames.

use std::collections::BTreeSet;

use coaxle_host::network::transport::Delivery;
use coaxle_node::keys::NodeName;

use super::FrameClock;
use super::rules::{SenderRule, Tallies};
use super::status::epoch_of;
use crate::conform::rule::{RuleOutcome, mismatch};

/// Zenoh's real-time priority.
const REAL_TIME: u8 = 1;

/// Tokens present.
#[derive(Debug)]
pub(super) struct PresenceChecks {
    node: NodeName,
    tokens: BTreeSet<String>,
}

impl PresenceChecks {
    pub(super) fn new(node: &NodeName) -> Self {
        Self {
            node: node.clone(),
            tokens: BTreeSet::new(),
        }
    }

    /// Takes the appearance or disappearance of a token.
    pub(super) fn token(&mut self, key: &str, is_there: bool) {
        if is_there {
            self.tokens.insert(key.to_owned());
        } else {
            self.tokens.remove(key);
        }
    }

    pub(super) fn alive(&self) -> RuleOutcome {
        let key = self.node.alive_key();
        match self.tokens.contains(&key) {
            true => RuleOutcome::kept(key),
            false => RuleOutcome::broken("no token", format!("a liveliness token {key}")),
        }
    }

    /// Outcome of the tokens of runs, of which one is to be that of the newest frame.
    pub(super) fn run(&self, frames: Option<&FrameClock>) -> RuleOutcome {
        let Some(epoch) = frames.map(|frames| frames.epoch) else {
            return RuleOutcome::not_seen("no good frame came");
        };
        let expected = self.node.run_key(epoch);
        let all = self.node.runs_key();
        let prefix = all.trim_end_matches('*');
        let runs = (self.tokens.iter()).filter_map(|key| key.strip_prefix(prefix));
        match runs.collect::<Vec<_>>().as_slice() {
            [] => RuleOutcome::broken("no token", expected),
            [run] if epoch_of(run) == Some(epoch) => RuleOutcome::kept(expected),
            [run] => RuleOutcome::broken(format!("{prefix}{run}"), expected),
            runs => RuleOutcome::broken(
                format!("the runs {}", runs.join(", ")),
                format!("one, {expected}: is there a second node of the name?"),
            ),
        }
    }
}

/// Checks the delivery of a frame, if it is known.
pub(super) fn check_delivery(delivery: Option<Delivery>, tallies: &mut Tallies) {
    let Some(delivery) = delivery else {
        return;
    };
    let Delivery {
        priority,
        is_dropped,
        is_express,
    } = delivery;
    let is_good = priority == REAL_TIME && is_dropped && !is_express;
    tallies.check(SenderRule::Qos, is_good, || {
        let congestion = if is_dropped { "dropped" } else { "waited for" };
        let express = if is_express { ", express" } else { "" };
        mismatch(
            format!("priority {priority}, {congestion} when the network cannot keep up{express}"),
            "priority 1 (real-time), dropped, not express",
        )
    });
}
