//! Opening the source that a config describes.

use crate::config::SourceConfig;
use crate::encoder::Encoder;
use crate::program::Program;
use crate::replay::{Replay, ReplayError};
use crate::source::Source;

/// Opens the source that a config describes; reads the file of a replay.
///
/// # Errors
/// [`ReplayError`] if that file cannot be replayed.
pub fn open(config: &SourceConfig) -> Result<Box<dyn Source>, ReplayError> {
    Ok(match config {
        SourceConfig::Program(program) => Box::new(Program::new(program)),
        SourceConfig::Encoder(encoder) => Box::new(Encoder::new(encoder)),
        SourceConfig::Replay(replay) => Box::new(Replay::open(replay)?),
    })
}
