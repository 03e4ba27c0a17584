//! Work of all cores on the missing runs.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::Context;

use super::record::RunRecord;
use super::{SweepPoint, store};
use crate::figures::SummaryFigure;
use crate::finished::Progress;
use crate::run::judged;
use crate::scenario::Scenario;
use crate::summary::World;
use crate::virtual_time;

/// A point with a seed.
#[derive(Clone, Debug)]
pub(super) struct SweepRun {
    /// Index of the point.
    pub(super) point: usize,
    /// Index of the seed, and the seed.
    pub(super) nth_seed: usize,
    pub(super) seed: u64,
    /// Path of its record.
    pub(super) place: PathBuf,
}

/// Progress of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepProgress {
    /// Number of all runs of the sweep: points times seeds.
    pub runs: usize,
    /// Number of these that the folder had already.
    pub kept: usize,
    /// Number of runs finished since then.
    pub done: usize,
    /// Number of these with unmet expectations.
    pub failed: usize,
    /// Finished share of the missing runs, 0 to 1, including runs under way.
    pub share: f64,
}

/// State that the cores share.
struct SweepState<'a> {
    waiting: std::vec::IntoIter<&'a SweepRun>,
    so_far: SweepProgress,
    /// Progress of each core in its run.
    under_way: Vec<f64>,
    /// True to continue.
    goes_on: bool,
    error: Option<anyhow::Error>,
}

/// Lets each core take the next run that is not begun, and write its record. The first error ends them all, and so does
/// `on_progress` with false: runs under way are then left out.
pub(super) fn run_missing(
    name: &str,
    points: &[SweepPoint],
    runs: &[SweepRun],
    figures: &[SummaryFigure],
    on_progress: &(dyn Fn(&SweepProgress) -> bool + Sync),
) -> anyhow::Result<()> {
    let missing: Vec<&SweepRun> = (runs.iter())
        .filter(|run| store::load(&run.place).is_none())
        .collect();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let cores = cores.min(missing.len());
    let so_far = SweepProgress {
        runs: runs.len(),
        kept: runs.len() - missing.len(),
        done: 0,
        failed: 0,
        share: if missing.is_empty() { 1.0 } else { 0.0 },
    };
    let shared = Mutex::new(SweepState {
        goes_on: on_progress(&so_far),
        so_far,
        under_way: vec![0.0; cores],
        waiting: missing.into_iter(),
        error: None,
    });
    std::thread::scope(|scope| {
        for number in 0..cores {
            let (shared, core) = (
                &shared,
                Core {
                    number,
                    shared: &shared,
                    on_progress,
                },
            );
            scope.spawn(move || {
                if let Err(error) = core.work(name, points, figures) {
                    let mut shared = lock(shared);
                    shared.goes_on = false;
                    // The first error is the cause: later ones may follow from the end that it brings.
                    shared.error.get_or_insert(error);
                }
            });
        }
    });
    let shared = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    shared.error.map_or(Ok(()), Err)
}

/// A core, which also observes the progress of its run.
struct Core<'s, 'a> {
    number: usize,
    shared: &'s Mutex<SweepState<'a>>,
    on_progress: &'s (dyn Fn(&SweepProgress) -> bool + Sync),
}

impl<'a> Core<'_, 'a> {
    fn work(
        mut self,
        name: &str,
        points: &[SweepPoint],
        figures: &[SummaryFigure],
    ) -> anyhow::Result<()> {
        while let Some(run) = self.next() {
            let point = &points[run.point];
            let scenario = point.with_seed(run.nth_seed)?;
            let record = self.run(name, &scenario, figures).with_context(|| {
                let values = point.values.join(", ");
                format!("at the point {values} with seed {}", run.seed)
            })?;
            // An interrupted run is none: the next sweep runs it from the beginning.
            let Some(record) = record else {
                break;
            };
            // Kept before it counts as done: progress never promises what a crash would take.
            store::keep(&run.place, &record)?;
            self.has_done(&record);
        }
        Ok(())
    }

    fn next(&self) -> Option<&'a SweepRun> {
        let mut shared = lock(self.shared);
        if shared.goes_on {
            shared.waiting.next()
        } else {
            None
        }
    }

    /// Absent if interrupted.
    fn run(
        &mut self,
        name: &str,
        scenario: &Scenario,
        figures: &[SummaryFigure],
    ) -> anyhow::Result<Option<RunRecord>> {
        let finished = virtual_time::run(scenario, &mut (), self)?;
        let summary = judged(name, scenario, World::Virtual, finished);
        let is_whole = summary.interrupted_at_s.is_none();
        Ok(is_whole.then(|| RunRecord::of(&summary, figures)))
    }

    fn has_done(&self, record: &RunRecord) {
        let mut shared = lock(self.shared);
        // Otherwise the run would count as done and as under way at the same time.
        shared.under_way[self.number] = 0.0;
        shared.so_far.done += 1;
        shared.so_far.failed += usize::from(!record.failures.is_empty());
        self.tell(&mut shared);
    }

    fn tell(&self, shared: &mut SweepState<'_>) {
        let SweepProgress {
            runs, kept, done, ..
        } = shared.so_far;
        let under_way: f64 = shared.under_way.iter().sum();
        let missing = (runs - kept) as f64;
        shared.so_far.share = ((done as f64 + under_way) / missing).min(1.0);
        shared.goes_on &= (self.on_progress)(&shared.so_far);
    }
}

impl Progress for Core<'_, '_> {
    fn at(&mut self, share: f64) -> bool {
        let mut shared = lock(self.shared);
        shared.under_way[self.number] = share;
        self.tell(&mut shared);
        // A finished run is kept, even if no other is begun.
        shared.goes_on || share >= 1.0
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A core that panics leaves counters that are still numbers, and the scope passes its panic on.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
