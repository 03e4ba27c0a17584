//! The cam plates of a receiver: one store, shared by its slaves.

use std::sync::Arc;

use coaxle_cam::{MOST_TABLES, ReservedPlate, TableId, Tables};
use coaxle_node::config::Wrong;

use crate::cam_source::CamSource;
use crate::config::ReceiverConfig;
use crate::program::StepConfig;

/// Greatest number of points and rows of all cam plates of a receiver together.
pub(super) const MOST_ROWS: usize = 4_000_000;
/// Error code of the NC for a number that no table can have.
const NO_TABLE_ID: u32 = 0x4b32;
/// Error code of the NC for a table that exists already.
const TABLE_EXISTS: u32 = 0x4063;

/// Creates the plates of a config, with room for later ones.
pub(super) fn plates(config: &ReceiverConfig) -> Result<Tables, Wrong> {
    // All slots at once: plates that come later over the network find theirs without an allocation.
    let mut plates = Tables::new(MOST_TABLES);
    for (k, source) in config.cams.iter().enumerate() {
        add(&mut plates, source).map_err(|wrong| wrong.within(format_args!("cams[{k}]")))?;
    }
    for (n, slave) in config.slaves.iter().enumerate() {
        for (k, source) in slave.cams.iter().enumerate() {
            add(&mut plates, source)
                .map_err(|wrong| wrong.within(format_args!("slave[{n}].cams[{k}]")))?;
        }
    }
    Ok(plates)
}

/// The plates that the steps of a slave load, for each step.
pub(super) fn plates_of_steps(
    plates: &mut Tables,
    steps: &[StepConfig],
) -> Result<Vec<Option<ReservedPlate>>, Wrong> {
    let reserved = steps.iter().enumerate().map(|(k, step)| {
        let Some((source, table)) = step.plate() else {
            return Ok(None);
        };
        let reserved = reserve(plates, source, table).map(Some);
        reserved.map_err(|wrong| wrong.within(format_args!("step[{k}].do.cam-table-select")))
    });
    reserved.collect()
}

fn reserve(
    plates: &mut Tables,
    source: &CamSource,
    table: Option<TableId>,
) -> Result<ReservedPlate, Wrong> {
    let wrong = |error| Wrong::with_reason("plate", error);
    let cam = source.read().map_err(wrong)?;
    // The error of the plate's file names the place; that of the number alone does not.
    let plate = cam.plate().map_err(wrong)?;
    check_room(plates, plate.rows()).map_err(|wrong| wrong.within("plate"))?;
    let id = table.or(cam.table_id.map(|id| u32::from(id.get())));
    let id = id.ok_or_else(|| {
        Wrong::of("table", "none, and no table-id in the plate", "1 to 255").with_code(NO_TABLE_ID)
    })?;
    let reserved = plates.reserve(id, Arc::new(cam.source()));
    reserved.map_err(|error| Wrong::with_reason("", error))
}

fn check_room(plates: &Tables, more: usize) -> Result<(), Wrong> {
    if more <= room(plates) {
        return Ok(());
    }
    let received = format!("{} points and rows with it", plates.rows() + more);
    let expected = format!("at most {MOST_ROWS} in a receiver");
    Err(Wrong::value(received, expected))
}

/// Number of points and rows that a further plate may have.
pub(super) fn room(plates: &Tables) -> usize {
    // A store beyond the bound has no room, rather than an underflow.
    MOST_ROWS.saturating_sub(plates.rows())
}

fn add(plates: &mut Tables, source: &CamSource) -> Result<(), Wrong> {
    let wrong = |error| Wrong::with_reason("", error);
    let cam = source.read().map_err(wrong)?;
    let none = || Wrong::value("no table-id", "1 to 255").with_code(NO_TABLE_ID);
    let id = u32::from(cam.table_id.ok_or_else(none)?.get());
    let plate = cam.plate().map_err(wrong)?;
    check_room(plates, plate.rows())?;
    if plates.plate(id).is_ok() {
        let received = format!("table-id {id} twice");
        let expected =
            "one of its own for each plate: all slaves of the receiver can be coupled by it";
        return Err(Wrong::value(received, expected).with_code(TABLE_EXISTS));
    }
    let inserted = plates.insert(id, plate);
    inserted.map_err(|error| Wrong::with_reason("", error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_plates_have_four_million_points_and_rows_at_most() {
        let plates = Tables::new(MOST_TABLES);
        assert!(check_room(&plates, 4_000_000).is_ok());
        let wrong = check_room(&plates, 4_000_001).unwrap_err();
        assert_eq!(
            wrong.to_string(),
            "received 4000001 points and rows with it, expected at most 4000000 in a receiver"
        );
    }
}
