//! Signals: the values that a node shows after each cycle, declared once.
//!
//! A declaration is a struct with a line of meaning and a unit per field. Each cycle the node fills
//! a row of such structs; traces, status and lists of columns are derived from the declaration
//! without listing any field. `last` behind the unit keeps the value of the last cycle for the
//! summary of a run, and a label behind that shows it in tables of results.
//!
//! ```
//! use coaxle_node::signal::{Group, Kind, Signals};
//!
//! coaxle_node::signals! {
//!     /// A boiler.
//!     pub struct BoilerSignals of Node {
//!         /// Temperature of the water.
//!         temperature: f64 ["°C"],
//!         /// Times it went off.
//!         offs: u64 [""] last "went off",
//!     }
//! }
//! let row = BoilerSignals { temperature: 80.5, offs: 3 };
//! assert_eq!(BoilerSignals::GROUP, Group::Node);
//! let [temperature, offs] = BoilerSignals::SIGNALS else { panic!() };
//! assert_eq!((temperature.name, temperature.unit), ("temperature", "°C"));
//! assert_eq!((temperature.kind, offs.kind), (Kind::Number, Kind::Count));
//! assert_eq!(offs.meaning(), "Times it went off.");
//! assert_eq!((offs.is_summarized, offs.label), (true, Some("went off")));
//! assert!(!temperature.is_summarized);
//! # let _ = row;
//! ```

use std::fmt;

use crate::config::Unit;

mod kind;

pub use kind::Kind;
#[doc(hidden)]
pub use kind::{AnyOther, Field};

/// A value that a node shows after each cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// Signal name, as in traces and status.
    pub name: &'static str,
    /// Unit; `u` is that of the axis, empty without a unit.
    pub unit: &'static str,
    /// Kind of its values, by the type of its field.
    pub kind: Kind,
    /// True if the summary of a run has its value of the last cycle.
    pub is_summarized: bool,
    /// Label in tables of results; none: it is not shown there.
    pub label: Option<&'static str>,
    #[doc(hidden)]
    pub doc: &'static str,
}

impl Signal {
    /// Meaning, in one sentence or two.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        // A doc comment keeps the blank behind its slashes.
        self.doc.trim()
    }
}

/// Subject of a group of signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// The node itself.
    Node,
    /// An axis that it publishes.
    Axis,
    /// A node that it follows.
    FarNode,
    /// An axis of such a node.
    FarAxis,
    /// A virtual axis of its own.
    VirtualAxis,
    /// A slave of its own.
    Slave,
    /// True motion of an axis, known only to an experiment.
    Truth,
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Node => "node",
            Self::Axis => "axis",
            Self::FarNode => "far node",
            Self::FarAxis => "far axis",
            Self::VirtualAxis => "virtual axis",
            Self::Slave => "slave",
            Self::Truth => "truth",
        })
    }
}

/// A declared group of signals; see [`signals!`](crate::signals).
pub trait Signals {
    /// Subject of the signals.
    const GROUP: Group;
    /// The signals, in declaration order.
    const SIGNALS: &'static [Signal];
}

/// A part of a node that has signals: the node, a far node, a far axis, a virtual axis or a slave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instance {
    /// Kind of part.
    pub group: Group,
    /// Name, the prefix of its columns; empty for the node itself.
    pub name: String,
    /// Unit for the `u` of its signals.
    pub unit: Unit,
    /// Signals of the part.
    pub signals: &'static [Signal],
}

impl Instance {
    /// The instance of a declared group.
    #[must_use]
    pub fn of<S: Signals>(name: impl Into<String>) -> Self {
        Self {
            group: S::GROUP,
            name: name.into(),
            unit: Unit::default(),
            signals: S::SIGNALS,
        }
    }

    /// Sets the unit of its axis.
    #[must_use]
    pub fn in_unit(self, unit: Unit) -> Self {
        Self { unit, ..self }
    }

    /// Names of its columns: `instance.signal`.
    pub fn columns(&self) -> impl Iterator<Item = String> {
        let name = &self.name;
        self.signals.iter().map(move |signal| match name.as_str() {
            // The node itself has no prefix.
            "" => signal.name.to_owned(),
            name => format!("{name}.{}", signal.name),
        })
    }
}

/// The columns of a trace of these instances: ideal and actual start of the cycle, on the world's
/// reference clock (true time in the simulation, the machine's monotonic clock in the real world),
/// and every signal.
#[must_use]
pub fn trace_columns(instances: &[Instance]) -> Vec<String> {
    let when = ["at_ns", "woke_ns"].map(str::to_owned);
    let signals = instances.iter().flat_map(Instance::columns);
    when.into_iter().chain(signals).collect()
}

/// The signals of a group as a table of a document.
#[must_use]
pub fn table<S: Signals>(title: &str) -> String {
    let head = format!("## {title}\n\n| signal | unit | summary | meaning |\n|--|--|--|--|\n");
    let row = |signal: &Signal| {
        let Signal { name, unit, .. } = signal;
        let summary = if signal.is_summarized { "last" } else { "" };
        let meaning = signal.meaning();
        format!("| `{name}` | {unit} | {summary} | {meaning} |\n")
    };
    head + &S::SIGNALS.iter().map(row).collect::<String>()
}

/// Declares a group of signals: a struct of them, and their table.
#[macro_export]
macro_rules! signals {
    (
        $(#[$meta:meta])*
        pub struct $name:ident of $group:ident {
            $( $(#[doc = $doc:literal])+
                $signal:ident: $kind:ty [$unit:literal] $($last:ident $($label:literal)?)?, )*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        pub struct $name {
            $( $(#[doc = $doc])+ pub $signal: $kind, )*
        }

        impl $crate::signal::Signals for $name {
            const GROUP: $crate::signal::Group = $crate::signal::Group::$group;
            const SIGNALS: &'static [$crate::signal::Signal] = &[
                $( $crate::signal::Signal {
                    name: ::std::stringify!($signal),
                    unit: $unit,
                    kind: {
                        // Only used where the type is not one of the named ones.
                        #[allow(unused_imports)]
                        use $crate::signal::AnyOther as _;
                        $crate::signal::Field::<$kind>::KIND
                    },
                    is_summarized: $crate::signals!(@is_summarized $($last)?),
                    label: $crate::signals!(@label $($($label)?)?),
                    doc: ::std::concat!($($doc),+),
                }, )*
            ];
        }
    };
    (@is_summarized) => { false };
    (@is_summarized last) => { true };
    (@label) => { ::std::option::Option::None };
    (@label $label:literal) => { ::std::option::Option::Some($label) };
}
