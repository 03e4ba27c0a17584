//! The PC on which a node runs: real-time settings, fitness for cycles, clocks, resources that a program needs, memory shared with a drive process.

mod clocks;
mod finding;
pub mod fitness;
pub mod needs;
pub mod real_time;
pub mod shared_memory;
