//! View of a plate on the page.

use coaxle_curve::law::{MinMax, MotionLaw};
use coaxle_files::cam::{CamFile, Shape};
use coaxle_plate::{Characteristics, Demand, Joint, LawAdvice, MotionPoint, Plate, PointType};
use coaxle_report::inspect::{QUANTITIES, name};
use coaxle_report::plotting::short;
use serde_json::{Value, json};

use super::curves::curve;
use super::view_settings::ViewSettings;
use super::{CamDesign, ComparedPlate};
use crate::cam::advise::{json_of, remarks};
use crate::cam::text::{description, heading, master_heading, velocity_steps};

/// Longer tables are drawn without their rows.
// Handles of more rows would cover each other on the screen.
const MOST_ROWS: usize = 2_000;

/// Six digits: enough to compare by eye.
fn shown(value: f64) -> String {
    short(value, 6)
}

pub(super) fn view(design: &CamDesign, text: &str, settings: &ViewSettings) -> Value {
    let parsed = CamFile::parse(&design.path, text);
    let planned = design.plate(text);
    let mut view = json!({
        "error": planned.as_ref().err(),
        "laws": MotionLaw::ALL.iter().map(|law| law.file_name()).collect::<Vec<_>>(),
        "types": PointType::ALL.map(PointType::file_name),
        "compared": design.compared.as_ref().map(|other| &other.name),
        "target": design.target.as_ref().map(|target| {
            let table = parsed.as_ref().ok().map(|cam| target.table(cam));
            json!({ "name": target.name(), "table": table })
        }),
    });
    let Ok(cam) = parsed else {
        view["curves"] = faint(design, settings);
        return view;
    };
    view["head"] = head(&cam);
    view["along"] = match settings.over_time {
        true => "time (s)".into(),
        false => master_heading(&cam).into(),
    };
    let headings: [String; 4] =
        std::array::from_fn(|quantity| shown_heading(&cam, settings, quantity));
    view["headings"] = json!(headings);
    view["limits"] = limits(settings);
    view["points"] = points(
        &cam,
        planned.as_ref().ok().map(|(_, plate)| plate),
        settings,
    );
    view["advice"] = advice(&cam, settings);
    let Ok((_, plate)) = &planned else {
        view["curves"] = faint(design, settings);
        return view;
    };
    view["description"] = description(&cam, plate).into();
    view["steps"] = velocity_steps(&cam, plate).into();
    let others = design
        .compared
        .iter()
        .map(|other| curve(&other.plate, &other.name, settings));
    let own = std::iter::once(curve(plate, "this plate", settings));
    view["curves"] = own.chain(others).collect();
    view["characteristics"] = characteristics(&cam, plate, design.compared.as_ref(), settings);
    view
}

/// The last text that made a plate, while the present one makes none.
fn faint(design: &CamDesign, settings: &ViewSettings) -> Value {
    let last = design
        .last
        .as_deref()
        .and_then(|text| design.plate(text).ok());
    let curve = last.map(|(_, plate)| {
        let mut curve = curve(&plate, "the last plate that was in order", settings);
        curve["is_faint"] = true.into();
        curve
    });
    curve.into_iter().collect()
}

fn head(cam: &CamFile) -> Value {
    let (kind, interpolation, equidistant) = match &cam.shape {
        Shape::Points(_) => ("points", None, None),
        Shape::Table(table) => (
            "table",
            Some(name(&table.interpolation)),
            Some(table.equidistant),
        ),
    };
    json!({
        "title": cam.title,
        "course": name(&cam.course),
        "table-id": cam.table_id.map(|id| id.get()),
        "master-unit": cam.master_unit,
        "slave-unit": cam.slave_unit,
        "kind": kind,
        "table.interpolation": interpolation,
        "table.equidistant": equidistant,
    })
}

fn shown_heading(cam: &CamFile, settings: &ViewSettings, quantity: usize) -> String {
    if settings.over_time {
        let per = ["", "/s", "/s²", "/s³"][quantity];
        format!("{} ({}{per})", QUANTITIES[quantity], cam.slave_unit)
    } else {
        heading(cam, quantity)
    }
}

/// The levels of each chart.
fn limits(settings: &ViewSettings) -> Value {
    let limits = settings.limits();
    let of = |quantity: usize, limit: Option<f64>| -> Vec<f64> {
        let limit = limit.map(|limit| settings.shown_limit(quantity, limit));
        limit.map_or(Vec::new(), |limit| vec![limit, -limit])
    };
    json!([
        [],
        of(1, limits.velocity),
        of(2, limits.acceleration),
        of(3, limits.jerk)
    ])
}

/// Points or rows, each with its place in the charts and its joint.
fn points(cam: &CamFile, plate: Option<&Plate>, settings: &ViewSettings) -> Value {
    let joints: Vec<Joint> = plate
        .map(|plate| plate.joints().collect())
        .unwrap_or_default();
    match &cam.shape {
        Shape::Points(points) if points.len() > MOST_ROWS => json!([]),
        Shape::Points(points) => {
            let start = points.first().map_or(0.0, |point| point.master);
            let of = |(n, point): (usize, &MotionPoint)| {
                let is_last = n + 1 == points.len();
                let mut json = point_json(point, is_last);
                json["along"] = settings.along(start, point.master).into();
                let values = [point.slave, point.velocity, point.acceleration];
                json["at"] = (0..3).map(|q| values[q] * settings.factor(q)).collect();
                // The end of a cyclic plate is its start.
                // A joint has the values of both sides; at the seam these are the end and the start.
                let is_seam = is_last
                    && plate.is_some_and(|plate| plate.course() == coaxle_plate::Course::Cyclic);
                let joint = match is_seam {
                    true => joints.first(),
                    // Compared exactly: a joint lies at the master of its point. An ignored point has none.
                    false => joints.iter().find(|joint| joint.master == point.master),
                };
                json["joint"] = joint.map(|joint| joint_json(cam, joint, settings)).into();
                json
            };
            points.iter().enumerate().map(of).collect()
        }
        Shape::Table(table) if table.rows.len() <= MOST_ROWS => {
            let start = table.rows.first().map_or(0.0, |row| row.0);
            let of = |&(master, slave): &(f64, f64)| {
                json!({
                    "master": master,
                    "slave": slave,
                    "along": settings.along(start, master),
                    "at": [slave],
                })
            };
            table.rows.iter().map(of).collect()
        }
        Shape::Table(_) => json!([]),
    }
}

fn point_json(point: &MotionPoint, is_last: bool) -> Value {
    json!({
        "master": point.master,
        "slave": point.slave,
        "velocity": point.velocity,
        "acceleration": point.acceleration,
        "jerk": point.jerk,
        "law": (!is_last || point.function.is_spline()).then(|| point.function.file_name()),
        "type": point.point_type.file_name(),
        "is_ignored": point.point_type == PointType::Ignore,
    })
}

/// The slave's motion on both sides, and whether each derivative is continuous.
fn joint_json(cam: &CamFile, joint: &Joint, settings: &ViewSettings) -> Value {
    let steps = joint.steps();
    let sides = |quantity: usize| {
        let of = |motion: &coaxle_curve::law::Motion| {
            let values = [
                motion.position,
                motion.velocity,
                motion.acceleration,
                motion.jerk,
            ];
            shown(values[quantity] * settings.factor(quantity))
        };
        [of(&joint.before), of(&joint.after)]
    };
    let marks = (1..4).map(|quantity| {
        let [before, after] = sides(quantity);
        // Exactly: `steps` has rounding taken out already.
        let goes_on = steps[quantity - 1] == 0.0;
        json!({
            "goes_on": goes_on,
            "before": before,
            "after": after,
            "words": if goes_on {
                format!("{} goes on at {before}", shown_heading(cam, settings, quantity))
            } else {
                format!("{} steps from {before} to {after}", shown_heading(cam, settings, quantity))
            },
        })
    });
    marks.collect()
}

/// Least and most of everything, of this plate and of the other one, against the limits.
fn characteristics(
    cam: &CamFile,
    plate: &Plate,
    other: Option<&ComparedPlate>,
    settings: &ViewSettings,
) -> Value {
    let of = |plate: &Plate| plate.characteristics(settings.master_velocity);
    let own = match of(plate) {
        Ok(values) => values,
        Err(error) => return json!({ "error": error.to_string() }),
    };
    // Another plate that has no characteristics leaves its column empty: the view is about this plate.
    let other = other.and_then(|other| of(&other.plate).ok());
    let limits = settings.limits();
    let unit = &cam.slave_unit;
    let extremes = &own.extremes;
    let rows = [
        (format!("position ({unit})"), extremes.position, None),
        (
            format!("velocity ({unit}/s)"),
            extremes.velocity,
            Some(Demand::Velocity),
        ),
        (
            format!("acceleration ({unit}/s²)"),
            extremes.acceleration,
            Some(Demand::Acceleration),
        ),
        (
            format!("jerk ({unit}/s³)"),
            extremes.jerk,
            Some(Demand::Jerk),
        ),
        (
            format!("torque: v·a ({unit}²/s³)"),
            own.dynamic_momentum,
            Some(Demand::Torque),
        ),
    ];
    let rows = rows
        .into_iter()
        .enumerate()
        .map(|(n, (name, range, demand))| {
            let limit = demand.and_then(|demand| limits.of(demand));
            let theirs = other.as_ref().map(|other| range_json(&range_of(other, n)));
            json!({
                "name": name,
                "own": range_json(&range),
                "other": theirs,
                "limit": limit.map(shown),
                // Limits bound both directions.
                "is_over": limit.is_some_and(|limit| range.magnitude() > limit),
            })
        });
    let single = |name: String, of: fn(&Characteristics) -> f64| {
        json!({
            "name": name,
            "own": shown(of(&own)),
            "other": other.as_ref().map(|other| shown(of(other))),
        })
    };
    json!({
        "at": format!("at a master velocity of {} {}/s", shown(settings.master_velocity), cam.master_unit),
        "ranges": rows.collect::<Vec<_>>(),
        "figures": [
            single(format!("mean of |velocity| ({unit}/s)"), |values| values.mean_velocity),
            single(format!("effective acceleration ({unit}/s²)"), |values| values.effective_acceleration),
            single("velocity steps".to_owned(), |values| values.velocity_steps as f64),
        ],
    })
}

fn range_of(values: &Characteristics, n: usize) -> MinMax {
    let extremes = &values.extremes;
    [
        extremes.position,
        extremes.velocity,
        extremes.acceleration,
        extremes.jerk,
        values.dynamic_momentum,
    ][n]
}

fn range_json(range: &MinMax) -> Value {
    json!({
        "least": shown(range.minimum.value),
        "least_at": shown(range.minimum.master),
        "most": shown(range.maximum.value),
        "most_at": shown(range.maximum.master),
    })
}

/// Advice about the segment that begins at the selected point.
fn advice(cam: &CamFile, settings: &ViewSettings) -> Value {
    let Some(n) = settings.selected else {
        return Value::Null;
    };
    let question = settings.question();
    // Points are counted from 1 in files and orders, from 0 on the page.
    let point = u32::try_from(n + 1).unwrap_or(u32::MAX);
    match cam.source().law_advice(point, &question) {
        Err(error) => json!({ "error": error.to_string() }),
        Ok(advice) => {
            let limits = question.limits;
            let row = |advice: &LawAdvice| {
                let shown_demand = |demand| match advice.demand(demand) {
                    demand if demand.is_finite() => shown(demand),
                    // A step of the acceleration has no bound of the jerk.
                    _ => "∞".to_owned(),
                };
                let mut row = json_of(advice, &limits);
                row["shown"] = Demand::ALL.map(shown_demand).into_iter().collect();
                row["remarks"] = remarks(cam, advice, &limits).join(", ").into();
                row
            };
            json!({
                "point": point,
                "least": question.least,
                "passes": advice.first().is_some_and(|best| best.passes),
                "rows": advice.iter().map(row).collect::<Vec<_>>(),
            })
        }
    }
}
