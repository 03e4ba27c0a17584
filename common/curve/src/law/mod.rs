//! Motion laws: the slave of a cam from one point to the next (TF5050 8.9, VDI 2143).
//!
//! A [`Segment`] is a law compiled between two [`Knot`]s. It can be evaluated at any master position, has
//! exact extremes, and finds the master positions of a slave position, all in closed form up to the roots
//! of its formulas and without allocating:
//!
//! ```
//! use coaxle_curve::law::{Knot, Motion, MotionLaw, Segment};
//!
//! let at = |master, position| Knot {
//!     master,
//!     motion: Motion { position, ..Motion::default() },
//! };
//! let segment = Segment::new(MotionLaw::Polynom5, &at(0.0, 0.0), &at(180.0, 40.0))?;
//! assert_eq!(segment.at(90.0).position, 20.0);
//! // The peak factor of the velocity is 1.875.
//! let peak = segment.extremes().velocity.maximum;
//! assert!((peak.value - 1.875 * 40.0 / 180.0).abs() < 1e-12);
//! assert_eq!(segment.masters_at(20.0)[0], 90.0);
//! # Ok::<(), coaxle_curve::law::LawError>(())
//! ```
//!
//! | laws | formula | family |
//! |--|--|--|
//! | `POLYNOM1`, `3`, `5`, `7`, `3_VV`, `5_MM`, `7_MM` | one polynomial through the derivatives at both ends | `polynom` |
//! | `POLYNOM8`, `9`, `11`, `PEISEKAH11` | one polynomial, written from either end | `high_degree` |
//! | `SINUSLINIE`, `BESTEHORN`, `MODSINUSLINIE`, `MODSINUSLINIE_VV` | arcs: pieces of a parabola plus sines | `sine` |
//! | `BESCHLTRAPEZ` and its `_RT`, `_TR`, `_RV`, `_VR` | arcs | `trapezoid` |
//! | `HARMONIC_KOMBI_RT`, `_TR`, `_VT`, `_TV` | arcs around a [`Turn`] | `harmonic` |
//! | `SPLINE` and its ends | cubics ([`Segment::cubic`]), found from all points of the spline | |

mod arc;
mod blend;
mod boundary;
mod demands;
mod error;
mod harmonic;
mod high_degree;
mod motion;
mod motion_law;
pub mod polynom;
pub mod polynomial;
pub mod roots;
mod segment;
mod sine;
mod trapezoid;
mod wave;

#[cfg(test)]
mod tests;

pub use error::{LawError, Quantity, Side};
pub use harmonic::Turn;
pub use motion::{Extreme, Extremes, Knot, MinMax, Motion};
pub use motion_law::MotionLaw;
pub use roots::Roots;
pub use segment::Segment;
