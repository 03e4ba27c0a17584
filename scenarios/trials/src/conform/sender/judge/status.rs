//! The status that a node publishes.

use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_os::Machine;
use serde_json::{Map, Value};

use super::FrameClock;
use super::rules::{SenderRule, Tallies};
use crate::conform::rule::{Mismatch, RuleOutcome, ensure, mismatch};

/// The longest that is read, bytes.
const LONGEST: usize = 16 << 20;
/// Shortest and longest mean pause, s: about four come each second.
const SHORTEST: f64 = 0.1;
const LONGEST_PAUSE: f64 = 1.0;
/// Time without a status that counts as none at all.
const STATUS_TIMEOUT: Span = Span::from_secs(2);
/// Greatest difference between its cycle and that of the frames, s.
const BEHIND: f64 = 1.5;

/// A field, its kind in words, and a check of a value.
type StatusField = (&'static str, &'static str, fn(&Value) -> bool);

/// Required fields of every node's status.
const FIELDS: [StatusField; 7] = [
    ("node", "a text", Value::is_string),
    ("role", "a text", Value::is_string),
    ("health", "a text", Value::is_string),
    ("epoch", "a text of 16 hexadecimal digits", is_epoch),
    ("uptime_s", "a number", Value::is_number),
    ("cycle", "a whole number", is_count),
    ("cycle_time_us", "a number", Value::is_number),
];

fn is_epoch(value: &Value) -> bool {
    value.as_str().and_then(epoch_of).is_some()
}

fn is_count(value: &Value) -> bool {
    value.is_u64()
}

/// An epoch as texts have it.
pub(super) fn epoch_of(text: &str) -> Option<u64> {
    let is_hex = text.len() == 16 && text.chars().all(|c| c.is_ascii_hexdigit());
    is_hex.then(|| u64::from_str_radix(text, 16).ok()).flatten()
}

/// Checks of the received statuses.
#[derive(Debug)]
pub(super) struct StatusChecks {
    node: NodeName,
    since: Instant<Machine>,
    /// Arrivals of the first and the last one.
    came: Option<(Instant<Machine>, Instant<Machine>)>,
}

impl StatusChecks {
    /// Listening since `since`.
    pub(super) fn new(node: &NodeName, since: Instant<Machine>) -> Self {
        Self {
            node: node.clone(),
            since,
            came: None,
        }
    }

    /// Takes a status that came at `at`.
    pub(super) fn take(
        &mut self,
        at: Instant<Machine>,
        bytes: &[u8],
        frames: Option<&FrameClock>,
        tallies: &mut Tallies,
    ) {
        let first = self.came.map_or(at, |(first, _)| first);
        self.came = Some((first, at));
        let status = match read(bytes) {
            Ok(status) => status,
            Err(bad) => {
                tallies.count(SenderRule::StatusJson, Err(bad));
                return;
            }
        };
        tallies.count(SenderRule::StatusJson, Ok(()));
        if tallies.count(SenderRule::StatusFields, check_fields(&status)) {
            let case = self.check_against(frames, at, &status);
            tallies.count(SenderRule::StatusTrue, case);
        }
    }

    pub(super) fn pace(&self, end: Instant<Machine>, tallies: &Tallies) -> RuleOutcome {
        let count = tallies.of(SenderRule::StatusJson).all();
        let Some((first, last)) = self.came else {
            let waited = end - self.since;
            if waited < STATUS_TIMEOUT {
                return RuleOutcome::not_seen("it takes two seconds");
            }
            let received = format!("none in {:.1} s", waited.as_secs_f64());
            return RuleOutcome::broken(received, "four a second");
        };
        // The silence behind the last one counts, too.
        let is_over = end - last > STATUS_TIMEOUT;
        let until = if is_over { end } else { last };
        if count < 3 && until - first < STATUS_TIMEOUT {
            return RuleOutcome::not_seen("it takes three of them");
        }
        let pause = (until - first).as_secs_f64() / (count.max(2) - 1) as f64;
        let is_kept = (SHORTEST..=LONGEST_PAUSE).contains(&pause);
        RuleOutcome::of(is_kept, format!("one every {pause:.3} s"), "four a second")
    }

    /// Checks a status against its key and the frames.
    fn check_against(
        &self,
        frames: Option<&FrameClock>,
        at: Instant<Machine>,
        status: &Map<String, Value>,
    ) -> Result<(), Mismatch> {
        let field = |is_good: bool, field: &str, expected: String| {
            ensure(is_good, || {
                mismatch(format!("{field}: {}", status[field]), expected)
            })
        };
        let node = self.node.as_str();
        let is_its_own = status["node"] == node;
        field(is_its_own, "node", format!("{node:?}, whose key it is"))?;
        let Some(frames) = frames else {
            return Ok(());
        };
        let is_its_run = status["epoch"].as_str().and_then(epoch_of) == Some(frames.epoch);
        let expected = format!("\"{:016x}\", as in its frames", frames.epoch);
        field(is_its_run, "epoch", expected)?;
        let cycle_us = frames.cycle_time.span().as_micros_f64();
        let is_its_cycle = status["cycle_time_us"].as_f64() == Some(cycle_us);
        let expected = format!("{cycle_us}, as in its frames");
        field(is_its_cycle, "cycle_time_us", expected)?;
        let cycle = frames.cycle_time.as_secs_f64();
        let count = frames.time(at).as_secs_f64() / cycle;
        let apart = status["cycle"].as_f64().unwrap_or(0.0) - count;
        let expected = format!("about {count:.0}, as in its frames");
        field((apart * cycle).abs() <= BEHIND, "cycle", expected)
    }
}

fn read(bytes: &[u8]) -> Result<Map<String, Value>, Mismatch> {
    ensure(bytes.len() <= LONGEST, || {
        mismatch(format!("{} bytes", bytes.len()), "16 MiB at most")
    })?;
    match serde_json::from_slice(bytes) {
        Ok(Value::Object(status)) => Ok(status),
        Ok(other) => {
            let received: String = other.to_string().chars().take(60).collect();
            Err(mismatch(received, "one JSON object"))
        }
        Err(error) => Err(mismatch(error.to_string(), "one JSON object in UTF-8")),
    }
}

fn check_fields(status: &Map<String, Value>) -> Result<(), Mismatch> {
    for (name, expected, is_good) in FIELDS {
        let value = status.get(name);
        ensure(value.is_some_and(is_good), || {
            let missing = || format!("no {name}");
            mismatch(
                value.map_or_else(missing, |value| format!("{name}: {value}")),
                expected,
            )
        })?;
    }
    Ok(())
}
