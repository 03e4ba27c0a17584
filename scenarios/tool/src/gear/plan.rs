//! `coaxle gear plan`, where the gear is possible.

use coaxle_files::gear::GearFile;
use coaxle_gear::{FlyingGear, FlyingGearRange};
use coaxle_report::inspect::{cells, shown, table};
use serde_json::{Value, json};

/// The plan for people.
pub(super) fn in_words(file: &GearFile, gear: &FlyingGear) -> String {
    let GearFile {
        master_unit: master,
        slave_unit: slave,
        ..
    } = file;
    let mut parts = Vec::new();
    if !file.title.is_empty() {
        parts.push(file.title.clone());
    }
    parts.push(outline(file, gear));

    let stretches = gear.ranges(file.master.velocity, file.cycle.0);
    let headings = [
        "from here".to_owned(),
        format!("master ({master})"),
        format!("position ({slave})"),
    ];
    let mut places = table(headings.each_ref().map(String::as_str));
    for (name, place, position) in steps(&stretches) {
        places.add_row(cells(name, &[place, position]));
    }
    parts.push(places.trim_fmt());

    let headings = [
        format!("at {} {master}/s", shown(file.master.velocity.abs())),
        "engaging".to_owned(),
        "releasing".to_owned(),
        "limit".to_owned(),
    ];
    let mut demands = table(headings.each_ref().map(String::as_str));
    let limits = &file.limits;
    // The smaller one binds: a master that turns round makes a deceleration of an acceleration.
    let acceleration = limits.acceleration().min(limits.deceleration());
    let rows: [(&str, &str, Demand, f64); 3] = [
        (
            "velocity",
            "/s",
            |stretch| stretch.velocity,
            limits.velocity(),
        ),
        (
            "acceleration",
            "/s²",
            |stretch| stretch.acceleration,
            acceleration,
        ),
        ("jerk", "/s³", |stretch| stretch.jerk, limits.jerk()),
    ];
    for (name, per_time, of, limit) in rows {
        let values = [of(&stretches[0]), of(&stretches[1]), limit];
        demands.add_row(cells(&format!("{name} ({slave}{per_time})"), &values));
    }
    parts.push(demands.trim_fmt());
    parts.push(format!(
        "the master may be up to {} {master}/s fast",
        // The cycle matters for a stretch without length, which is passed within one.
        shown(gear.fastest(&file.limits, file.cycle.0))
    ));
    parts.join("\n\n")
}

/// A figure of the load that a stretch puts on the slave.
type Demand = fn(&FlyingGearRange) -> f64;

/// The gear in a line.
pub(super) fn outline(file: &GearFile, gear: &FlyingGear) -> String {
    let [engaging, releasing] = gear.ranges(file.master.velocity, file.cycle.0);
    // The magnitude: with a negative direction the coupled end is the smaller one.
    let length = |stretch: &FlyingGearRange| (stretch.master_coupled - stretch.master_free).abs();
    let release = if gear.returns() {
        "on the way back"
    } else {
        "on the way out"
    };
    format!(
        "flying gear, ratio {}: engaged over {} {unit} of the master, released {release} over {} {unit}",
        shown(gear.ratio()),
        shown(length(&engaging)),
        shown(length(&releasing)),
        unit = file.master_unit,
    )
}

/// Beginnings of the phases, in the order in which the master passes them, with the positions of master and slave.
fn steps(stretches: &[FlyingGearRange; 2]) -> [(&'static str, f64, f64); 4] {
    let [engaging, releasing] = stretches;
    [
        ("engaging", engaging.master_free, engaging.slave_free),
        ("engaged", engaging.master_coupled, engaging.slave_coupled),
        (
            "releasing",
            // A release is passed from its coupled end to its free one.
            releasing.master_coupled,
            releasing.slave_coupled,
        ),
        ("released", releasing.master_free, releasing.slave_free),
    ]
}

/// The plan with all digits.
pub(super) fn json_of(file: &GearFile, gear: &FlyingGear) -> Value {
    let stretch = |stretch: FlyingGearRange| {
        json!({
            "master_free": stretch.master_free,
            "master_coupled": stretch.master_coupled,
            "slave_free": stretch.slave_free,
            "slave_coupled": stretch.slave_coupled,
            "velocity": stretch.velocity,
            "acceleration": stretch.acceleration,
            "jerk": stretch.jerk,
        })
    };
    let [engaging, releasing] = gear.ranges(file.master.velocity, file.cycle.0).map(stretch);
    json!({
        "title": file.title,
        "master_unit": file.master_unit,
        "slave_unit": file.slave_unit,
        "ratio": gear.ratio(),
        "returns": gear.returns(),
        "engaging": engaging,
        "releasing": releasing,
        "fastest_master": gear.fastest(&file.limits, file.cycle.0),
    })
}
