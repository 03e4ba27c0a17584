//! A motion as a function: of the time, or of the position of a master.
//!
//! * [`profile`]: from one state of an axis to another, over time, within limits of velocity,
//!   acceleration and jerk.
//! * [`ramp`]: to a changing velocity, from cycle to cycle.
//! * [`law`]: the slave of a cam from one point to the next, over the master.
#![cfg_attr(
    feature = "alloc",
    doc = "* [`curve`]: such pieces one after the other, found quickly; [`spline`]: the cubics through many points."
)]
//! * [`between`]: the motion between two known states.
//! * [`quadrature`]: integrals over them.
//! * [`figure`]: numbers as messages show them.
//!
//! A motion is planned once, and evaluated at any place: with its derivatives and its own extremes.
//!
//! ```
//! use coaxle_clock::Seconds;
//! use coaxle_curve::law::{Knot, Motion, MotionLaw, Segment};
//! use coaxle_curve::profile::{Kinematics, Limits, to_position};
//!
//! // Over time: 50 mm, at most 100 mm/s.
//! let limits = Limits::new(100.0, 500.0, 500.0, 5_000.0)?;
//! let profile = to_position(&Kinematics::at_rest(0.0), 50.0, &limits);
//! assert_eq!(profile.at(profile.duration()).position, 50.0);
//!
//! // Over a master: 40 mm in half a turn.
//! let at = |master, position| Knot {
//!     master,
//!     motion: Motion { position, ..Motion::default() },
//! };
//! let segment = Segment::new(MotionLaw::Polynom5, &at(0.0, 0.0), &at(180.0, 40.0))?;
//! assert_eq!(segment.at(90.0).position, 20.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `MC_MotionFunctionType`, `MOTIONFUNCTYPE_…` | TF5050 8.9 | [`law::MotionLaw`] |
//!
//! The crate is `no_std`, allocates nothing without its feature `alloc`, and reads no clock.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod between;
#[cfg(feature = "alloc")]
pub mod curve;
pub mod figure;
pub mod law;
pub mod profile;
pub mod quadrature;
pub mod ramp;
#[cfg(feature = "alloc")]
pub mod spline;
