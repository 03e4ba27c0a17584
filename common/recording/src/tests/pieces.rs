//! Recordings in pieces, joined to one.

use super::{CYCLE_NS, recording};
use crate::example::{boiler, row};
use crate::{Facts, Item, Join, Pieces, Reader, RowEncoder, Value};

/// Makes a run of the boiler in pieces of this number of rows.
fn pieces(epoch: &str, rows: u64, each: u64) -> Vec<Vec<u8>> {
    let facts = Facts::from([("epoch".to_owned(), epoch.to_owned())]);
    let mut encoder = RowEncoder::of(&boiler());
    let mut pieces = Pieces::of(boiler(), facts, 1_000);
    let mut taken = Vec::new();
    for k in 0..rows {
        let at = k as i64 * CYCLE_NS;
        let encoded = encoder.encode(at, at + 7, &row(k)).unwrap();
        pieces.row(&encoded).unwrap();
        if (k + 1) % each == 0 {
            taken.extend(pieces.take().unwrap());
        }
    }
    assert!(pieces.take().unwrap().is_none(), "nothing is left");
    taken
}

fn rows_of(file: &[u8]) -> Vec<(i64, Vec<Option<Value>>)> {
    let items = Reader::new(file).map(Result::unwrap);
    let rows = items.filter_map(|item| match item {
        Item::Row(row) => Some((row.at_ns, row.values)),
        _ => None,
    });
    rows.collect()
}

#[test]
fn every_piece_is_a_recording_and_all_together_are_one() {
    let pieces = pieces("1", 30, 10);
    assert_eq!(rows_of(&pieces[1]).len(), 10);
    let mut join = Join::create(Vec::new(), false).unwrap();
    for piece in &pieces {
        join.piece("boiler", piece).unwrap();
    }
    let joined = join.nodes();
    assert_eq!((joined[0].rows, joined[0].missing), (30, 0));
    let file = join.finish().unwrap();
    assert_eq!(rows_of(&file), rows_of(&recording(&[boiler()], 30)));
    let facts = Reader::new(file.as_slice()).filter_map(|item| match item.unwrap() {
        Item::Facts(facts) => facts.get("epoch").cloned(),
        _ => None,
    });
    assert_eq!(facts.collect::<Vec<_>>(), ["1"]);
}

#[test]
fn rows_that_never_came_are_counted_and_a_new_run_is_no_gap() {
    let mut join = Join::create(Vec::new(), false).unwrap();
    let first = pieces("1", 30, 10);
    // The second is lost on the way, with its ten rows.
    for piece in [&first[0], &first[2]] {
        join.piece("boiler", piece).unwrap();
    }
    join.piece("boiler", &pieces("2", 30, 10)[1]).unwrap();
    let joined = join.nodes();
    assert_eq!((joined[0].rows, joined[0].missing), (30, 10));
}

#[test]
fn pieces_of_several_nodes_are_told_apart() {
    let mut other = boiler();
    other.name = "kettle".to_owned();
    let mut encoder = RowEncoder::of(&other);
    let mut kettle = Pieces::of(other, Facts::new(), 5_000);
    kettle.row(&encoder.encode(7, 7, &row(3)).unwrap()).unwrap();
    let kettle = kettle.take().unwrap().unwrap();
    let mut join = Join::create(Vec::new(), true).unwrap();
    join.piece("boiler", &pieces("1", 2, 2)[0]).unwrap();
    join.piece("kettle", &kettle).unwrap();
    let file = join.finish().unwrap();
    let mut reader = Reader::new(file.as_slice());
    let items: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
    let names: Vec<_> = reader.tables().iter().map(|table| &table.name).collect();
    assert_eq!(names, ["boiler", "kettle"]);
    let at = items.iter().filter_map(|item| match item {
        Item::Row(row) => Some((row.table, row.at_ns)),
        _ => None,
    });
    // By the time of day of each node.
    assert_eq!(
        at.collect::<Vec<_>>(),
        [(0, 1_000), (0, 1_000 + CYCLE_NS), (1, 5_007)]
    );
}

#[test]
fn what_cannot_be_joined_is_named_and_leaves_the_rest_as_it_was() {
    let mut join = Join::create(Vec::new(), false).unwrap();
    let good = &pieces("1", 10, 10)[0];
    join.piece("boiler", good).unwrap();
    let mut said = |node: &str, piece: &[u8]| join.piece(node, piece).unwrap_err().to_string();
    assert!(said("boiler", b"hello").contains("no piece of a recording"));
    assert!(said("boiler", &good[..good.len() / 2]).contains("no piece of a recording"));
    let foreign = said("kettle", good);
    assert!(
        foreign.contains("\"boiler\", expected one of \"kettle\""),
        "{foreign}"
    );
    let mut smaller = boiler();
    smaller.instances.pop();
    let mut changed = Pieces::of(smaller, Facts::new(), 0);
    changed.status(0, "{}").unwrap();
    let changed = changed.take().unwrap().unwrap();
    assert_eq!(
        said("boiler", &changed),
        "boiler shows other signals than before"
    );
    assert_eq!(rows_of(&join.finish().unwrap()).len(), 10);
}
