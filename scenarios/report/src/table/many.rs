//! The figures of more receivers than have room beside each other.

use coaxle_lab::number::{quantile, significant};
use coaxle_lab::summary::ReceiverSummary;
use comfy_table::Table;

use super::rows;
use crate::inspect::{right, table};

/// Returns the least, the median and the largest of each figure, and the number of receivers that have it.
pub(super) fn ranges(receivers: &[(&str, &ReceiverSummary)]) -> Table {
    let heading = format!("{} far axes", receivers.len());
    let mut table = table([&heading, "least", "median", "most", "of"]);
    for (label, values) in rows(receivers) {
        // A word may follow the figure.
        let numbers = values.iter().filter_map(|value| value.split(' ').next());
        let mut numbers: Vec<f64> = numbers.filter_map(|number| number.parse().ok()).collect();
        numbers.sort_by(f64::total_cmp);
        let (Some(least), Some(most)) = (numbers.first(), numbers.last()) else {
            continue;
        };
        let cells =
            [*least, quantile(&numbers, 0.5), *most].map(|number| right(&significant(number, 3)));
        let label = std::iter::once(comfy_table::Cell::new(label));
        let count = right(&numbers.len().to_string());
        table.add_row(label.chain(cells).chain([count]));
    }
    table
}
