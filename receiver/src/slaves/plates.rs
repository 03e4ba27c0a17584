//! The cam plates of a receiver: one store, shared by its slaves.

use std::sync::Arc;

use coaxle_cam::{MOST_TABLES, ReservedPlate, TableId, Tables};

use crate::cam_source::CamSource;
use crate::config::{ReceiverConfig, WrongSlave};
use crate::program::StepConfig;

/// Greatest number of points and rows of all cam plates of a receiver together.
pub(super) const MOST_ROWS: usize = 4_000_000;

/// Creates the plates of a config, with room for later ones.
pub(super) fn plates(config: &ReceiverConfig) -> Result<Tables, WrongSlave> {
    // All slots at once: plates that come later over the network find theirs without an allocation.
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

/// The plates that the steps of a slave load, for each step.
pub(super) fn plates_of_steps(
    plates: &mut Tables,
    n: usize,
    steps: &[StepConfig],
) -> Result<Vec<Option<ReservedPlate>>, WrongSlave> {
    let reserved = steps.iter().enumerate().map(|(k, step)| {
        let Some((source, table)) = step.plate() else {
            return Ok(None);
        };
        reserve(
            plates,
            source,
            table,
            &format!("slave[{n}].step[{k}].do.cam-table-select"),
        )
        .map(Some)
    });
    reserved.collect()
}

fn reserve(
    plates: &mut Tables,
    source: &CamSource,
    table: Option<TableId>,
    field: &str,
) -> Result<ReservedPlate, WrongSlave> {
    let cam = (source.read()).map_err(|error| wrong(&format!("{field}.plate"), error))?;
    // The error of the plate's file names the place; that of the number alone does not.
    let plate = cam
        .plate()
        .map_err(|error| wrong(&format!("{field}.plate"), error))?;
    check_room(plates, plate.rows(), &format!("{field}.plate"))?;
    let id = table
        .or(cam.table_id.map(|id| u32::from(id.get())))
        .ok_or_else(|| {
            let reason = "0x4b32: received none, and no table-id in the plate, expected 1 to 255";
            wrong(&format!("{field}.table"), reason)
        })?;
    plates
        .reserve(id, Arc::new(cam.source()))
        .map_err(|error| wrong(field, error))
}

fn check_room(plates: &Tables, more: usize, field: &str) -> Result<(), WrongSlave> {
    if more <= room(plates) {
        return Ok(());
    }
    let rows = plates.rows() + more;
    let reason = format!(
        "received {rows} points and rows with it, expected at most {MOST_ROWS} in a receiver"
    );
    Err(wrong(field, reason))
}

/// Number of points and rows that a further plate may have.
pub(super) fn room(plates: &Tables) -> usize {
    // A store beyond the bound has no room, rather than an underflow.
    MOST_ROWS.saturating_sub(plates.rows())
}

fn add(plates: &mut Tables, source: &CamSource, field: &str) -> Result<(), WrongSlave> {
    let cam = source.read().map_err(|error| wrong(field, error))?;
    let id = cam
        .table_id
        .ok_or_else(|| wrong(field, "0x4b32: received no table-id, expected 1 to 255"))?;
    let plate = cam.plate().map_err(|error| wrong(field, error))?;
    check_room(plates, plate.rows(), field)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_plates_have_four_million_points_and_rows_at_most() {
        let plates = Tables::new(MOST_TABLES);
        assert!(check_room(&plates, 4_000_000, "cams[0]").is_ok());
        let wrong = check_room(&plates, 4_000_001, "cams[0]").unwrap_err();
        assert_eq!(
            wrong.reason,
            "received 4000001 points and rows with it, expected at most 4000000 in a receiver"
        );
    }
}
