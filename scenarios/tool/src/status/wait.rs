//! `coaxle wait-sync`: waits until a node knows the clocks that it follows.

use clap::Args;
use coaxle_clock::Span;
use coaxle_host::cli::{NetworkArgs, parse_duration};
use coaxle_host::client::SeenNode;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::Exit;
use coaxle_os::machine;
use coaxle_report::inspect;

use super::plain::{error_bound, largest_error, state};
use super::reading::StatusFields;
use super::words::seconds;
use super::{absent, reading};

/// The receiver, its far node, the accuracy and the timeout.
#[derive(Debug, Args)]
pub struct WaitArgs {
    /// The receiver
    #[arg(value_parser = |name: &str| NodeName::new(name))]
    node: NodeName,
    /// Only this one of the nodes that it follows [default: all of them]
    #[arg(long, value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    far: Option<NodeName>,
    /// Give up after this time
    #[arg(long, value_name = "DURATION", default_value = "60s", value_parser = parse_duration)]
    timeout: Span,
    /// Wait also for this accuracy of far time: 200us, 1ms … Counted is the largest error that the receiver reports
    #[arg(long, value_name = "DURATION", value_parser = parse_duration)]
    max_error: Option<Span>,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Waits, and prints the state then: not met if the timeout passes, no data if the node publishes no status.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, or a node that follows no node of that name.
pub fn wait(args: &WaitArgs) -> anyhow::Result<Exit> {
    let watcher = args.network.watch(std::slice::from_ref(&args.node))?;
    let began = machine::now();
    let own = |seen: &[SeenNode]| seen.iter().position(|node| node.name == args.node);
    let met = |seen: &[SeenNode]| {
        let status = own(seen).and_then(|n| reading(&seen[n]));
        status.is_some_and(|status| args.is_met(&status))
    };
    // With every status, not once at the end: the command ends as soon as the condition is met.
    let seen = watcher.wait_for(args.timeout, met);
    let passed = seconds((machine::now() - began).as_secs_f64());
    let Some(status) = own(&seen).and_then(|n| reading(&seen[n])) else {
        // Before the watcher is closed, which it still asks.
        let why = absent(&watcher, &args.node);
        watcher.close();
        tracing::error!("{why}");
        return Ok(Exit::NoData);
    };
    watcher.close();
    // Of the very status that is printed: exit code and text cannot contradict each other.
    let is_met = args.is_met(&status);
    let text = format!(
        "{}: after {passed}: {}",
        args.node,
        args.progress_text(&status)
    );
    inspect::print_text(&text)?;
    Ok(Exit::NotMet.done_if(is_met))
}

impl WaitArgs {
    /// The far nodes that are waited for: those followed, or the one that is named.
    fn far<'a>(&self, status: &StatusFields<'a>) -> Vec<(&'a str, StatusFields<'a>)> {
        let is_wanted = |(name, far): &(&str, StatusFields<'_>)| match &self.far {
            Some(wanted) => *name == wanted.as_str(),
            // A standby that is not followed need not be synchronised.
            None => far.is("followed"),
        };
        status.parts("far").filter(is_wanted).collect()
    }

    fn is_met(&self, status: &StatusFields<'_>) -> bool {
        let far = self.far(status);
        // `all` of none is true, and a node that follows nobody would pass.
        !far.is_empty() && far.iter().all(|(_, far)| self.is_known(far))
    }

    fn is_known(&self, far: &StatusFields<'_>) -> bool {
        let is_good_enough = match self.max_error {
            // An unknown error is not small.
            Some(most) => largest_error(far).is_some_and(|error| error <= most.as_micros_f64()),
            None => true,
        };
        far.is("synced") && is_good_enough
    }

    fn progress_text(&self, status: &StatusFields<'_>) -> String {
        let far = self.far(status);
        if far.is_empty() {
            let names: Vec<_> = status.parts("far").map(|(name, _)| name).collect();
            return match (&self.far, names.as_slice()) {
                (_, []) => "it follows no other node".to_owned(),
                (Some(far), names) => format!("it does not follow {far}, but {}", names.join(", ")),
                (None, _) => "none of its far nodes is followed".to_owned(),
            };
        }
        let one = |(name, far): &(&str, StatusFields<'_>)| {
            let error = match largest_error(far) {
                Some(_) => format!("± {}", error_bound(far)),
                None => "not known how well".to_owned(),
            };
            format!("{name} {}, {error}", state(far))
        };
        far.iter().map(one).collect::<Vec<_>>().join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::samples::object;
    use clap::Parser;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        wait: WaitArgs,
    }

    fn args(line: &str) -> WaitArgs {
        let words = std::iter::once("wait-sync").chain(line.split_whitespace());
        Cli::try_parse_from(words)
            .unwrap_or_else(|e| panic!("{e}"))
            .wait
    }

    #[test]
    fn a_configured_offset_is_beside_the_error() {
        let status = STATUS.replace(
            r#""offset_sigma_us": 1.0"#,
            r#""offset_sigma_us": 1.0, "time_offset_us": 30000.0"#,
        );
        let status = object(&status);
        let status = StatusFields::of(&status);
        let told = args("saw --far a").progress_text(&status);
        assert_eq!(told, "a observer, synced, ± 150.0 µs beside 30.00 ms ahead");
        // Wanted, and so no part of the error that is waited for.
        assert!(args("saw --far a --max-error 151us").is_met(&status));
    }

    const STATUS: &str = r#"{ "far": {
        "a": { "followed": true, "synced": true, "mode": "observer", "observer_state": "synced",
               "offset_sigma_us": 1.0, "delay_uncertainty_us": 100.0, "slew_remaining_us": -50.0 },
        "b": { "followed": true, "synced": false, "mode": "observer", "observer_state": "locking" },
        "c": { "followed": false, "synced": false, "mode": "observer", "standby_of": "a" } } }"#;

    #[test]
    fn all_that_are_followed_are_waited_for_or_the_one_that_is_named() {
        let status = object(STATUS);
        let status = StatusFields::of(&status);
        for (line, met) in [
            ("saw", false),
            ("saw --far a", true),
            ("saw --far b", false),
            ("saw --far x", false),
            ("saw --far a --max-error 151us", true),
            ("saw --far a --max-error 149us", false),
        ] {
            assert_eq!(args(line).is_met(&status), met, "{line}");
        }
        let nobody = object("{}");
        assert!(!args("saw").is_met(&StatusFields::of(&nobody)));
    }

    #[test]
    fn it_says_how_things_are() {
        let status = object(STATUS);
        let status = StatusFields::of(&status);
        let told = args("saw").progress_text(&status);
        assert_eq!(
            told,
            "a observer, synced, ± 150.0 µs; b observer, locking, not known how well"
        );
        assert_eq!(
            args("saw --far x").progress_text(&status),
            "it does not follow x, but a, b, c"
        );
        let nobody = object("{}");
        assert_eq!(
            args("saw").progress_text(&StatusFields::of(&nobody)),
            "it follows no other node"
        );
    }
}
