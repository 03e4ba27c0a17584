//! Opening the source that a config describes.

use crate::config::{AxisConfig, SourceConfig};
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

/// Opens the source of an axis; a program takes its decisions ahead by [the lead](AxisConfig::lead), and reacts to the followers
/// of the axis.
pub(crate) fn open_ahead(axis: &AxisConfig) -> Result<Box<dyn AxisSource>, ReplayError> {
    match &axis.source {
        SourceConfig::Program(program) => {
            let program = MotionProgram::new(program).with_lead(axis.lead());
            Ok(Box::new(match &axis.followers {
                Some(followers) => program.with_followers(followers),
                None => program,
            }))
        }
        source @ (SourceConfig::Encoder(_) | SourceConfig::Replay(_)) => open(source),
    }
}
