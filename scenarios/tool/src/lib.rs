//! The `coaxle` tool: one command line over all of it.
//!
//! [`cli`] knows every command and does none of them itself. From the top down:
//!
//! * scenarios: `run`, `soak` and `sweep`, over the lab, the report and the trials;
//! * running nodes: `status`, `why`, `when`, `audit`, `command`, `scope`, `recorded`, `ros2`, `doctor`, `topology`;
//! * files: `cam`, `saw` and `gear`, with pages to design them on (`edit`), which `web` serves as it does those of `scope`; `schema`, `signals`, `examples`, `node_config`;
//! * [`secure`]: rights in a network, and the certificates for them.

mod audit;
pub mod cam;
pub mod cli;
pub mod command;
pub mod doctor;
mod edit;
mod examples;
mod fmu;
pub mod gear;
mod init;
pub mod node_config;
mod overview;
mod recorded;
mod ros2;
mod run;
#[cfg(test)]
mod samples;
pub mod saw;
pub mod schema;
mod scope;
pub mod secure;
mod seed;
mod signals;
mod soak;
pub mod status;
mod sweep;
mod sync_flags;
mod topology;
mod web;
mod when;
mod why;
