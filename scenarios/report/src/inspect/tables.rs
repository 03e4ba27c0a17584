//! Tables for people.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{Cell, CellAlignment, Table};

use super::shown;

/// A table with only a header, its columns aligned to the right.
pub fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table.set_header(header.map(right));
    table.style_mut().row_separator = comfy_table::LineStyle::none();
    table
}

/// A row: a name, and numbers.
pub fn cells(name: &str, values: &[f64]) -> Vec<Cell> {
    let values = values.iter().map(|value| right(&shown(*value)));
    std::iter::once(Cell::new(name)).chain(values).collect()
}

/// A cell aligned to the right.
pub fn right(text: &str) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}
