//! What tests of several crates share.

pub mod hostile;
pub mod python;
pub mod retries;
