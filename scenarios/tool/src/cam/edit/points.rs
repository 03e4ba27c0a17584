//! Points and rows in the text of a cam file.

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use crate::edit::toml_text::{number, put};

/// Number of points in the text, in either notation.
pub(super) fn count(document: &DocumentMut) -> usize {
    match document.get("point") {
        Some(Item::ArrayOfTables(tables)) => tables.len(),
        Some(Item::Value(Value::Array(points))) => points.len(),
        _ => 0,
    }
}

/// A point by its place, from 0.
pub(super) fn point(document: &mut DocumentMut, n: usize) -> Option<&mut dyn TableLike> {
    match document.get_mut("point")? {
        Item::ArrayOfTables(tables) => tables.get_mut(n).map(|table| table as &mut dyn TableLike),
        Item::Value(Value::Array(points)) => {
            let point = points.get_mut(n).and_then(Value::as_inline_table_mut);
            point.map(|point| point as &mut dyn TableLike)
        }
        _ => None,
    }
}

/// The rows of a table that are in the text.
pub(super) fn rows(document: &mut DocumentMut) -> Option<&mut Array> {
    document
        .get_mut("table")?
        .as_table_like_mut()?
        .get_mut("rows")?
        .as_array_mut()
}

/// A field of a point as a whole number.
fn whole(point: &dyn TableLike, field: &str) -> Option<i64> {
    point.get(field).and_then(Item::as_integer)
}

/// Puts a point behind another one, which leads to it from then on.
pub(super) fn insert_behind(
    document: &mut DocumentMut,
    n: usize,
    law: Option<&str>,
    master: f64,
    slave: f64,
) {
    // The new point takes over where the old one led to.
    let next = point(document, n).map(|before| {
        let next = whole(before, "relative-next");
        put(before, "relative-next", None);
        next
    });
    // Those before it that lead past it lead one further.
    for k in 0..n {
        let Some(before) = point(document, k) else {
            continue;
        };
        if let Some(next) = whole(before, "relative-next").filter(|next| k as i64 + next > n as i64)
        {
            put(before, "relative-next", Some(Value::from(next + 1)));
        }
    }
    let fields = law
        .map(|law| ("law", Value::from(law)))
        .into_iter()
        .chain(
            next.flatten()
                .map(|next| ("relative-next", Value::from(next))),
        )
        .chain([("master", number(master)), ("slave", number(slave))]);
    match document.get_mut("point") {
        Some(Item::ArrayOfTables(tables)) => {
            let mut table = Table::new();
            fields.for_each(|(field, value)| put(&mut table, field, Some(value)));
            // A blank line before the header, as people write tables.
            table.decor_mut().set_prefix("\n");
            tables.insert(n + 1, table);
            in_order(tables);
        }
        Some(Item::Value(Value::Array(points))) => {
            let mut table = InlineTable::new();
            fields.for_each(|(field, value)| put(&mut table, field, Some(value)));
            let decor = points.get(n).map(|point| point.decor().clone());
            let mut value = Value::from(table);
            *value.decor_mut() = decor.unwrap_or_default();
            points.insert_formatted(n + 1, value);
        }
        _ => {}
    }
    renumber(document);
}

/// Takes a point out; those that led to it lead to the one behind it.
pub(super) fn remove(document: &mut DocumentMut, n: usize) {
    // Points that led to the last one lead to the one before it, as there is none behind.
    let is_last = n + 1 == count(document);
    for k in 0..n {
        let Some(before) = point(document, k) else {
            continue;
        };
        let next = whole(before, "relative-next");
        let shorter = |next: &i64| {
            let to = k as i64 + next;
            to > n as i64 || is_last && to == n as i64
        };
        if let Some(next) = next.filter(shorter) {
            put(
                before,
                "relative-next",
                // 1 is the default and is left out.
                (next > 2).then(|| Value::from(next - 1)),
            );
        }
    }
    match document.get_mut("point") {
        Some(Item::ArrayOfTables(tables)) => {
            tables.remove(n);
            in_order(tables);
        }
        Some(Item::Value(Value::Array(points))) => {
            points.remove(n);
        }
        _ => {}
    }
    renumber(document);
}

/// Tables are written by their positions in the text.
fn in_order(tables: &mut ArrayOfTables) {
    for (n, table) in tables.iter_mut().enumerate() {
        // Numbered again, as a table that was inserted has no position of its own.
        table.set_position(Some(n as isize + 1));
    }
}

/// Renumbers points whose number is written, by their places.
fn renumber(document: &mut DocumentMut) {
    for n in 0..count(document) {
        // Only where a number is written: the place is the number otherwise.
        if let Some(point) = point(document, n)
            && point.contains_key("index")
        {
            put(point, "index", Some(Value::from(n as i64 + 1)));
        }
    }
}
