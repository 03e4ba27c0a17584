//! The slave axis: an axis with a life cycle, to be commanded and to be coupled to a master.
//!
//! A [`SlaveAxis`] is in one state of the PLCopen diagram ([`AxisStatus`](coaxle_axis::AxisStatus))
//! at a time. Commands are data ([`Command`]); each is accepted or refused at once ([`Refusal`]),
//! and one that is accepted replaces the one under way. Once per cycle [`SlaveAxis::update`]
//! calculates the set values and moves the drive.
//!
//! ```
//! use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
//! use coaxle_axis::{AxisStatus, CommandState};
//! use coaxle_cam::Tables;
//! use coaxle_clock::{CycleTime, Seconds, Span};
//! use coaxle_curve::profile::Kinematics;
//! use coaxle_saw::{GearInVelo, Ratio, SyncLimits, SyncMode};
//! use coaxle_slave::{Command, SlaveAxis, SlaveParameters};
//!
//! let parameters = SlaveParameters::new(1_000.0, 5_000.0, 100_000.0);
//! let drive = Box::new(SimulatedDrive::new(DriveParameters::default())?);
//! let cycle = CycleTime::new(Span::from_millis(1))?;
//! let mut axis = SlaveAxis::new(&parameters, drive, cycle)?;
//! let mut plates = Tables::new(0); // without cam plates
//! let mut master = Kinematics { position: 0.0, velocity: 500.0, acceleration: 0.0 };
//!
//! axis.command(&mut plates, &Command::Power(true))?;
//! axis.update(&mut plates, Some(&master), Seconds(0.001));
//! let saw = Command::GearInVelo(GearInVelo {
//!     ratio: Ratio::of(1.0),
//!     sync_mode: SyncMode::default(),
//!     limits: SyncLimits::default(),
//! });
//! let job = axis.command(&mut plates, &saw)?;
//! for _ in 0..2_000 {
//!     master.position += 0.5;
//!     axis.update(&mut plates, Some(&master), Seconds(0.001));
//! }
//! assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
//! assert_eq!(axis.progress(job), CommandState::InSync);
//! assert_eq!(axis.set().velocity, 500.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `examples/saw_in_your_loop.rs` cuts piece after piece from a conveyor, in a custom loop: `cargo
//! run -p coaxle-slave --example saw_in_your_loop`.
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `MC_Power` | PLCopen part 1 | [`Command::Power`] |
//! | `MC_Reset` | PLCopen part 1 | [`Command::Reset`] |
//! | `MC_Home` (set position) | PLCopen part 1 | [`Command::Home`] |
//! | `MC_MoveAbsolute`, `MC_MoveRelative` | PLCopen part 1 | [`Command::MoveAbsolute`], [`Command::MoveRelative`] |
//! | `MC_MoveVelocity` | PLCopen part 1 | [`Command::MoveVelocity`] |
//! | `MC_Halt`, `MC_Stop` | PLCopen part 1 | [`Command::Halt`], [`Command::Stop`] |
//! | `MC_GearIn` | PLCopen part 1 | [`Command::GearIn`] |
//! | `MC_GearInMultiMaster`, `MC_GearInDyn`, `MC_CombineAxes` | Tc2_MC2, PLCopen part 1 | [`Command::GearInMultiMaster`] |
//! | `MC_PhasingAbsolute`, `MC_PhasingRelative` | PLCopen part 1 | [`Command::PhasingAbsolute`], [`Command::PhasingRelative`] |
//! | `MC_MoveSuperImposed` | PLCopen part 1, TF5050 | [`Command::MoveSuperimposed`] |
//! | `MC_GearOut` | TS5055 12.2.1 | [`Command::GearOut`] |
//! | `MC_GearInPos`, `MC_GearInVelo` | TS5055 12.1, TF5055 4 | [`Command::GearInPos`], [`Command::GearInVelo`] |
//! | `MC_ReadFlyingSawCharacteristics` | TS5055 12.1.3, TF5055 4.3 | [`SlaveAxis::saw_plan`], [`Command::ReadFlyingSawCharacteristics`] |
//! | `MC_CamTableSelect` | TF5050 4.1 | [`SlaveAxis::prepare_cams`], [`Tables`](coaxle_cam::Tables) |
//! | `MC_CamIn`, `MC_CamOut`, `MC_CamScaling` | TF5050 4.2 to 4.5 | [`Command::CamIn`], [`Command::CamOut`], [`Command::CamScaling`] |
//! | `MC_CamIn_V2`, `MC_CamAdd`, `MC_CamExchange`, `MC_CamRemove`, `MC_CamScaling_V2` | TF5050 5 | the commands of the same names |
//! | `MC_SetCamOnlineChangeMode`, `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint` | TF5050 6 | [`Command::SetCamOnlineChangeMode`], [`Command::WriteMotionFunction`] |
//! | `MC_FlyingGear` | `MC_FlyingGear_BkPlcMc` | [`Command::FlyingGear`] |
//! | `MC_ReadStatus`, `MC_ReadAxisError` | PLCopen part 1 | [`SlaveAxis::status`], [`SlaveAxis::error`] |
//!
//! Guarantees of the set values, for any commands and any motion of the master:
//!
//! * they are finite;
//! * the positions, differenced from cycle to cycle, keep velocity, acceleration (or deceleration,
//!   whichever is larger) and jerk: a last stage,
//!   [`SetValueGuard`](coaxle_axis::set_value_guard::SetValueGuard), passes values within the
//!   limits to the bit, and departs as little as possible from others. [`SlaveAxis::tracking`] and
//!   [`SlaveAxis::distance`] report this, and a distance that is too large for too long
//!   ([`DistanceParameters`]) ends in an error stop;
//! * a motion that takes over from another continues from its position, velocity and acceleration;
//! * an axis within its software limits stays there: a motion that would leave them is refused, and
//!   one without an end, or a coupling, is braked in time and ends in an error stop;
//! * an error stop lasts until it is reset, and the axis is not coupled again automatically.
//!
//! Two reactions have limits of their own: the stop within one cycle that
//! `GearInSync_OpMask_InstantStopOnRollback` requests, and [`OnMasterLoss::QuickStop`], which keeps
//! velocity and deceleration and not the jerk. Plans that cannot start from an acceleration are
//! refused: a flying gear, and a cam plate that waits for its activation, begin at rest; a flying
//! saw has P5 then, and no P1.
//!
//! A flying saw whose master runs back past the coupling position ends as in TS5055 8: its command
//! is aborted and the axis comes to rest. The manual does not specify the state meanwhile; here the
//! axis is in `DiscreteMotion`, as after a halt, so that a command can take over, and `MC_Reset` is
//! not needed. A master that leads the axis beyond a limit causes an error stop.
//!
//! A command is planned against the current axis ([`SlaveAxis::plan`]), with a [`Change`] or a
//! [`Refusal`] as the result; applying the change ([`SlaveAxis::apply`]) cannot fail. A dry run is
//! a plan that is not applied. One [`Job`](coaxle_axis::Job) follows an accepted command of any
//! kind to its end: [`SlaveAxis::progress`], [`SlaveAxis::take_ended`].
//!
//! The cam plates are a store that is passed to the axis when it acts, so that the axes of a node share
//! it without locks: [`SlaveAxis::prepare_cams`].
//!
//! A coupling of the axis is one of the kinds listed in `couplings.rs`, each a crate that
//! implements [`Coupling`](coaxle_axis::Coupling) and [`Engage`](coaxle_axis::Engage).
//!
//! Two events preset the position, since the axis does not move by them: `MC_Home`, and power that
//! is switched on, off, or on again after a trip of the drive: without power the set position is
//! the actual one.
//!
//! A [`Drive`](coaxle_axis::drive::Drive) follows the set values: the simulated one above, a custom
//! one, or one in another process. An axis has power when its drive follows: until then it is
//! `Disabled`, and stands at its drive's position. A drive that trips, that stops following, or
//! that has implausible actual values brings it to an error stop ([`SlaveError::Drive`]); the
//! guarantees above hold for any values of a drive.
//!
//! The crate is `no_std` and reads no clock. Commands and cycles allocate no memory.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod axis;
mod cam_points;
mod change;
mod circle;
mod command;
mod couplings;
mod error;
mod held_back;
mod image;
mod job;
mod motion;
mod parameters;
mod port;
mod refusal;
mod shift;
mod sync_position;
mod waiting;

#[cfg(test)]
mod tests;

pub use axis::{CoupledStart, Outlook, SlaveAxis};
pub use cam_points::{CamPoints, WrongNumberOfPoints};
pub use change::Change;
pub use circle::{CIRCLE_CODE, CircleState};
pub use coaxle_axis::{CouplingPhase, Dynamics};
#[doc(hidden)]
pub use command::key;
pub use command::table::CommandRow;
pub use command::{Command, CommandTraits};
pub use couplings::{CouplingFault, CouplingRefusal};
pub use error::SlaveError;
pub use held_back::MOST_HELD_BACK;
pub use job::{EndedJob, JobError, JobState};
pub use parameters::{DistanceParameters, OnMasterLoss, SlaveParameters, WrongSlaveParameter};
pub use refusal::Refusal;
pub use sync_position::{SyncPosition, WrongSyncPosition};
pub use waiting::WaitingSets;
