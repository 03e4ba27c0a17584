//! Worlds in which scenarios are played.

use std::path::Path;

use crate::finished::{Finished, Progress};
use crate::row::RowSink;
use crate::scenario::Scenario;
use crate::summary::World;
use crate::virtual_time;

/// Plays scenarios in a world of its own.
pub trait Stage: Sync {
    /// The world.
    fn world(&self) -> World;

    /// Plays a checked scenario. Files of its nodes, if they leave any, go to a folder in `out`; each row goes to `sink`.
    ///
    /// # Errors
    /// A node that does not start, breaks its contract or ends by itself. An unmet expectation is no error.
    fn play(
        &self,
        scenario: &Scenario,
        out: &Path,
        sink: &mut dyn RowSink,
        progress: &mut dyn Progress,
    ) -> anyhow::Result<Finished>;
}

/// The simulation: as fast as it goes, with equal bytes for equal seeds.
#[derive(Clone, Copy, Debug)]
pub struct VirtualTime;

impl Stage for VirtualTime {
    fn world(&self) -> World {
        World::Virtual
    }

    fn play(
        &self,
        scenario: &Scenario,
        _out: &Path,
        mut sink: &mut dyn RowSink,
        progress: &mut dyn Progress,
    ) -> anyhow::Result<Finished> {
        virtual_time::run(scenario, &mut sink, progress)
    }
}
