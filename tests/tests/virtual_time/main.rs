//! Scenarios in virtual time.

mod accuracy;
mod catalogue;
mod common;
mod determinism;
