//! Every row of `docs/LIMITS.md`: what is as long as it says is taken, and what is longer refused.

use std::panic::catch_unwind;

use crate::root;
use crate::{Bench, contents, files};

/// Attempts at and beyond the bound of a row.
pub(crate) type Probe = fn(&Bench);

/// A row of the page, and its attempts. Both texts are those of the page, so that a change of the page leads to its probe.
pub(crate) type ProbedRow = (&'static str, &'static str, Probe);

/// Beginning of the table whose rows the link tests itself (`common/zenoh-link-tls/src/bounds.rs`).
const OF_LINKS: &str = "| connections to a listening endpoint";

/// The rows of the page's tables: subject and bound.
fn rows(page: &str) -> Vec<(String, String)> {
    let (page, _) = page.split_once(OF_LINKS).expect("the last table");
    let lines = page.lines().filter_map(|line| line.strip_prefix("| "));
    let cells = lines.filter_map(|line| line.trim_end().strip_suffix(" |"));
    let pairs = cells.filter_map(|line| line.split_once(" | "));
    pairs
        // The heads of both tables.
        .filter(|(_, bound)| *bound != "at most")
        .map(|(subject, bound)| (subject.to_owned(), bound.to_owned()))
        .collect()
}

#[test]
fn every_row_of_the_page_is_probed_and_holds() {
    let page = std::fs::read_to_string(root().join("docs/LIMITS.md")).expect("the page");
    let mut probes: Vec<ProbedRow> = [files::ROWS, contents::ROWS].concat();
    let mut wrong = Vec::new();
    for (subject, bound) in rows(&page) {
        match probes.iter().position(|(of, ..)| *of == subject) {
            None => wrong.push(format!("no probe for {subject:?}")),
            Some(place) => {
                let (_, known, _) = probes[place];
                if known != bound {
                    wrong.push(format!(
                        "{subject}: the page says {bound:?}, its probe knows {known:?}"
                    ));
                }
                let (_, _, probe) = probes.remove(place);
                // The others are tried nevertheless; the panic has printed the cause.
                if catch_unwind(|| probe(&Bench::new())).is_err() {
                    wrong.push(format!("{subject}: does not hold"));
                }
            }
        }
    }
    let left = probes
        .iter()
        .map(|(subject, ..)| format!("no row for the probe of {subject:?}"));
    wrong.extend(left);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
