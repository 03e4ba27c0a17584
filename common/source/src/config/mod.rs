//! Config of an axis and of its source, in a file.

mod axis;
mod plant;
mod program;

pub use axis::{AxisConfig, EncoderConfig, Interpolation, ReplayConfig, SourceConfig};
pub use program::{LimitsConfig, MAX_LOOP_DEPTH, ProgramConfig, Repeat, StepConfig};
