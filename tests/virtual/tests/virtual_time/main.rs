//! Scenarios in virtual time.

mod accuracy;
mod arrivals;
mod catalogue;
mod common;
mod cuts;
mod determinism;
mod faults;
mod hot_standby;
mod rotary_knife;
mod zero_lag;
