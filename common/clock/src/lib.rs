//! What time is it?
//!
//! Instants typed by the clock that read them, signed spans, the wrapping cycle index of a far
//! sender, and the block that turns that index into a correction time.
//!
//! | PLC name (TS5066) | here |
//! |--|--|
//! | `FB_TimeSync` | [`time_sync::TimeSync`] |
//! | `ST_TimeSyncParameters` | [`time_sync::TimeSyncParameters`] |
//! | `ST_TimeSyncDiagnostic` | [`time_sync::TimeSyncDiagnostic`] |
//! | `E_Sync_ErrorCodes` | [`time_sync::SyncError`] |
//! | `E_Sync_WarningCodes` | [`time_sync::SyncWarning`] |
//!
//! The crate is `no_std`, allocates nothing and asks no machine for the time: every instant is an
//! argument.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod age_gate;
pub mod cycle;
pub mod instant;
pub mod observer;
pub mod time_sync;

pub use age_gate::{Age, AgeGate};
pub use cycle::{CycleIndex, CycleTime, Schedule};
pub use instant::{Domain, Instant, Local, Remote, Seconds, Span};
pub use observer::PhaseObserver;
