//! `coaxle soak`.

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Args;
use coaxle_lab::junit;
use coaxle_lab::soak::schedule::{self, ScheduleKind};
use coaxle_lab::soak::{Soak, SoakResult, seeds_of_hours};
use coaxle_lab::stage::{Stage, VirtualTime};
use coaxle_os::exit::Exit;
use coaxle_os::{Interrupt, machine};
use coaxle_report::{inspect, reported};
use coaxle_trials::processes::Processes;

/// Arguments of a soak.
#[derive(Debug, Args)]
pub(crate) struct SoakArgs {
    /// Hours of schedules, 40 s each, of a swarm 100 s: of virtual time, or with --processes of real time
    #[arg(long, default_value_t = 1.0, value_parser = hours)]
    hours: f64,
    /// In virtual time, as fast as it goes (the default)
    #[arg(long = "virtual", conflicts_with = "processes")]
    virtual_time: bool,
    /// As real processes over real Zenoh on this machine, in real time
    #[arg(long)]
    processes: bool,
    /// The seed of the first schedule; the next ones follow
    #[arg(long, default_value_t = 0, value_parser = crate::seed::parser())]
    seed: u64,
    /// Draw more than usual: masters in motion, cycle times and limits of many decades, blocks of TS5066 that bear little,
    /// receivers that are stopped again and again
    #[arg(long)]
    wide: bool,
    /// Switch whole features on and off in each schedule, among them modulo and virtual masters, standbys, chains, plates, strategies,
    /// routers and timing channels, and judge at the end that every axis is where it should be
    #[arg(long, conflicts_with_all = ["wide", "processes"])]
    swarm: bool,
    /// Write a report in JUnit's format: a case for each schedule that was run
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Folder for the failed schedules
    #[arg(long, value_name = "DIR", default_value = "out/soak")]
    out: PathBuf,
}

fn hours(text: &str) -> Result<f64, String> {
    let hours: Result<f64, _> = text.parse();
    // 100 000 h are nine million schedules; NaN fails both comparisons.
    let hours = hours.ok().filter(|hours| *hours > 0.0 && *hours <= 1e5);
    hours.ok_or_else(|| format!("received {text}, expected hours above 0, at most 100000"))
}

fn kind(args: &SoakArgs) -> ScheduleKind {
    match (args.swarm, args.wide) {
        (true, _) => schedule::SWARM,
        (false, true) => schedule::WIDE,
        (false, false) => schedule::PLAIN,
    }
}

/// Soaks until all schedules have run or Ctrl-C comes, and prints the results up to then.
pub(crate) fn run(args: &SoakArgs) -> anyhow::Result<Exit> {
    let stage: &dyn Stage = if args.processes {
        &Processes
    } else {
        &VirtualTime
    };
    let kind = kind(args);
    let length = kind.length_s;
    let soak = Soak {
        stage,
        seeds: seeds_of_hours(args.hours, args.seed, &kind),
        schedule: kind,
        out: args.out.clone(),
        junit: args.junit.clone(),
        leave: &reported::leave,
    };
    let all = soak.seeds.end - soak.seeds.start;
    let (seeds, name) = (&soak.seeds, stage.world().name());
    print_progress(&format!(
        "{all} random schedules of {length} s, seeds {} to {}, {name}",
        seeds.start,
        seeds.end - 1
    ));
    let (begin, told) = (machine::now(), AtomicU64::new(0));
    let interrupt = Interrupt::listen()?;
    let soaked = soak.run(&|| !interrupt.is_received(), &|done, failed| {
        // A line for every twentieth part.
        // In whole numbers: a float could skip a part or print it twice.
        let part = done * 20 / all;
        // Several threads report: only the one that raises the part prints its line.
        if told.fetch_max(part, Ordering::Relaxed) < part {
            let took = (machine::now() - begin).as_secs_f64();
            let rate = done as f64 * length / took;
            // `part` is at least 1 here, and so `done` is not 0.
            let left = took / done as f64 * (all - done) as f64;
            print_progress(&format!(
                "{done:7} of {all}, {failed} failed, {rate:.0} times as fast as time, {left:.0} s to go"
            ));
        }
    });
    // Also of an error: otherwise a build server finds no report at all.
    let soaked = junit::report_error(args.junit.as_deref(), &soak.suite(), soaked)?;
    print_summary(&soaked)?;
    if soaked.schedules < soaked.of {
        tracing::warn!(
            "interrupted: {} of {} schedules were run",
            soaked.schedules,
            soaked.of
        );
        return Ok(Exit::Interrupted);
    }
    Ok(Exit::NotMet.done_if(soaked.failures.is_empty()))
}

/// Prints a line of progress. A failure to write it is ignored.
fn print_progress(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

fn print_summary(soaked: &SoakResult) -> anyhow::Result<()> {
    let mut lines = vec![format!(
        "{} schedules, {:.2} h, in {:.0} s: {} failed",
        soaked.schedules,
        soaked.simulated_s / 3_600.0,
        soaked.took_s,
        soaked.failures.len()
    )];
    for failure in &soaked.failures {
        let file = failure.file.display();
        lines.push(format!(
            "seed {}, repeated by: coaxle run {file}",
            failure.seed
        ));
        lines.extend(failure.wrong.iter().map(|line| format!("  {line}")));
    }
    if !soaked.waits.is_empty() {
        lines.push(format!(
            "{} slaves wait at the end, which is no failure:",
            soaked.waits.len()
        ));
        let waits = soaked.waits.iter();
        lines.extend(waits.map(|(seed, line)| format!("  seed {seed}: {line}")));
    }
    inspect::print_text(&lines.join("\n"))
}
