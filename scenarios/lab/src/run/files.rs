//! The files that hold every cycle of a run: its trace, and each receiver's raw arrivals.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::Context;
use coaxle_clock::Instant;
use coaxle_clock::cycle::Tick;
use coaxle_node::Arrival;
use coaxle_os::{ArrivalsTrace, arrivals_beside};
use coaxle_sim::True;

use crate::row::{Row, RowSink};
use crate::scenario::Scenario;
use crate::summary::World;
use crate::topology::Topology;
use crate::trace::TraceWriter;
use crate::trace_recording::TraceRecording;

use super::{NODES_FOLDER, TraceFormat};

/// The files, open.
pub(super) struct RunFiles {
    trace: TraceFile,
    /// Arrivals of each receiver; none for processes, which write them themselves.
    arrivals: Vec<ArrivalsTrace>,
}

enum TraceFile {
    Csv(Box<TraceWriter<BufWriter<File>>>),
    Recording(Box<TraceRecording>),
}

impl RunFiles {
    /// Creates the files in the folder `out`.
    ///
    /// # Errors
    /// Names the file or folder that cannot be written.
    pub(super) fn create(
        name: &str,
        scenario: &Scenario,
        world: World,
        format: TraceFormat,
        out: &Path,
    ) -> anyhow::Result<Self> {
        let topology = Topology::of(scenario).map_err(|wrong| wrong.in_file("scenario"))?;
        let arrivals = match world {
            World::Virtual => create_arrivals(scenario, &out.join(NODES_FOLDER))?,
            World::Processes => Vec::new(),
        };
        let trace = match format {
            TraceFormat::Mcap => {
                let path = out.join("trace.mcap");
                let views = topology.views();
                // Tables are declared at the beginning of a recording, so the views have to be known by now.
                let recording = TraceRecording::create(&path, name, scenario, world, views)?;
                TraceFile::Recording(Box::new(recording))
            }
            TraceFormat::Csv => {
                let path = out.join("trace.csv");
                let file = File::create(&path)
                    .with_context(|| format!("cannot write {}", path.display()))?;
                let (receivers, views) = (&scenario.receivers, topology.views());
                let trace = TraceWriter::new(receivers, views, BufWriter::new(file));
                TraceFile::Csv(Box::new(trace))
            }
        };
        Ok(Self { trace, arrivals })
    }

    /// Writes the rest, and closes the files.
    ///
    /// # Errors
    /// Names the file that is incomplete.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        match self.trace {
            // Errors of all rows come out here, as a sink returns none.
            TraceFile::Csv(trace) => trace.finish(),
            TraceFile::Recording(trace) => trace.finish(),
        }?;
        for mut arrivals in self.arrivals {
            arrivals.finish()?;
        }
        Ok(())
    }
}

impl RowSink for RunFiles {
    fn row(&mut self, view: usize, row: &Row) {
        match &mut self.trace {
            TraceFile::Csv(trace) => trace.row(view, row),
            TraceFile::Recording(trace) => trace.row(view, row),
        }
    }

    fn arrived(&mut self, receiver: usize, at: Instant<True>, tick: &Tick, arrival: &Arrival) {
        // Without a file the receiver is a process, which writes its own.
        if let Some(arrivals) = self.arrivals.get_mut(receiver) {
            arrivals.write(at, tick, arrival);
        }
    }
}

/// Creates the files under the names that they have as processes.
fn create_arrivals(scenario: &Scenario, folder: &Path) -> anyhow::Result<Vec<ArrivalsTrace>> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let path = |name: &str| -> PathBuf { arrivals_beside(&folder.join(format!("{name}.csv"))) };
    let receivers = scenario.receivers.iter();
    receivers
        .map(|receiver| ArrivalsTrace::create(&path(receiver.name.as_str())))
        .collect()
}
