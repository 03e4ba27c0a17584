//! The characteristic values by name.

use coaxle_motion::saw::{FlyingSawCharacteristics, SawTable};
use coaxle_node::saw_file::SawFile;
use comfy_table::Cell;
use serde_json::{Value, json};

use super::text::unit;
use crate::inspect::{name, right, shown, table};

/// What a value is measured in.
#[derive(Clone, Copy)]
enum Unit {
    MasterVelocity,
    Master,
    /// One of the [`QUANTITIES`](crate::inspect::QUANTITIES) of the slave.
    Slave(usize),
    /// Velocity times acceleration.
    Moment,
}

use Unit::{Master, MasterVelocity, Moment, Slave};

/// The values in the order of `MC_FlyingSawCharacValues`, TS5055 12.3.2.
const VALUES: [(&str, &str, Unit); 31] = [
    ("fMasterVeloNom", "velocity of the master", MasterVelocity),
    ("fMasterPosStart", "master at the start", Master),
    ("fSlavePosStart", "slave at the start", Slave(0)),
    ("fSlaveVeloStart", "its velocity", Slave(1)),
    ("fSlaveAccStart", "its acceleration", Slave(2)),
    ("fSlaveJerkStart", "its jerk", Slave(3)),
    ("fMasterPosEnd", "master at the end", Master),
    ("fSlavePosEnd", "slave at the end", Slave(0)),
    ("fSlaveVeloEnd", "its velocity", Slave(1)),
    ("fSlaveAccEnd", "its acceleration", Slave(2)),
    ("fSlaveJerkEnd", "its jerk", Slave(3)),
    ("fMPosAtSPosMin", "master where the slave is lowest", Master),
    ("fSlavePosMin", "lowest position", Slave(0)),
    ("fMPosAtSVeloMin", "master at the least velocity", Master),
    ("fSlaveVeloMin", "least velocity", Slave(1)),
    ("fMPosAtSAccMin", "master at the least acceleration", Master),
    ("fSlaveAccMin", "least acceleration", Slave(2)),
    (
        "fSVeloAtSAccMin",
        "velocity at the least acceleration",
        Slave(1),
    ),
    ("fSlaveJerkMin", "least jerk", Slave(3)),
    ("fSlaveDynMomMin", "least velocity · acceleration", Moment),
    (
        "fMPosAtSPosMax",
        "master where the slave is highest",
        Master,
    ),
    ("fSlavePosMax", "highest position", Slave(0)),
    ("fMPosAtSVeloMax", "master at the highest velocity", Master),
    ("fSlaveVeloMax", "highest velocity", Slave(1)),
    (
        "fMPosAtSAccMax",
        "master at the highest acceleration",
        Master,
    ),
    ("fSlaveAccMax", "highest acceleration", Slave(2)),
    (
        "fSVeloAtSAccMax",
        "velocity at the highest acceleration",
        Slave(1),
    ),
    ("fSlaveJerkMax", "highest jerk", Slave(3)),
    ("fSlaveDynMomMax", "highest velocity · acceleration", Moment),
    ("fSlaveVeloMean", "mean of |velocity|", Slave(1)),
    ("fSlaveAccEff", "effective acceleration", Slave(2)),
];

impl Unit {
    fn of(self, saw: &SawFile) -> String {
        match self {
            Self::MasterVelocity => format!("{}/s", saw.master_unit),
            Self::Master => saw.master_unit.clone(),
            Self::Slave(quantity) => unit(saw, quantity),
            Self::Moment => format!("{}²/s³", saw.slave_unit),
        }
    }
}

/// The values as a table, and below it the header of the table that holds the profile.
pub(super) fn in_words(saw: &SawFile, values: &FlyingSawCharacteristics) -> String {
    let mut rows = table(["", "characteristic value", "", "", ""]);
    let named = VALUES.iter().zip(values.values()).zip(1..);
    for (((plc_name, meaning, unit), value), number) in named {
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
    let named = VALUES.iter().zip(values.values()).zip(1..);
    named
        .map(|(((name, meaning, unit), value), number)| {
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
