//! The slave axis: an axis with a life cycle, to be commanded and to be coupled to a master.
//!
//! A [`SlaveAxis`] is in one state of the PLCopen diagram
//! ([`AxisStatus`](coaxle_axis::AxisStatus)) at a time. Commands are data ([`Command`]); each is
//! accepted or refused at once ([`Refusal`]), and one that is accepted replaces the one under way.
//! Once per cycle [`SlaveAxis::update`] makes the set values and moves the drive.
//!
//! ```
//! use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
//! use coaxle_axis::{AxisStatus, CommandState};
//! use coaxle_clock::{CycleTime, Seconds, Span};
//! use coaxle_curve::profile::Kinematics;
//! use coaxle_saw::{GearInVelo, Ratio, SyncLimits, SyncMode};
//! use coaxle_slave::{Command, SlaveAxis, SlaveParameters};
//!
//! let parameters = SlaveParameters::new(1_000.0, 5_000.0, 100_000.0);
//! let drive = Box::new(SimulatedDrive::new(DriveParameters::default())?);
//! let cycle = CycleTime::new(Span::from_millis(1))?;
//! let mut axis = SlaveAxis::new(&parameters, drive, cycle)?;
//! let mut master = Kinematics { position: 0.0, velocity: 500.0, acceleration: 0.0 };
//!
//! axis.command(&Command::Power(true))?;
//! axis.update(Some(&master), Seconds(0.001));
//! let saw = Command::GearInVelo(GearInVelo {
//!     ratio: Ratio::of(1.0),
//!     sync_mode: SyncMode::default(),
//!     limits: SyncLimits::default(),
//! });
//! let job = axis.command(&saw)?;
//! for _ in 0..2_000 {
//!     master.position += 0.5;
//!     axis.update(Some(&master), Seconds(0.001));
//! }
//! assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
//! assert_eq!(axis.progress(job), CommandState::InSync);
//! assert_eq!(axis.set().velocity, 500.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `examples/saw_in_your_loop.rs` cuts piece after piece from a conveyor, in a loop of your own:
//! `cargo run -p coaxle-slave --example saw_in_your_loop`.
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
//! | `MC_CamTableSelect` | TF5050 4.1 | [`SlaveAxis::select_cams`], [`SlaveAxis::share_cams`] |
//! | `MC_CamIn`, `MC_CamOut`, `MC_CamScaling` | TF5050 4.2 to 4.5 | [`Command::CamIn`], [`Command::CamOut`], [`Command::CamScaling`] |
//! | `MC_CamIn_V2`, `MC_CamAdd`, `MC_CamExchange`, `MC_CamRemove`, `MC_CamScaling_V2` | TF5050 5 | the commands of the same names |
//! | `MC_SetCamOnlineChangeMode`, `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint` | TF5050 6 | [`Command::SetCamOnlineChangeMode`], [`Command::WriteMotionFunction`] |
//! | `MC_FlyingGear` | `MC_FlyingGear_BkPlcMc` | [`Command::FlyingGear`] |
//! | `MC_ReadStatus`, `MC_ReadAxisError` | PLCopen part 1 | [`SlaveAxis::status`], [`SlaveAxis::error`] |
//!
//! What the set values keep, whatever is commanded and whatever the master does:
//!
//! * they are finite;
//! * the positions, differenced from cycle to cycle, keep velocity, acceleration (or deceleration, whichever is
//!   larger) and jerk: a last stage, [`SetValueGuard`](coaxle_axis::set_value_guard::SetValueGuard), lets through to
//!   the bit what keeps them, and departs as little as it can from what does not. [`SlaveAxis::tracking`] and
//!   [`SlaveAxis::distance`] tell, and a distance that is too large for too long
//!   ([`DistanceParameters`]) ends in an error stop;
//! * where a motion takes over from any other it goes on from position, velocity and acceleration as they are;
//! * an axis within its software limits stays there: a motion that would leave them is refused, and
//!   one without an end, or a coupling, is braked in time and ends in an error stop;
//! * an error stop lasts until it is reset, and nothing couples the axis again by itself.
//!
//! Two reactions have limits of their own: the stop within one cycle that
//! `GearInSync_OpMask_InstantStopOnRollback` asks for, and [`OnMasterLoss::QuickStop`], which keeps velocity and
//! deceleration and not the jerk. Where a plan cannot start from an acceleration, none is made: a flying gear, and
//! a cam plate that waits for its activation, begin at rest; a flying saw has P5 then, and no P1.
//!
//! A flying saw whose master runs back past the coupling position ends as TS5055 8 has it: its
//! command is aborted and the axis comes to rest. Of the states meanwhile the manual says nothing;
//! here the axis is in `DiscreteMotion`, as after a halt, so that a command can take over, and
//! `MC_Reset` is not needed. What the master leads beyond a limit is an error stop.
//!
//! A command is planned against the axis as it is ([`SlaveAxis::plan`]), which gives a [`Change`] or a
//! [`Refusal`]; applying the change ([`SlaveAxis::apply`]) cannot fail. A dry run is a plan that is not
//! applied. One [`Job`](coaxle_axis::Job) follows an accepted command to its end, whatever it started:
//! [`SlaveAxis::progress`], [`SlaveAxis::take_ended`].
//!
//! What couples the axis is one of the kinds that `couplings.rs` lists, each a crate that implements
//! [`Coupling`](coaxle_axis::Coupling) and [`Engage`](coaxle_axis::Engage).
//!
//! Two events set the position anew, since the axis does not move by them: `MC_Home`, and power
//! that comes, goes or returns after a trip of the drive: without power the set position is the
//! actual one.
//!
//! What follows the set values is a [`Drive`](coaxle_axis::drive::Drive): the simulated one above, one of
//! your own, or one in another process. An axis has power when its drive follows: until then it is
//! `Disabled`, and stands where its drive is. A drive that trips, that stops to follow, or whose actual
//! values no axis can have brings it to an error stop ([`SlaveError::Drive`]); whatever a drive says, the set
//! values keep the above.
//!
//! The crate is `no_std` and asks no machine for the time. Commands and cycles allocate nothing.
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
mod image;
mod job;
mod motion;
mod parameters;
mod port;
mod refusal;
mod shift;
mod sync_position;

#[cfg(test)]
mod tests;

pub use axis::{CoupledStart, Outlook, SlaveAxis};
pub use cam_points::{CamPoints, WrongNumberOfPoints};
pub use change::Change;
pub use circle::{CIRCLE_CODE, CircleState};
pub use coaxle_axis::{CouplingPhase, Dynamics};
pub use command::Command;
pub use couplings::{CouplingFault, CouplingRefusal};
pub use error::SlaveError;
pub use job::{EndedJob, JobError, JobState};
pub use parameters::{DistanceParameters, OnMasterLoss, SlaveParameters, WrongSlaveParameter};
pub use refusal::Refusal;
pub use sync_position::{SyncPosition, WrongSyncPosition};
