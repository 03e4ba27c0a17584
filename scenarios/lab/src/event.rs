//! Events of a scenario.

use coaxle_clock::Span;
use coaxle_node::command::{
    Addressee, AnyCommand, CommandAnswer, CommandOrder, CommandVerdict, FarName, SlaveName,
};
use coaxle_node::config::Wrong;
use coaxle_node::keys::NodeName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::verdict::Verdict;

/// An event at a node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "EventInFile", into = "EventInFile")]
pub struct Event {
    /// Time, s after the start.
    pub at_s: ScenarioTime,
    /// Addressee: a node, or in virtual time a router.
    pub node: NodeName,
    /// Kind of the event.
    pub what: EventKind,
}

/// Kind of an event at a node.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a scenario has a handful, and plain values are simpler"
)]
pub enum EventKind {
    /// Absence of the node, or presence of a duplicate.
    Away {
        /// Kind of absence.
        action: Action,
        /// Duration, s.
        for_s: ScenarioTime,
    },
    /// A command about one of its slaves or a node that it follows.
    Command(EventCommand),
}

/// Kind of a node's absence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// The node dies, as in a power cut, and is restarted afterwards.
    Restart,
    /// The node stands still, as in a debugger, and then continues.
    Freeze,
    /// Like `freeze`, but waiting messages come in pieces, as a mailbox is drained, and not at once. Processes do that in either case.
    Stop,
    /// A duplicate node of this name and config starts beside it, as by a mistake, and dies afterwards.
    Twin,
}

/// A command to a slave, or about a far node. It comes at once in virtual time, and through the network to a process.
#[derive(Clone, Debug, PartialEq)]
pub struct EventCommand {
    /// Order to send.
    pub order: CommandOrder,
    /// Expected code of a refusal; absent if the command is expected to be accepted.
    pub expect_refusal: Option<u32>,
}

impl EventCommand {
    /// Compares the response with the expected one; none if none came. A scenario fails unless they match.
    pub fn judge(&self, event: &Event, answer: Option<&CommandAnswer>) -> Verdict {
        let expected = match self.expect_refusal {
            None => "accepted".to_owned(),
            Some(code) => format!("refused, {code:#06x}"),
        };
        let (received, text) = match answer.map(|answer| &answer.verdict) {
            Some(CommandVerdict::Accepted { .. }) => ("accepted".to_owned(), None),
            Some(CommandVerdict::Refused { code, text, .. }) => {
                (format!("refused, {code}"), Some(text))
            }
            Some(CommandVerdict::NotTaken { text, .. }) => ("not taken".to_owned(), Some(text)),
            None => ("no answer".to_owned(), None),
        };
        // Compared as text, so that what is shown is what was compared.
        let met = received == expected;
        let command = self.order.command_name();
        let (slave, what) = match &self.order {
            CommandOrder::Slave(_) | CommandOrder::Plate(_) => {
                (Some(self.order.addressee().to_owned()), command.to_owned())
            }
            CommandOrder::Far(order) => (None, format!("{}.{command}", order.addressee)),
        };
        Verdict {
            receiver: event.node.to_string(),
            slave,
            field: format!("{what} at {} s", f64::from(event.at_s)),
            expected,
            received: match text {
                Some(text) if !met => json!(format!("{received}: {text}")),
                _ => json!(received),
            },
            met,
        }
    }
}

/// An event as a file has it.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct EventInFile {
    /// Time, s after the start.
    at_s: ScenarioTime,
    /// The node concerned.
    node: NodeName,
    /// Kind of the node's absence; with `for-s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    action: Option<Action>,
    /// Duration of the absence, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    for_s: Option<ScenarioTime>,
    /// The slave that is commanded; with `command`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    slave: Option<SlaveName>,
    /// The followed node that the command is about; with `command`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    far: Option<FarName>,
    /// Expected code of a refusal; without, the command is expected to be accepted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    expect_refusal: Option<u32>,
    /// Plan the command only, and report the result.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    dry_run: bool,
    /// The command, by its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    command: Option<AnyCommand>,
}

impl TryFrom<EventInFile> for Event {
    type Error = Wrong;

    fn try_from(file: EventInFile) -> Result<Self, Wrong> {
        // Each arm names every field of the other kind, so that one of them is refused and not ignored.
        let what = match file {
            EventInFile {
                action: Some(action),
                for_s: Some(for_s),
                slave: None,
                far: None,
                expect_refusal: None,
                dry_run: false,
                command: None,
                ..
            } => EventKind::Away { action, for_s },
            EventInFile {
                action: None,
                for_s: None,
                slave,
                far,
                expect_refusal,
                dry_run,
                command: Some(command),
                ..
            } => EventKind::Command(EventCommand {
                order: CommandOrder::new(addressee(slave, far)?, command, dry_run)
                    .map_err(|error| Wrong::with_reason("", error))?,
                expect_refusal,
            }),
            _ => {
                let reason =
                    "expected either action and for-s, or command and slave, or command and far";
                return Err(Wrong::with_reason("", reason));
            }
        };
        Ok(Self {
            at_s: file.at_s,
            node: file.node,
            what,
        })
    }
}

/// The addressee of a command.
fn addressee(slave: Option<SlaveName>, far: Option<FarName>) -> Result<Addressee, Wrong> {
    match (slave, far) {
        (Some(slave), None) => Ok(Addressee::Slave(slave)),
        (None, Some(far)) => Ok(Addressee::Far(far)),
        _ => {
            let reason =
                "expected slave beside a command to a slave, or far beside one about a far node";
            Err(Wrong::with_reason("", reason))
        }
    }
}

impl From<Event> for EventInFile {
    fn from(event: Event) -> Self {
        let mut file = Self {
            at_s: event.at_s,
            node: event.node,
            action: None,
            for_s: None,
            slave: None,
            far: None,
            expect_refusal: None,
            dry_run: false,
            command: None,
        };
        match event.what {
            EventKind::Away { action, for_s } => {
                file.action = Some(action);
                file.for_s = Some(for_s);
            }
            EventKind::Command(EventCommand {
                order,
                expect_refusal,
            }) => {
                file.dry_run = order.is_dry_run();
                let (addressee, command) = order.into_parts();
                match addressee {
                    Addressee::Slave(slave) => file.slave = Some(slave),
                    Addressee::Far(far) => file.far = Some(far),
                }
                file.command = Some(command);
                file.expect_refusal = expect_refusal;
            }
        }
        file
    }
}

/// A time in a scenario, in whole milliseconds so that it can be compared.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "f64", into = "f64")]
#[schemars(inline, extend("minimum" = 0, "maximum" = 1e9))]
pub struct ScenarioTime {
    millis: u64,
}

impl ScenarioTime {
    /// The time since the start.
    #[must_use]
    pub const fn span(self) -> Span {
        Span::from_millis(self.millis as i64)
    }
}

impl TryFrom<f64> for ScenarioTime {
    type Error = Wrong;
    fn try_from(seconds: f64) -> Result<Self, Wrong> {
        // 1e9 s in nanoseconds are 1e18, and fit into an i64.
        if seconds.is_finite() && (0.0..=1e9).contains(&seconds) {
            Ok(Self {
                // Rounded: 1.001 · 1000 is 1000.9999999999999, which would be cut to 1000.
                millis: (seconds * 1e3).round() as u64,
            })
        } else {
            Err(Wrong::value(seconds, "seconds from 0 to 1e9"))
        }
    }
}

impl From<ScenarioTime> for f64 {
    fn from(moment: ScenarioTime) -> Self {
        // Dividing gives the closest number: 2.3, not 2.3000000000000003.
        moment.millis as Self / 1e3
    }
}

#[cfg(test)]
mod tests;
