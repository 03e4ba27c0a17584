//! The PC on which a node runs: real-time settings, fitness for cycles, clocks, resources that a program needs.

mod clocks;
mod finding;
pub mod fitness;
pub mod needs;
pub mod real_time;
