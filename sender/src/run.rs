//! The sender in the real world: `coaxle-sender` and `coaxle sender`.

mod recorder;

use coaxle_clock::{Instant, Local};
use coaxle_host::cli::NodeArgs;
use coaxle_host::files::Rows;
use coaxle_host::node::{BuildNode, Recorder, Setup, TransportService};
use coaxle_node::Node;
use coaxle_node::lab::NodeFile;
use coaxle_os::exit::Exit;

use crate::config::SenderConfig;
use crate::node::Sender;
use recorder::SenderRecorder;

/// Command line arguments of a sender.
pub type Args = NodeArgs;

/// Checks the config, or runs the sender until its time is up or a signal arrives.
///
/// # Errors
/// The config names a wrong value (file, field, received, expected), the trace file or the
/// endpoints cannot be opened, or the trace could not be kept.
pub fn run(args: &Args) -> anyhow::Result<Exit> {
    run_with_service(args, None)
}

/// Runs the sender with a further service on its transport.
///
/// # Errors
/// As [`run`], and those of the service.
pub fn run_with_service(
    args: &Args,
    transport_service: Option<TransportService>,
) -> anyhow::Result<Exit> {
    let NodeFile { mut config, lab } = args.load::<SenderConfig>()?;
    // Before the check as well, since checking reads the files.
    config.relative_to(args.folder());
    config.transport = args.transport(&config.name, &config.transport)?;
    if args.check {
        // Built and dropped: only building finds an unreadable recording.
        build(args, &config, Instant::EPOCH, 0)?;
        return args.report_valid().map(|()| Exit::Done);
    }
    args.die_with_parent()?;
    let recorder = SenderRecorder::new(&config, rows(args, &config)?);
    // Owned by the closure, which builds the node on the cycle thread.
    let (args_of_node, node) = (args.clone(), config.clone());
    let build = move |start, epoch| build(&args_of_node, &node, start, epoch);
    let outcome = coaxle_host::node::run(Setup {
        run_for: args.run_for,
        lab,
        transport_service,
        ..setup(&config, Box::new(build), Box::new(recorder))
    })?;
    tracing::info!(
        cycles = outcome.cycles,
        published = outcome.published,
        not_published = outcome.not_published,
        not_recorded = outcome.telemetry_dropped,
        "cycles of this run"
    );
    Ok(Exit::Done)
}

/// The host's set-up of a config, for a run until a signal: the node that `build` creates, whose
/// records `recorder` keeps.
#[must_use]
pub fn setup<N: Node>(
    config: &SenderConfig,
    build: BuildNode<N>,
    recorder: Box<dyn Recorder<N::Snapshot>>,
) -> Setup<N> {
    Setup {
        name: config.name.clone(),
        role: "sender",
        transport: config.transport.clone(),
        real_time: config.real_time,
        clock: config.clock.clone(),
        seed: config.seed,
        lab: None,
        send_stamps: config.send_stamps,
        wiring: config.wiring(),
        plant: config.plant_node("config"),
        timing: config.timing_endpoints(),
        run_for: None,
        build,
        recorder,
        transport_service: None,
    }
}

fn rows(args: &Args, config: &SenderConfig) -> anyhow::Result<Rows> {
    args.rows(
        &config.name,
        "sender",
        config.instances(),
        &config.columns(),
        config.cycle_time_us.0.span(),
    )
}

fn build(
    args: &NodeArgs,
    config: &SenderConfig,
    start: Instant<Local>,
    epoch: u64,
) -> anyhow::Result<Sender> {
    Ok(Sender::new(config, start, epoch).map_err(|wrong| args.wrong(wrong))?)
}
