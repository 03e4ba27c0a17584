//! Followers of the sender's axes: their reports, and their condition in sum.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::keys::NodeName;
use coaxle_node::{FollowerState, PresentAfter, ReceivedReport};
use coaxle_source::Followers;
use coaxle_source::config::{AxisConfig, FollowersConfig};
use serde::Serialize;

use crate::config::SenderConfig;

/// Followers of all axes that have some.
#[derive(Debug)]
pub(crate) struct FollowerWatch {
    /// Run of this node: reports about an earlier one say nothing of this one.
    run: u64,
    axes: Box<[WatchedAxis]>,
}

/// An axis with followers.
#[derive(Debug)]
struct WatchedAxis {
    id: u32,
    age_limit: Span,
    followers: Box<[WatchedFollower]>,
}

/// A follower of an axis.
#[derive(Debug)]
struct WatchedFollower {
    /// Number among all nodes that report.
    node: usize,
    heard: Option<HeardReport>,
    /// Run before this one, whose last reports may come late.
    former: Option<u64>,
    /// True if it was in sync, has begun again, and is not in sync yet.
    has_begun_again: bool,
    /// In the newest cycle.
    condition: FollowerCondition,
}

/// Newest report of a follower.
#[derive(Clone, Copy, Debug)]
struct HeardReport {
    at: Instant<Local>,
    epoch: u64,
    count: u64,
    state: FollowerState,
}

/// Condition of a follower of an axis, as the status shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FollowerCondition {
    /// Without a report so far.
    #[default]
    Unheard,
    /// Without a slave of the axis.
    WithoutSlaves,
    /// With a slave that is not in sync.
    NotInSync,
    /// In sync, with all of its slaves.
    InSync,
    /// With a slave in error.
    InError,
    /// Without a report for the age limit.
    Silent,
    /// Begun again after it was in sync, and not in sync yet.
    BegunAgain,
}

impl FollowerCondition {
    /// True if an axis stops by it, or halts.
    #[must_use]
    pub const fn is_failure(self) -> bool {
        matches!(self, Self::InError | Self::Silent | Self::BegunAgain)
    }
}

impl FollowerWatch {
    /// Creates the watch of a run; none without an axis that has followers.
    pub(crate) fn new(config: &SenderConfig, run: u64) -> Option<Self> {
        let nodes = config.followers();
        let axis = |axis: &AxisConfig| {
            let config = axis.followers.as_ref()?;
            Some(WatchedAxis::new(axis.id.get(), config, &nodes))
        };
        let axes: Box<[_]> = config.axes.iter().filter_map(axis).collect();
        (!axes.is_empty()).then_some(Self { run, axes })
    }

    /// Stores a report of the node with this number.
    pub(crate) fn store(&mut self, at: Instant<Local>, node: usize, report: &ReceivedReport) {
        if report.run != self.run {
            return;
        }
        let axis = self.axes.iter_mut().find(|axis| axis.id == report.axis_id);
        let follower =
            axis.and_then(|axis| axis.followers.iter_mut().find(|other| other.node == node));
        if let Some(follower) = follower {
            follower.store(at, report);
        }
    }

    /// Judges each follower in a cycle.
    pub(crate) fn judge(&mut self, now: Instant<Local>) {
        for axis in &mut self.axes {
            for follower in &mut axis.followers {
                follower.condition = follower.judged(now, axis.age_limit);
            }
        }
    }

    /// Followers of an axis in the newest cycle; none of one that has no followers.
    pub(crate) fn of(&self, id: u32) -> Option<Followers> {
        let axis = self.axes.iter().find(|axis| axis.id == id)?;
        let mut sum = Followers {
            are_in_sync: true,
            ..Followers::UNKNOWN
        };
        for follower in &axis.followers {
            sum.are_in_sync &= follower.condition == FollowerCondition::InSync;
            sum.have_failed |= follower.condition.is_failure();
            if let Some(heard) = &follower.heard {
                sum.limits = sum.limits.at_most(&heard.state.limits);
            }
        }
        Some(sum)
    }

    /// True if all followers of all axes are in sync.
    pub(crate) fn are_in_sync(&self) -> bool {
        let mut followers = self.axes.iter().flat_map(|axis| &axis.followers);
        followers.all(|follower| follower.condition == FollowerCondition::InSync)
    }

    /// Greatest presentation delay that a follower wants; none before one says so.
    pub(crate) fn wanted_delay(&self) -> Option<Span> {
        let followers = self.axes.iter().flat_map(|axis| &axis.followers);
        let heard = followers.filter_map(|follower| follower.heard.as_ref());
        let wanted = heard.filter_map(|heard| heard.state.wanted_delay);
        wanted.max().map(PresentAfter::span)
    }

    /// Condition of each follower of each axis in the newest cycle, in the order of the config.
    pub(crate) fn conditions(&self) -> impl Iterator<Item = FollowerCondition> {
        let followers = self.axes.iter().flat_map(|axis| &axis.followers);
        followers.map(|follower| follower.condition)
    }
}

impl WatchedAxis {
    fn new(id: u32, config: &FollowersConfig, nodes: &[NodeName]) -> Self {
        let number = |name: &NodeName| nodes.iter().position(|other| other == name);
        let follower = |node| WatchedFollower {
            node,
            heard: None,
            former: None,
            has_begun_again: false,
            condition: FollowerCondition::default(),
        };
        let followers = config.nodes.iter().filter_map(number).map(follower);
        Self {
            id,
            age_limit: config.age_limit(),
            followers: followers.collect(),
        }
    }
}

impl WatchedFollower {
    fn store(&mut self, at: Instant<Local>, report: &ReceivedReport) {
        let ReceivedReport { epoch, count, .. } = *report;
        match &self.heard {
            Some(heard) if heard.epoch == epoch && count <= heard.count => return,
            _ if self.former == Some(epoch) => return,
            Some(heard) if heard.epoch != epoch => {
                self.has_begun_again |= is_in_sync(&heard.state);
                self.former = Some(heard.epoch);
            }
            _ => {}
        }
        let state = report.state;
        self.has_begun_again &= !is_in_sync(&state);
        self.heard = Some(HeardReport {
            at,
            epoch,
            count,
            state,
        });
    }

    fn judged(&self, now: Instant<Local>, age_limit: Span) -> FollowerCondition {
        let Some(HeardReport { at, state, .. }) = &self.heard else {
            return FollowerCondition::Unheard;
        };
        if now - *at > age_limit {
            FollowerCondition::Silent
        } else if state.in_error > 0 {
            FollowerCondition::InError
        } else if self.has_begun_again {
            FollowerCondition::BegunAgain
        } else if state.slaves == 0 {
            FollowerCondition::WithoutSlaves
        } else if is_in_sync(state) {
            FollowerCondition::InSync
        } else {
            FollowerCondition::NotInSync
        }
    }
}

/// True if there are slaves, and all of them are in sync.
const fn is_in_sync(state: &FollowerState) -> bool {
    state.slaves > 0 && state.in_sync == state.slaves
}
