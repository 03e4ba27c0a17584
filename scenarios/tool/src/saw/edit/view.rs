//! View of a saw on the page.

use coaxle_files::saw::SawFile;
use coaxle_report::inspect::LevelLine;
use coaxle_saw::{SawCommand, SyncMask};
use serde_json::{Value, json};

use super::super::course::SlaveCourse;
use super::super::plan::{in_words, json_of, outline};
use super::super::plot::{charts, lines};
use super::super::refusal;
use super::super::text::{command_name, description, heading, sync_mode};
use super::SawDesign;
use super::fields::sliders;
use crate::edit::toml_text::document;
use crate::sync_flags::flag_name;

pub(super) fn view(design: &mut SawDesign, text: &str) -> Value {
    let saw = match design.saw(text) {
        Ok(saw) => saw,
        Err(error) => return json!({ "error": error, "curves": faint(design) }),
    };
    let command = command_name(&saw.command);
    let sliders = document(text)
        .map(|document| sliders(&document, command))
        .unwrap_or_default();
    let mask = sync_mode(&saw.command).mask;
    let flags = SyncMask::all().iter();
    let flags = flags.map(|flag| json!({ "flag": flag_name(flag), "on": mask.contains(flag) }));
    let mut view = json!({
        "title": saw.title,
        "description": description(&saw),
        "sliders": sliders,
        "flags": flags.collect::<Vec<_>>(),
        "headings": std::array::from_fn::<_, 4, _>(|quantity| heading(&saw, quantity)),
        "limits": lines(&saw).each_ref().map(|lines| lines.iter().map(line).collect::<Vec<_>>()),
    });
    match saw.plan() {
        Ok(plan) => {
            // As text, since a plan alone has no units.
            design.last = Some(text.to_owned());
            let (along, unit) = charts(&saw, &SlaveCourse::of(&plan)).along;
            view["along"] = format!("{along} ({unit})").into();
            view["curves"] = json!([curve(&saw, &SlaveCourse::of(&plan), false)]);
            view["points"] = marks(&saw, &SlaveCourse::of(&plan));
            view["outline"] = outline(&saw, &plan).into();
            view["words"] = in_words(&saw, &plan).into();
            view["plan"] = json_of(&saw, &plan);
        }
        Err(refused) => {
            view["refusal"] = refusal::in_words(&design.path, &saw, &refused).into();
            let remedies = refusal::remedies(&saw).into_iter();
            let remedies = remedies.map(|(words, fields)| json!({ "words": words, "set": fields }));
            view["remedies"] = remedies.collect();
            // The refused course shows where a limit is passed; without one, the last good one stays for comparison.
            view["curves"] = unchecked(&saw).unwrap_or_else(|| faint(design));
        }
    }
    view
}

/// The course that is refused, as it would be if nothing were checked.
fn unchecked(saw: &SawFile) -> Option<Value> {
    let mut free = saw.clone();
    let mode = match &mut free.command {
        SawCommand::GearInPos(command) => &mut command.sync_mode,
        SawCommand::GearInVelo(command) => &mut command.sync_mode,
    };
    // Only the checks: flags that shape the profile stay.
    mode.mask.remove(SyncMask::CHECKS);
    let plan = free.plan().ok()?;
    Some(json!([curve(saw, &SlaveCourse::of(&plan), true)]))
}

fn curve(saw: &SawFile, course: &SlaveCourse<'_>, is_faint: bool) -> Value {
    let charts = charts(saw, course);
    let (along, values) = charts.course.columns();
    json!({ "name": "the slave", "along": along, "values": values, "is_faint": is_faint })
}

/// Beginnings and ends of the phases.
fn marks(saw: &SawFile, course: &SlaveCourse<'_>) -> Value {
    let charts = charts(saw, course);
    let (along, values) = charts.marks.columns();
    let mark = |n: usize| {
        let at = values.each_ref().map(|values| values[n]);
        json!({ "along": along[n], "at": at, "label": charts.labels.get(n) })
    };
    (0..along.len()).map(mark).collect()
}

/// The last plan, while the present text is refused.
fn faint(design: &SawDesign) -> Value {
    let last = design
        .last
        .as_deref()
        .and_then(|text| design.saw(text).ok());
    let planned = last.and_then(|saw| Some((saw.plan().ok()?, saw)));
    let curve = planned.map(|(plan, saw)| curve(&saw, &SlaveCourse::of(&plan), true));
    curve.into_iter().collect()
}

fn line(line: &LevelLine) -> Value {
    json!({ "name": line.name, "value": line.value, "binds": line.binds })
}
