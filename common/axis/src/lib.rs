//! The axis: its data, state diagram, limits, couplings and drives.
//!
//! * The structure that one controller sends to another, once per cycle: [`NcToPlcAxis`], and its
//!   images in the memory of a PLC ([`ImageLayout`]).
//! * The PLCopen state diagram as a table, [`AxisStatus::after`] a [`Transition`]; a
//!   [`StateMachine`] has no other way to change a state.
//! * The limits of its set values: the [`guard`] checks motions before and during their execution,
//!   the [`set_value_guard`] keeps velocity, acceleration, jerk and software limits on the
//!   positions that leave the axis, for every motion.
//! * The progress of a command ([`CommandState`]), its identity ([`Job`]), and the phase of a
//!   coupling ([`CouplingPhase`]).
//! * The connection to its [`Masters`]: a [`Coupling`] of any kind. Each kind is a crate, which
//!   implements that and [`Engage`]; the slave axis uses only these traits.
//! * The follower of its set values: a [`drive`], simulated, in another process, or custom.
//! * A motion promised ahead: a [`motion_plan`].
//!
//! ```
//! use coaxle_axis::guard::{Guard, GuardRefusal};
//! use coaxle_axis::{AxisStatus, Transition};
//! use coaxle_curve::profile::{Kinematics, Limits};
//!
//! let standstill = AxisStatus::default().after(Transition::PowerOn);
//! assert_eq!(standstill, Some(AxisStatus::Standstill));
//! // Without power there is no motion.
//! assert_eq!(AxisStatus::Disabled.after(Transition::Move), None);
//!
//! let limits = Limits::new(100.0, 500.0, 500.0, 5_000.0)?;
//! let guard = Guard::new(limits, 0.0, 1_000.0);
//! assert_eq!(
//!     guard.check_target("position", 1_200.0),
//!     Err(GuardRefusal::SoftwareLimit { reached: 1_200.0, limit: 1_000.0 })
//! );
//! // At 100 mm/s it could not stop before the end any more.
//! let fast = Kinematics { position: 999.0, velocity: 100.0, acceleration: 0.0 };
//! assert!(guard.check_stop(998.9, &fast).is_err());
//! # Ok::<(), coaxle_curve::profile::InvalidLimit>(())
//! ```
//!
//! Positions are in user units (u, for example mm or degrees), time in seconds.
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `NCTOPLC_AXLESTRUCT`, `NCTOPLC_AXIS_REF` | TS5066 | [`NcToPlcAxis`], [`ImageLayout`] |
//! | `nStateDWord`, `nAxisState`, `nCoupleState` | TS5066 | [`StateWord`], [`AxisState`], [`CoupleState`] |
//! | `ModuloSetPos`, `ModuloSetTurns` | TS5066 | [`Modulo`], [`ModuloPosition`] |
//! | `VELOSYNC`, `POSSYNC1` | Tc2_MC2 | [`set_value_guard::DistancePolicy`] |
//! | `SMC_GetTravelTime` | CODESYS | [`motion_plan::MotionPlan::passage`] |
//! | the PLCopen state diagram, `MC_ReadStatus` | PLCopen part 1 | [`AxisStatus`] |
//!
//! The crate is `no_std`, allocates nothing and reads no clock.
#![no_std]

#[cfg(test)]
extern crate std;

mod awaits;
mod command_state;
mod coupling;
mod coupling_phase;
pub mod drive;
mod dynamics;
pub mod guard;
mod guard_error;
mod image;
mod job;
mod master_demands;
mod masters;
mod modulo;
pub mod motion_plan;
mod nc_to_plc;
mod plcopen;
pub mod set_value_guard;
mod state;
mod travel_direction;
mod window_monitor;

pub use awaits::Awaits;
pub use command_state::CommandState;
pub use coupling::{
    Coupling, CouplingEffect, Engage, NoFault, NotPlanned, PlanInputs, Planned, Scan, Step,
    SyncPositions,
};
pub use coupling_phase::CouplingPhase;
pub use dynamics::Dynamics;
pub use image::{IMAGE_LEN, ImageLayout, ImageLengthError};
pub use job::{Job, Origin};
pub use master_demands::MasterDemands;
pub use masters::Masters;
pub use modulo::{Modulo, ModuloPosition, WrongModulo};
pub use nc_to_plc::NcToPlcAxis;
pub use plcopen::{AxisStatus, StateMachine, Transition};
pub use state::{AxisState, CoupleState, StateWord};
pub use travel_direction::TravelDirection;
pub use window_monitor::WindowMonitor;
