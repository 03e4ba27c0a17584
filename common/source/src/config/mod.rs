//! Config of an axis and of its source, in a file.

mod axis;
mod followers;
mod plant;
mod program;

pub use axis::{AxisConfig, EncoderConfig, Interpolation, ReplayConfig, SourceConfig};
pub use followers::{FollowersConfig, MOST_FOLLOWERS, OnFailure};
pub use program::{
    FollowersState, LimitsConfig, MAX_LOOP_DEPTH, ProgramConfig, Repeat, StepConfig,
};
