//! The receiver in the real world: what `coaxle-receiver` and `coaxle receiver` do.

mod fault;
mod journal;
mod recorder;
mod status;

use std::path::PathBuf;

use anyhow::anyhow;
use coaxle_clock::{Instant, Local};
use coaxle_host::{NodeArgs, Publication, Setup, Subscription, Trace};
use coaxle_node::{Channel, Intake, Reader};

use crate::config::ReceiverConfig;
use crate::node::Receiver;
use crate::record::ReceiverRecord;
use recorder::ReceiverRecorder;

/// What a receiver is told on its command line.
pub type Args = NodeArgs;

/// Checks the config, or runs the receiver until its time is up or a signal comes.
///
/// # Errors
/// The config names a wrong value (file, field, received, expected), the trace file or the
/// endpoints cannot be opened, or the trace could not be kept.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let mut config: ReceiverConfig = args.load()?;
    config.relative_to(args.folder());
    config.transport = args.transport(&config.transport)?;
    if args.check {
        build(&args.file(), &config, Instant::EPOCH, 0)?;
        return args.say_ok();
    }
    let outcome = coaxle_host::run(setup(args, config)?)?;
    tracing::info!(
        cycles = outcome.cycles,
        received = outcome.received,
        refused = outcome.refused,
        mailbox_dropped = outcome.mailbox_dropped,
        published = outcome.published,
        not_published = outcome.not_published,
        not_recorded = outcome.telemetry_dropped,
        "cycles of this run"
    );
    Ok(())
}

fn setup(args: &Args, config: ReceiverConfig) -> anyhow::Result<Setup<Receiver>> {
    let recorder = ReceiverRecorder::new(&config, trace(args, &config)?);
    let file = args.file();
    Ok(Setup {
        name: config.name.clone(),
        role: "receiver",
        transport: config.transport.clone(),
        real_time: config.real_time,
        clock: config.clock.clone(),
        seed: config.seed,
        send_stamps: true,
        publishes: publications(&config),
        subscriptions: subscriptions(&config),
        run_for: args.run_for,
        build: Box::new(move |start, epoch| build(&file, &config, start, epoch)),
        recorder: Box::new(recorder),
    })
}

fn trace(args: &Args, config: &ReceiverConfig) -> anyhow::Result<Option<Trace<ReceiverRecord>>> {
    let names = config.slaves.iter().map(|slave| slave.name.as_str());
    let columns = ReceiverRecord::columns(names);
    let create = |path: &PathBuf| Trace::with_columns(path, &columns);
    args.trace.as_ref().map(create).transpose()
}

fn publications(config: &ReceiverConfig) -> Vec<Publication> {
    let own = [Channel::Slaves, Channel::Answers];
    let questions = config.asks().then(|| Publication {
        node: config.master.node.clone(),
        channel: Channel::Questions,
        faults: config.faults_of_questions().clone(),
    });
    own.map(|channel| Publication::new(&config.name, channel))
        .into_iter()
        .chain(questions)
        .collect()
}

fn subscriptions(config: &ReceiverConfig) -> Vec<Subscription> {
    let master = &config.master;
    let of_master = |channel, reader| Subscription {
        node: master.node.clone(),
        channel,
        reader,
        faults: config.faults.clone(),
    };
    let channel = master.channel.into();
    let intake = Intake::new(&master.node.channel_key(channel), &master.node, master.axis);
    let answers = config.asks().then(|| {
        let reader = Reader::answers_of(&master.node, &config.name);
        of_master(Channel::Answers, reader)
    });
    [
        of_master(channel, intake.into()),
        Subscription::questions_to(&config.name),
    ]
    .into_iter()
    .chain(answers)
    .collect()
}

fn build(
    file: &str,
    config: &ReceiverConfig,
    start: Instant<Local>,
    epoch: u64,
) -> anyhow::Result<Receiver> {
    // The error's own text tells its cause, which would be printed once more as its source.
    Receiver::new(config, start, epoch).map_err(|error| anyhow!("{file}: {error}"))
}
