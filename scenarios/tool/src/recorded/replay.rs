//! `coaxle replay`: a receiver in virtual time, given the inputs of a real one.

mod compare;
mod node;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use coaxle_node::NodeScan;
use coaxle_node::config::{ConfigError, parse, parse_table};
use coaxle_node::lab::NodeFile;
use coaxle_os::exit::{Exit, Mistake, wrong_file};
use coaxle_os::machine;
use coaxle_receiver::ReceiverConfig;
use coaxle_recording::{Facts, Item, Reader};
use coaxle_report::inspect;

use super::{beside, create, open};
use compare::compare;
use node::ReplayedReceiver;

/// Arguments of `coaxle replay`.
#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// The recording of a receiver, as `coaxle receiver --record` writes it
    file: PathBuf,
    /// Another config than the one that is in the recording: other parameters, other slaves. It follows the same axes
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// The file to write the recording of the replay to, which must not be there yet [default: beside it, FILE-replayed.mcap]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs a receiver with the inputs of the recorded one, writes its rows, and compares both.
///
/// # Errors
/// Names the file that cannot be read or written, and the reason why it cannot be replayed.
pub(crate) fn replay(args: &ReplayArgs) -> anyhow::Result<Exit> {
    let out = match &args.out {
        Some(out) => out.clone(),
        None => beside(&args.file, "-replayed", "mcap"),
    };
    let begin = machine::now();
    let replayed = run(args, &out)?;
    // Before the comparison, which is no part of the replay.
    let took_s = (machine::now() - begin).as_secs_f64();
    let compared = compare(&args.file, &out)?;
    let mut lines = vec![format!(
        "{} cycles, {:.1} s, replayed in {took_s:.2} s: {:.0} times as fast as they were",
        replayed.cycles,
        replayed.seconds,
        replayed.seconds / took_s
    )];
    lines.extend(replayed.notes);
    lines.extend(compared.lines());
    lines.push(format!("recording: {}", out.display()));
    inspect::print_text(&lines.join("\n"))?;
    // With another config a difference is the result that is asked for, and no failure.
    let is_as_it_was = args.config.is_some() || compared.is_same();
    Ok(Exit::NotMet.done_if(is_as_it_was))
}

/// Result of a replay.
struct ReplayResult {
    cycles: u64,
    seconds: f64,
    /// Reservations about the comparison.
    notes: Vec<String>,
}

/// Content of a recording before its first scan.
#[derive(Default)]
struct ReplaySetup {
    facts: Facts,
    files: BTreeMap<String, Vec<u8>>,
}

fn run(args: &ReplayArgs, out: &Path) -> anyhow::Result<ReplayResult> {
    let file = args.file.display();
    let mut known = ReplaySetup::default();
    let mut replayed: Option<ReplayedReceiver<_>> = None;
    let mut broken = None;
    for item in Reader::new(open(&args.file)?) {
        match item {
            Ok(Item::Facts(facts)) => known.facts.extend(facts),
            Ok(Item::Attachment { name, data, .. }) => {
                known.files.insert(name, data);
            }
            Ok(Item::Inputs {
                at_ns,
                woke_ns,
                bytes,
                ..
            }) => {
                // Noticed only when inputs follow the damage: at the end of the file it is the usual end of a killed node.
                if let Some(damage) = broken {
                    // A receiver that misses cycles is another one.
                    return wrong_file(format!(
                        "{file}: {damage}; inputs of cycles are lost, which cannot be replayed"
                    ));
                }
                let scan = NodeScan::from_bytes(&bytes);
                let scan = scan.with_context(|| format!("{file}: inputs at {at_ns} ns"))?;
                let node = match &mut replayed {
                    Some(node) => node,
                    // At the first scan, when facts and config are read: they precede it in the file.
                    None => replayed.insert(start(args, &known, out)?),
                };
                node.scan(at_ns, woke_ns, &scan)?;
            }
            Ok(Item::Row(_) | Item::Log(_) | Item::Status { .. } | Item::Audit { .. }) => {}
            // The end of a file that was not ended properly: it is replayed up to here.
            Err(damage) => broken = Some(damage),
        }
    }
    let replayed = replayed.ok_or_else(|| nothing_to_replay(&args.file, &known))?;
    let mut notes = replayed.notes();
    notes.extend(broken.map(|damage| damage.to_string()));
    if let Some(gaps) = known.facts.get("input-gaps").filter(|gaps| *gaps != "0") {
        notes.push(format!(
            "inputs are missing {gaps} times: from the first time on the replay need not be what was recorded"
        ));
    }
    let (cycles, seconds) = replayed.finish()?;
    Ok(ReplayResult {
        cycles,
        seconds,
        notes,
    })
}

fn nothing_to_replay(file: &Path, known: &ReplaySetup) -> anyhow::Error {
    let file = file.display();
    let text = match known.facts.get("role").map(String::as_str) {
        Some("receiver") => format!(
            "{file}: received a recording without inputs, expected one that the receiver wrote itself, with `--record`"
        ),
        Some(role) => format!("{file}: received the recording of a {role}, expected a receiver's"),
        None => format!(
            "{file}: received a recording of several nodes or of none, expected one of a receiver"
        ),
    };
    Mistake::in_file(text).into()
}

fn start(
    args: &ReplayArgs,
    known: &ReplaySetup,
    out: &Path,
) -> anyhow::Result<ReplayedReceiver<std::fs::File>> {
    let recorded = recorded_config(&args.file, known)?;
    let config = match &args.config {
        Some(path) => {
            let config = read_config(path)?;
            check_follows_the_same(path, &config, &recorded)?;
            config
        }
        None => recorded,
    };
    let epoch = known.facts.get("epoch");
    // The run is a signal itself, and responses to time requests name it.
    let epoch = epoch.and_then(|epoch| u64::from_str_radix(epoch, 16).ok());
    let epoch = epoch.with_context(|| format!("{}: the run is not in it", args.file.display()))?;
    // Last, so that a config that does not fit leaves no empty file behind.
    let to = create(&args.file, out)?;
    ReplayedReceiver::start(&config, epoch, to, &known.facts)
        .with_context(|| args.file.display().to_string())
}

/// The config in the recording; files that it names lie beside the recording.
fn recorded_config(file: &Path, known: &ReplaySetup) -> anyhow::Result<ReceiverConfig> {
    let shown = file.display();
    // A receiver's recording has a single attachment; with several it is unknown which one ran.
    let [(name, data)] = Vec::from_iter(&known.files)[..] else {
        let count = known.files.len();
        return wrong_file(format!(
            "{shown}: received {count} files in it, expected the config of a receiver"
        ));
    };
    let text = String::from_utf8_lossy(data);
    let mut config = parse_recorded(&format!("{shown}: {name}"), &text)?;
    config.relative_to(file.parent().unwrap_or(Path::new("")));
    Ok(config)
}

/// A recording of before there was a `[lab]` table has its fields where a scenario has them.
fn parse_recorded(file: &str, text: &str) -> Result<ReceiverConfig, ConfigError> {
    if parse_table(file, text)?.contains_key("lab") {
        return NodeFile::parse(file, text).map(|file| file.config);
    }
    parse(file, text)
}

fn read_config(path: &Path) -> anyhow::Result<ReceiverConfig> {
    let NodeFile { mut config, .. } = NodeFile::<ReceiverConfig>::load(path)?;
    config.relative_to(path.parent().unwrap_or(Path::new("")));
    Ok(config)
}

/// Refuses a config that needs messages which the recorded receiver did not receive.
fn check_follows_the_same(
    path: &Path,
    config: &ReceiverConfig,
    recorded: &ReceiverConfig,
) -> anyhow::Result<()> {
    let heard = |config: &ReceiverConfig| {
        let subscriptions = config.wiring().subscriptions;
        let keys = subscriptions
            .iter()
            .map(|of| of.node.channel_key(of.channel));
        let axes = config.far_axis_names();
        (keys.collect::<Vec<_>>(), axes)
    };
    let ((keys, axes), (recorded_keys, recorded_axes)) = (heard(config), heard(recorded));
    // Before the keys, as other axes change those too and are the clearer error.
    if axes != recorded_axes {
        return wrong_file(format!(
            "{}: follows {}, expected {} as in the recording",
            path.display(),
            axes.join(", "),
            recorded_axes.join(", ")
        ));
    }
    if keys != recorded_keys {
        return wrong_file(format!(
            "{}: hears {}, expected {} as in the recording: does `delay` differ?",
            path.display(),
            keys.join(", "),
            recorded_keys.join(", ")
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_with_and_without_a_lab_table_are_read() {
        let machine = "name = 'r'\ncycle-time-us = 1000\nmaster = { node = 'belt' }\n";
        let read = |rest: &str| parse_recorded("r", &format!("{machine}{rest}")).unwrap();
        let in_place = read("clock.drift-ppm = 5\nfaults.loss = 0.5\n");
        let in_lab =
            read("[lab]\nclock.drift-ppm = 5\nfar = [{ node = 'belt', faults.loss = 0.5 }]\n");
        assert_eq!(in_place, in_lab);
        assert_eq!(in_lab.far[0].faults.loss.get(), 0.5);
    }
}
