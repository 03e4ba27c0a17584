//! `coaxle get`: single values of a status, for scripts.

use clap::Args;
use coaxle_host::cli::NetworkArgs;
use coaxle_node::guess::did_you_mean;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::{Exit, wrong_argument};
use coaxle_report::inspect;
use serde_json::Value;

use super::reading::StatusFields;
use super::{gather, reading};

/// The node and its signals.
#[derive(Debug, Args)]
pub struct GetArgs {
    /// The node
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    node: NodeName,
    /// Signals as in traces and docs/SIGNALS.md: conveyor.drift_ppm, conveyor.1.corrected_position, slave.position; health,
    /// cycles and other fields of the node itself by their names alone
    #[arg(value_name = "SIGNAL", required = true)]
    signals: Vec<String>,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Prints a value in a line for each signal: numbers, words, true or false; nothing for an unknown value, whose exit code is that
/// of missing data.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, a node that does not turn up, or a signal that it does not have.
pub fn get(args: &GetArgs) -> anyhow::Result<Exit> {
    let watcher = args.network.watch(std::slice::from_ref(&args.node))?;
    let seen = gather(&watcher, std::slice::from_ref(&args.node));
    watcher.close();
    let seen = seen?;
    let Some(status) = seen.first().and_then(reading) else {
        return Ok(Exit::NoData);
    };
    let values = args.signals.iter().map(|signal| value(&status, signal));
    let values = values.collect::<Result<Vec<_>, _>>();
    let values = values.or_else(wrong_argument)?;
    let lines: Vec<_> = values.iter().map(|value| line(value)).collect();
    inspect::print_text(&lines.join("\n"))?;
    Ok(Exit::NoData.done_if(values.iter().all(|value| !value.is_null())))
}

/// Parts of a status whose fields are signals, each under its name.
const PARTS: [&str; 5] = ["far", "axes", "virtual_axes", "slaves", "sources"];

/// Returns the value of a signal.
///
/// # Errors
/// The signals that are there instead, in words.
fn value<'a>(status: &StatusFields<'a>, signal: &str) -> Result<&'a Value, String> {
    let (of, name) = signal.rsplit_once('.').unwrap_or(("", signal));
    let owners = owners(status, of);
    let found = owners.iter().find_map(|fields| fields.value(name));
    found.ok_or_else(|| missing(status, &owners, signal))
}

/// Parts of this name: a far node and its source have the same, and so may an axis.
fn owners<'a>(status: &StatusFields<'a>, name: &str) -> Vec<StatusFields<'a>> {
    if name.is_empty() {
        return vec![*status];
    }
    let parts = PARTS.iter().flat_map(|part| status.parts(part));
    let own = parts.filter(|(own, _)| *own == name);
    own.map(|(_, fields)| fields).collect()
}

fn missing(status: &StatusFields<'_>, owners: &[StatusFields<'_>], signal: &str) -> String {
    let names: Vec<&str> = match owners {
        [] => {
            let parts = PARTS.iter().flat_map(|part| status.parts(part));
            parts.map(|(name, _)| name).collect()
        }
        owners => {
            let fields = owners.iter().flat_map(StatusFields::fields);
            fields.map(|(name, _)| name).collect()
        }
    };
    let part = match (owners, signal.rsplit_once('.')) {
        // The part itself is unknown.
        ([], Some((of, _))) => of,
        (_, Some((_, name))) => name,
        (_, None) => signal,
    };
    let meant = did_you_mean(part, names.iter().copied());
    let names = names.join(", ");
    format!(
        "received {signal:?}, expected a signal of the node: {part:?} is none of {names}{meant}"
    )
}

fn line(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::samples::{RECEIVER, object};

    #[test]
    fn signals_have_the_names_of_traces() {
        let status = object(RECEIVER);
        let status = StatusFields::of(&status);
        for (signal, expected) in [
            ("health", "error"),
            ("cycles", "24995"),
            ("conveyor.drift_ppm", "500.1"),
            ("conveyor.synced", "true"),
            ("conveyor.frame_age_ms", "0.41"),
            ("conveyor.3.corrected_position", "12597.89375"),
            ("slave.position", "12597.5"),
            // Unknown.
            ("conveyor.3.error", ""),
        ] {
            let found = value(&status, signal).map(line);
            assert_eq!(found.as_deref(), Ok(expected), "{signal}");
        }
    }

    #[test]
    fn what_is_no_signal_is_answered_with_those_that_are_meant() {
        let status = object(RECEIVER);
        let status = StatusFields::of(&status);
        for (signal, expected) in [
            ("helth", "did you mean \"health\"?"),
            ("conveyer.drift_ppm", "did you mean \"conveyor\"?"),
            ("conveyor.drift", "drift_ppm"),
            ("slave.positon", "did you mean \"position\"?"),
        ] {
            let error = value(&status, signal).unwrap_err();
            assert!(
                error.starts_with(&format!("received {signal:?}, expected ")),
                "{error}"
            );
            assert!(error.contains(expected), "{error}");
        }
    }
}
