//! Liveliness tokens of a node, and the delivery of its frames.

use std::collections::BTreeSet;

use coaxle_host::network::transport::Delivery;
use coaxle_node::keys::NodeName;

use super::rules::{ALIVE, QOS, RUN_TOKEN};
use super::status::epoch_of;
use crate::conform::rule::{RuleFinding, RuleOutcome, Tally};

/// Zenoh's real-time priority.
const REAL_TIME: u8 = 1;

/// Tokens present, and deliveries of frames.
#[derive(Debug)]
pub(super) struct PresenceChecks {
    node: NodeName,
    tokens: BTreeSet<String>,
    qos: Tally,
}

impl PresenceChecks {
    pub(super) fn new(node: &NodeName) -> Self {
        Self {
            node: node.clone(),
            tokens: BTreeSet::new(),
            qos: Tally::default(),
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

    /// Checks the delivery of a frame, if it is known.
    pub(super) fn delivery(&mut self, delivery: Option<Delivery>) {
        let Some(delivery) = delivery else {
            return;
        };
        let Delivery {
            priority,
            is_dropped,
            is_express,
        } = delivery;
        let is_good = priority == REAL_TIME && is_dropped && !is_express;
        self.qos.check(is_good, || {
            let congestion = if is_dropped { "dropped" } else { "waited for" };
            let express = if is_express { ", express" } else { "" };
            (
                format!(
                    "priority {priority}, {congestion} when the network cannot keep up{express}"
                ),
                "priority 1 (real-time), dropped, not express".to_owned(),
            )
        });
    }

    /// Findings; `epoch` is that of the newest frame.
    pub(super) fn findings(&self, epoch: Option<u64>) -> Vec<RuleFinding> {
        vec![
            RuleFinding::new(&ALIVE, self.alive()),
            RuleFinding::new(&RUN_TOKEN, self.run(epoch)),
            RuleFinding::new(
                &QOS,
                self.qos.outcome("frames", "the transport does not tell"),
            ),
        ]
    }

    fn alive(&self) -> RuleOutcome {
        let key = self.node.alive_key();
        match self.tokens.contains(&key) {
            true => RuleOutcome::kept(key),
            false => RuleOutcome::broken("no token", format!("a liveliness token {key}")),
        }
    }

    fn run(&self, epoch: Option<u64>) -> RuleOutcome {
        let Some(epoch) = epoch else {
            return RuleOutcome::not_seen("no good frame came");
        };
        let expected = self.node.run_key(epoch);
        let all = self.node.runs_key();
        let prefix = all.trim_end_matches('*');
        let runs = self
            .tokens
            .iter()
            .filter_map(|key| key.strip_prefix(prefix));
        let runs: Vec<_> = runs.collect();
        match runs.as_slice() {
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
