//! Tests of real processes over real Zenoh.
//!
//! A scenario runs as processes, nodes are watched and supervised, attacked in a secure network, and talk to programs that others wrote.

mod conform;
mod gateway;
mod linuxcnc;
mod opcua;
mod python_package;
mod ros2;
mod runs;
mod secure;
mod supervised;
mod watched;
