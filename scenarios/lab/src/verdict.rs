//! Outcome of an expectation.

use serde::Serialize;
use serde_json::Value;

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
    /// Expected value, in words.
    pub expected: String,
    /// Received value.
    pub received: Value,
    /// True if met.
    pub met: bool,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (place, received, expected) = (self.place(), &self.received, &self.expected);
        write!(f, "{place} is {received}, expected {expected}")
    }
}

impl Verdict {
    /// The receiver, the slave if the outcome is about one, and the field.
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
