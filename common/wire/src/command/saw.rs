//! What the answer to an order says of a flying saw.

use coaxle_saw::{
    CouplingMoment, FlyingSawCharacteristics, SawCommand, SawForm, SawPlan, SawRefusal, SawRemedy,
    SawTable, SyncMask, Violation, saw_table_id,
};
use coaxle_slave::{Command, CouplingRefusal, Refusal};
use serde::{Deserialize, Serialize};

/// A flying saw as the cycle says it: plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawView {
    /// The plan, in force or only tried.
    pub plan: SawPlan,
    /// The axis id of the slave, which that of the plan's table follows from.
    pub axis_id: u32,
}

/// A flying saw that was refused: plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawAttempt {
    /// What was to be planned, with its positions on the axes.
    pub command: SawCommand,
    /// From what.
    pub moment: CouplingMoment,
}

/// What a flying saw comes to if its master keeps its velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct SawFigures {
    /// What the profile is made of.
    pub form: SawForm,
    /// How long the synchronisation takes, s; none while the master stands.
    pub duration: Option<f64>,
    /// Where the master is when the slave is synchronous at the latest, u.
    pub master_sync_position: f64,
    /// Where the slave is then, u.
    pub slave_sync_position: f64,
    /// Its highest speed until then, u/s.
    pub peak_velocity: f64,
    /// Its highest acceleration or deceleration, u/s².
    pub peak_acceleration: f64,
    /// Its highest jerk, u/s³.
    pub peak_jerk: f64,
    /// All characteristic values in their order, for somebody who asked for them.
    pub characteristics: Option<Vec<NamedValue>>,
    /// The header of the table that holds the profile, for the same; none if the axis id has none.
    pub table: Option<SawTable>,
}

/// A characteristic value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedValue {
    /// Its name in `MC_FlyingSawCharacValues`.
    pub name: String,
    /// The value, in u of master or slave and s.
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

/// Why a flying saw is refused, and what would pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct SawRefused {
    /// The check that it violates, if that is why.
    pub violation: Option<ViolatedCheck>,
    /// What would pass, all else unchanged.
    pub remedy: SawRemedy,
}

/// A check that a profile does not pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct ViolatedCheck {
    /// The flag of the sync mode that asks for the check; the axis keeps its own limits without.
    pub checked_by: SyncMask,
    /// The check's own code, whether `detailed-error-codes` is set or not.
    pub detailed_code: String,
    /// What of the slave it is about.
    pub quantity: String,
    /// Its value: u, u/s, u/s² or u/s³.
    pub measured: f64,
    /// The limit.
    pub limit: f64,
    /// Where the master is then, u.
    pub master_position: f64,
}

impl SawRefused {
    /// It plans some hundred times: not for the cycle.
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

/// Whether another distance or speed of the master could help at all.
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
