//! The bounds of docs/LIMITS.md against the constants here. The tests of each module try what happens at and beyond them.

use crate::accept::{LONGEST_HANDSHAKE, MOST_DESCRIPTORS};
use crate::admission::{MOST_GREETED, MOST_SILENT, OF_ALL, OF_ORIGIN};
use crate::flood::MOST_ORIGINS;
use crate::revocation::MOST_LIST_BYTES;

const PAGE: &str = include_str!("../../../docs/LIMITS.md");

#[test]
fn the_page_has_the_bounds_of_links() {
    let (_, table) = PAGE
        .split_once("| connections to a listening endpoint")
        .expect("the table");
    let rows = table.lines().skip(2);
    let rows: Vec<_> = rows.take_while(|line| line.starts_with('|')).collect();
    let per_second = |interval: std::time::Duration| (1.0 / interval.as_secs_f64()).round();
    let expected = [
        format!(
            "| without a complete ClientHello | {MOST_SILENT}; then the oldest of the busiest address makes room |"
        ),
        format!("| with one, before the end of the handshake | {MOST_GREETED}, likewise |"),
        format!("| descriptors of both | {MOST_DESCRIPTORS} |"),
        format!(
            "| duration of a handshake | {} s |",
            LONGEST_HANDSHAKE.as_secs()
        ),
        format!(
            "| handshakes of one address (IPv6: of one /64) | {} at once, then {} a second |",
            OF_ORIGIN.burst,
            per_second(OF_ORIGIN.interval)
        ),
        format!(
            "| handshakes of all addresses | {} at once, then {} a second |",
            OF_ALL.burst,
            per_second(OF_ALL.interval)
        ),
        format!("| addresses that are counted one by one during a flood | {MOST_ORIGINS} |"),
        format!(
            "| list of revoked certificates (`revoked.list`) | {} MiB |",
            MOST_LIST_BYTES >> 20
        ),
    ];
    assert_eq!(rows, expected);
}
