//! The characteristic values by name.

use coaxle_files::saw::SawFile;
use coaxle_report::inspect::{name, right, shown, table};
use coaxle_saw::{FlyingSawCharacteristics, SawTable};
use comfy_table::Cell;
use serde_json::{Value, json};

use super::text::unit;

/// Unit of a value.
#[derive(Clone, Copy)]
enum ValueUnit {
    MasterVelocity,
    Master,
    /// Unit of one of the [`QUANTITIES`](coaxle_report::inspect::QUANTITIES) of the slave.
    Slave(usize),
    /// Velocity times acceleration.
    Moment,
}

use ValueUnit::{Master, MasterVelocity, Moment, Slave};

/// The values in the order of `MC_FlyingSawCharacValues`, TS5055 12.3.2.
const VALUES: [(&str, ValueUnit); 31] = [
    ("velocity of the master", MasterVelocity),
    ("master at the start", Master),
    ("slave at the start", Slave(0)),
    ("its velocity", Slave(1)),
    ("its acceleration", Slave(2)),
    ("its jerk", Slave(3)),
    ("master at the end", Master),
    ("slave at the end", Slave(0)),
    ("its velocity", Slave(1)),
    ("its acceleration", Slave(2)),
    ("its jerk", Slave(3)),
    ("master where the slave is lowest", Master),
    ("lowest position", Slave(0)),
    ("master at the least velocity", Master),
    ("least velocity", Slave(1)),
    ("master at the least acceleration", Master),
    ("least acceleration", Slave(2)),
    ("velocity at the least acceleration", Slave(1)),
    ("least jerk", Slave(3)),
    ("least velocity · acceleration", Moment),
    ("master where the slave is highest", Master),
    ("highest position", Slave(0)),
    ("master at the highest velocity", Master),
    ("highest velocity", Slave(1)),
    ("master at the highest acceleration", Master),
    ("highest acceleration", Slave(2)),
    ("velocity at the highest acceleration", Slave(1)),
    ("highest jerk", Slave(3)),
    ("highest velocity · acceleration", Moment),
    // Of the magnitude: the mean of the velocity is only the distance over the time.
    ("mean of |velocity|", Slave(1)),
    ("effective acceleration", Slave(2)),
];

impl ValueUnit {
    fn of(self, saw: &SawFile) -> String {
        match self {
            // Values are over time, except for the master's own positions.
            Self::MasterVelocity => format!("{}/s", saw.master_unit),
            Self::Master => saw.master_unit.clone(),
            Self::Slave(quantity) => unit(saw, quantity),
            // u/s · u/s².
            Self::Moment => format!("{}²/s³", saw.slave_unit),
        }
    }
}

type Named = (
    ((&'static str, &'static (&'static str, ValueUnit)), f64),
    u32,
);

/// PLC name, meaning and unit, value, number.
fn named(values: &FlyingSawCharacteristics) -> impl Iterator<Item = Named> {
    let meanings = FlyingSawCharacteristics::NAMES.into_iter().zip(&VALUES);
    // Numbers from 1, as in the manual's table.
    meanings.zip(values.values()).zip(1..)
}

/// The values as a table, and below it the header of the table that holds the profile.
pub(super) fn in_words(saw: &SawFile, values: &FlyingSawCharacteristics) -> String {
    let mut rows = table(["", "characteristic value", "", "", ""]);
    for (((plc_name, (meaning, unit)), value), number) in named(values) {
        rows.add_row([
            right(&format!("{number}")),
            Cell::new(plc_name),
            Cell::new(meaning),
            right(&shown(value)),
            Cell::new(unit.of(saw)),
        ]);
    }
    let SawTable {
        id,
        rows: points,
        columns,
        table_type,
        periodic,
    } = &values.table;
    let periodic = if *periodic {
        "periodic"
    } else {
        "not periodic"
    };
    format!(
        "{}\n\ntable {id}: {}, rows {points}, columns {columns}, {periodic}",
        rows.trim_fmt(),
        name(table_type),
    )
}

/// The values, in order.
pub(super) fn json_of(saw: &SawFile, values: &FlyingSawCharacteristics) -> Value {
    named(values)
        .map(|(((name, (meaning, unit)), value), number)| {
            json!({
                "number": number,
                "name": name,
                "meaning": meaning,
                "value": value,
                "unit": unit.of(saw),
            })
        })
        .collect()
}

/// The header of the table that holds the profile.
pub(super) fn table_json(table: &SawTable) -> Value {
    json!({
        "id": table.id,
        "rows": table.rows,
        "columns": table.columns,
        "table_type": table.table_type,
        "periodic": table.periodic,
    })
}
