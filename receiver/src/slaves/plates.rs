//! The cam plates of a receiver: one store, which its slaves share.

use std::path::Path;

use coaxle_cam::{MOST_TABLES, Tables};
use coaxle_node::cam_file::CamFile;

use crate::config::{CamSource, ReceiverConfig, WrongSlave};

/// Most points and rows of all cam plates of a receiver together.
pub(super) const MOST_ROWS: usize = 4_000_000;

/// The plates of a config, with room for others that come later.
pub(super) fn plates(config: &ReceiverConfig) -> Result<Tables, WrongSlave> {
    let mut plates = Tables::new(MOST_TABLES);
    for (k, source) in config.cams.iter().enumerate() {
        add(&mut plates, source, &format!("cams[{k}]"))?;
    }
    for (n, slave) in config.slaves.iter().enumerate() {
        for (k, source) in slave.cams.iter().enumerate() {
            add(&mut plates, source, &format!("slave[{n}].cams[{k}]"))?;
        }
    }
    Ok(plates)
}

/// How many points and rows more a plate could have that comes now.
pub(super) fn room(plates: &Tables) -> usize {
    MOST_ROWS.saturating_sub(plates.rows())
}

fn add(plates: &mut Tables, source: &CamSource, field: &str) -> Result<(), WrongSlave> {
    let cam = match source {
        CamSource::File(file) => CamFile::load(file),
        CamSource::Here(table) => CamFile::from_table("here", Path::new(""), table.clone()),
    };
    let cam = cam.map_err(|error| wrong(field, error))?;
    let id = cam
        .table_id
        .ok_or_else(|| wrong(field, "0x4b32: received no table-id, expected 1 to 255"))?;
    let plate = cam.plate().map_err(|error| wrong(field, error))?;
    if plate.rows() > room(plates) {
        let rows = plates.rows() + plate.rows();
        let reason = format!(
            "received {rows} points and rows with it, expected at most {MOST_ROWS} in a receiver"
        );
        return Err(wrong(field, reason));
    }
    let id = u32::from(id.get());
    if plates.plate(id).is_ok() {
        let reason = format!(
            "0x4063: received table-id {id} twice, expected one of its own for each plate: all slaves of the receiver \
             can be coupled by it"
        );
        return Err(wrong(field, reason));
    }
    plates
        .insert(id, plate)
        .map_err(|error| wrong(field, error))
}

fn wrong(field: &str, reason: impl ToString) -> WrongSlave {
    WrongSlave {
        field: field.to_owned(),
        reason: reason.to_string(),
    }
}
