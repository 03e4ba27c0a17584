//! Variables of a unit, and their values.

use std::collections::BTreeMap;

use coaxle_node::config::Wrong;
use serde::{Deserialize, Serialize};

/// A variable. Its value reference is its place among all of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name, as in the traces of `docs/SIGNALS.md` where they have it.
    pub name: String,
    /// Meaning, in one sentence or two.
    pub description: String,
    /// Unit of measure; empty without one.
    pub unit: String,
    /// Role in the unit.
    pub causality: Causality,
    /// Value before the first step. It determines the type.
    pub start: UnitValue,
}

/// Role of a variable in a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// A value that is fixed when the simulation begins.
    Parameter,
    /// A value that is given before each step.
    Input,
    /// A value that others follow.
    Output,
    /// A value to look at.
    Local,
}

/// Value of a variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum UnitValue {
    /// A number. One that is not known is a NaN.
    Float64(f64),
    /// An integer that may be negative. One that is not known is 0.
    Int64(i64),
    /// A count. One that is not known is 0.
    UInt64(u64),
    /// True or false. One that is not known is false.
    Boolean(bool),
    /// A word or a text. One that is not known is empty.
    String(String),
}

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// `fmi3Float64`.
    Float64,
    /// `fmi3Int64`.
    Int64,
    /// `fmi3UInt64`.
    UInt64,
    /// `fmi3Boolean`.
    Boolean,
    /// `fmi3String`.
    String,
}

impl ValueKind {
    /// The name of the type in FMI.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Float64 => "Float64",
            Self::Int64 => "Int64",
            Self::UInt64 => "UInt64",
            Self::Boolean => "Boolean",
            Self::String => "String",
        }
    }
}

impl UnitValue {
    /// The type.
    #[must_use]
    pub const fn kind(&self) -> ValueKind {
        match self {
            Self::Float64(_) => ValueKind::Float64,
            Self::Int64(_) => ValueKind::Int64,
            Self::UInt64(_) => ValueKind::UInt64,
            Self::Boolean(_) => ValueKind::Boolean,
            Self::String(_) => ValueKind::String,
        }
    }
}

/// Variables of a unit, in the order of their value references, from time on.
#[derive(Clone, Debug, PartialEq)]
pub struct Variables {
    list: Vec<Variable>,
    by_name: BTreeMap<String, u32>,
}

impl Variables {
    /// The variables of a unit, behind its time.
    ///
    /// # Errors
    /// [`Wrong`]: a name twice.
    pub(crate) fn new(variables: Vec<Variable>) -> Result<Self, Wrong> {
        let time = Variable {
            name: "time".to_owned(),
            description: "Time of the simulation.".to_owned(),
            unit: "s".to_owned(),
            causality: Causality::Independent,
            start: UnitValue::Float64(0.0),
        };
        let list: Vec<_> = std::iter::once(time).chain(variables).collect();
        let mut by_name = BTreeMap::new();
        for (reference, variable) in (0..).zip(&list) {
            if by_name.insert(variable.name.clone(), reference).is_some() {
                let received = format!("two variables {:?}", variable.name);
                let expected = "slaves whose names are no signals of the receiver";
                return Err(Wrong::of("slave", received, expected));
            }
        }
        Ok(Self { list, by_name })
    }

    /// The variables.
    pub fn iter(&self) -> impl Iterator<Item = &Variable> {
        self.list.iter()
    }

    /// The variable with a value reference.
    #[must_use]
    pub fn get(&self, reference: u32) -> Option<&Variable> {
        self.list.get(usize::try_from(reference).ok()?)
    }

    /// The value reference of a name.
    #[must_use]
    pub fn reference(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).copied()
    }

    /// Place of a variable that the unit itself declares.
    pub(crate) fn place(&self, name: &str) -> usize {
        self.reference(name).map_or(0, |place| place as usize)
    }

    /// Values before the first step.
    pub(crate) fn starts(&self) -> Vec<UnitValue> {
        self.list.iter().map(|it| it.start.clone()).collect()
    }
}
