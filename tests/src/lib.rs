//! Helpers shared by tests of several crates.

pub mod hostile;
pub mod python;
pub mod retries;
