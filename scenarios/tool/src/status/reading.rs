//! A status, or a part of it, as JSON: a missing field is unknown.

use serde_json::{Map, Value};

/// Fields by their names.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatusFields<'a>(&'a Map<String, Value>);

impl<'a> StatusFields<'a> {
    pub(crate) const fn of(fields: &'a Map<String, Value>) -> Self {
        Self(fields)
    }

    /// A field of any type; `null` if its value is unknown.
    pub(crate) fn value(&self, name: &str) -> Option<&'a Value> {
        self.0.get(name)
    }

    pub(crate) fn number(&self, name: &str) -> Option<f64> {
        // Nodes of an older version lack fields, and unknown values are null: both are unknown here.
        self.0.get(name)?.as_f64()
    }

    /// A counter; 0 if it is not there.
    pub(crate) fn count(&self, name: &str) -> u64 {
        let count = self.0.get(name).and_then(Value::as_u64);
        // Counters begin at 0, so an older node without one has counted nothing.
        count.unwrap_or_default()
    }

    pub(crate) fn text(&self, name: &str) -> Option<&'a str> {
        self.0.get(name)?.as_str()
    }

    pub(crate) fn is(&self, name: &str) -> bool {
        self.0.get(name).and_then(Value::as_bool) == Some(true)
    }

    /// A part with fields of its own.
    pub(crate) fn part(&self, name: &str) -> Option<Self> {
        self.0.get(name)?.as_object().map(Self)
    }

    /// The parts of a part, with their names.
    pub(crate) fn parts(&self, name: &str) -> impl Iterator<Item = (&'a str, Self)> {
        let all = self.0.get(name).and_then(Value::as_object);
        let parts = all.into_iter().flatten();
        parts.filter_map(|(name, part)| Some((name.as_str(), Self(part.as_object()?))))
    }

    /// Names in a list, with commas.
    pub(crate) fn names(&self, name: &str) -> String {
        self.texts(name).collect::<Vec<_>>().join(", ")
    }

    /// The texts of a list.
    pub(crate) fn texts(&self, name: &str) -> impl Iterator<Item = &'a str> {
        let list = self.0.get(name).and_then(Value::as_array);
        list.into_iter().flatten().filter_map(Value::as_str)
    }

    /// A fault: `0x4B52: what it means`.
    pub(crate) fn fault(&self, name: &str) -> Option<String> {
        let fault = self.part(name)?;
        Some(format!("{}: {}", fault.text("code")?, fault.text("text")?))
    }

    pub(crate) fn fields(&self) -> impl Iterator<Item = (&'a str, &'a Value)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }
}
