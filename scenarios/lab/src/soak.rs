//! Soak tests: random schedules of faults and commands, with all invariants checked.
//!
//! A schedule is a scenario made from a seed. In virtual time a day of them takes minutes; a failing one is shrunk for as
//! long as it fails, and left as a scenario file that repeats it.

pub mod schedule;
mod shrink;

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::Context;
use coaxle_node::config::{ClockConfig, CycleMicros};
use coaxle_os::machine;
use coaxle_receiver::ContinuityName;
use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::config::{FarConfig, Mode};

use crate::catalog::Source;
use crate::expect::receiver_of;
use crate::finished::{Finished, Progress};
use crate::invariants::Invariant;
use crate::junit::{self, JunitCase};
use crate::results_folder::ResultsFolder;
use crate::run::{Options, TraceFormat};
use crate::scenario::Scenario;
use crate::stage::Stage;
use crate::summary::{ReceiverSummary, World};
use crate::virtual_time;

/// Schedules to run, and their results' destination.
#[derive(Clone)]
pub struct Soak<'a> {
    /// In virtual time, or as processes: these run one schedule after the other, virtual time as many as there are processors.
    pub stage: &'a dyn Stage,
    /// The schedules.
    pub seeds: Range<u64>,
    /// True for [wide](schedule::wide) schedules.
    pub wide: bool,
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

/// Seeds of the schedules for this many hours, from the first seed on.
#[must_use]
pub fn seeds_of_hours(hours: f64, first: u64) -> Range<u64> {
    let count = (hours * 3_600.0 / schedule::DURATION_S).ceil().max(1.0);
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
        let _held = ResultsFolder::hold(&self.out)?;
        let next = AtomicU64::new(self.seeds.start);
        let results = Mutex::new((BTreeSet::new(), Vec::new()));
        let work = || -> anyhow::Result<()> {
            loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= self.seeds.end || !goes_on() {
                    return Ok(());
                }
                // An interrupted schedule has no result.
                let Some(failed) = self.run_one(seed, goes_on)? else {
                    return Ok(());
                };
                let mut results = results.lock().expect("no worker panics");
                let (done, failures) = &mut *results;
                done.insert(seed);
                failures.extend(failed);
                progress(done.len() as u64, failures.len());
            }
        };
        let workers = match self.stage.world() {
            World::Virtual => std::thread::available_parallelism().map_or(1, usize::from),
            World::Processes => 1,
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
            let ended = workers
                .into_iter()
                .map(|one| one.join().expect("no worker panics"));
            ended.collect::<anyhow::Result<Vec<()>>>()
        })?;
        let (done, mut failures) = results.into_inner().expect("no worker panics");
        failures.sort();
        let schedules = done.len() as u64;
        let soaked = SoakResult {
            schedules,
            of: self.seeds.end - self.seeds.start,
            simulated_s: schedules as f64 * schedule::DURATION_S,
            took_s: (machine::now() - begin).as_secs_f64(),
            failures,
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

    /// The failure, if any; the outer option is absent if it was interrupted.
    fn run_one(
        &self,
        seed: u64,
        goes_on: &dyn Fn() -> bool,
    ) -> anyhow::Result<Option<Option<SoakFailure>>> {
        let text = match self.wide {
            true => schedule::wide(seed),
            false => schedule::of(seed),
        };
        let wrong = match self.stage.world() {
            World::Virtual => wrong_while(&text, goes_on),
            World::Processes => {
                let out = self.out.join(format!("seed-{seed}-processes"));
                wrong_on(self.stage, &text, &out, goes_on)
            }
        };
        let Some(wrong) = wrong else {
            return Ok(None);
        };
        if wrong.is_empty() {
            return Ok(Some(None));
        }
        let (text, wrong) = match self.stage.world() {
            World::Virtual => shrink::shrunk(text, wrong, goes_on),
            World::Processes => (text, wrong),
        };
        let file = self.out.join(format!("seed-{seed}.toml"));
        write(&file, &text)?;
        if self.stage.world() == World::Virtual {
            self.leave_rows(&file, text)?;
        }
        Ok(Some(Some(SoakFailure { seed, wrong, file })))
    }

    /// Leaves the rows of a failure, and its report, beside its file.
    fn leave_rows(&self, file: &Path, text: String) -> anyhow::Result<()> {
        let out = file.with_extension("");
        let options = Options {
            seed: None,
            overrides: Vec::new(),
            receivers: Vec::new(),
            out,
            trace: Some(TraceFormat::Mcap),
        };
        let command = format!("coaxle run {}", file.display());
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

/// Faults of a scenario in virtual time, a line each: a violated invariant, a receiver that is not in sync at the end, or
/// the error that prevents the run.
#[must_use]
pub fn faults_of(text: &str) -> Vec<String> {
    wrong_while(text, &|| true).unwrap_or_default()
}

/// Ends a run once the condition is false.
struct RunWhile<'a>(&'a dyn Fn() -> bool);

impl Progress for RunWhile<'_> {
    fn at(&mut self, _share: f64) -> bool {
        (self.0)()
    }
}

/// Faults of a scenario as long as `goes_on` returns true; none if it was interrupted.
fn wrong_while(text: &str, goes_on: &dyn Fn() -> bool) -> Option<Vec<String>> {
    let run = || {
        let scenario = source(text.to_owned()).read(&[])?;
        let finished = virtual_time::run(&scenario, &mut (), &mut RunWhile(goes_on))?;
        if finished.interrupted_at_s.is_some() {
            return Ok(None);
        }
        let duration = scenario.duration_s.get();
        let lost = finished
            .figures()
            .iter()
            .filter(|(_, receiver)| synchronises(receiver.mode) && !is_back(receiver, duration))
            .filter(|(name, _)| is_to_be_in_sync(&scenario, name))
            .map(|(name, receiver)| {
                format!("{name} ({}) is not in sync at the end", receiver.mode)
            });
        anyhow::Ok(Some(violations(&finished).chain(lost).collect()))
    };
    run().unwrap_or_else(|error: anyhow::Error| Some(vec![format!("{error:#}")]))
}

/// Faults of a run as processes. Only conditions that hold on a busy machine too are checked: the invariants, and that every
/// node runs to the end and is not killed by a signal.
fn wrong_on(
    stage: &dyn Stage,
    text: &str,
    out: &Path,
    goes_on: &dyn Fn() -> bool,
) -> Option<Vec<String>> {
    let run = || {
        let scenario = source(text.to_owned()).read(&[])?;
        let finished = stage.play(&scenario, out, &mut (), &mut RunWhile(goes_on))?;
        let is_whole = finished.interrupted_at_s.is_none();
        let deaths = finished.deaths.iter().map(ToString::to_string);
        anyhow::Ok(is_whole.then(|| deaths.chain(violations(&finished)).collect()))
    };
    run().unwrap_or_else(|error: anyhow::Error| Some(vec![format!("{error:#}")]))
}

/// Violations. A slave may end in error stop, as its orders come at random. Whether far axes end well is judged by
/// `is_back`.
fn violations(finished: &Finished) -> impl Iterator<Item = String> {
    let all = finished.violations().iter();
    let judged = all.filter(|one| one.invariant != Invariant::EndsWell);
    judged.map(ToString::to_string)
}

/// Least tolerance of a block, in cycles of silence or of difference, for a quiet network of these schedules: with less it
/// may never get in sync.
const LEAST_TOLERANCE: f64 = 20.0;

/// True if a receiver has to be in sync once the network is quiet: its blocks tolerate the remaining faults, and its master
/// is published.
fn is_to_be_in_sync(scenario: &Scenario, name: &str) -> bool {
    let named = |name: &str| {
        let mut receivers = scenario.receivers.iter();
        receivers.find(|receiver| receiver.name.as_str() == name)
    };
    let receiver = named(receiver_of(name));
    let mut far = receiver.into_iter().flat_map(|receiver| &receiver.far);
    far.all(|far| {
        // Slaves of an axis that cannot keep up with its master wait for it with their power off, for any time.
        let master = named(far.node.as_str());
        let may_wait = master.is_some_and(has_limits);
        let is_published =
            master.is_none_or(|master| is_to_be_in_sync(scenario, master.name.as_str()));
        let has_beats = far.mode == Mode::Observer
            || receiver.is_some_and(|receiver| has_beats(scenario, receiver, far));
        tolerates_the_network(far) && has_beats && is_published && !may_wait
    })
}

/// Shortest cycle that is longer than the jitter of these schedules, s. In shorter ones TS5066 finds no beat.
const SHORTEST_CYCLE: f64 = 0.4e-3;
/// Longest time between two beats with which it learns the drift before a schedule is over, s.
const BETWEEN_BEATS: f64 = 10.0;

/// True if a block of TS5066 sees beats from which it can learn the drift.
fn has_beats(scenario: &Scenario, receiver: &ReceiverConfig, far: &FarConfig) -> bool {
    let of = |name: &str, cycle: CycleMicros, clock: &ClockConfig| {
        (name == far.node.as_str()).then(|| (cycle.0.as_secs_f64(), clock.drift_ppm.get()))
    };
    let mut senders = scenario.senders.iter();
    let mut receivers = scenario.receivers.iter();
    let master = senders
        .find_map(|one| of(one.name.as_str(), one.cycle_time_us, &one.clock))
        .or_else(|| receivers.find_map(|one| of(one.name.as_str(), one.cycle_time_us, &one.clock)));
    let Some((cycle, drift)) = master else {
        return true;
    };
    let own = receiver.cycle_time_us.0.as_secs_f64();
    let drift = (drift - receiver.clock.drift_ppm.get()).abs() * 1e-6;
    cycle.min(own) >= SHORTEST_CYCLE && cycle.max(own) <= BETWEEN_BEATS * drift
}

fn tolerates_the_network(far: &FarConfig) -> bool {
    let parameters = &far.sync.time_sync;
    let least = f64::from(parameters.age_of_data_limit).min(parameters.max_cycle_index_difference);
    far.mode == Mode::Observer || least >= LEAST_TOLERANCE
}

fn has_limits(receiver: &ReceiverConfig) -> bool {
    let mut axes = receiver.far.iter().flat_map(|far| far.axes.iter());
    axes.any(|axis| axis.limits.is_some())
}

/// Time that an observer may take to lock, s. A follower of another receiver starts once that is back itself.
const STARTING_UP: f64 = 30.0;
/// TS5066 learns the drift from one beat to the next.
const BEATS: u64 = 2;

/// True if a receiver is in sync after this time, or cannot be yet; or if its clock is and the axis is on its way. That
/// takes up to half a minute after a long absence.
fn is_back(receiver: &ReceiverSummary, duration: f64) -> bool {
    let (far, axis) = (&receiver.last.far, &receiver.last.axis);
    let is_on_its_way = far.synced && axis.continuity == ContinuityName::Rejoining;
    let heard_for = match far.last_relock_s {
        // Only another run restarted it: frames come since then.
        Some(since) if u64::from(far.relocks) <= far.restarts => duration - since,
        _ if far.restarts == 0 => {
            far.cycle_time_us.unwrap_or_default() * 1e-6 * far.expected as f64
        }
        _ => f64::INFINITY,
    };
    let has_just_begun = far.expected > 0 && heard_for < STARTING_UP;
    let waits_for_beats =
        receiver.mode != "observer" && far.error == 0 && u64::from(far.beats) < BEATS;
    receiver.synced_at_end || is_on_its_way || has_just_begun || waits_for_beats
}

fn synchronises(mode: &str) -> bool {
    matches!(mode, "observer" | "sync" | "time")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::VirtualTime;

    fn soak(folder: &Path) -> Soak<'static> {
        Soak {
            stage: &VirtualTime,
            seeds: 0..3,
            wide: false,
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
        assert!(report.contains("tests=\"0\" failures=\"0\""), "{report}");
        assert_eq!(wrong_while(&schedule::of(1), &|| false), None);
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
