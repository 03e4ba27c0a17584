//! Clocks of machines, and the time of a far one.
//!
//! Instants typed by the clock that read them, signed spans, the wrapping cycle index of a far
//! sender, the block that turns that index into a correction time, and what is better than it: the
//! phase observer and the exchange that measures the delay. The observer is a bank of Kalman filters and a lower edge of the
//! delays. `examples/observer_table` compares it with other methods.
//!
//! To follow a far clock, take [`FarClock`]: messages and responses in, requests out, far time and its
//! uncertainty at any local instant. Its page has an example; `examples/follow.rs` follows a far clock
//! from files that receivers write: `cargo run --example follow -- saw-arrivals.csv saw-exchanges.csv`.
//!
//! | PLC name (TS5066) | here |
//! |--|--|
//! | `FB_TimeSync` | [`time_sync::TimeSync`] |
//! | `ST_TimeSyncParameters` | [`time_sync::TimeSyncParameters`] |
//! | `ST_TimeSyncDiagnostic` | [`time_sync::TimeSyncDiagnostic`] |
//! | `E_Sync_ErrorCodes` | [`time_sync::SyncError`] |
//! | `E_Sync_WarningCodes` | [`time_sync::SyncWarning`] |
//!
//! The crate is `no_std`, allocates nothing and reads no clock: every instant is an argument.
#![no_std]

#[cfg(any(test, feature = "perturb"))]
extern crate std;

pub mod age_gate;
pub mod common_time;
pub mod cycle;
pub mod cycle_lock;
pub mod delay;
pub mod far_clock;
pub mod instant;
mod numbers;
pub mod observer;
mod slewed_span;
mod straight_line;
pub mod time_sync;
pub mod timing;
#[cfg(feature = "perturb")]
pub mod tuning;
#[cfg(not(feature = "perturb"))]
mod tuning;
mod two_way;

pub use age_gate::{Age, AgeGate};
pub use cycle::{CycleIndex, CycleTime, Schedule};
pub use cycle_lock::CycleLock;
pub use delay::DelayExchange;
pub use far_clock::FarClock;
pub use instant::{Domain, Instant, Local, Remote, Seconds, Span};
pub use observer::PhaseObserver;
pub use slewed_span::SlewedSpan;

/// Iterates over the tuned constants of all blocks.
#[cfg(feature = "perturb")]
pub fn tuned_blocks() -> impl Iterator<Item = &'static tuning::TunedBlock> {
    let others = [
        delay::ALL_TUNED,
        timing::ALL_TUNED,
        &[age_gate::TUNED, two_way::TUNED],
    ];
    observer::TUNED.iter().copied().chain(others).flatten()
}
