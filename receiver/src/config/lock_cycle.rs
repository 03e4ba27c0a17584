//! `lock-cycle`: the own cycle follows that of a far node.

use coaxle_clock::Span;
use coaxle_node::config::{AtLeastZero, Wrong};
use coaxle_node::keys::NodeName;
use coaxle_remote::FilterMode;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ReceiverConfig;

/// Lock of the own cycle to that of a far node.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct LockCycleConfig {
    /// The node, one that it follows in mode `observer`. The first one by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<NodeName>,
    /// Start of a cycle after the frame that is to be the newest one has arrived, µs: longer than the jitter of its way, and shorter than the cycle. Three tenths of
    /// the cycle time by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_us: Option<AtLeastZero>,
}

/// Lock of a receiver, resolved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LockedTo {
    /// Number of the far node.
    pub(crate) far: usize,
    pub(crate) offset: Span,
}

impl ReceiverConfig {
    /// The node that its cycle is locked to, if any.
    pub(crate) fn locked_to(&self) -> Option<LockedTo> {
        let lock = self.lock_cycle.as_ref()?;
        let cycle = self.cycle_time_us.0.span();
        let named = |node: &NodeName| self.far.iter().position(|far| far.node == *node);
        Some(LockedTo {
            far: lock.to.as_ref().map_or(Some(0), named)?,
            offset: (lock.offset_us)
                .map_or(cycle * 3 / 10, |offset| Span::from_micros_f64(offset.get())),
        })
    }

    /// Checks that there is such a node, that its clock is observed, and that the cycle begins before its next frame.
    pub(super) fn check_lock_cycle(&self) -> Result<(), Wrong> {
        let Some(lock) = &self.lock_cycle else {
            return Ok(());
        };
        let Some(LockedTo { far, offset }) = self.locked_to().filter(|to| to.far < self.far.len())
        else {
            let received = match &lock.to {
                Some(to) if *to == self.name => format!("{:?}, the node itself", to.as_str()),
                Some(to) => format!("{:?}", to.as_str()),
                None => "none, and no far node".to_owned(),
            };
            let known: Vec<_> = self.far.iter().map(|far| far.node.as_str()).collect();
            let expected = format!("a node that it follows: {}", known.join(", "));
            return Err(Wrong::of("lock-cycle.to", received, expected));
        };
        let mode = self.far[far].mode;
        if mode != FilterMode::Observer {
            let received = format!("{:?} in mode {}", self.far[far].node.as_str(), mode.name());
            let expected = "a node in mode observer, which knows its clock";
            return Err(Wrong::of("lock-cycle.to", received, expected));
        }
        let cycle = self.cycle_time_us.0.span();
        if offset >= cycle {
            let expected = format!("less than the cycle time, {} us", cycle.as_micros_f64());
            return Err(Wrong::of(
                "lock-cycle.offset-us",
                offset.as_micros_f64(),
                expected,
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::test_config::config;

    #[test]
    fn it_is_locked_to_the_first_node_or_the_one_named() {
        let lock = |text: &str| config(text).unwrap().locked_to();
        let to = |far, micros| {
            let offset = Span::from_micros(micros);
            Some(LockedTo { far, offset })
        };
        let two = "[[far]]\nnode = 'a'\n[[far]]\nnode = 'b'\n";
        assert_eq!(lock(two), None);
        assert_eq!(lock(&format!("lock-cycle = {{}}\n{two}")), to(0, 300));
        let named = "lock-cycle = { to = 'b', offset-us = 120 }\n";
        assert_eq!(lock(&format!("{named}{two}")), to(1, 120));
    }

    #[test]
    fn what_cannot_be_locked_to_is_refused() {
        for (text, expected) in [
            (
                "lock-cycle = { to = 'c' }",
                "lock-cycle.to: received \"c\", expected a node that it follows: a",
            ),
            (
                "mode = 'sync'\nlock-cycle = {}",
                "lock-cycle.to: received \"a\" in mode sync",
            ),
            (
                "lock-cycle = { offset-us = 1000 }",
                "lock-cycle.offset-us: received 1000, expected less than",
            ),
        ] {
            let error = config(&format!("{text}\nmaster.node = 'a'")).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
