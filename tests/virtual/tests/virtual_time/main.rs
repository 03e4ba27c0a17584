//! Scenarios in virtual time.

mod accuracy;
mod arrivals;
mod cases;
mod catalogue;
mod common;
mod common_time;
mod cuts;
mod determinism;
mod faults;
mod hot_standby;
mod random_schedules;
mod rotary_knife;
mod same_stream;
mod start_up;
mod topology;
mod zero_lag;
