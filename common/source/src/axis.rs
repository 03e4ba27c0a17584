//! An axis of a config with its source.

use coaxle_axis::motion_plan::MotionPlan;
use coaxle_axis::{Modulo, NcToPlcAxis};
use coaxle_clock::Span;

use crate::axis_struct::write_axis_struct;
use crate::config::AxisConfig;
use crate::followers::Followers;
use crate::open::{open, open_ahead};
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
        Ok(Self::with(config, open(&config.source)?))
    }

    /// Opens the axis with a source that takes its decisions ahead, by [the lead](AxisConfig::lead) of the config.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_ahead(config: &AxisConfig) -> Result<Self, ReplayError> {
        let source = open_ahead(config)?;
        Ok(Self::with(config, source))
    }

    /// Returns the axis of a config, moved by a source of the caller's in place of its own.
    #[must_use]
    pub fn with(config: &AxisConfig, source: Box<dyn AxisSource>) -> Self {
        Self {
            id: config.id.get(),
            modulo: config.modulo,
            source,
        }
    }

    /// Returns the axis id.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// Returns its plan from the newest motion on: [`AxisSource::plan`].
    #[must_use]
    pub fn plan(&self, since_start: Span, origin: Span) -> Option<MotionPlan> {
        self.source.plan(since_start, origin)
    }

    /// Returns the number of decisions so far: each changes the plan.
    #[must_use]
    pub fn decisions(&self) -> u64 {
        self.source.decisions()
    }

    /// Takes the state of its followers, before its motion at that time: [`AxisSource::take_followers`].
    pub fn take_followers(&mut self, since_start: Span, followers: &Followers) {
        self.source.take_followers(since_start, followers);
    }

    /// True if it stands still, or ramps down, because a follower has failed.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.source.is_held()
    }

    /// Returns its motion at a time after the start of its node, which must not go back, and writes its
    /// axis structure to `shown`.
    pub fn at(&mut self, since_start: Span, shown: &mut NcToPlcAxis) -> SourceSample {
        let sample = self.source.sample(since_start);
        write_axis_struct(self.id, self.modulo, &sample, shown);
        sample
    }
}
