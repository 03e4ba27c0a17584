//! Signals: what a node shows of itself after each cycle, declared once.
//!
//! A declaration is a struct with a line of meaning and a unit per field. Each cycle the node fills a row of
//! such structs; traces, status and lists of columns are made from the declaration and know no field by
//! hand. `last` behind the unit keeps the value of the last cycle for the summary of a run, and a label
//! behind that shows it in tables of results.
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
    /// Its name, as in traces and status.
    pub name: &'static str,
    /// Its unit; `u` is that of the axis, empty what has none.
    pub unit: &'static str,
    /// What its values are, by the type of its field.
    pub kind: Kind,
    /// Whether the summary of a run has its value of the last cycle.
    pub is_summarized: bool,
    /// What tables of results call it; none: they do not show it.
    pub label: Option<&'static str>,
    #[doc(hidden)]
    pub doc: &'static str,
}

impl Signal {
    /// What it says, in one sentence or two.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        self.doc.trim()
    }
}

/// What a signal is about.
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
    /// What an axis truly did, as an experiment knows it.
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
    /// What they are about.
    const GROUP: Group;
    /// The signals, in their order.
    const SIGNALS: &'static [Signal];
}

/// What of a node has signals: it, a far node, a far axis, a virtual axis or a slave, with all of its signals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instance {
    /// What it is.
    pub group: Group,
    /// Its name, which columns have in front; the node itself has none.
    pub name: String,
    /// What the `u` of its signals stands for.
    pub unit: Unit,
    /// Its signals.
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

    /// The same with an axis in this unit.
    #[must_use]
    pub fn in_unit(self, unit: Unit) -> Self {
        Self { unit, ..self }
    }

    /// The names of its columns: `instance.signal`.
    pub fn columns(&self) -> impl Iterator<Item = String> {
        let name = &self.name;
        self.signals.iter().map(move |signal| match name.as_str() {
            "" => signal.name.to_owned(),
            name => format!("{name}.{}", signal.name),
        })
    }
}

/// The columns of a trace of these instances: when the cycle began ideally and really, on the world's
/// reference clock (true time in the simulation, the machine's monotonic clock in the real world), and every
/// signal.
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
                        // Only of use where the type is none of those that are named.
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
