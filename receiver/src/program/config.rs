//! `[[slave.step]]`

use coaxle_cam::{ReservedPlate, TableId};
use coaxle_node::command::PlateCommand;
use coaxle_node::config::{Positive, Wrong, did_you_mean};
use coaxle_slave::Command;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::branches::Branches;
use super::condition::When;
use super::due::Due;
use super::step_command::{StepCommand, StepCommandSchema};
use super::{Step, at_mark, step_command};
use crate::cam_source::CamSource;

/// Most steps of a program.
const MOST_STEPS: usize = 1_000;

/// A step of a program.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
#[schemars(rename = "SlaveStep")]
pub struct StepConfig {
    /// A name, as a target of branches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Condition for the step. None by default.
    #[serde(skip_serializing_if = "When::is_empty")]
    pub when: When,
    /// The command to the slave, or on the cam plates. A step without one only waits.
    #[serde(
        rename = "do",
        deserialize_with = "step_command::read",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<StepCommandSchema>")]
    pub command: Option<StepCommand>,
    /// Master positions of the command count from the oldest unused mark detected, and the mark is
    /// used up. The step waits for a mark.
    ///
    /// * `gear-in-pos`, `flying-gear`: the synchronous position of the master;
    /// * `cam-in`: the plate's master 0 is at the mark, unless the plate counts from where the master
    ///   is; an activation position of the master's axis counts from the mark;
    /// * `write-motion-function`: the plate's masters count from its end, if it began at the mark
    ///   used before and ended at this one. The scaling is that of the plate in force.
    #[serde(skip_serializing_if = "is_false")]
    pub at_mark: bool,
    /// The tool cuts at the slave's position in the cycle in which the step is taken. Refused while
    /// its coupling leads the slave to its master or away from it, and while it is behind: farther
    /// from the position of its coupling than `distance.in-sync-window`.
    #[serde(skip_serializing_if = "is_false")]
    pub cut: bool,
    /// Label of the next step. The following one by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub go_to: Option<String>,
    /// Synonym of [`go_to`](Self::go_to), for a label further up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repeat_from: Option<String>,
    /// Longest wait for the step, s since the step before. Unlimited by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timeout_s: Option<Positive>,
    /// Branches for a wait that ends early, or a refused command.
    #[serde(skip_serializing_if = "Otherwise::is_empty")]
    pub otherwise: Otherwise,
    /// Expected refusal code of the command.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expect_refusal: Option<u32>,
}

impl StepConfig {
    /// The command to its slave, if any.
    #[must_use]
    pub const fn slave_command(&self) -> Option<&Command> {
        match &self.command {
            Some(StepCommand::Slave(command)) => Some(command),
            Some(StepCommand::Plate(_) | StepCommand::Far(_)) | None => None,
        }
    }

    /// The plate that it loads, if any, with its explicit number.
    pub(crate) const fn plate(&self) -> Option<(&CamSource, Option<TableId>)> {
        match &self.command {
            Some(StepCommand::Plate(PlateCommand::CamTableSelect { table, plate, .. })) => {
                Some((plate, *table))
            }
            _ => None,
        }
    }

    pub(crate) const fn plate_mut(&mut self) -> Option<&mut CamSource> {
        match &mut self.command {
            Some(StepCommand::Plate(PlateCommand::CamTableSelect { plate, .. })) => Some(plate),
            _ => None,
        }
    }
}

fn is_false(flag: &bool) -> bool {
    !flag
}

/// Branches of a program for a step that cannot be taken: labels of steps.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Otherwise {
    /// The program's command was aborted by an order, or by the loss of power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aborted: Option<String>,
    /// Error stop of the slave.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// The step's command was refused, or, while the step waits, an earlier one when it was due.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// The master of the program's flying saw ran back past the coupling position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolled_back: Option<String>,
    /// The step has waited for `timeout-s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timed_out: Option<String>,
}

impl Otherwise {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The steps with their labels resolved.
pub(super) fn checked(
    steps: &[StepConfig],
    has_marks: bool,
    plates: &[Option<ReservedPlate>],
) -> Result<Vec<Step>, Wrong> {
    if steps.len() > MOST_STEPS {
        let received = format!("{} steps", steps.len());
        return Err(Wrong::of(
            "step",
            received,
            format_args!("at most {MOST_STEPS}"),
        ));
    }
    let labels = Labels(steps);
    steps
        .iter()
        .enumerate()
        .map(|(n, step)| {
            check_marks(step, has_marks)
                .and_then(|()| resolved(n, step, &labels, plates))
                .map_err(|wrong| wrong.within(format_args!("step[{n}]")))
        })
        .collect()
}

/// Step `n`, with its labels resolved.
fn resolved(
    n: usize,
    step: &StepConfig,
    labels: &Labels<'_>,
    plates: &[Option<ReservedPlate>],
) -> Result<Step, Wrong> {
    if let Some(label) = &step.label
        && labels.place(label) != Some(n)
    {
        let received = format!("{label:?} twice");
        return Err(Wrong::of("label", received, "a label of its own"));
    }
    check_command(step)?;
    let next = [
        labels.resolve("go-to", step.go_to.as_ref())?,
        labels.resolve("repeat-from", step.repeat_from.as_ref())?,
    ];
    if let [Some(_), Some(_)] = next {
        return Err(Wrong::of("go-to", "one beside repeat-from", "one of them"));
    }
    Ok(Step {
        when: step.when,
        command: due(step, plates.get(n).copied().flatten())?,
        at_mark: step.at_mark,
        cut: step.cut,
        expected: step.expect_refusal,
        next: next[0].or(next[1]).unwrap_or(n + 1),
        timeout: step.timeout_s,
        otherwise: branches(step, labels)?,
    })
}

/// The step's command, ready for the cycle.
fn due(step: &StepConfig, plate: Option<ReservedPlate>) -> Result<Option<Due>, Wrong> {
    Ok(Some(match (&step.command, plate) {
        (None, _) => return Ok(None),
        (Some(StepCommand::Slave(command)), _) => Due::Slave(*command),
        (Some(StepCommand::Plate(PlateCommand::CamTableDelete { table })), _) => {
            Due::DeletePlate { table: *table }
        }
        (Some(StepCommand::Plate(PlateCommand::CamTableSelect { replace, .. })), Some(plate)) => {
            Due::SelectPlate {
                plate,
                replace: *replace,
            }
        }
        (Some(StepCommand::Plate(PlateCommand::CamTableSelect { .. })), None) => {
            return Err(Wrong::of(
                "do",
                "no store of plates",
                "one for cam-table-select",
            ));
        }
        (Some(other @ (StepCommand::Plate(_) | StepCommand::Far(_))), _) => {
            let expected = "a command to the slave, or one that changes the cam plates";
            return Err(Wrong::of("do", other.name(), expected));
        }
    }))
}

/// Checks fields that require a command that can be refused, or a timeout.
fn check_command(step: &StepConfig) -> Result<(), Wrong> {
    let otherwise = &step.otherwise;
    if step.expect_refusal.is_some() && step.command.is_none() {
        return Err(Wrong::of("do", "none", "a command that can be refused"));
    }
    if step.expect_refusal.is_some() && otherwise.refused.is_some() {
        let received = "one beside expect-refusal";
        return Err(Wrong::of("otherwise.refused", received, "one of them"));
    }
    if otherwise.timed_out.is_some() && step.timeout_s.is_none() {
        return Err(Wrong::of(
            "timeout-s",
            "none",
            "one for otherwise.timed-out",
        ));
    }
    Ok(())
}

fn branches(step: &StepConfig, labels: &Labels<'_>) -> Result<Branches, Wrong> {
    let Otherwise {
        aborted,
        failed,
        refused,
        rolled_back,
        timed_out,
    } = &step.otherwise;
    Ok(Branches {
        aborted: labels.resolve("otherwise.aborted", aborted.as_ref())?,
        failed: labels.resolve("otherwise.failed", failed.as_ref())?,
        refused: labels.resolve("otherwise.refused", refused.as_ref())?,
        rolled_back: labels.resolve("otherwise.rolled-back", rolled_back.as_ref())?,
        timed_out: labels.resolve("otherwise.timed-out", timed_out.as_ref())?,
    })
}

/// The labels of all steps.
struct Labels<'a>(&'a [StepConfig]);

impl Labels<'_> {
    fn place(&self, label: &str) -> Option<usize> {
        let is_it = |step: &StepConfig| step.label.as_deref() == Some(label);
        self.0.iter().position(is_it)
    }

    /// The step that a field names, if it names one.
    fn resolve(&self, field: &'static str, label: Option<&String>) -> Result<Option<usize>, Wrong> {
        let Some(label) = label else {
            return Ok(None);
        };
        let unknown = || {
            let known = self.0.iter().filter_map(|step| step.label.as_deref());
            let known: Vec<_> = known.collect();
            let meant = did_you_mean(label, known.iter().copied());
            let expected = format!("the label of a step, one of {known:?}{meant}");
            Wrong::of(field, format_args!("{label:?}"), expected)
        };
        self.place(label).map(Some).ok_or_else(unknown)
    }
}

/// Checks the requirements of the fields for marks.
fn check_marks(step: &StepConfig, has_marks: bool) -> Result<(), Wrong> {
    let asks = [
        ("when.mark-seen", step.when.mark_seen.is_some()),
        ("at-mark", step.at_mark),
    ];
    if let Some((field, _)) = asks.iter().find(|(_, asks)| *asks && !has_marks) {
        let expected = "a slave with marks, which are simulated so far: `marks` of the slave in a scenario, \
                        [[lab.slave]] in the config of a node";
        return Err(Wrong::of(*field, "no marks of the slave", expected));
    }
    if step.at_mark && !step.slave_command().is_some_and(at_mark::has_positions) {
        let received = step.command.as_ref();
        let received = received.map_or("no command", StepCommand::name);
        let expected = format!("one of: {}", at_mark::keys_with_positions());
        return Err(Wrong::of("at-mark", received, expected));
    }
    let elsewhere = at_mark::counts_from_elsewhere;
    if step.at_mark && step.slave_command().is_some_and(elsewhere) {
        let received = "one beside a master-sync-position that is ahead or in-turn";
        let expected = "a plain one, which counts from the mark";
        return Err(Wrong::of("at-mark", received, expected));
    }
    Ok(())
}
