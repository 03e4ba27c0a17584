//! Couplings by cam plates: one slave follows one master by up to four superposed plates.
//!
//! ```
//! use coaxle_cam::{
//!     CamCoupling, CamIn, CamLimits, CamRequest, CouplingParameters, Tables,
//! };
//! use coaxle_plate::{Course, Interpolation, Plate, PositionTable};
//! use coaxle_curve::profile::Kinematics;
//!
//! let rows = [(0.0, 0.0), (90.0, 30.0), (360.0, 0.0)];
//! let table = PositionTable::new(&rows, Interpolation::Linear, Course::Cyclic)?;
//! let mut tables = Tables::new(16);
//! tables.insert(1, Plate::from_table(table))?;
//!
//! let mut coupling = CamCoupling::new(CouplingParameters {
//!     master_axis_id: 1,
//!     slave_axis_id: 2,
//!     limits: CamLimits {
//!         velocity: 1_000.0,
//!         acceleration: 10_000.0,
//!         deceleration: 10_000.0,
//!         jerk: 1e6,
//!         cycle: 1e-3,
//!     },
//! })?;
//! let cam_in = CamRequest::from(CamIn { table: 1, slave_scaling: 2.0, ..CamIn::default() });
//! let (master, slave) = (Kinematics::at_rest(0.0), Kinematics::at_rest(0.0));
//! coupling.start(&mut tables, &cam_in, &master, &slave)?;
//!
//! let master = Kinematics { position: 45.0, velocity: 9.0, acceleration: 0.0 };
//! let slave = coupling.update(&mut tables, &master);
//! assert_eq!(slave.position, 30.0);
//! assert!((slave.velocity - 6.0).abs() < 1e-12);
//! # Ok::<(), coaxle_cam::CouplingError>(())
//! ```
//!
//! [`Tables`] holds the plates, [`CamCoupling`] is one slave's coupling; [`Cam`] is that of a slave axis. They take commands as values; `coaxle-plc` wraps them as PLC function blocks.
//!
//! | PLC name | TF5050 | here |
//! |--|--|--|
//! | `MC_CamTableSelect` | 4.1 | [`Tables::insert`]; while the axis runs [`Tables::select`], [`PreparedTable`]; by a program [`Tables::reserve`], [`Tables::select_reserved`] |
//! | `MC_CamOut` | 4.2 | [`CamOut`] |
//! | `MC_CamIn`, `ST_CamInOptions` | 4.3, 8.16 | [`CamIn`] |
//! | `MC_CamScaling` | 4.5 | [`CamScaling`] |
//! | `MC_CamIn_V2`, `ST_CamInOptions_V2` | 5.1 | [`CamInV2`] |
//! | `MC_CamAdd`, `ST_CamAddOptions` | 5.2 | [`CamAdd`] |
//! | `MC_CamExchange`, `ST_CamExchangeOptions` | 5.3 | [`CamExchange`] |
//! | `MC_CamRemove`, `ST_CamRemoveOptions` | 5.4 | [`CamRemove`] |
//! | `MC_CamScaling_V2`, `ST_CamScalingOptions_V2` | 5.5 | [`CamScalingV2`] |
//! | `MC_ReadMotionFunction`, `MC_ReadMotionFunctionPoint` | 6.1, 6.2 | [`Tables::read`] |
//! | `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint` | 6.3, 6.4 | [`Tables::write`] |
//! | `MC_SetCamOnlineChangeMode` | 6.5 | [`Tables::set_online_change_mode`], [`OnlineChangeMode`] |
//! | reading a plate | 6.6, 7.1, 7.4, 7.5 | [`Tables::read_plate`], and then [`Plate`](coaxle_plate::Plate) |
//! | `MC_CamInfo`, `MC_CamInfo_V2` | 7.2, 7.3 | [`CamCoupling::info`] |
//! | `MC_CAM_ID` | 8.1 | [`TableId`] |
//! | `MC_CamActivationMode` | 8.3 | [`ActivationMode`], [`Operation::allows`] |
//! | `MC_CamScalingMode` | 8.4 | [`ScalingMode`] |
//! | `MC_CamInfoData` | 8.5 | [`CamInfo`] |
//! | `MC_StartMode` | 8.15 | [`StartMode`] |
//! | `MC_CamOperationMode` | 8.18 | [`OperationMode`] |
//! | `ST_CamScalingData` | 8.19 | [`ScalingData`] |
//! | `ST_SetOnlineChangeModeOptions`, `ST_WriteMotionFunctionOptions` (`SynchronousAccess`) | 8.21, 8.22 | every access is synchronous |
//! | `CamTableQueued`, `CamDataQueued`, `CamScalingPending` | 4.3, 6.3, 4.5 | [`CamCoupling::state_word`] |
//!
//! Deviations from the original:
//!
//! * A plate that would make the slave jump, or that it could not follow, is refused, or approached on a
//!   ramp: [`JumpHandling`], [`CamLimits`]. Such an online change waits until it is possible.
//! * `NEXTCYCLEONCE` exists.
//! * The strokes that a cyclic plate with lift has completed are kept when it is scaled; the new scaling
//!   holds for later ones.
//! * The interpolation belongs to a position table, not to its coupling.
//!
//! The crate is `no_std` and reads no clock. A store of tables allocates when plates are inserted into
//! it; commands and cycles do not.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod apply;
mod cam;
mod carry_out;
mod change_moment;
mod checks;
mod command;
mod coupling;
mod course_ahead;
mod course_bound;
mod course_change;
mod early_check;
mod ending;
mod error;
mod info;
mod layer;
mod limits;
mod modes;
mod one_cycle;
mod online;
mod placement;
mod plan;
mod prepared;
mod ramp;
mod reading;
mod request;
mod reserve;
mod rules;
mod select;
mod select_reserved;
mod tables;
mod trigger;
mod versions;

#[cfg(test)]
mod tests;

pub use cam::Cam;
pub use command::{
    Activation, AxisScaling, CamAdd, CamExchange, CamIn, CamInV2, CamOut, CamRemove, CamScaling,
    CamScalingV2, ScalingData,
};
pub use coupling::{CamCoupling, CouplingParameters, CouplingState, MOST_PLATES};
pub use error::{CouplingError, TableId};
pub use info::{CamInfo, CamState, QueuedChange, QueuedTable};
pub use limits::CamLimits;
pub use modes::{ActivationMode, JumpHandling, OperationMode, ScalingMode, StartMode};
pub use plan::CamChange;
pub use prepared::{PreparedTable, ReservedPlate};
pub use reading::{MOST_POINTS_CHANGED, PlateReading};
pub use request::CamRequest;
pub use rules::{MOST_POINTS_REPLACED_IN_USE, Operation};
pub use tables::{MOST_TABLES, Tables};
pub use versions::OnlineChangeMode;
