//! Scenarios in virtual time.

mod accuracy;
mod arrivals;
mod catalogue;
mod common;
mod cuts;
mod determinism;
mod rotary_knife;
mod zero_lag;
