//! The PLC interface: function blocks with levels, edges and booleans, and nothing else.
//!
//! The behaviour of a block is in the crates below, as plain commands and cycles. The rest of a PLC
//! function block is here: the rising edge of [`Execute`], and the [`Outputs`], all derived from one
//! [`CommandState`](coaxle_axis::CommandState).
//!
//! ```
//! use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
//! use coaxle_cam::Tables;
//! use coaxle_clock::{CycleTime, Seconds, Span};
//! use coaxle_plc::{CommandBlock, Outputs, Power};
//! use coaxle_slave::{Command, Dynamics, JobError, SlaveAxis, SlaveParameters};
//!
//! let parameters = SlaveParameters::new(100.0, 1_000.0, 20_000.0);
//! let drive = Box::new(SimulatedDrive::new(DriveParameters::default())?);
//! let cycle = CycleTime::new(Span::from_millis(1))?;
//! let mut axis = SlaveAxis::new(&parameters, drive, cycle)?;
//! let mut plates = Tables::new(0); // without cam plates
//!
//! let (mut power, mut go) = (Power::default(), CommandBlock::default());
//! let there = Command::MoveAbsolute { position: 50.0, velocity: None, dynamics: Dynamics::default() };
//! let mut shown = Outputs::default();
//! for _ in 0..1_000 {
//!     let ready = power.scan(true, &mut axis, &mut plates).status;
//!     shown = Outputs::of(&go.scan(ready, &there, &mut axis, &mut plates), JobError::code);
//!     axis.update(&mut plates, None, Seconds(0.001));
//! }
//! assert!(shown.done && axis.set().position == 50.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `Execute`, `Busy`, `Active`, `InSync`, `Done`, `CommandAborted`, `Error`, `ErrorID` | PLCopen part 1 | [`Execute`], [`Outputs`] |
//! | `MC_Power` | PLCopen part 1 | [`Power`] |
//! | `MC_Reset`, `MC_Home`, `MC_MoveAbsolute`, `MC_MoveRelative`, `MC_MoveVelocity`, `MC_Halt`, `MC_Stop` | PLCopen part 1 | [`CommandBlock`] |
//! | `MC_GearIn`, `MC_GearOut`, `MC_CamOut` | PLCopen part 1, TS5055 12.2.1, TF5050 4.2 | [`CommandBlock`] |
//! | `MC_GearInMultiMaster`, `MC_GearInDyn`, `MC_CombineAxes` | Tc2_MC2, PLCopen part 1 | [`EnableMultiMasterGear`] |
//! | `MC_PhasingAbsolute`, `MC_PhasingRelative`, `MC_MoveSuperImposed` | PLCopen part 1 | [`CommandBlock`] |
//! | `MC_FlyingGear` | `MC_FlyingGear_BkPlcMc` | [`EnableFlyingGear`] |
//! | `MC_GearInPos`, `MC_GearInVelo` | TS5055 12.1, TF5055 4 | [`FlyingSawBlock`] |
//! | `MC_ReadFlyingSawCharacteristics` | TS5055 12.1.3, TF5055 4.3 | [`ReadFlyingSawCharacteristicsBlock`] |
//! | `MC_CamIn`, `MC_CamScaling`, `MC_CamIn_V2`, `MC_CamAdd`, `MC_CamExchange`, `MC_CamRemove`, `MC_CamScaling_V2` | TF5050 4, 5 | [`CommandBlock`]; without an axis, [`CouplingBlock`] |
//! | all others of TF5050 | TF5050 6, 7 | [`TableBlock`] |
//!
//! The crate is `no_std`, allocates nothing and reads no clock.
#![no_std]

#[cfg(test)]
extern crate std;

mod axis;
mod cams;
mod execute;
mod multi_master;
mod saw;

#[cfg(test)]
mod tests;

pub use axis::{CommandBlock, EnableFlyingGear, FlyingGearOutputs, Power, PowerOutputs};
pub use cams::{CouplingBlock, TableBlock};
pub use execute::{Execute, Outputs};
pub use multi_master::EnableMultiMasterGear;
pub use saw::{FlyingSawBlock, FlyingSawOutputs, ReadFlyingSawCharacteristicsBlock};
