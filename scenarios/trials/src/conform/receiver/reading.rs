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

/// Frames that were played in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Playback {
    /// Frames to be counted.
    pub(super) played: u64,
    /// Epoch and count of the newest frame.
    pub(super) epoch: u64,
    pub(super) count: u64,
}

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
    fn besides(&self, before: &Self, but_for: &str) -> Option<String> {
        let others = WRONG.iter().filter(|name| **name != but_for);
        let up = others.filter_map(|name| {
            let by = self.since(before, name).filter(|by| *by > 0)?;
            Some(format!("{name} + {by}"))
        });
        let up: Vec<_> = up.collect();
        (!up.is_empty()).then(|| up.join(", "))
    }

    /// Outcome of a step by this status.
    pub(super) fn outcome(&self, before: &Self, expect: Expect, by: &Playback) -> RuleOutcome {
        let outcome = match expect {
            Expect::Used => self.used(before, by),
            Expect::Counted(name) => self.counted(before, name, by.played),
            Expect::Any(name) => self.any(before, name),
            Expect::Error(code) => self.error(code),
            Expect::Run => self.run(before, by.epoch),
        };
        outcome.unwrap_or_else(|field| RuleOutcome::not_seen(format!("its status has no {field}")))
    }

    fn used(&self, before: &Self, by: &Playback) -> Result<RuleOutcome, String> {
        let (received, newest) = (self.since(before, "received"), self.count("count"));
        let both = received.zip(newest);
        let (received, newest) = both.ok_or_else(|| self.path("received, or no count"))?;
        let expected = format!(
            "received + {} or more, and nothing counted as wrong",
            by.played
        );
        Ok(if let Some(wrong) = self.besides(before, "") {
            RuleOutcome::broken(wrong, expected)
        } else if received < by.played {
            RuleOutcome::broken(format!("received + {received}"), expected)
        } else if newest < by.count {
            RuleOutcome::broken(
                format!("count {newest}, which is what is used"),
                format!("{} or more, as was played", by.count),
            )
        } else {
            RuleOutcome::kept(format!("received + {received}, nothing counted as wrong"))
        })
    }

    fn counted(&self, before: &Self, name: &str, played: u64) -> Result<RuleOutcome, String> {
        let by = self.since(before, name).ok_or_else(|| self.path(name))?;
        let expected = format!("{name} + {played}");
        let besides = self.besides(before, name);
        let is_kept = besides.is_none() && by == played;
        let besides = besides.map_or_else(String::new, |wrong| format!(", {wrong}"));
        Ok(RuleOutcome::of(
            is_kept,
            format!("{name} + {by}{besides}"),
            expected,
        ))
    }

    fn any(&self, before: &Self, name: &str) -> Result<RuleOutcome, String> {
        let by = self.since(before, name).ok_or_else(|| self.path(name))?;
        let expected = format!("{name} to go up");
        Ok(RuleOutcome::of(by > 0, format!("{name} + {by}"), expected))
    }

    fn error(&self, code: u32) -> Result<RuleOutcome, String> {
        let shown = self.axis.get("received_error").and_then(Value::as_u64);
        let shown = shown.ok_or("received_error of the axis")?;
        let expected = format!("{code}, the nErrorCode that came");
        let received = format!("received_error {shown}");
        Ok(RuleOutcome::of(
            shown == u64::from(code),
            received,
            expected,
        ))
    }

    fn run(&self, before: &Self, epoch: u64) -> Result<RuleOutcome, String> {
        let both = self.count("epoch").zip(self.since(before, "restarts"));
        let (followed, restarts) = both.ok_or_else(|| self.path("epoch, or no restarts"))?;
        let words =
            |epoch: u64, restarts: u64| format!("epoch {epoch:016x}, restarts + {restarts}");
        Ok(RuleOutcome::of(
            (followed, restarts) == (epoch, 1),
            words(followed, restarts),
            words(epoch, 1),
        ))
    }

    fn path(&self, name: &str) -> String {
        format!("{}.{name}", self.place)
    }
}
