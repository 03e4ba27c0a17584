//! Values of a TOML text, changed in their places: comments and blank lines stay.

use toml_edit::{DocumentMut, Item, TableLike, Value};

/// The text as a document.
///
/// # Errors
/// It is no TOML.
pub(crate) fn document(text: &str) -> Result<DocumentMut, String> {
    text.parse().map_err(|error: toml_edit::TomlError| {
        let message = error.message();
        format!(
            "the text is not valid TOML: {}",
            coaxle_node::one_line(message)
        )
    })
}

/// A number as people write it: whole ones without a point.
pub(crate) fn number(value: f64) -> Value {
    // Below 2^53 ≈ 9e15, where every whole f64 is exact in an i64.
    if value.fract() == 0.0 && value.abs() < 1e15 {
        Value::from(value as i64)
    } else {
        Value::from(value)
    }
}

/// A value of the page: a number, a word, or a boolean.
///
/// # Errors
/// The value is of another kind.
pub(crate) fn value_of(json: &serde_json::Value) -> Result<Value, String> {
    match json {
        serde_json::Value::Number(given) => {
            let finite = given.as_f64().filter(|given| given.is_finite());
            finite
                .map(number)
                .ok_or_else(|| format!("received {given}, expected a finite number"))
        }
        serde_json::Value::String(word) => Ok(Value::from(word.as_str())),
        serde_json::Value::Bool(flag) => Ok(Value::from(*flag)),
        other => Err(format!(
            "received {other}, expected a number, a word, true or false"
        )),
    }
}

/// Puts a value in its place, with the comment behind the one before; `None` takes the field out.
pub(crate) fn put(table: &mut dyn TableLike, key: &str, value: Option<Value>) {
    let Some(mut value) = value else {
        table.remove(key);
        return;
    };
    match table.get_mut(key) {
        Some(Item::Value(known)) => {
            // Blanks and the comment behind the value.
            *value.decor_mut() = known.decor().clone();
            *known = value;
        }
        _ => {
            table.insert(key, Item::Value(value));
        }
    }
}

/// Puts a value where a path of tables leads; tables on the way that are not there are made.
///
/// # Errors
/// Something on the way is no table.
pub(crate) fn put_at(
    document: &mut DocumentMut,
    path: &str,
    value: Option<Value>,
) -> Result<(), String> {
    let (tables, key) = path.rsplit_once('.').unwrap_or(("", path));
    let mut table: &mut dyn TableLike = document.as_table_mut();
    for name in tables.split('.').filter(|name| !name.is_empty()) {
        if !table.contains_key(name) {
            // Nothing to take out, and no empty table for it.
            if value.is_none() {
                return Ok(());
            }
            table.insert(name, toml_edit::table());
        }
        let item = table.get_mut(name).and_then(Item::as_table_like_mut);
        table = item.ok_or_else(|| format!("{name}: received no table, expected one"))?;
    }
    put(table, key, value);
    Ok(())
}
