//! Cam plates: the slave as a function of the master. TF5050.
//!
//! A plate is a [`MotionFunction`] (few points, a [law](coaxle_curve::law) from each to the next) or a
//! [`PositionTable`] (many rows, interpolated), passed once or repeated:
//!
//! ```
//! use coaxle_plate::{Course, MotionFunction, MotionPoint, Plate};
//!
//! let up_and_down = [
//!     MotionPoint::rest(1, 0.0, 0.0),
//!     MotionPoint::rest(2, 180.0, 50.0),
//!     MotionPoint::rest(3, 360.0, 0.0),
//! ];
//! let plate = Plate::from_function(MotionFunction::new(up_and_down.into())?, Course::Cyclic);
//!
//! assert_eq!(plate.at(180.0).position, 50.0);
//! assert_eq!(plate.at(180.0 + 3.0 * 360.0).position, 50.0);
//! assert!((plate.at(90.0).position - 25.0).abs() < 1e-12);
//! let masters: Vec<f64> = plate.masters_at(25.0).collect();
//! assert!((masters[0] - 90.0).abs() < 1e-9 && (masters[1] - 270.0).abs() < 1e-9);
//! # Ok::<(), coaxle_plate::CamError>(())
//! ```
//!
//! Positions are in master units (x) and slave units (u), raw: offsets and scalings belong to the
//! coupling. Derivatives are with respect to the master unless they say "over time".
//!
//! | PLC name | TF5050 | here |
//! |--|--|--|
//! | `MC_MotionFunctionPoint`, `MC_MotionFunctionPoint_ID` | 8.7, 8.8 | [`MotionPoint`] |
//! | `MC_MotionFunctionType` | 8.9 | [`MotionLaw`](coaxle_curve::law::MotionLaw) |
//! | `MC_MotionPointType` | 8.10 | [`PointType`] |
//! | `MC_CAM_REF`, `Periodic` | 8.2, 4.1 | [`PlateSource`], [`Plate`], [`Course`] |
//! | `MC_TableType` | 8.13 | [`TableType`] |
//! | `MC_InterpolationType` | 8.6 | [`Interpolation`] |
//! | `MC_TableErrorCodes` | 8.12 | [`CamError`] |
//! | `MC_ReadMotionFunction` | 6.1 | [`MotionFunction::read`] |
//! | `MC_ReadMotionFunctionPoint` | 6.2 | [`MotionFunction::point`] |
//! | `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint` | 6.3, 6.4 | [`Plate::change`] |
//! | `MC_ReadMotionFunctionValues` | 6.6 | [`Plate::values`] |
//! | `MC_ValueSelectType` | 8.14 | [`ValueSelect`] |
//! | `MC_ReadCamTableSlaveDynamics` | 7.1 | [`Plate::slave_dynamics`] |
//! | `MC_ReadCamTableCharacteristics` | 7.4 | [`Plate::characteristics`] |
//! | `MC_TableCharacValues` | 8.11 | [`Characteristics`] |
//! | `MC_ReadCamTableMasterPosition` | 7.5 | [`Plate::master_positions`], [`MasterQuery`] |
//! | `CamMasterData` | 8.17 | [`MasterPosition`] |
//!
//! The crate is `no_std` and reads no clock. A plate allocates when it is made; reading and changing it
//! does not.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod advice;
mod characteristics;
mod compile;
mod curve_peaks;
mod error;
mod function;
mod inverse;
mod joints;
mod kind;
mod neighbours;
mod peaks;
mod plate;
mod point;
mod source;
mod steps;
mod table;
mod values;
#[cfg(feature = "serde")]
mod written;

#[cfg(test)]
mod tests;

pub use advice::{Demand, LawAdvice, LawCriteria, LawLimits};
pub use characteristics::{Characteristics, PlateEnd};
pub use curve_peaks::PeakDemands;
pub use error::{CamError, PlateLocation};
pub use function::MotionFunction;
pub use inverse::{MasterPosition, MasterQuery};
pub use joints::Joint;
pub use kind::{Course, TableType};
pub use plate::{Cursor, Plate, slave_of};
pub use point::{MotionPoint, PointType};
pub use source::{PlateSource, SourceRows};
pub use steps::VelocityStep;
pub use table::{Interpolation, PositionTable};
pub use values::{ValueRow, ValueSelect};
#[cfg(feature = "serde")]
pub use written::WrittenPoint;
