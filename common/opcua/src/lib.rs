//! OPC UA: running nodes as objects with their signals, commands as methods, changes of health and faults as events.
//! docs/OPCUA.md is its manual.
//!
//! * [`part`]: the objects of a node and their variables, from the table of its rows; [`rows`]: their newest values.
//! * [`mod@unit`]: units as codes of UNECE Recommendation 20.
//! * [`method`]: the arguments of each command, from the schema of commands, and the order that a call makes;
//!   [`outcome`]: the outputs of a call.
//! * [`occurrence`]: changes of a status as events.
//! * [`config`] and [`rights`]: the config file, and who may command.
//!
//! Nothing of these sends or receives. The server is in `host`, a feature.
//!
//! ```
//! use coaxle_node::command::{Addressee, SlaveName};
//! use coaxle_opcua::method::{ArgumentValue, CommandMethod};
//!
//! let methods = CommandMethod::of_slaves();
//! let power = methods.iter().find(|method| method.key == "power").ok_or("no power")?;
//! let carriage = Addressee::Slave(SlaveName::new("carriage")?);
//! let [is_dry_run, on] = [ArgumentValue::Flag(true), ArgumentValue::Flag(true)];
//! let order = power.order(carriage, &[is_dry_run, on]).map_err(|error| format!("{error:?}"))?;
//! assert!(order.is_dry_run());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod config;
#[cfg(feature = "host")]
pub mod host;
pub mod method;
pub mod occurrence;
pub mod outcome;
pub mod part;
pub mod rights;
pub mod rows;
pub mod unit;
