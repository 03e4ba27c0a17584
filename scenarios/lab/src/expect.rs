//! Expectations of a scenario.

use coaxle_node::fields_of;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::number::significant;
use crate::summary::{Summary, World};
use crate::verdict::Verdict;

/// An expectation: a field of the summary of one receiver, or router, against a bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Expectation {
    /// The receiver.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub receiver: String,
    /// The router, instead of a receiver. There are none in real processes, and nothing is expected of them there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub router: Option<String>,
    /// The slave, if the field is one of a slave's.
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
    /// The only world in which it applies; both if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world: Option<World>,
}

/// The receiver that is meant by the name of one of its far axes, or by its own.
pub(crate) fn receiver_of(name: &str) -> &str {
    name.split_once('/').map_or(name, |(receiver, _)| receiver)
}

/// A share of the same field of another receiver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Share {
    /// The other receiver.
    pub of: String,
    /// The share.
    pub share: f64,
}

impl Expectation {
    /// The receivers it speaks of.
    pub fn nodes(&self) -> impl Iterator<Item = &str> {
        let receiver = self.router.is_none().then_some(self.receiver.as_str());
        (receiver.into_iter()).chain(self.at_most_share.iter().map(|share| share.of.as_str()))
    }

    /// True if it has a bound.
    pub(crate) const fn has_bound(&self) -> bool {
        self.at_most.is_some()
            || self.at_least.is_some()
            || self.equals.is_some()
            || self.at_most_share.is_some()
    }

    /// Judges it; none where it does not apply in this world.
    #[must_use]
    pub fn judge(&self, summary: &Summary) -> Option<Verdict> {
        if self.world.is_some_and(|world| world != summary.world) {
            return None;
        }
        if self.router.is_some() && summary.world == World::Processes {
            return None;
        }
        let received = self.value_of(summary, &self.receiver);
        let mut expected = Vec::new();
        let mut met = true;
        if let Some(bound) = self.at_most {
            expected.push(format!("at most {bound}"));
            // A value that is missing meets no bound: a receiver that never synchronised has no error, but is no success.
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
                // Inclusive, so that a share of 1 allows equal figures.
                (Some(this), Some(other)) => this <= share.share * other,
                _ => false,
            };
        }
        Some(Verdict {
            receiver: self.router.as_ref().unwrap_or(&self.receiver).clone(),
            slave: self.slave.clone(),
            field: self.field.clone(),
            expected: expected.join(" and "),
            received,
            met,
        })
    }
}

impl Expectation {
    /// Value of the field for a receiver, or for its slave of this name.
    fn value_of(&self, summary: &Summary, receiver: &str) -> Value {
        if let Some(router) = &self.router {
            let fields = summary.routers.get(router).map(fields_of);
            let value = fields.and_then(|fields| fields.get(&self.field).cloned());
            return value.unwrap_or(Value::Null);
        }
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

/// Numbers are the same if they have the same value, however they are written.
fn same(expected: &Value, received: &Value) -> bool {
    match (expected.as_f64(), received.as_f64()) {
        // TOML has 3 and 3.0, and JSON whole numbers of either sign: types differ where values do not.
        (Some(expected), Some(received)) => expected == received,
        _ => expected == received,
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_f64()
}
