//! The real world: threads, the operating system's clock, and a transport to other nodes.
//!
//! [`node::run()`] drives a [`Node`](coaxle_node::Node) from a [`Setup`](node::Setup), over Zenoh;
//! [`node::run_over()`] does it over any other transport, such as
//! [`InProcess`](network::transport::InProcess). The rooms, each of which knows only those above it:
//!
//! | room | contents |
//! |--|--|
//! | [`network`] | the [`Transport`](network::transport::Transport) to other nodes, and credentials for a secure network |
//! | [`machine`] | this PC: real-time settings, fitness for cycles, resources that a program needs |
//! | [`files`] | files of a run: traces and recordings |
//! | [`node`] | a node in real time: cycle thread, rings, command server, status |
//! | [`client`] | running nodes from outside: who is there, their statuses, commands to them |
//! | [`cli`] | the command line that all programs share |
//!
//! Only [`coaxle_os`] knows the operating system.
//! Only the module behind [`OverZenoh`](network::transport::OverZenoh) knows Zenoh.

pub mod cli;
pub mod client;
pub mod files;
pub mod machine;
pub mod network;
pub mod node;
