//! A receiver's status of the node that is played.

use coaxle_node::keys::NodeName;
use serde_json::{Map, Value};

use super::script::Expect;
use crate::conform::rule::RuleOutcome;

/// Counters of rejected messages of all kinds.
const WRONG: [&str; 14] = [
    "rejected_wrong_version",
    "rejected_truncated",
    "rejected_wrong_checksum",
    "rejected_malformed",
    "rejected_trailing_bytes",
    "rejected_cycle_time_out_of_range",
    "rejected_present_after_out_of_range",
    "rejected_foreign_sender",
    "rejected_axis_missing",
    "rejected_implausible",
    "duplicates",
    "late",
    "foreign_frames",
    "restarts",
];

/// Fields of a status.
#[derive(Clone, Debug)]
pub(super) struct ReceiverReading {
    far: Map<String, Value>,
    axis: Map<String, Value>,
    /// `far.conveyor`, for messages.
    place: String,
}

impl ReceiverReading {
    /// The receiver's status of the axis `axis` of `node`; none where it does not follow that one.
    pub(super) fn of(status: &Map<String, Value>, node: &NodeName, axis: u32) -> Option<Self> {
        let far = status.get("far")?.get(node.as_str())?.as_object()?;
        let mut axes = status.get("axes")?.as_object()?.values();
        let is_it = |shown: &&Value| shown["node"] == node.as_str() && shown["id"] == axis;
        let axis = axes.find(is_it)?.as_object()?;
        Some(Self {
            far: far.clone(),
            axis: axis.clone(),
            place: format!("far.{node}"),
        })
    }

    fn count(&self, name: &str) -> Option<u64> {
        self.far.get(name)?.as_u64()
    }

    /// Increase of a counter.
    fn since(&self, before: &Self, name: &str) -> Option<u64> {
        self.count(name)?.checked_sub(before.count(name)?)
    }

    /// Other counters that went up, in words.
    fn besides(&self, before: &Self, but_for: &[&str]) -> Option<String> {
        let others = WRONG.iter().filter(|name| !but_for.contains(name));
        let up = others.filter_map(|name| {
            let by = self.since(before, name).filter(|by| *by > 0)?;
            Some(format!("{name} + {by}"))
        });
        let up: Vec<_> = up.collect();
        (!up.is_empty()).then(|| up.join(", "))
    }

    /// Outcome of a step by this status, after `played` frames up to this epoch and count.
    pub(super) fn outcome(
        &self,
        before: &Self,
        expect: Expect,
        played: u64,
        (epoch, count): (u64, u64),
    ) -> RuleOutcome {
        match expect {
            Expect::Used => self.used(before, played, count),
            Expect::Counted(name) => self.counted(before, name, played),
            Expect::Some(name) => match self.since(before, name) {
                None => self.no_field(name),
                Some(0) => RuleOutcome::broken(format!("{name} + 0"), format!("{name} to go up")),
                Some(by) => RuleOutcome::kept(format!("{name} + {by}")),
            },
            Expect::Error(code) => match self.axis.get("received_error").and_then(Value::as_u64) {
                None => RuleOutcome::not_seen("its status has no received_error of the axis"),
                Some(shown) if shown == u64::from(code) => {
                    RuleOutcome::kept(format!("received_error {shown}"))
                }
                Some(shown) => RuleOutcome::broken(
                    format!("received_error {shown}"),
                    format!("{code}, the nErrorCode that came"),
                ),
            },
            Expect::Run => self.run(before, epoch),
        }
    }

    fn used(&self, before: &Self, played: u64, count: u64) -> RuleOutcome {
        let (Some(received), Some(newest)) = (self.since(before, "received"), self.count("count"))
        else {
            return self.no_field("received, or no count");
        };
        let expected = format!("received + {played} or more, and nothing counted as wrong");
        if let Some(wrong) = self.besides(before, &[]) {
            return RuleOutcome::broken(wrong, expected);
        }
        if received < played {
            return RuleOutcome::broken(format!("received + {received}"), expected);
        }
        if newest < count {
            return RuleOutcome::broken(
                format!("count {newest}, which is what is used"),
                format!("{count} or more, as was played"),
            );
        }
        RuleOutcome::kept(format!("received + {received}, nothing counted as wrong"))
    }

    fn counted(&self, before: &Self, name: &str, played: u64) -> RuleOutcome {
        let Some(by) = self.since(before, name) else {
            return self.no_field(name);
        };
        let expected = format!("{name} + {played}");
        let besides = self.besides(before, &[name]);
        match besides {
            None if by == played => RuleOutcome::kept(expected),
            None => RuleOutcome::broken(format!("{name} + {by}"), expected),
            Some(wrong) => RuleOutcome::broken(format!("{name} + {by}, {wrong}"), expected),
        }
    }

    fn run(&self, before: &Self, epoch: u64) -> RuleOutcome {
        let (Some(followed), Some(restarts)) =
            (self.count("epoch"), self.since(before, "restarts"))
        else {
            return self.no_field("epoch, or no restarts");
        };
        let words = format!("epoch {followed:016x}, restarts + {restarts}");
        match followed == epoch && restarts == 1 {
            true => RuleOutcome::kept(words),
            false => RuleOutcome::broken(words, format!("epoch {epoch:016x}, restarts + 1")),
        }
    }

    fn no_field(&self, name: &str) -> RuleOutcome {
        RuleOutcome::not_seen(format!("its status has no {}.{name}", self.place))
    }
}
