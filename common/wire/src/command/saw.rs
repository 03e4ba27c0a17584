//! Flying saw in the response to an order.

use coaxle_saw::{
    CouplingMoment, FlyingSawCharacteristics, SawCommand, SawForm, SawPlan, SawRefusal, SawRemedy,
    SawTable, SyncMask, Violation, saw_table_id,
};
use coaxle_slave::{Command, CouplingRefusal, Refusal};
use serde::{Deserialize, Serialize};

/// Flying saw in the cycle: plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawView {
    /// Plan, in force or of a dry run.
    pub plan: SawPlan,
    /// Axis id of the slave, from which the id of the plan's table follows.
    pub axis_id: u32,
}

/// Refused flying saw: plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawAttempt {
    /// Command to plan, with its positions on the axes.
    pub command: SawCommand,
    /// State of master and slave at the plan.
    pub moment: CouplingMoment,
}

/// Result of a flying saw if its master keeps its velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct SawFigures {
    /// Form of the profile.
    pub form: SawForm,
    /// Duration of the synchronisation, s; none while the master stands still.
    pub duration: Option<f64>,
    /// Position of the master at which the slave is synchronous at the latest, u.
    pub master_sync_position: f64,
    /// Position of the slave then, u.
    pub slave_sync_position: f64,
    /// Greatest speed of the slave until then, u/s.
    pub peak_velocity: f64,
    /// Greatest acceleration or deceleration, u/s².
    pub peak_acceleration: f64,
    /// Greatest jerk, u/s³.
    pub peak_jerk: f64,
    /// Characteristic values in their order, if they were requested.
    pub characteristics: Option<Vec<NamedValue>>,
    /// Header of the table that holds the profile, if it was requested; none if the axis id has no table.
    pub table: Option<SawTable>,
}

/// A characteristic value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedValue {
    /// Name in `MC_FlyingSawCharacValues`.
    pub name: String,
    /// Value, in u of master or slave and s.
    pub value: f64,
}

impl SawFigures {
    pub(super) fn of(view: &SawView, command: &Command) -> Self {
        let SawView { plan, axis_id } = view;
        let table = saw_table_id(*axis_id, |_| false);
        let values = plan.characteristics(table.unwrap_or_default());
        let asked = matches!(command, Command::ReadFlyingSawCharacteristics {});
        let peaks = values.extremes;
        Self {
            form: plan.form(),
            duration: Some(plan.duration().0).filter(|duration| duration.is_finite()),
            master_sync_position: plan.line().master,
            slave_sync_position: plan.line().slave,
            peak_velocity: peaks.velocity.magnitude(),
            peak_acceleration: peaks.acceleration.magnitude(),
            peak_jerk: peaks.jerk.magnitude(),
            characteristics: asked.then(|| named(&values)),
            table: table.ok().filter(|_| asked).map(|_| values.table),
        }
    }
}

fn named(values: &FlyingSawCharacteristics) -> Vec<NamedValue> {
    let names = FlyingSawCharacteristics::NAMES.iter();
    names
        .zip(values.values())
        .map(|(name, value)| NamedValue {
            name: (*name).to_owned(),
            value,
        })
        .collect()
}

/// Reason of a refused flying saw, and values that would be accepted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct SawRefused {
    /// Violated check, if that is the reason.
    pub violation: Option<ViolatedCheck>,
    /// Values that would be accepted, all else unchanged.
    pub remedy: SawRemedy,
}

/// Check that a profile violates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct ViolatedCheck {
    /// Flag of the sync mode that enables the check; without it, the limits of the axis apply.
    pub checked_by: SyncMask,
    /// Own code of the check, whether `detailed-error-codes` is set or not.
    pub detailed_code: String,
    /// Quantity of the slave.
    pub quantity: String,
    /// Measured value: u, u/s, u/s² or u/s³.
    pub measured: f64,
    /// Limit of the quantity.
    pub limit: f64,
    /// Position of the master then, u.
    pub master_position: f64,
}

impl SawRefused {
    /// Plans some hundred times: not for the cycle.
    pub(super) fn of(refusal: &Refusal, attempt: Option<&SawAttempt>) -> Option<Self> {
        let Refusal::Coupling(CouplingRefusal::Saw(refusal)) = refusal else {
            return None;
        };
        let remedy = match attempt {
            Some(attempt) if depends_on_the_master(refusal) => {
                attempt.command.remedy(&attempt.moment)
            }
            _ => SawRemedy::default(),
        };
        Some(Self {
            violation: refusal.violation().map(ViolatedCheck::of),
            remedy,
        })
    }
}

/// True if another distance or speed of the master could help at all.
const fn depends_on_the_master(refusal: &SawRefusal) -> bool {
    !matches!(
        refusal,
        SawRefusal::TableInUse { .. } | SawRefusal::NoTable { .. }
    )
}

impl ViolatedCheck {
    fn of(violation: &Violation) -> Self {
        let check = violation.check;
        Self {
            checked_by: check.flag(),
            detailed_code: format!("{:#06x}", check.code()),
            quantity: check.quantity().to_owned(),
            measured: violation.measured,
            limit: violation.limit,
            master_position: violation.master_position,
        }
    }
}
