//! Units for co-simulation by FMI 3.0: Coaxle inside another simulation.
//!
//! A unit is an archive (`.fmu`) of a description, a library and resources, which a co-simulation loads and steps. There are two kinds:
//!
//! | unit | inputs | outputs | made of |
//! |--|--|--|--|
//! | [`link`](LinkUnitModel) | motion of a master | the far axis at the other end: over clocks, a network with its faults, and a receiver | a scenario of one sender and one receiver |
//! | [`slave`](SlaveUnitModel) | motion of a master, and commands | set values and state of a slave axis | a saw, gear or cam file |
//!
//! A [`Model`] is what a unit is by its [`Resources`]: its variables, and how it starts. A [`UnitInstance`] is one under way, by the
//! rules of FMI; `scenarios/fmu` lays the functions of the standard over it. A [`package`](UnitPackage) is the archive.
//! Units are deterministic: the same parameters, inputs and steps give the same outputs, to the last bit. A state of an instance is
//! therefore the record of what it was given, and is restored by doing it again.
//!
//! ```
//! use coaxle_fmi::{Resources, UnitInstance, UnitValue};
//!
//! let text = std::fs::read_to_string("../saws/saw-velocity-1.toml")?;
//! let model = Resources::of_slave("saw.toml", &text, 1000)?.model(std::path::Path::new(""))?;
//! let mut saw = UnitInstance::new(model);
//! saw.enter_initialization(0.0)?;
//! saw.exit_initialization()?;
//! let velocity = saw.reference("master.velocity").ok_or("no such variable")?;
//! saw.set(velocity, UnitValue::Float64(500.0))?;
//! saw.step(0.0, 0.001)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod communication;
mod description;
mod instance;
mod journal;
mod link;
mod mode;
mod model;
mod package;
mod resources;
mod signal_values;
mod slave;
mod state;
mod units_of_measure;
mod variable;

pub use instance::UnitInstance;
pub use link::LinkUnitModel;
pub use model::{CoSimulation, Model};
pub use package::{LIBRARY, PLATFORM, UnitPackage};
pub use resources::{MOST_FILE_BYTES, Resources, UnitKind};
pub use slave::SlaveUnitModel;
pub use state::InstanceState;
pub use variable::{Causality, UnitValue, ValueKind, Variable, Variables};
