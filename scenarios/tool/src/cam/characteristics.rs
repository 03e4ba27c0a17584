//! `coaxle cam characteristics`.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use coaxle_curve::law::{Extreme, MinMax};
use coaxle_files::cam::CamFile;
use coaxle_plate::{Characteristics, PlateEnd};
use coaxle_report::inspect::{QUANTITIES, cells, shown, table};
use serde_json::{Value, json};

use super::load;
use super::text::{description, parse_finite, velocity_steps};

/// Arguments of `coaxle cam characteristics`.
#[derive(Debug, Args)]
pub struct CharacteristicsArgs {
    /// Cam file, TOML
    file: PathBuf,
    /// Velocity of the master, in master units per second
    #[arg(long, value_name = "V", default_value = "1", value_parser = parse_finite, allow_negative_numbers = true)]
    master_velocity: f64,
    /// As JSON with all digits
    #[arg(long)]
    json: bool,
}

impl CharacteristicsArgs {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<()> {
        let (cam, plate) = load(&self.file)?;
        // Per second, because limits of drives are: with V of the master, v = s'·V, a = s''·V² and j = s'''·V³.
        let values = plate.characteristics(self.master_velocity)?;
        if self.json {
            let mut json = json_of(&values);
            json["lift"] = plate.lift().into();
            json["master_unit"] = cam.master_unit.into();
            json["slave_unit"] = cam.slave_unit.into();
            writeln!(out, "{json:#}")?;
        } else {
            writeln!(out, "{}", description(&cam, &plate))?;
            writeln!(out, "{}", tables(&cam, &values))?;
            // Beside the extremes, which a step leaves finite although its acceleration has no bound.
            if let Some(steps) = velocity_steps(&cam, &plate) {
                writeln!(out, "{steps}")?;
            }
        }
        Ok(())
    }
}

fn tables(cam: &CamFile, values: &Characteristics) -> String {
    let [start, end] = [&values.start, &values.end].map(in_order);
    let mut extremes = table(["", "least", "at master", "most", "at master"]);
    let mut ends = table(["", "start", "end"]);
    ends.add_row(cells("master", &[values.start.master, values.end.master]));
    for (quantity, range) in ranges(values).into_iter().enumerate() {
        let name = format!("{} ({})", QUANTITIES[quantity], over_time(cam, quantity));
        extremes.add_row(cells(&name, &four(range)));
        ends.add_row(cells(&name, &[start[quantity], end[quantity]]));
    }
    // v·a is proportional to the power for a constant inertia: P = m·v·a.
    let unit = format!("{}²/s³", cam.slave_unit);
    let name = format!("velocity · acceleration ({unit})");
    extremes.add_row(cells(&name, &four(&values.dynamic_momentum)));

    format!(
        "at a master velocity of {} {}/s\n\n{}\n\n{}\n\n\
         mean of |velocity|:       {} {}\n\
         effective acceleration:   {} {}\n\
         velocity where the acceleration is least: {} {velocity}, most: {} {velocity}",
        shown(values.master_velocity),
        cam.master_unit,
        extremes.trim_fmt(),
        ends.trim_fmt(),
        shown(values.mean_velocity),
        over_time(cam, 1),
        shown(values.effective_acceleration),
        over_time(cam, 2),
        shown(values.velocity_at_minimum_acceleration),
        shown(values.velocity_at_maximum_acceleration),
        velocity = over_time(cam, 1),
    )
}

/// Position, velocity, acceleration, jerk.
const fn ranges(values: &Characteristics) -> [&MinMax; 4] {
    let extremes = &values.extremes;
    [
        &extremes.position,
        &extremes.velocity,
        &extremes.acceleration,
        &extremes.jerk,
    ]
}

const fn in_order(end: &PlateEnd) -> [f64; 4] {
    let slave = &end.slave;
    [
        slave.position,
        slave.velocity,
        slave.acceleration,
        slave.jerk,
    ]
}

fn over_time(cam: &CamFile, quantity: usize) -> String {
    let per_time = ["", "/s", "/s²", "/s³"][quantity];
    format!("{}{per_time}", cam.slave_unit)
}

// In the order of the columns of the table of extremes.
const fn four(range: &MinMax) -> [f64; 4] {
    let MinMax { minimum, maximum } = range;
    [minimum.value, minimum.master, maximum.value, maximum.master]
}

fn json_of(values: &Characteristics) -> Value {
    let mut json = json!({
        "table_type": values.table_type,
        "course": values.course,
        "rows": values.rows,
        "columns": values.columns,
        "master_velocity": values.master_velocity,
        "start": end_json(&values.start),
        "end": end_json(&values.end),
        "dynamic_momentum": range_json(&values.dynamic_momentum),
        "mean_velocity": values.mean_velocity,
        "effective_acceleration": values.effective_acceleration,
        "velocity_steps": values.velocity_steps,
        "largest_velocity_step": values.largest_velocity_step.map(|step| json!({
            "master": step.master,
            "before": step.before,
            "after": step.after,
        })),
    });
    for (name, range) in QUANTITIES.into_iter().zip(ranges(values)) {
        json[name] = range_json(range);
    }
    // Velocities at the extremes of the acceleration: together they are what a motor must give there.
    let acceleration = &mut json["acceleration"];
    acceleration["minimum"]["velocity"] = values.velocity_at_minimum_acceleration.into();
    acceleration["maximum"]["velocity"] = values.velocity_at_maximum_acceleration.into();
    json
}

fn end_json(end: &PlateEnd) -> Value {
    let mut json = json!({ "master": end.master });
    for (name, value) in QUANTITIES.into_iter().zip(in_order(end)) {
        json[name] = value.into();
    }
    json
}

fn range_json(range: &MinMax) -> Value {
    let json = |extreme: &Extreme| json!({ "value": extreme.value, "master": extreme.master });
    json!({ "minimum": json(&range.minimum), "maximum": json(&range.maximum) })
}
