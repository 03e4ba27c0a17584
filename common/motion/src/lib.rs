//! What moves.
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `NCTOPLC_AXLESTRUCT` | TS5066 | [`axis::NcToPlcAxis`] |
//! | `FB_AxisSync` | TS5066 | [`remote::AxisSync`] |
//! | `FB_AxisExtrapolateValues` | TS5066 | [`remote::AxisExtrapolate`] |
//!
//! The crate is `no_std` and asks no machine for the time.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod axis;
pub mod drive;
pub mod gear;
pub mod profile;
pub mod remote;
