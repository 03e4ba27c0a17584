//! `[[slave.step]]`

use coaxle_axis::AxisStatus;
use coaxle_node::config::{AtLeastZero, Finite};
use coaxle_slave::Command;
use serde::{Deserialize, Serialize};

use super::{Step, at_mark};

/// Most steps of a program.
const MOST_STEPS: usize = 1_000;

/// A step of a program.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct StepConfig {
    /// A name, to repeat from here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// What has to be the case before the step is taken. Nothing by default.
    #[serde(skip_serializing_if = "When::is_empty")]
    pub when: When,
    /// The command to the slave. A step without only waits.
    #[serde(rename = "do", skip_serializing_if = "Option::is_none")]
    pub command: Option<Command>,
    /// The command's positions of the master count from the oldest mark that was seen and not used,
    /// and the mark is used up. The step waits until there is one.
    ///
    /// * `gear-in-pos`, `flying-gear`: the synchronous position of the master;
    /// * `cam-in`: the plate's master 0 is at the mark, unless the plate counts from where the master
    ///   is; an activation position of the master's axis counts from the mark;
    /// * `write-motion-function`: the plate's masters count from its end, if it began at the mark
    ///   used before and ended at this one. The scaling is that of the plate in force.
    #[serde(skip_serializing_if = "is_false")]
    pub at_mark: bool,
    /// The tool cuts, where the slave is in the cycle in which the step is taken.
    #[serde(skip_serializing_if = "is_false")]
    pub cut: bool,
    /// The label of the step to go on with. The next one by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repeat_from: Option<String>,
    /// The code with which the command shall be refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expect_refusal: Option<u32>,
}

fn is_false(flag: &bool) -> bool {
    !flag
}

/// A condition; everything that is given has to hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct When {
    /// So much time has passed since the program began, s of the node's own clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<AtLeastZero>,
    /// So much time has passed since the step before, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_s: Option<AtLeastZero>,
    /// The slave moves with its master, or does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub in_sync: Option<bool>,
    /// The slave stands, or does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standstill: Option<bool>,
    /// The master is there, without error and in a mode that synchronises in sync, or is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub master_ready: Option<bool>,
    /// A mark was seen that is neither used nor past the slave's position 0, or none was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mark_seen: Option<bool>,
    /// The master's position is above this, in its units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub master_above: Option<Finite>,
    /// The master's position is below this, in its units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub master_below: Option<Finite>,
    /// The slave's set position is above this, u.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_above: Option<Finite>,
    /// The slave's set position is below this, u.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_below: Option<Finite>,
    /// The slave is in this state of the PLCopen diagram.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<AxisStatus>,
}

impl When {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A step that no program can have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct WrongStep {
    /// The step and the field.
    pub field: String,
    /// What was received and what is expected.
    pub reason: String,
}

/// The steps with their labels resolved.
pub(super) fn checked(steps: &[StepConfig], has_marks: bool) -> Result<Vec<Step>, WrongStep> {
    let wrong = |field: String, reason: String| WrongStep { field, reason };
    if steps.len() > MOST_STEPS {
        let reason = format!(
            "received {} steps, expected at most {MOST_STEPS}",
            steps.len()
        );
        return Err(wrong("step".to_owned(), reason));
    }
    let labelled = |label: &str| {
        let is_it = |step: &StepConfig| step.label.as_deref() == Some(label);
        steps.iter().position(is_it)
    };
    steps
        .iter()
        .enumerate()
        .map(|(n, step)| {
            if let Some(label) = &step.label
                && labelled(label) != Some(n)
            {
                let reason = format!("received {label:?} twice, expected a label of its own");
                return Err(wrong(format!("step[{n}].label"), reason));
            }
            if step.expect_refusal.is_some() && step.command.is_none() {
                let reason = "expected a command that can be refused".to_owned();
                return Err(wrong(format!("step[{n}].do"), reason));
            }
            check_marks(step, has_marks)
                .map_err(|(field, reason)| wrong(format!("step[{n}].{field}"), reason))?;
            let next = match &step.repeat_from {
                None => n + 1,
                Some(label) => labelled(label).ok_or_else(|| {
                    let reason = format!("received {label:?}, expected the label of a step");
                    wrong(format!("step[{n}].repeat-from"), reason)
                })?,
            };
            Ok(Step {
                when: step.when,
                command: step.command,
                at_mark: step.at_mark,
                cut: step.cut,
                expected: step.expect_refusal,
                next,
            })
        })
        .collect()
}

/// What a step needs to ask for marks. Gives the wrong field and the reason.
fn check_marks(step: &StepConfig, has_marks: bool) -> Result<(), (&'static str, String)> {
    let asks = [
        ("when.mark-seen", step.when.mark_seen.is_some()),
        ("at-mark", step.at_mark),
    ];
    if let Some((field, _)) = asks.iter().find(|(_, asks)| *asks && !has_marks) {
        return Err((field, "expected a slave with marks".to_owned()));
    }
    if step.at_mark && !step.command.as_ref().is_some_and(at_mark::has_positions) {
        let received = step.command.map_or("no command", |command| command.name());
        let expected = at_mark::THOSE_WITH_POSITIONS;
        return Err((
            "at-mark",
            format!("received {received}, expected one of: {expected}"),
        ));
    }
    Ok(())
}
