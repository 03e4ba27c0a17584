//! Rows of a point's runs that belong together.

use super::record::{FigureRow, RunRecord};
use crate::figures::Units;

/// The rows of one receiver, or of one slave, at one point with all seeds.
pub(super) struct PointGroup<'a> {
    pub(super) receiver: &'a str,
    pub(super) slave: Option<&'a str>,
    pub(super) is_first: bool,
    pub(super) units: &'a Units,
    /// A row for each seed.
    pub(super) rows: Vec<&'a FigureRow>,
}

/// Groups of a point, from its runs with their seeds.
pub(super) fn groups(records: &[(u64, RunRecord)]) -> impl Iterator<Item = PointGroup<'_>> {
    // Runs that differ only in the seed have matching rows.
    let first = records
        .first()
        .into_iter()
        .flat_map(|(_, record)| &record.rows);
    first.enumerate().map(|(n, row)| PointGroup {
        receiver: &row.receiver,
        slave: row.slave.as_deref(),
        is_first: row.is_first,
        units: &row.units,
        rows: (records.iter())
            .filter_map(|(_, record)| record.rows.get(n))
            .collect(),
    })
}
