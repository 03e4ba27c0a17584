//! An axis of a config with its source.

use coaxle_axis::{Modulo, NcToPlcAxis};
use coaxle_clock::Span;

use crate::axis_struct::write_axis_struct;
use crate::config::AxisConfig;
use crate::open::open;
use crate::replay::ReplayError;
use crate::source::{AxisSource, SourceSample};

/// An axis of a config with the source that moves it.
#[derive(Debug)]
pub struct SourceAxis {
    id: u32,
    modulo: Option<Modulo>,
    source: Box<dyn AxisSource>,
}

impl SourceAxis {
    /// Opens the axis that a config describes; reads the file of a replay.
    ///
    /// # Errors
    /// [`ReplayError`] if that file cannot be replayed.
    pub fn open(config: &AxisConfig) -> Result<Self, ReplayError> {
        Ok(Self {
            id: config.id.get(),
            modulo: config.modulo,
            source: open(&config.source)?,
        })
    }

    /// Returns the axis id.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// Returns its motion at a time after the start of its node, which must not go back, and writes its
    /// axis structure to `shown`.
    pub fn at(&mut self, since_start: Span, shown: &mut NcToPlcAxis) -> SourceSample {
        let sample = self.source.sample(since_start);
        write_axis_struct(self.id, self.modulo, &sample, shown);
        sample
    }
}
