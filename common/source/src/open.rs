//! Opening the source that a config describes.

use crate::config::SourceConfig;
use crate::encoder::EncoderSource;
use crate::program::MotionProgram;
use crate::replay::{Replay, ReplayError};
use crate::source::AxisSource;

/// Opens the source that a config describes; reads the file of a replay.
///
/// # Errors
/// [`ReplayError`] if that file cannot be replayed.
pub fn open(config: &SourceConfig) -> Result<Box<dyn AxisSource>, ReplayError> {
    Ok(match config {
        SourceConfig::Program(program) => Box::new(MotionProgram::new(program)),
        SourceConfig::Encoder(encoder) => Box::new(EncoderSource::new(encoder)),
        SourceConfig::Replay(replay) => Box::new(Replay::open(replay)?),
    })
}
