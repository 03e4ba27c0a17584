//! The table of routers.

use coaxle_lab::number::significant;
use coaxle_lab::summary::Summary;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{Cell, Table};

use super::right;

/// Returns the traffic over each router and each link from one to another, per second; empty without routers.
#[must_use]
pub fn routers(summary: &Summary) -> String {
    if summary.routers.is_empty() {
        return String::new();
    }
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    let columns = [
        "messages/s in",
        "kB/s in",
        "to nodes",
        "kB/s",
        "to routers",
        "kB/s",
        "dropped",
    ];
    table.set_header(std::iter::once(Cell::new("router")).chain(columns.map(right)));
    let rate = |value: f64| right(&significant(value, 4));
    for (name, router) in &summary.routers {
        table.add_row([
            Cell::new(name),
            rate(router.received_per_s),
            rate(1e-3 * router.received_bytes_per_s),
            rate(router.to_nodes_per_s),
            rate(1e-3 * router.to_nodes_bytes_per_s),
            rate(router.to_routers_per_s),
            rate(1e-3 * router.to_routers_bytes_per_s),
            right(&router.dropped.to_string()),
        ]);
        for (to, link) in &router.links {
            let mut row = vec![Cell::new(format!("  to {to}"))];
            // Links go to routers: the columns of what comes in and of nodes stay empty.
            row.resize(5, Cell::new(""));
            row.extend([rate(link.messages_per_s), rate(1e-3 * link.bytes_per_s)]);
            table.add_row(row);
        }
    }
    table.style_mut().row_separator = comfy_table::LineStyle::none();
    table.trim_fmt()
}
