//! Scenarios in virtual time.

mod accuracy;
mod catalogue;
mod common;
mod determinism;
mod zero_lag;
