//! The universal flying saw: a slave that catches up with its moving master and then runs with it.
//! TS5055 and TF5055.
//!
//! A command is planned from the moment of coupling. The plan keeps all requested limits, or the command
//! is refused with the violated limit, the excess and the place; nothing has moved then. A coupling runs
//! a plan: the master's set values in, the slave's out.
//!
//! ```
//! use coaxle_clock::Seconds;
//! use coaxle_curve::profile::{Kinematics, Limits};
//! use coaxle_saw::{
//!     CouplingMoment, GearInPos, Ratio, SawCommand, SawCoupling, SawForm, SawTolerances,
//!     SlaveLimits, SyncLimits, SyncMask, SyncMode,
//! };
//!
//! let mut master = Kinematics { position: -500.0, velocity: 500.0, acceleration: 0.0 };
//! let moment = CouplingMoment {
//!     master,
//!     encoder: None,
//!     slave: Kinematics { position: -250.0, velocity: 250.0, acceleration: 0.0 },
//!     axis: SlaveLimits {
//!         dynamics: Limits::new(2_000.0, 2_500.0, 2_500.0, 5_000.0)?,
//!         min_position: None,
//!         max_position: None,
//!         guard: None,
//!     },
//! };
//! let command = GearInPos {
//!     ratio: Ratio::of(1.0),
//!     master_sync_position: 1_000.0,
//!     slave_sync_position: 1_000.0,
//!     master_start_distance: None,
//!     strategy: None,
//!     sync_mode: SyncMode::position_based(SyncMask::OVERSHOOT_VELO | SyncMask::MAX_ACC),
//!     limits: SyncLimits::default(),
//! };
//! assert_eq!(command.plan(&moment)?.form(), SawForm::QuinticLine);
//!
//! let command = SawCommand::GearInPos(command);
//! let mut coupling = SawCoupling::start(command, &moment, SawTolerances::default())?;
//! for _ in 0..3_100 {
//!     master.position += 0.5;
//!     coupling.update(&master, Seconds(0.001));
//! }
//! assert_eq!(coupling.slave().position, master.position);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Positions are in user units (u, say mm or degrees), time in seconds.
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `MC_GearInVelo` | TS5055 12.1.1, TF5055 4.1 | [`GearInVelo`] |
//! | `MC_GearInPos` | TS5055 12.1.2, TF5055 4.2 | [`GearInPos`] |
//! | `MC_ReadFlyingSawCharacteristics` | TS5055 12.1.3, TF5055 4.3 | [`SawPlan::characteristics`] |
//! | `MC_GearOut` | TS5055 12.2.1 | [`SawCoupling::gear_out`] |
//! | `ST_SyncMode` | TF5055 5.1 | [`SyncMode`] |
//! | `E_GearInSyncMode` | TF5055 5.2 | [`GearInSyncMode`] |
//! | `MC_FlyingSawCharacValues` | TF5055 5.3 | [`FlyingSawCharacteristics`] |
//! | `ST_GearInPosOptions`, `ST_GearInVeloOptions` | TF5055 5.4, 5.5 | [`SyncLimits::min_position`], [`SyncLimits::max_position`] |
//! | `RatioNumerator`, `RatioDenominator` | TS5055 12.1 | [`Ratio`]; for a diagonal saw [`diagonal_ratio`] |
//! | `MasterStartDistance` | TS5055 12.1.2 | [`GearInPos::master_start_distance`]: implemented |
//! | `MC_SYNC_STRATEGY` of `MC_GearInPosCA` | TF5410, `MC_SYNC_STRATEGY` | [`SyncStrategy`] |
//! | `EGearInPosSyncState` of MC3's `MC_GearInPos` | TF5500, MC3 | [`CouplingPhase`](coaxle_axis::CouplingPhase), with a strategy |
//! | `BufferMode` | TS5055 12.1 | none: a command acts at once, as in the original |
//! | `nAxisState` 11, 12, 13 | TS5055 10 | [`SawCoupling::axis_state`] |
//! | `StartSync` | TS5055 12.1 | [`SawCoupling::has_started_sync`] |
//! | error codes of a check | TF5055 8.1 | [`Check`] |
//! | rollback, cases 1 to 8 | TS5055 8 | [`RollbackReaction`], [`RollbackStop`] |
//! | 0x4289, illegal reversal | TF5055 8 | never: a reversal of the slave is a check (0x4384 to 0x4387), of the master a rollback |
//! | optimisation of the profile | TS5055 7 | [`GearInPos::plan`] |
//! | table id 256 − axis id | TS5055 13 | [`saw_table_id`] |
//!
//! | flag of `ST_SyncMode` | value | here |
//! |--|--|--|
//! | `GearInSync_CheckMask_MinPos` | 0x1 | [`SyncMask::MIN_POS`] |
//! | `GearInSync_CheckMask_MaxPos` | 0x2 | [`SyncMask::MAX_POS`] |
//! | `GearInSync_CheckMask_MaxVelo` | 0x4 | [`SyncMask::MAX_VELO`] |
//! | `GearInSync_CheckMask_MaxAcc` | 0x8 | [`SyncMask::MAX_ACC`] |
//! | `GearInSync_CheckMask_MaxDec` | 0x10 | [`SyncMask::MAX_DEC`] |
//! | `GearInSync_CheckMask_MaxJerk` | 0x20 | [`SyncMask::MAX_JERK`] |
//! | `GearInSync_CheckMask_OptionalMinPos` | 0x40, not in the manual | [`SyncMask::OPTIONAL_MIN_POS`] |
//! | `GearInSync_CheckMask_OptionalMaxPos` | 0x80, not in the manual | [`SyncMask::OPTIONAL_MAX_POS`] |
//! | `GearInSync_CheckMask_OvershootPos` | 0x100 | [`SyncMask::OVERSHOOT_POS`] |
//! | `GearInSync_CheckMask_UndershootPos` | 0x200 | [`SyncMask::UNDERSHOOT_POS`] |
//! | `GearInSync_CheckMask_OvershootVelo` | 0x400 | [`SyncMask::OVERSHOOT_VELO`] |
//! | `GearInSync_CheckMask_UndershootVelo` | 0x800 | [`SyncMask::UNDERSHOOT_VELO`] |
//! | `GearInSync_CheckMask_OvershootVeloZero` | 0x1000 | [`SyncMask::OVERSHOOT_VELO_ZERO`] |
//! | `GearInSync_CheckMask_UndershootVeloZero` | 0x2000 | [`SyncMask::UNDERSHOOT_VELO_ZERO`] |
//! | `GearInSync_OpMask_RollbackLock` | 0x1_0000 | [`SyncMask::ROLLBACK_LOCK`] |
//! | `GearInSync_OpMask_InstantStopOnRollback` | 0x2_0000 | [`SyncMask::INSTANT_STOP_ON_ROLLBACK`] |
//! | `GearInSync_OpMask_PreferConstVelo` | 0x10_0000 | [`SyncMask::PREFER_CONST_VELO`] |
//! | `GearInSync_OpMask_IgnoreMasterAcc` | 0x20_0000 | [`SyncMask::IGNORE_MASTER_ACC`] |
//! | `GearInSync_OpMask_IgnoreSlaveAcc` | 0x40_0000, not in the manual | [`SyncMask::IGNORE_SLAVE_ACC`] |
//! | `GearInSync_OpMask_DetailedErrorCodes` | 0x80_0000, not in the manual | [`SyncMask::DETAILED_ERROR_CODES`] |
//!
//! The crate is `no_std` and reads no clock. Planning and cycles allocate nothing.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod by_strategy;
mod characteristics;
mod checks;
mod command;
mod coupling_moment;
mod curved_ramp;
mod demands;
mod diagonal;
mod path_limits;
mod path_piece;
mod plan;
mod plateau;
mod position;
mod ramp;
mod refusal;
mod remedy;
mod rollback;
mod running;
mod slave_path;
mod strategy;
#[cfg(feature = "serde")]
mod sync_mask_names;
mod sync_mode;
mod sync_span;
mod task;
mod velocity;

pub use characteristics::{FlyingSawCharacteristics, SawEnd, SawTable, saw_table_id};
pub use command::{GearInPos, GearInVelo, Ratio, SyncLimits};
pub use coupling_moment::{CouplingMoment, EncoderNoise, LimitGuard, SlaveLimits};
pub use diagonal::{DiagonalAngle, diagonal_ratio};
pub use plan::{SawForm, SawPlan, SyncLine};
pub use refusal::{Check, SawRefusal, Violation};
pub use remedy::SawRemedy;
pub use rollback::{RollbackReaction, RollbackStop};
pub use running::{Saw, SawCommand, SawCoupling, SawFault, SawTolerances};
pub use strategy::SyncStrategy;
pub use sync_mode::{GearInSyncMode, SyncMask, SyncMode};

#[cfg(test)]
mod tests;
