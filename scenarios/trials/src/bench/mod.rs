//! `coaxle bench`: the real path from end to end, beside the same machine without coaxle.
//!
//! Contenders are measured in turns within one run, so that changes of the machine's speed affect all of them equally;
//! ratios say more than times. Processes are this very program, which starts itself.

mod configs;
mod cyclictest;
mod end_to_end;
mod load;
mod namespace;
mod pair;
mod peer;
mod plan;
mod process;
mod quantiles;
mod report;
mod settings;
mod transports;
mod turns;
mod wake_up;

use anyhow::Context;
use clap::{Args, ValueEnum};
use coaxle_clock::Span;
use coaxle_host::cli::parse_duration;
use coaxle_node::config::{CycleMicros, RealTimeConfig};
use coaxle_os::exit::Exit;
use coaxle_os::{Os, System};
use coaxle_report::inspect;
use serde::Serialize;

use crate::Bar;
use end_to_end::EndToEnd;
use load::ProcessorLoad;
use settings::BenchSettings;
use transports::Transports;
use turns::{BenchProgress, MeasurementInterrupted};
use wake_up::WakeUp;

pub use peer::{PeerArgs, run as run_peer};
pub use plan::PEER;

/// Arguments of `coaxle bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Parts to measure [default: wake-up, end-to-end, load]
    #[arg(value_enum)]
    parts: Vec<BenchPart>,
    /// Time that each part measures, without startup: 30s, 2min …
    #[arg(long = "for", value_name = "DURATION", default_value = "30s", value_parser = parse_duration)]
    time: Span,
    /// Number of rounds: contenders take turns in each
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Cycle time of all loops and nodes, µs: 100 to 100000
    #[arg(long, value_name = "MICROS", default_value = "1000", value_parser = cycle_micros)]
    cycle_us: CycleMicros,
    /// Axes of a frame in the part end-to-end, 1 to 128; the others have messages as long
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=128))]
    axes: u32,
    /// Axes of a frame in the part load, 1 to 128
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=128))]
    load_axes: u32,
    /// Loss in each direction in the part transports, % of packets, in a network namespace: that takes root, ip and
    /// iptables
    #[arg(long, value_name = "PERCENT", value_delimiter = ',', default_value = "0,1,5", value_parser = percent)]
    loss: Vec<f64>,
    /// Real-time priority of all cycles, if it is permitted; 0: none
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=99))]
    priority: u8,
    /// Tables, or JSON
    #[arg(short, long, value_enum, default_value_t)]
    format: BenchFormat,
}

/// A part of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BenchPart {
    /// Lateness of a node's cycle thread at wake-up, beside a bare loop and cyclictest
    WakeUp,
    /// Latency of a sample between two processes, beside datagrams and Zenoh alone
    EndToEnd,
    /// Load of each side for many axes in one frame
    Load,
    /// Age of the newest message over each transport while packets are lost
    Transports,
}

/// Format of the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum BenchFormat {
    /// Tables.
    #[default]
    Plain,
    /// A single object.
    Json,
}

fn cycle_micros(text: &str) -> Result<CycleMicros, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    CycleMicros::try_from(number).map_err(|wrong| wrong.to_string())
}

/// A share, from a percentage.
fn percent(text: &str) -> Result<f64, String> {
    let percent = text.parse().ok().filter(|p| (0.0..=50.0).contains(p));
    let share = percent.map(|percent: f64| percent / 100.0);
    share.ok_or_else(|| "expected a percentage from 0 to 50".to_owned())
}

/// Results of all parts.
#[derive(Debug, Serialize)]
struct BenchFigures {
    kernel: String,
    processors: usize,
    settings: settings::PrintedSettings,
    #[serde(skip_serializing_if = "Option::is_none")]
    wake_up: Option<WakeUp>,
    #[serde(skip_serializing_if = "Option::is_none")]
    end_to_end: Option<EndToEnd>,
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<ProcessorLoad>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transports: Option<Transports>,
}

/// Measures and prints.
///
/// # Errors
/// A thread or process that cannot be started or fails.
pub fn bench(args: &BenchArgs) -> anyhow::Result<Exit> {
    let mut bar = Bar::new("of the measurement".to_owned())?;
    let found = measure(args, &mut BenchProgress::new(&mut bar));
    bar.clear();
    let found = match found {
        // Ctrl-C is the user's wish and has an exit code of its own.
        Err(error) if error.is::<MeasurementInterrupted>() => {
            tracing::warn!("{error}");
            return Ok(Exit::Interrupted);
        }
        found => found?,
    };
    let text = match args.format {
        BenchFormat::Plain => plain(&found),
        BenchFormat::Json => {
            serde_json::to_string_pretty(&found).context("cannot write the figures as JSON")?
        }
    };
    inspect::print_text(&text)?;
    Ok(Exit::Done)
}

fn measure(args: &BenchArgs, turns: &mut BenchProgress<'_>) -> anyhow::Result<BenchFigures> {
    let settings = BenchSettings {
        cycle: args.cycle_us.0.span(),
        time: args.time,
        rounds: args.rounds,
        real_time: RealTimeConfig {
            // Priorities of SCHED_FIFO begin at 1.
            priority: (args.priority > 0).then_some(args.priority),
            ..RealTimeConfig::default()
        },
    };
    let wanted = |part| match args.parts.as_slice() {
        // Never by default, as it takes root.
        [] => part != BenchPart::Transports,
        parts => parts.contains(&part),
    };
    for (part, planned) in [
        (BenchPart::WakeUp, wake_up::planned(&settings)),
        (BenchPart::EndToEnd, end_to_end::planned(&settings)),
        (BenchPart::Load, load::planned(&settings)),
        (
            BenchPart::Transports,
            transports::planned(&settings, &args.loss),
        ),
    ] {
        // All parts are planned before the first one begins: the bar shows the share of the whole.
        if wanted(part) {
            turns.plan(planned);
        }
    }
    // Printed beside the figures, which mean nothing without the machine.
    let facts = Os::facts().unwrap_or_default();
    let mut found = BenchFigures {
        kernel: facts.kernel,
        processors: facts.processors,
        settings: settings.shown(),
        wake_up: None,
        end_to_end: None,
        load: None,
        transports: None,
    };
    if wanted(BenchPart::WakeUp) {
        found.wake_up = Some(wake_up::measure(&settings, turns)?);
    }
    if wanted(BenchPart::EndToEnd) {
        found.end_to_end = Some(end_to_end::measure(&settings, args.axes, turns)?);
    }
    if wanted(BenchPart::Load) {
        found.load = Some(load::measure(&settings, args.load_axes, turns)?);
    }
    if wanted(BenchPart::Transports) {
        let measured = transports::measure(&settings, args.axes, &args.loss, turns)?;
        found.transports = Some(measured);
    }
    Ok(found)
}

fn plain(found: &BenchFigures) -> String {
    let parts = [
        found.wake_up.as_ref().map(report::wake_up),
        found.end_to_end.as_ref().map(report::end_to_end),
        found.load.as_ref().map(report::load),
        found.transports.as_ref().map(report::transports),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    parts.join("\n\n")
}
