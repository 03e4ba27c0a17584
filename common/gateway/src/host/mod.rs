//! A gateway in the real world: clients of the PLC by ADS, UDP and pipes, each in threads that wait for it, and their
//! connection to the node's cycle. All decisions are in the other modules.

mod ads;
mod pipe;
mod port;
mod recorder;
mod udp;

use std::sync::Arc;
use std::thread::JoinHandle;

use anyhow::Context;
use coaxle_host::cli::NodeArgs;
use coaxle_host::node::{Setup, TransportService};
use coaxle_node::config::TimingEndpoints;
use coaxle_node::lab::{LabFields, NodeFile};
use coaxle_os::exit::Exit;

use crate::Gateway;
use crate::config::GatewayConfig;
use port::{PlcEnd, RingPort, StopFlag};
use recorder::GatewayRecorder;

/// Checks the config, or runs the gateway until its time is up or a signal comes, with something else on its transport.
///
/// # Errors
/// The config names a wrong value (file, field, received, expected), the trace file, a socket or the endpoints cannot be
/// opened, or the trace could not be kept. A PLC that is not there is no error: the gateway waits for it.
pub fn run(args: &NodeArgs, transport_service: Option<TransportService>) -> anyhow::Result<Exit> {
    let (config, lab) = load(args)?;
    if args.check {
        return args.report_valid().map(|()| Exit::Done);
    }
    args.die_with_parent()?;
    let stop = Arc::new(StopFlag::default());
    // An address that cannot be opened ends the program before the node is announced.
    let (port, end) = port::rings(&config, Arc::clone(&stop));
    let threads = start(&config, end).map_err(|error| args.wrong(format!("{error:#}")))?;
    let outcome = coaxle_host::node::run(Setup {
        lab,
        ..setup(args, config, port, transport_service)?
    });
    // Not before the end of the node: outputs are written until then.
    stop.set();
    for thread in threads {
        // Joined before the outcome is returned: handles of the PLC are released in these threads.
        // A thread that panicked has reported it.
        let _ = thread.join();
    }
    let outcome = outcome?;
    tracing::info!(
        cycles = outcome.cycles,
        published = outcome.published,
        not_published = outcome.not_published,
        "cycles of this run"
    );
    Ok(Exit::Done)
}

fn load(args: &NodeArgs) -> anyhow::Result<(GatewayConfig, Option<LabFields>)> {
    let NodeFile { mut config, lab } = args.load::<GatewayConfig>()?;
    config.clock.relative_to(args.folder());
    config.transport = args.transport(&config.name, &config.transport)?;
    config.check().map_err(|wrong| args.wrong(wrong))?;
    Ok((config, lab))
}

/// Starts the threads that wait for the PLC. Returns those that can be ended.
fn start(config: &GatewayConfig, end: PlcEnd) -> anyhow::Result<Vec<JoinHandle<()>>> {
    if let Some(ads) = &config.ads {
        return ads::start(config, ads, end);
    }
    match &config.udp {
        Some(udp) => udp::start(config, udp, end),
        None => pipe::start(config, end),
    }
}

fn setup(
    args: &NodeArgs,
    config: GatewayConfig,
    port: RingPort,
    transport_service: Option<TransportService>,
) -> anyhow::Result<Setup<Gateway<RingPort>>> {
    let rows = args.rows(
        &config.name,
        recorder::ROLE,
        config.instances(),
        &config.columns(),
        config.cycle_time_us.0.span(),
    )?;
    Ok(Setup {
        name: config.name.clone(),
        role: recorder::ROLE,
        transport: config.transport.clone(),
        real_time: config.real_time,
        clock: config.clock.clone(),
        seed: 0,
        lab: None,
        send_stamps: true,
        wiring: config.wiring(),
        plant: config.plant_node("config"),
        // Beacons would show the clock of the gateway, not that of the PLC.
        timing: TimingEndpoints::default(),
        run_for: args.run_for,
        recorder: Box::new(GatewayRecorder::new(&config, rows)),
        build: Box::new(move |start, epoch| Ok(Gateway::new(&config, port, start, epoch))),
        transport_service,
    })
}

/// A thread of the gateway.
fn thread(name: &str, work: impl FnOnce() + Send + 'static) -> anyhow::Result<JoinHandle<()>> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .with_context(|| format!("cannot start the thread {name}"))
}
