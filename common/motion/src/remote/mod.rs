//! A far axis made local: extrapolation by a correction time, and the block that does it all.

mod axis_sync;
mod extrapolate;
mod pt1;

pub use axis_sync::{
    AxisSync, AxisSyncDiagnostic, AxisSyncOutput, AxisSyncParameters, FilterMode, FilterState,
    StartUpMode,
};
pub use extrapolate::{
    AxisExtrapolate, ExtrapolateDiagnostic, ExtrapolateMode, ExtrapolateOutput,
    ExtrapolateParameters, FallBackMode,
};
