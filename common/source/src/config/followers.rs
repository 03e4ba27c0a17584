//! Followers that an axis waits for, stops with, and whose limits it keeps.

use coaxle_clock::Span;
use coaxle_node::config::{AgeLimitMs, Wrong};
use coaxle_node::keys::NodeName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Greatest number of followers of an axis.
pub const MOST_FOLLOWERS: usize = 64;

/// Followers of an axis: nodes whose slaves it leads, and which report how these are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct FollowersConfig {
    /// Their names: 1 to 64, each once. Each must follow the axis, and have a slave of it.
    pub nodes: Vec<NodeName>,
    /// Reaction to a follower that fails: one with a slave in error, one that is silent, or one that begins again.
    #[serde(default)]
    pub on_failure: OnFailure,
    /// Keep the limits of all their slaves, as far as these are coupled: the axis moves within its own limits and theirs. Off by
    /// default.
    #[serde(default)]
    pub keep_limits: bool,
    /// Time without a report after which a follower has failed, ms. They come every 50 ms, and with each change. 300 by default.
    #[serde(default)]
    pub age_limit_ms: AgeLimitMs,
}

/// Reaction of an axis to a follower that fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnFailure {
    /// Ramps down, as fast as the slowest follower can, and ends its program.
    #[default]
    Stop,
    /// Ramps down likewise, and goes on when all followers are well again.
    Halt,
    /// Continues.
    Ignore,
}

impl FollowersConfig {
    /// Time without a report after which a follower has failed.
    #[must_use]
    pub fn age_limit(&self) -> Span {
        self.age_limit_ms.span()
    }

    pub(super) fn check(&self) -> Result<(), Wrong> {
        let nodes = &self.nodes;
        if !(1..=MOST_FOLLOWERS).contains(&nodes.len()) {
            let received = format!("{} nodes", nodes.len());
            let expected = format!("1 to {MOST_FOLLOWERS}");
            return Err(Wrong::of("nodes", received, expected));
        }
        let is_repeated = |n: &usize| nodes[..*n].contains(&nodes[*n]);
        match (0..nodes.len()).find(is_repeated) {
            Some(n) => {
                let received = format!("{:?} twice", nodes[n].as_str());
                Err(Wrong::of(format!("nodes[{n}]"), received, "each once"))
            }
            None => Ok(()),
        }
    }
}
