//! What a scenario expects of its outcome.

use coaxle_host::fields_of;
use coaxle_receiver::{ReceiverConfig, SlaveConfig};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::scenario::{Scenario, receiver_of};
use crate::summary::{ReceiverSummary, SlaveSummary, Summary, World};
use crate::table::significant;

/// One expectation: a field of one receiver's summary against a bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Expectation {
    /// The receiver.
    pub receiver: String,
    /// One of its slaves, if the field is one of a slave's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slave: Option<String>,
    /// The field of its summary.
    pub field: String,
    /// The field must not be above this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// The field must not be below this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// The field must be exactly this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equals: Option<Value>,
    /// The field must not be above a share of another receiver's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most_share: Option<Share>,
    /// The only world it holds in; both if not said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world: Option<World>,
}

/// A share of the same field of another receiver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Share {
    /// The other receiver.
    pub of: String,
    /// The share.
    pub share: f64,
}

/// An expectation's outcome.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The receiver.
    pub receiver: String,
    /// The slave, if it is one of a slave's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slave: Option<String>,
    /// The field.
    pub field: String,
    /// What was expected, in words.
    pub expected: String,
    /// What came out.
    pub received: Value,
    /// Whether it holds.
    pub met: bool,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (place, received, expected) = (self.place(), &self.received, &self.expected);
        write!(f, "{place} is {received}, expected {expected}")
    }
}

impl Verdict {
    /// The receiver, the slave if it is one's, and the field.
    #[must_use]
    pub fn place(&self) -> String {
        let Self {
            receiver, field, ..
        } = self;
        match &self.slave {
            None => format!("{receiver}.{field}"),
            Some(slave) => format!("{receiver}.{slave}.{field}"),
        }
    }
}

impl Expectation {
    /// The receivers it speaks of.
    pub fn nodes(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self.receiver.as_str())
            .chain(self.at_most_share.iter().map(|share| share.of.as_str()))
    }

    /// Whether it can be judged at all. Gives the wrong field and the reason.
    pub(crate) fn check(&self, scenario: &Scenario) -> Result<(), (&'static str, String)> {
        for (name, field) in self.nodes().zip(["receiver", "at-most-share.of"]) {
            let views = judged_names(scenario);
            if !views.iter().any(|view| view == name) {
                let reason = format!("received {name:?}, expected one of: {}", views.join(", "));
                return Err((field, reason));
            }
        }
        let fields = match &self.slave {
            None => fields_of(&ReceiverSummary::default()),
            Some(name) => {
                let of_slave = |slave: &SlaveConfig| slave.name.as_str() == name;
                for node in self.nodes() {
                    let node = receiver_of(node);
                    let receiver = scenario.receivers.iter().find(|r| r.name.as_str() == node);
                    if !receiver.is_some_and(|r| r.slaves.iter().any(of_slave)) {
                        let reason = format!("received {name:?}, expected a slave of {node}");
                        return Err(("slave", reason));
                    }
                }
                fields_of(&SlaveSummary::default())
            }
        };
        if !fields.contains_key(&self.field) {
            let known: Vec<_> = fields.keys().map(String::as_str).collect();
            let reason = format!(
                "received {:?}, expected one of: {}",
                self.field,
                known.join(", ")
            );
            return Err(("field", reason));
        }
        let bounds = [
            self.at_most.is_some(),
            self.at_least.is_some(),
            self.equals.is_some(),
            self.at_most_share.is_some(),
        ];
        if bounds.iter().any(|given| *given) {
            Ok(())
        } else {
            let reason = "expected at least one of at-most, at-least, equals, at-most-share";
            Err(("field", reason.to_owned()))
        }
    }

    /// Judges it; none where it does not hold in this world.
    #[must_use]
    pub fn judge(&self, summary: &Summary) -> Option<Verdict> {
        if self.world.is_some_and(|world| world != summary.world) {
            return None;
        }
        let received = self.value_of(summary, &self.receiver);
        let mut expected = Vec::new();
        let mut met = true;
        if let Some(bound) = self.at_most {
            expected.push(format!("at most {bound}"));
            met &= number(&received).is_some_and(|n| n <= bound);
        }
        if let Some(bound) = self.at_least {
            expected.push(format!("at least {bound}"));
            met &= number(&received).is_some_and(|n| n >= bound);
        }
        if let Some(exactly) = &self.equals {
            expected.push(format!("{exactly}"));
            met &= same(exactly, &received);
        }
        if let Some(share) = &self.at_most_share {
            let other = self.value_of(summary, &share.of);
            expected.push(format!(
                "at most {} of {}, that of {}",
                share.share,
                number(&other).map_or_else(|| other.to_string(), |n| significant(n, 6)),
                share.of
            ));
            met &= match (number(&received), number(&other)) {
                (Some(this), Some(other)) => this <= share.share * other,
                _ => false,
            };
        }
        Some(Verdict {
            receiver: self.receiver.clone(),
            slave: self.slave.clone(),
            field: self.field.clone(),
            expected: expected.join(" and "),
            received,
            met,
        })
    }
}

impl Expectation {
    /// What came out for a receiver, or for its slave of the name.
    fn value_of(&self, summary: &Summary, receiver: &str) -> Value {
        let figures = summary.receivers.get(receiver);
        let fields = figures.and_then(|figures| match &self.slave {
            None => Some(fields_of(figures)),
            Some(slave) => figures.slaves.get(slave).map(fields_of),
        });
        fields
            .and_then(|fields| fields.get(&self.field).cloned())
            .unwrap_or(Value::Null)
    }
}

/// The names that figures are under: receivers, and where they follow several axes, each of them.
fn judged_names(scenario: &Scenario) -> Vec<String> {
    let names = |receiver: &ReceiverConfig| match &receiver.far_axis_names()[..] {
        [_] => vec![receiver.name.to_string()],
        axes => axes
            .iter()
            .map(|axis| format!("{}/{axis}", receiver.name))
            .collect(),
    };
    scenario.receivers.iter().flat_map(names).collect()
}

/// Numbers are the same if they have the same value, however they are written.
fn same(expected: &Value, received: &Value) -> bool {
    match (expected.as_f64(), received.as_f64()) {
        (Some(expected), Some(received)) => expected == received,
        _ => expected == received,
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_f64()
}
