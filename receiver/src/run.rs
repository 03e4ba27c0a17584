//! The receiver in the real world: `coaxle-receiver` and `coaxle receiver`.

#[cfg(test)]
mod circle_tests;
mod drives;
mod fault;
mod journal;
mod recorder;
mod status;

use std::path::PathBuf;

use coaxle_clock::{Instant, Local};
use coaxle_host::cli::NodeArgs;
use coaxle_host::files::Rows;
use coaxle_host::node::{BuildNode, Recorder, Setup, TransportService};
use coaxle_node::lab::NodeFile;
use coaxle_os::exit::Exit;
use coaxle_os::{ArrivalsTrace, EndReason, arrivals_beside};

use crate::config::ReceiverConfig;
use crate::drives::Drives;
use crate::node::Receiver;
use crate::snapshot::ReceiverSnapshot;
use drives::drives;
use recorder::ReceiverRecorder;

/// Command line arguments of a receiver.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    node: NodeArgs,
    /// Write the raw arrivals to this file, as CSV with a header line: for each message that was
    /// used, the sender's run, count and send stamp and the arrival, in ns. The four stamps t1 to
    /// t4 of the time exchanges go to FILE-exchanges.csv. An estimator can be run over them again;
    /// `coaxle record-arrivals --from` turns them into a recording [default: next to the trace, if
    /// there is one]
    #[arg(long, value_name = "FILE", conflicts_with = "check")]
    arrivals: Option<PathBuf>,
}

/// Checks the config, or runs the receiver until its time is up or a signal arrives.
///
/// # Errors
/// The config names a wrong value (file, field, received, expected), the trace file or the
/// endpoints cannot be opened, or the trace could not be kept.
pub fn run(args: &Args) -> anyhow::Result<Exit> {
    run_with_service(args, None)
}

/// Runs the receiver with a further service on its transport.
///
/// # Errors
/// As [`run`], and those of the service.
pub fn run_with_service(
    args: &Args,
    transport_service: Option<TransportService>,
) -> anyhow::Result<Exit> {
    let node = &args.node;
    let NodeFile { mut config, lab } = node.load::<ReceiverConfig>()?;
    config.relative_to(node.folder());
    config.transport = node.transport(&config.name, &config.transport)?;
    for note in config.notes() {
        tracing::warn!("{}: {note}", node.file());
    }
    if node.check {
        // A check must not create shared memory, which a running node may have.
        build(node, &config, Drives::simulated(), Instant::EPOCH, 0)?;
        return node.report_valid().map(|()| Exit::Done);
    }
    // Before anything moves: a parent that has ended already refuses the start.
    node.die_with_parent()?;
    // Before the node: a file that cannot be written ends the program before anything moves.
    let recorder = recorder(args, &config)?;
    let follows = !config.received_nodes().is_empty();
    let (args_of_node, built) = (node.clone(), config.clone());
    // Called by the host, which knows start and epoch only once its clock runs.
    let build = move |start, epoch| {
        let drives = drives(&built, epoch).map_err(|error| args_of_node.wrong(error))?;
        build(&args_of_node, &built, drives, start, epoch)
    };
    let outcome = coaxle_host::node::run(Setup {
        run_for: node.run_for,
        lab,
        transport_service,
        ..setup(&config, Box::new(build), Box::new(recorder))
    })?;
    tracing::info!(
        cycles = outcome.cycles,
        received = outcome.received,
        refused = outcome.refused,
        mailbox_dropped = outcome.mailbox_dropped,
        published = outcome.published,
        not_published = outcome.not_published,
        not_recorded = outcome.telemetry_dropped,
        arrivals_not_recorded = outcome.arrivals_dropped,
        "cycles of this run"
    );
    // A run that a signal ended early may have had no time to receive anything.
    if outcome.ended == EndReason::TimeUp && follows && outcome.received == 0 {
        tracing::error!("no data came of any node that is followed");
        return Ok(Exit::NoData);
    }
    Ok(Exit::Done)
}

/// The host's set-up of a config, for a run until a signal: the receiver that `build` creates,
/// whose records `recorder` keeps.
#[must_use]
pub fn setup(
    config: &ReceiverConfig,
    build: BuildNode<Receiver>,
    recorder: Box<dyn Recorder<ReceiverSnapshot>>,
) -> Setup<Receiver> {
    Setup {
        name: config.name.clone(),
        role: "receiver",
        transport: config.transport.clone(),
        real_time: config.real_time,
        clock: config.clock.clone(),
        seed: config.seed,
        // Only a file has a lab table: `run_with_service` sets it.
        lab: None,
        send_stamps: true,
        wiring: config.wiring(),
        plant: config.plant_node("config"),
        timing: config.timing_endpoints(),
        run_for: None,
        build,
        recorder,
        transport_service: None,
    }
}

/// Creates the recorder: rows to their destinations; raw arrivals to the requested file, or next to
/// the trace.
fn recorder(args: &Args, config: &ReceiverConfig) -> anyhow::Result<ReceiverRecorder> {
    let rows = rows(&args.node, config)?;
    let trace = args.node.trace.as_deref();
    let arrivals = args.arrivals.clone().or_else(|| trace.map(arrivals_beside));
    let arrivals = arrivals.as_deref().map(ArrivalsTrace::create).transpose()?;
    Ok(ReceiverRecorder::new(config, rows, arrivals))
}

fn rows(node: &NodeArgs, config: &ReceiverConfig) -> anyhow::Result<Rows> {
    let (instances, columns) = (config.instances(), config.columns());
    let cycle = config.cycle_time_us.0.span();
    node.rows(&config.name, "receiver", instances, &columns, cycle)
}

fn build(
    args: &NodeArgs,
    config: &ReceiverConfig,
    drives: Drives,
    start: Instant<Local>,
    epoch: u64,
) -> anyhow::Result<Receiver> {
    let built = Receiver::with_drives(config, drives, start, epoch);
    Ok(built.map_err(|error| args.wrong(error))?)
}
