//! Soak tests: random schedules of faults and commands, with all invariants checked.
//!
//! A schedule is a scenario made from a seed. In virtual time a day of them takes minutes; a failing one is shrunk for as
//! long as it fails, and left as a scenario file that repeats it.

mod at_end;
mod liveness;
pub mod schedule;
mod shrink;

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::Context;
use coaxle_os::machine;

use crate::catalog::Source;
use crate::finished::{Finished, Progress};
use crate::invariants::Invariant;
use crate::junit::{self, JunitCase};
use crate::results_folder::ResultsFolder;
use crate::run::{Options, TraceFormat};
use crate::shell;
use crate::stage::Stage;
use crate::summary::World;
use crate::topology::Topology;
use crate::virtual_time;
use liveness::Liveness;
use schedule::ScheduleKind;

/// Schedules to run, and their results' destination.
#[derive(Clone)]
pub struct Soak<'a> {
    /// In virtual time, or as processes: these run one schedule after the other, virtual time as many as there are processors.
    pub stage: &'a dyn Stage,
    /// The schedules.
    pub seeds: Range<u64>,
    /// Kind of the schedules: [`schedule::PLAIN`], [`schedule::WIDE`] or [`schedule::SWARM`].
    pub schedule: ScheduleKind,
    /// Folder for files of failures, and of processes.
    pub out: PathBuf,
    /// Path of a report in JUnit's format.
    pub junit: Option<PathBuf>,
    /// Runs a failure once more, beside its file, and leaves its trace and report.
    pub leave: &'a Leave,
}

/// Runs a scenario with these options, which this command repeats, and leaves the results.
pub type Leave = dyn Fn(&Source, &Options, &str) -> anyhow::Result<()> + Sync;

/// Result of a soak.
#[derive(Clone, Debug)]
pub struct SoakResult {
    /// Number of schedules that were run, to their end.
    pub schedules: u64,
    /// Number of all schedules; more than those that were run if the soak was interrupted.
    pub of: u64,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Elapsed time, s.
    pub took_s: f64,
    /// Failures, by seed.
    pub failures: Vec<SoakFailure>,
    /// Slaves that wait at the end of a schedule that is judged for liveness, a line each, by seed: no failure, as an order may name
    /// a position that its master does not reach.
    pub waits: Vec<(u64, String)>,
}

/// A schedule that failed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SoakFailure {
    /// Seed of the schedule.
    pub seed: u64,
    /// Faults found, a line each.
    pub wrong: Vec<String>,
    /// The scenario that repeats it.
    pub file: PathBuf,
}

/// Seeds of the schedules of a kind for this many hours, from the first seed on.
#[must_use]
pub fn seeds_of_hours(hours: f64, first: u64, schedule: &ScheduleKind) -> Range<u64> {
    // At least one schedule, as a soak of none would pass.
    let count = (hours * 3_600.0 / schedule.length_s).ceil().max(1.0);
    first..first.saturating_add(count as u64)
}

impl Soak<'_> {
    /// Runs all schedules, for as long as `goes_on` returns true; `progress` receives the numbers of finished and of
    /// failed schedules.
    ///
    /// # Errors
    /// A folder that another run writes to, a file that cannot be written. A failing schedule is no error.
    pub fn run(
        &self,
        goes_on: &(dyn Fn() -> bool + Sync),
        progress: &(dyn Fn(u64, usize) + Sync),
    ) -> anyhow::Result<SoakResult> {
        let begin = machine::now();
        // Held to the end: two soaks would write the same files of seeds.
        let _held = ResultsFolder::hold(&self.out)?;
        let next = AtomicU64::new(self.seeds.start);
        let results = Mutex::new((BTreeSet::new(), Vec::new(), Vec::new()));
        let work = || -> anyhow::Result<()> {
            loop {
                // The counter alone hands out the seeds, and the lock orders the results.
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= self.seeds.end || !goes_on() {
                    return Ok(());
                }
                // An interrupted schedule has no result.
                let Some(ScheduleResult { failure, waits }) = self.run_one(seed, goes_on)? else {
                    return Ok(());
                };
                let mut results = results.lock().expect("no worker panics");
                let (done, failures, all_waits) = &mut *results;
                done.insert(seed);
                failures.extend(failure);
                all_waits.extend(waits.into_iter().map(|line| (seed, line)));
                progress(done.len() as u64, failures.len());
            }
        };
        let workers = match self.stage.world() {
            World::Virtual => std::thread::available_parallelism().map_or(1, usize::from),
            // Processes compete for the processors, and late cycles would be taken for faults.
            World::Processes => 1,
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
            let ended = workers
                .into_iter()
                .map(|one| one.join().expect("no worker panics"));
            ended.collect::<anyhow::Result<Vec<()>>>()
        })?;
        let (done, mut failures, mut waits) = results.into_inner().expect("no worker panics");
        // Workers end in any order.
        failures.sort();
        waits.sort();
        // Schedules that were under way at an interruption have not been judged.
        let schedules = done.len() as u64;
        let soaked = SoakResult {
            schedules,
            of: self.seeds.end - self.seeds.start,
            simulated_s: schedules as f64 * self.schedule.length_s,
            took_s: (machine::now() - begin).as_secs_f64(),
            failures,
            waits,
        };
        if let Some(path) = &self.junit {
            let cases = cases(&done, &soaked);
            junit::write(path, &self.suite(), soaked.took_s, cases)?;
        }
        Ok(soaked)
    }

    /// Name of the suite in the report.
    #[must_use]
    pub fn suite(&self) -> String {
        format!("soak {}", self.stage.world().name())
    }

    /// The result of a schedule; absent if it was interrupted.
    fn run_one(
        &self,
        seed: u64,
        goes_on: &dyn Fn() -> bool,
    ) -> anyhow::Result<Option<ScheduleResult>> {
        let text = (self.schedule.text)(seed);
        let outcome = match self.stage.world() {
            World::Virtual => outcome_of(&text, goes_on),
            World::Processes => {
                let out = self.out.join(format!("seed-{seed}-processes"));
                outcome_on(self.stage, &text, &out, goes_on)
            }
        };
        let (found, is_refused) = match outcome {
            ScheduleOutcome::Ended => return Ok(None),
            ScheduleOutcome::Run(found) => (found, false),
            ScheduleOutcome::Refused(reason) => (FoundAtEnd::wrong(vec![reason]), true),
        };
        let FoundAtEnd { wrong, waits } = found;
        if wrong.is_empty() {
            let failure = None;
            return Ok(Some(ScheduleResult { failure, waits }));
        }
        let (text, wrong) = match self.stage.world() {
            World::Virtual => shrink::shrunk(text, wrong, goes_on),
            // A failure of processes may not come again, so nothing tells a smaller scenario that passes from chance.
            World::Processes => (text, wrong),
        };
        let file = self.out.join(format!("seed-{seed}.toml"));
        write(&file, &text)?;
        // What is refused leaves no rows.
        if self.stage.world() == World::Virtual && !is_refused {
            self.leave_rows(&file, text)?;
        }
        let failure = Some(SoakFailure { seed, wrong, file });
        Ok(Some(ScheduleResult { failure, waits }))
    }

    /// Leaves the rows of a failure, and its report, beside its file.
    fn leave_rows(&self, file: &Path, text: String) -> anyhow::Result<()> {
        let out = file.with_extension("");
        let options = Options {
            // The seed is in the text of the schedule.
            seed: None,
            overrides: Vec::new(),
            receivers: Vec::new(),
            out,
            trace: Some(TraceFormat::Mcap),
        };
        let command = format!("coaxle run {}", shell::word(&file.display().to_string()));
        (self.leave)(&source(text), &options, &command)
    }
}

/// A case of the report for each schedule that was run.
fn cases(done: &BTreeSet<u64>, soaked: &SoakResult) -> impl Iterator<Item = JunitCase> {
    done.iter().map(|seed| {
        let failed = soaked.failures.iter().find(|failure| failure.seed == *seed);
        JunitCase {
            name: format!("seed {seed}"),
            failure: failed.map(|failure| junit::JunitFailure {
                message: failure.file.display().to_string(),
                text: failure.wrong.join("\n"),
            }),
        }
    })
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("{}: cannot be written", path.display()))
}

fn source(text: String) -> Source {
    Source {
        name: "schedule".to_owned(),
        file: "schedule.toml".to_owned(),
        text,
    }
}

/// Result of a schedule that was run to its end.
struct ScheduleResult {
    failure: Option<SoakFailure>,
    waits: Vec<String>,
}

/// Findings of a run, a line each.
#[derive(Debug, Default, PartialEq)]
struct FoundAtEnd {
    /// Faults.
    wrong: Vec<String>,
    /// Slaves that still wait.
    waits: Vec<String>,
}

impl FoundAtEnd {
    const fn wrong(wrong: Vec<String>) -> Self {
        let waits = Vec::new();
        Self { wrong, waits }
    }
}

/// Outcome of a schedule.
#[derive(Debug, PartialEq)]
enum ScheduleOutcome {
    /// Run to its end.
    Run(FoundAtEnd),
    /// Not run: a config refuses a drawn value, or a node breaks its contract.
    Refused(String),
    /// Ended before its time.
    Ended,
}

/// Faults of a scenario in virtual time, a line each: a violated invariant, a receiver that is not in sync at the end, a relation that
/// does not hold then, or the error that prevents the run.
#[must_use]
pub fn faults_of(text: &str) -> Vec<String> {
    match outcome_of(text, &|| true) {
        ScheduleOutcome::Run(found) => found.wrong,
        ScheduleOutcome::Refused(reason) => vec![reason],
        ScheduleOutcome::Ended => Vec::new(),
    }
}

/// Ends a run once the condition is false.
struct RunWhile<'a>(&'a dyn Fn() -> bool);

impl Progress for RunWhile<'_> {
    fn at(&mut self, _share: f64) -> bool {
        (self.0)()
    }
}

/// Runs a scenario in virtual time, as long as `goes_on` returns true.
fn outcome_of(text: &str, goes_on: &dyn Fn() -> bool) -> ScheduleOutcome {
    let run = || {
        let scenario = source(text.to_owned()).read(&[])?;
        let topology = Topology::of(&scenario).map_err(|wrong| wrong.in_file("schedule"))?;
        let mut liveness = Liveness::new(&scenario, &topology);
        let finished = virtual_time::run(&scenario, &mut liveness, &mut RunWhile(goes_on))?;
        if finished.interrupted_at_s.is_some() {
            return Ok(ScheduleOutcome::Ended);
        }
        let lost = at_end::out_of_sync(&scenario, &finished);
        let found = violations(&finished).chain(lost);
        anyhow::Ok(ScheduleOutcome::Run(FoundAtEnd {
            wrong: found.chain(liveness.broken()).collect(),
            waits: liveness.waits().collect(),
        }))
    };
    run().unwrap_or_else(refused)
}

/// Runs a scenario as processes. Only conditions that hold on a busy machine too are checked: the invariants, and that every
/// node runs to the end and is not killed by a signal.
fn outcome_on(
    stage: &dyn Stage,
    text: &str,
    out: &Path,
    goes_on: &dyn Fn() -> bool,
) -> ScheduleOutcome {
    let run = || {
        let scenario = source(text.to_owned()).read(&[])?;
        let finished = stage.play(&scenario, out, &mut (), &mut RunWhile(goes_on))?;
        if finished.interrupted_at_s.is_some() {
            return Ok(ScheduleOutcome::Ended);
        }
        let deaths = finished.deaths.iter().map(ToString::to_string);
        let wrong = deaths.chain(violations(&finished)).collect();
        anyhow::Ok(ScheduleOutcome::Run(FoundAtEnd::wrong(wrong)))
    };
    run().unwrap_or_else(refused)
}

fn refused(error: anyhow::Error) -> ScheduleOutcome {
    ScheduleOutcome::Refused(format!("it cannot be run: {error:#}"))
}

/// Violations. A slave may end in error stop, as its orders come at random. Whether far axes end well is judged by
/// `is_back`.
fn violations(finished: &Finished) -> impl Iterator<Item = String> {
    let all = finished.violations().iter();
    let judged = all.filter(|one| one.invariant != Invariant::EndsWell);
    judged.map(ToString::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::VirtualTime;

    fn soak(folder: &Path) -> Soak<'static> {
        Soak {
            stage: &VirtualTime,
            seeds: 0..3,
            schedule: schedule::PLAIN,
            out: folder.join("out"),
            junit: Some(folder.join("junit.xml")),
            leave: &|_, _, _| Ok(()),
        }
    }

    #[test]
    fn one_that_is_ended_says_how_much_was_run_and_what_was_on_its_way_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let soaked = soak(folder.path()).run(&|| false, &|_, _| {}).unwrap();
        assert_eq!((soaked.schedules, soaked.of), (0, 3));
        assert!(soaked.failures.is_empty());
        let report = std::fs::read_to_string(folder.path().join("junit.xml")).unwrap();
        // A schedule that was ended is no case, neither a failed one nor a passed one.
        assert!(report.contains("tests=\"0\" failures=\"0\""), "{report}");
        assert_eq!(
            outcome_of(&(schedule::PLAIN.text)(1), &|| false),
            ScheduleOutcome::Ended
        );
    }

    const SHORT: &str = "title = 'short'\nduration-s = 1\n[network]\nlatency-us = 200\n[[sender]]\nname = 'a'\ncycle-time-us = 1000\n\
        [[sender.axis]]\nid = 1\nname = 'x'\nprogram.start-velocity = 1.0\nprogram.limits = { velocity = 2.0, acceleration = 3.0, \
        jerk = 4.0 }\n[[receiver]]\nname = 'b'\ncycle-time-us = 1000\nmode = 'bypass'\nmaster = { node = 'a', axis = 1 }\n";

    /// Drew a jerk of 4.6e15 once, and the soak ended with its refusal and without its seed.
    #[test]
    fn a_schedule_that_a_config_refuses_is_a_failure_of_its_seed_and_the_others_are_run() {
        let folder = tempfile::tempdir().unwrap();
        let soak = Soak {
            schedule: ScheduleKind {
                text: |seed| match seed {
                    // A field that no network has.
                    1 => SHORT.replace("latency-us = 200", "mtu = 9000"),
                    _ => SHORT.to_owned(),
                },
                length_s: 1.0,
            },
            leave: &|source, _, _| source.read(&[]).map(|_| ()),
            ..soak(folder.path())
        };
        let soaked = soak.run(&|| true, &|_, _| {}).unwrap();
        assert_eq!(soaked.schedules, 3);
        let [failure] = &soaked.failures[..] else {
            panic!("{soaked:?}");
        };
        assert_eq!(failure.seed, 1);
        let [line] = &failure.wrong[..] else {
            panic!("{failure:?}");
        };
        assert!(
            line.starts_with("it cannot be run: ") && line.contains("mtu"),
            "{line}"
        );
        assert!(failure.file.is_file());
    }

    #[test]
    fn two_into_one_folder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let soak = soak(folder.path());
        let _held = ResultsFolder::hold(&soak.out).unwrap();
        let refused = soak.run(&|| true, &|_, _| {}).unwrap_err().to_string();
        assert!(refused.contains("which another run writes to"), "{refused}");
    }
}
