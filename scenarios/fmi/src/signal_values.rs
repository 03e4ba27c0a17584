//! Signals as variables, and their values.

use coaxle_node::config::Unit;
use coaxle_node::signal::{Kind, Signal, Signals};
use serde::Serialize;

use crate::variable::{Causality, UnitValue, Variable};

/// Signals of one part of a node, as variables.
pub(crate) struct SignalVariables<'a> {
    /// Beginning of their names: `axis.`; empty for the node itself.
    pub(crate) prefix: &'a str,
    pub(crate) causality: Causality,
    /// Unit of the axis.
    pub(crate) unit: &'a Unit,
    /// Unit of its master.
    pub(crate) master_unit: &'a Unit,
}

impl SignalVariables<'_> {
    /// The variables of the signals with these names; of all for an empty list.
    pub(crate) fn of<S: Signals>(&self, names: &[&str]) -> Vec<Variable> {
        chosen::<S>(names)
            .map(|signal| self.variable(signal))
            .collect()
    }

    fn variable(&self, signal: &Signal) -> Variable {
        let unit = match signal.unit.strip_prefix("master ") {
            Some(unit) => self.master_unit.in_place_of_u(unit),
            None => self.unit.in_place_of_u(signal.unit),
        };
        Variable {
            name: format!("{}{}", self.prefix, signal.name),
            description: signal.meaning().to_owned(),
            // In FMI only numbers have one.
            unit: match signal.kind {
                Kind::Number => unit,
                Kind::Integer | Kind::Count | Kind::Flag | Kind::Text => String::new(),
            },
            causality: self.causality,
            start: unknown(signal.kind),
        }
    }
}

/// Writes the signals with these names to values, in their order; all for an empty list.
pub(crate) fn write<S: Signals + Serialize>(signals: &S, names: &[&str], values: &mut [UnitValue]) {
    // What cannot be written as JSON has no signals: those are numbers, flags and words.
    let written = serde_json::to_value(signals).unwrap_or_default();
    for (signal, value) in chosen::<S>(names).zip(values) {
        *value = value_of(signal.kind, &written[signal.name]);
    }
}

fn chosen<S: Signals>(names: &[&str]) -> impl Iterator<Item = &'static Signal> {
    let is_chosen = move |signal: &&Signal| names.is_empty() || names.contains(&signal.name);
    S::SIGNALS
        .iter()
        .filter(is_chosen)
        .collect::<Vec<_>>()
        .into_iter()
}

fn value_of(kind: Kind, written: &serde_json::Value) -> UnitValue {
    let known = match kind {
        Kind::Number => written.as_f64().map(UnitValue::Float64),
        Kind::Count => written.as_u64().map(UnitValue::UInt64),
        Kind::Integer => written.as_i64().map(UnitValue::Int64),
        Kind::Flag => written.as_bool().map(UnitValue::Boolean),
        Kind::Text => written
            .as_str()
            .map(|word| UnitValue::String(word.to_owned())),
    };
    known.unwrap_or_else(|| unknown(kind))
}

/// The value of a signal that is not known.
const fn unknown(kind: Kind) -> UnitValue {
    match kind {
        Kind::Number => UnitValue::Float64(f64::NAN),
        Kind::Count => UnitValue::UInt64(0),
        Kind::Integer => UnitValue::Int64(0),
        Kind::Flag => UnitValue::Boolean(false),
        Kind::Text => UnitValue::String(String::new()),
    }
}
