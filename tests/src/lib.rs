//! Helpers shared by tests of several crates.

pub mod python;
pub mod retries;
