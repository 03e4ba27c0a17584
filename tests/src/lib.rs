//! Helpers shared by tests of several crates.

pub mod ports;
pub mod python;
pub mod retries;
