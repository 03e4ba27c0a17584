//! Opening the source that a config describes.

use coaxle_clock::Span;

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

/// Opens the source that a config describes; a program takes its decisions ahead by `lead`.
pub(crate) fn open_ahead(
    config: &SourceConfig,
    lead: Span,
) -> Result<Box<dyn AxisSource>, ReplayError> {
    match config {
        SourceConfig::Program(program) => Ok(Box::new(MotionProgram::new(program).with_lead(lead))),
        SourceConfig::Encoder(_) | SourceConfig::Replay(_) => open(config),
    }
}
