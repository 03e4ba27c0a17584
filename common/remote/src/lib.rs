//! A far axis made local: extrapolation by a correction time, and the block that combines it with a
//! time sync.
//!
//! A far axis is received once per cycle of a far clock. [`AxisSync`] learns the drift between the
//! two clocks from the cycle indices ([`coaxle_clock::time_sync`]) and moves the set values in
//! time, so that they fit the cycles of this one; [`AxisExtrapolate`] moves them by a correction
//! time from another source. For many axes of one clock, one [`FarSync`] serves as many
//! [`FarAxis`]: the two halves of [`AxisSync`]. [`Continuity`] removes the steps that these leave
//! when a node falls silent, returns or restarts.
//!
//! ```
//! use coaxle_axis::NcToPlcAxis;
//! use coaxle_clock::{CycleIndex, Span};
//! use coaxle_remote::{AxisSync, AxisSyncParameters, FilterMode};
//!
//! let mut sync = AxisSync::start(Span::from_millis(1), AxisSyncParameters::default())?;
//! for index in 0..100 {
//!     let axis = NcToPlcAxis {
//!         set_position: 0.5 * f64::from(index),
//!         set_velocity: 500.0,
//!         ..NcToPlcAxis::default()
//!     };
//!     let local = sync.update(CycleIndex(index), &axis, FilterMode::Bypass, 1);
//!     assert_eq!(local.axis.set_position, axis.set_position, "as it came");
//! }
//! # Ok::<(), coaxle_clock::time_sync::WrongParameter>(())
//! ```
//!
//! A generated master may be shown later, by everybody alike: a [`FrameHistory`] has its motion between the received
//! frames, a [`AxisPresentation`] follows the delay that they state, and [`FarAxis::update`] takes both as the axis [`ShownLater`]. Where frames are missing, the [`PlannedMotion`]
//! that its node has promised takes their place.
//!
//! A far axis that is only measured is received in increments: an [`EncoderMaster`] calculates a
//! smooth master from their counts, with limited jerk and acceleration, a compensated lag and a
//! certain direction. It takes the place of the extrapolation: the correction time is its horizon.
//!
//! ```
//! use coaxle_axis::TravelDirection;
//! use coaxle_clock::{Seconds, Span};
//! use coaxle_remote::{EncoderMaster, EncoderParameters, EncoderSample};
//!
//! let parameters = EncoderParameters { increment: 0.01, ..EncoderParameters::default() };
//! let mut master = EncoderMaster::new(&parameters.checked(Span::from_millis(1))?);
//! for cycle in 0..=1_000 {
//!     let counted = 0.01 * (0.3 * f64::from(cycle) / 0.01_f64).floor();
//!     let sample = EncoderSample::next_position(counted, parameters.increment);
//!     let output = master.update(sample, Seconds(2e-3), 1);
//!     if cycle == 1_000 {
//!         let wanted = 300.0 + 300.0 * 2e-3;
//!         assert!((output.set.position - wanted).abs() < 0.01);
//!         assert!((output.set.velocity - 300.0).abs() < 1.0, "differences jump by 10");
//!         assert_eq!(output.direction, Some(TravelDirection::Forward));
//!     }
//! }
//! # Ok::<(), coaxle_clock::time_sync::WrongParameter>(())
//! ```
//!
//! | PLC name | TS5066 | here |
//! |--|--|--|
//! | `FB_AxisSync` | 3.1 | [`AxisSync`] |
//! | `FB_AxisExtrapolateValues` | 3.3 | [`AxisExtrapolate`] |
//! | `ST_AxisSyncParameters` | 3.4 | [`AxisSyncParameters`] |
//! | `ST_AxisSyncDiagnostic` | 3.5 | [`AxisSyncDiagnostic`] |
//! | `E_Sync_FallBackMode` | 3.6 | [`FallBackMode`] |
//! | `E_Sync_FilterMode` | 3.7 | [`FilterMode`] |
//! | `E_Sync_FilterState` | 3.8 | [`FilterState`] |
//! | `E_Sync_StartUpMode` | 3.9 | [`StartUpMode`] |
//! | `ST_AxisExtrapolateDiagnostic` | 3.12 | [`ExtrapolateDiagnostic`] |
//! | `ST_AxisExtrapolateParameters` | 3.13 | [`ExtrapolateParameters`] |
//! | `E_Sync_ExtrapolateMode`, `E_Sync_ExtrapolateState` | 3.14, 3.15 | [`ExtrapolateMode`] |
//!
//! `FB_TimeSync` and its types are in [`coaxle_clock`].
//!
//! The crate is `no_std`, does not allocate and reads no clock of the machine.
#![no_std]

#[cfg(feature = "schema")]
extern crate alloc;
#[cfg(test)]
extern crate std;

mod axis_sync;
mod changes;
mod continuity;
mod encoder;
mod extrapolate;
mod far_axis;
mod far_sync;
mod parameters;
mod planned;
mod prediction;
mod presented;
mod pt1;

pub use axis_sync::{AxisSync, AxisSyncDiagnostic, AxisSyncOutput};
pub use changes::{AxisSyncChanges, ExtrapolateChanges, TimeSyncChanges};
pub use continuity::{Continuity, ContinuityState, MasterCycle, Reach, ReceivedMotion};
pub use encoder::{
    COARSE_INCREMENT_MM, CheckedEncoder, EncoderMaster, EncoderOutput, EncoderParameters,
    EncoderSample, Smoothing,
};
pub use extrapolate::{
    AxisExtrapolate, ExtrapolateDiagnostic, ExtrapolateMode, ExtrapolateOutput,
    ExtrapolateParameters, FallBackMode,
};
pub use far_axis::{FarAxis, FarAxisOutput};
pub use far_sync::{FarCorrection, FarSync};
pub use parameters::{AxisSyncParameters, CheckedParameters, FilterMode, FilterState, StartUpMode};
pub use planned::{KnownMotion, PlanCoverage, PlannedAhead, PlannedMotion, ReceivedPlan};
pub use prediction::LASTING;
pub use presented::{
    AxisPresentation, FrameDelay, FrameHistory, NeededDelay, PresentedNow, ShownChange, ShownLater,
};
