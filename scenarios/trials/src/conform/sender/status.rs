//! The status that a node publishes.

use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_os::Machine;
use serde_json::{Map, Value};

use super::exchange::FrameClock;
use super::rules::{STATUS_FIELDS, STATUS_JSON, STATUS_PACE, STATUS_TRUE};
use crate::conform::rule::{RuleFinding, RuleOutcome, Tally};

/// The longest that is read, bytes.
const LONGEST: usize = 16 << 20;
/// Shortest and longest mean pause, s: about four come each second.
const SHORTEST: f64 = 0.1;
const LONGEST_PAUSE: f64 = 1.0;
/// Time without a status that counts as none at all.
const STATUS_TIMEOUT: Span = Span::from_secs(2);
/// Share of statuses that may differ in run from the newest frame: a restarting node reports before it sends, or after.
const BETWEEN_RUNS: f64 = 0.1;
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
    json: Tally,
    fields: Tally,
    is_true: Tally,
    since: Instant<Machine>,
    first: Option<Instant<Machine>>,
    last: Option<Instant<Machine>>,
}

impl StatusChecks {
    /// Listening since `since`.
    pub(super) fn new(node: &NodeName, since: Instant<Machine>) -> Self {
        Self {
            node: node.clone(),
            json: Tally::default(),
            fields: Tally::default(),
            is_true: Tally::default(),
            since,
            first: None,
            last: None,
        }
    }

    /// Takes a status that came at `at`.
    pub(super) fn take(&mut self, at: Instant<Machine>, bytes: &[u8], frames: Option<&FrameClock>) {
        self.first.get_or_insert(at);
        self.last = Some(at);
        let status = match serde_json::from_slice(bytes) {
            _ if bytes.len() > LONGEST => {
                self.json
                    .bad(format!("{} bytes", bytes.len()), "16 MiB at most");
                return;
            }
            Ok(Value::Object(status)) => status,
            Ok(other) => {
                let received = other.to_string().chars().take(60).collect::<String>();
                self.json.bad(received, "one JSON object");
                return;
            }
            Err(error) => {
                self.json.bad(error.to_string(), "one JSON object in UTF-8");
                return;
            }
        };
        self.json.good();
        let wrong = FIELDS.iter().find(|(name, _, is_good)| {
            let value = status.get(*name);
            !value.is_some_and(is_good)
        });
        self.fields.check(wrong.is_none(), || {
            let (name, expected) = wrong.map_or(("", ""), |(name, expected, _)| (*name, *expected));
            let received = match status.get(name) {
                Some(value) => format!("{name}: {value}"),
                None => format!("no {name}"),
            };
            (received, expected.to_owned())
        });
        if wrong.is_none() {
            self.judge(at, &status, frames);
        }
    }

    /// Findings at `end`.
    pub(super) fn findings(&self, end: Instant<Machine>) -> Vec<RuleFinding> {
        let none = "no status came";
        let some = "no status with all fields came";
        vec![
            RuleFinding::new(&STATUS_JSON, self.json.outcome("messages", none)),
            RuleFinding::new(
                &STATUS_FIELDS,
                self.fields
                    .outcome("messages", "no status came that is JSON"),
            ),
            RuleFinding::new(
                &STATUS_TRUE,
                self.is_true.outcome_but_for(BETWEEN_RUNS, "messages", some),
            ),
            RuleFinding::new(&STATUS_PACE, self.pace(end)),
        ]
    }

    /// Checks a status against the frames.
    fn judge(
        &mut self,
        at: Instant<Machine>,
        status: &Map<String, Value>,
        frames: Option<&FrameClock>,
    ) {
        let wrong = self.contradiction(at, status, frames);
        self.is_true
            .check(wrong.is_none(), || wrong.unwrap_or_default());
    }

    fn contradiction(
        &self,
        at: Instant<Machine>,
        status: &Map<String, Value>,
        frames: Option<&FrameClock>,
    ) -> Option<(String, String)> {
        let wrong =
            |field: &str, expected: String| Some((format!("{field}: {}", status[field]), expected));
        if status["node"] != self.node.as_str() {
            return wrong("node", format!("{:?}, whose key it is", self.node.as_str()));
        }
        let frames = frames?;
        if status["epoch"].as_str().and_then(epoch_of) != Some(frames.epoch) {
            return wrong(
                "epoch",
                format!("\"{:016x}\", as in its frames", frames.epoch),
            );
        }
        let cycle_us = frames.cycle_time.span().as_micros_f64();
        if status["cycle_time_us"].as_f64() != Some(cycle_us) {
            return wrong("cycle_time_us", format!("{cycle_us}, as in its frames"));
        }
        let cycle = frames.cycle_time.as_secs_f64();
        let count = (frames.left + (at - frames.at)).as_secs_f64() / cycle;
        let apart = status["cycle"].as_f64().unwrap_or(0.0) - count;
        if (apart * cycle).abs() > BEHIND {
            return wrong("cycle", format!("about {count:.0}, as in its frames"));
        }
        None
    }

    fn pace(&self, end: Instant<Machine>) -> RuleOutcome {
        let count = self.json.all();
        let (Some(first), Some(last)) = (self.first, self.last) else {
            let waited = end - self.since;
            return match waited >= STATUS_TIMEOUT {
                true => RuleOutcome::broken(
                    format!("none in {:.1} s", waited.as_secs_f64()),
                    "four a second",
                ),
                false => RuleOutcome::not_seen("it takes two seconds"),
            };
        };
        // The silence behind the last one counts, too.
        let until = if end - last > STATUS_TIMEOUT {
            end
        } else {
            last
        };
        if count < 3 && until - first < STATUS_TIMEOUT {
            return RuleOutcome::not_seen("it takes three of them");
        }
        let pause = (until - first).as_secs_f64() / (count.max(2) - 1) as f64;
        let words = format!("one every {pause:.3} s");
        if (SHORTEST..=LONGEST_PAUSE).contains(&pause) {
            return RuleOutcome::kept(words);
        }
        RuleOutcome::broken(words, "four a second")
    }
}
