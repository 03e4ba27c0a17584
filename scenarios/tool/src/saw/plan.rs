//! `coaxle saw plan`, where the synchronisation is possible.

use coaxle_curve::law::Motion;
use coaxle_files::saw::SawFile;
use coaxle_report::inspect::{cells, shown, table};
use coaxle_saw::{SawForm, SawPlan};
use serde_json::{Value, json};

use super::characteristics;
use super::course::SlaveCourse;
use super::text::{command_name, description, heading};

/// The plan for people.
pub(super) fn in_words(saw: &SawFile, plan: &SawPlan) -> String {
    let values = plan.characteristics(saw.table_id);
    let mut parts = Vec::new();
    if !saw.title.is_empty() {
        parts.push(saw.title.clone());
    }
    parts.push(format!("{}: {}", description(saw), outline(saw, plan)));
    // A slave that is synchronous already has no phases.
    if plan.form() != SawForm::Synchronous {
        parts.push(phases(saw, plan));
    }
    parts.push(synchronous_phase(saw, plan));
    parts.push(characteristics::in_words(saw, &values));
    parts.join("\n\n")
}

/// Form and length of the profile.
pub(super) fn outline(saw: &SawFile, plan: &SawPlan) -> String {
    let form = match plan.form() {
        SawForm::Quintic => "P5",
        SawForm::LineQuintic => "P1+P5",
        SawForm::QuinticLine => "P5+P1",
        SawForm::QuinticLineQuintic => "P5+P1+P5",
        SawForm::Ramp => "the shortest ramp",
        SawForm::JerkPhases => "phases of constant jerk",
        SawForm::Synchronous => return "the slave is synchronous already".to_owned(),
    };
    // The way, whichever direction the master runs.
    let distance = shown((plan.master_end() - plan.master_start()).abs());
    let duration = plan.duration().0;
    // Infinite for a profile over a master that stands.
    let duration = if duration.is_finite() {
        format!("{} s", shown(duration))
    } else {
        "for as long as the master stands".to_owned()
    };
    format!(
        "{form}, {duration}, {distance} {} of the master",
        saw.master_unit
    )
}

/// Beginnings of the phases, and the end of the last one.
fn phases(saw: &SawFile, plan: &SawPlan) -> String {
    let course = SlaveCourse::of(plan);
    let master = format!("master ({})", saw.master_unit);
    let [slave, velocity, acceleration] = [0, 1, 2].map(|quantity| heading(saw, quantity));
    let mut rows = table([
        "from here",
        "time (s)",
        &master,
        &slave,
        &velocity,
        &acceleration,
    ]);
    let begins = course
        .phases
        .iter()
        .map(|phase| (&phase.law[..], phase.begin));
    for (law, along) in begins.chain([("synchronous", course.end())]) {
        let slave = course.slave_at(along);
        rows.add_row(cells(
            law,
            &[
                course.time_at(along),
                course.master_at(along),
                slave.position,
                slave.velocity,
                slave.acceleration,
            ],
        ));
    }
    rows.trim_fmt()
}

fn synchronous_phase(saw: &SawFile, plan: &SawPlan) -> String {
    let line = plan.line();
    format!(
        "synchronous with the master at {} {}, the slave at {} {}, ratio {}",
        shown(line.master),
        saw.master_unit,
        shown(line.slave),
        saw.slave_unit,
        shown(line.ratio),
    )
}

/// The plan with all digits.
pub(super) fn json_of(saw: &SawFile, plan: &SawPlan) -> Value {
    let values = plan.characteristics(saw.table_id);
    json!({
        "title": saw.title,
        "command": command_name(&saw.command),
        "master_unit": saw.master_unit,
        "slave_unit": saw.slave_unit,
        "form": plan.form(),
        // Infinite while the master stands, which becomes null in JSON.
        "duration": plan.duration().0,
        "master_distance": (plan.master_end() - plan.master_start()).abs(),
        "slave_distance": plan.line().slave - plan.slave_start().position,
        "phases": phases_json(plan),
        "synchronous": plan.line(),
        "characteristics": characteristics::json_of(saw, &values),
        "table": characteristics::table_json(&values.table),
    })
}

fn phases_json(plan: &SawPlan) -> Value {
    let course = SlaveCourse::of(plan);
    let place = |along: f64| {
        let Motion {
            position,
            velocity,
            acceleration,
            ..
        } = course.slave_at(along);
        json!({
            "time": course.time_at(along),
            "master": course.master_at(along),
            "position": position,
            "velocity": velocity,
            "acceleration": acceleration,
        })
    };
    let phase = |law: &str, begin: f64, end: f64| {
        json!({
            "law": law,
            "duration": course.time_at(end) - course.time_at(begin),
            "master_distance": (course.master_at(end) - course.master_at(begin)).abs(),
            "start": place(begin),
            "end": place(end),
        })
    };
    let phases = course.phases.iter();
    phases.map(|p| phase(&p.law, p.begin, p.end)).collect()
}
