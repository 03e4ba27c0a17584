//! Sources of axes: those that a sender publishes, and a receiver's own virtual axes.
//!
//! An [`AxisSource`] gives the motion of an axis at an instant: a [`MotionProgram`] of moves, one measured by an
//! [`EncoderSource`], or a recorded motion, [`Replay`]ed. [`config`] describes an axis and its source in a
//! config file, [`open()`] makes the source, and [`write_axis_struct()`] writes the axis structure of its
//! controller; a [`SourceAxis`] is all of it.
//!
//! ```
//! use coaxle_axis::NcToPlcAxis;
//! use coaxle_clock::Span;
//! use coaxle_node::config::parse;
//! use coaxle_source::SourceAxis;
//! use coaxle_source::config::AxisConfig;
//!
//! let config: AxisConfig = parse(
//!     "axis.toml",
//!     r#"
//!     id = 1
//!     name = "table"
//!     unit = "°"
//!     modulo = 360
//!
//!     [program]
//!     start-velocity = 90.0
//!     limits = { velocity = 180, acceleration = 720, jerk = 7200 }
//!     "#,
//! )?;
//! let mut axis = SourceAxis::open(&config)?;
//! let mut shown = NcToPlcAxis::default();
//! axis.at(Span::from_secs(5), &mut shown);
//! assert_eq!((shown.set_position, shown.set_velocity), (450.0, 90.0));
//! assert_eq!((shown.modulo_set_turns, shown.modulo_set_position), (1, 90.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `MC_Power` | Tc2_MC2 | [`StepConfig::Enable`](config::StepConfig::Enable) |
//! | `MC_MoveAbsolute` | Tc2_MC2 | [`StepConfig::MoveAbsolute`](config::StepConfig::MoveAbsolute) |
//! | `MC_MoveRelative` | Tc2_MC2 | [`StepConfig::MoveRelative`](config::StepConfig::MoveRelative) |
//! | `MC_MoveVelocity` | Tc2_MC2 | [`StepConfig::Velocity`](config::StepConfig::Velocity) |
//! | `MC_Halt` | Tc2_MC2 | [`StepConfig::Halt`](config::StepConfig::Halt) |
//! | `NCTOPLC_AXLESTRUCT` | TS5066 | [`write_axis_struct()`] |

mod axis;
mod axis_struct;
pub mod config;
mod encoder;
mod followers;
mod instructions;
mod open;
mod program;
mod replay;
mod source;

pub use axis::SourceAxis;
pub use axis_struct::write_axis_struct;
pub use encoder::EncoderSource;
pub use followers::Followers;
pub use open::open;
pub use program::MotionProgram;
pub use replay::{Replay, ReplayError};
pub use source::{Activity, AxisSource, SourceSample};
