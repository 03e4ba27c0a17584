//! What a config file says of an axis and of what moves it.

mod axis;
mod program;

pub use axis::{AxisConfig, EncoderConfig, Interpolation, ReplayConfig, SourceConfig};
pub use program::{
    InvalidProgram, LimitsConfig, MAX_LOOP_DEPTH, ProgramConfig, Repeat, StepConfig,
};
