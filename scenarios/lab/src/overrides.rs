//! `--set path.to.field=value`.

use anyhow::Context;
use coaxle_node::config::did_you_mean;
use coaxle_os::exit::{Mistake, wrong_argument};
use toml::{Table, Value};

/// Most keys of a path.
// Setting goes down by recursion, a call for each key.
const MOST_KEYS: usize = 32;

/// Most list elements named in the error about an unknown one.
const MOST_LISTED: usize = 24;

/// Sets one field of a table. A path is keys and list positions with dots between; the elements of
/// the lists `sender` and `receiver` also go by their names: `receiver.saw.cycle-time-us=2000`.
///
/// # Errors
/// Names what was received and what is expected.
pub fn apply(table: &mut Table, text: &str) -> anyhow::Result<()> {
    let (path, value) = text.split_once('=').ok_or_else(|| {
        Mistake::in_argument(format!(
            "received --set {text:?}, expected path.to.field=value"
        ))
    })?;
    let keys: Vec<&str> = path.trim().split('.').collect();
    if keys.len() > MOST_KEYS {
        return wrong_argument(format!(
            "received --set with a path of {} keys, expected at most {MOST_KEYS}",
            keys.len()
        ));
    }
    if keys.iter().any(|key| key.is_empty()) {
        return wrong_argument(format!(
            "received --set {text:?}, expected keys with single dots between them"
        ));
    }
    let value = parse_value(value.trim());
    let mut root = Value::Table(std::mem::take(table));
    let set = set(&mut root, &keys, value).with_context(|| format!("--set {text}"));
    // Put back after an error, too: the caller's table was taken.
    if let Value::Table(changed) = root {
        *table = changed;
    }
    set
}

/// Parses a value as TOML; anything else is a text.
fn parse_value(text: &str) -> Value {
    format!("x = {text}")
        .parse::<Table>()
        .ok()
        .and_then(|mut table| table.remove("x"))
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

fn set(at: &mut Value, keys: &[&str], value: Value) -> anyhow::Result<()> {
    let [key, rest @ ..] = keys else {
        *at = value;
        return Ok(());
    };
    match at {
        Value::Table(table) => {
            let next = table
                .entry((*key).to_owned())
                // Missing tables are made: defaults are not written in a scenario. Reading refuses fields that are none.
                .or_insert_with(|| Value::Table(Table::new()));
            set(next, rest, value)
        }
        Value::Array(list) => {
            // A number is a position, even where an element has it as its name.
            let found = match key.parse::<usize>() {
                Ok(position) => Some(position),
                Err(_) => list.iter().position(|element| is_named(element, key)),
            };
            match found.filter(|position| *position < list.len()) {
                Some(position) => set(&mut list[position], rest, value),
                None => wrong_argument(unknown(list, key)),
            }
        }
        other => wrong_argument(format!(
            "received {key:?} below a plain value ({other}), expected no more keys"
        )),
    }
}

/// The error about an unknown element, with the known ones: by their names, or by their positions from 0.
fn unknown(list: &[Value], received: &str) -> String {
    let name = |element: &Value| Some(element.get("name")?.as_str()?.to_owned());
    let name = |(n, element): (usize, &Value)| name(element).unwrap_or_else(|| n.to_string());
    let known: Vec<String> = list
        .iter()
        .take(MOST_LISTED)
        .enumerate()
        .map(name)
        .collect();
    let meant = did_you_mean(received, known.iter().map(String::as_str));
    let known = known.join(", ");
    format!("received {received:?}, expected one of: {known}{meant}")
}

fn is_named(element: &Value, name: &str) -> bool {
    element.get("name").and_then(Value::as_str) == Some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str) -> anyhow::Result<Table> {
        let mut table: Table = "seed = 1\n[network]\nloss = 0.0\n[[receiver]]\nname = \"a\"\n[[receiver]]\nname = \"b\"\n"
            .parse()
            .unwrap();
        apply(&mut table, text)?;
        Ok(table)
    }

    #[test]
    fn fields_lists_and_names_are_reached() {
        assert_eq!(changed("seed=7").unwrap()["seed"].as_integer(), Some(7));
        let table = changed("network.loss = 0.25").unwrap();
        assert_eq!(table["network"]["loss"].as_float(), Some(0.25));
        for path in ["receiver.1.mode=pt1", "receiver.b.mode=\"pt1\""] {
            let table = changed(path).unwrap();
            assert_eq!(table["receiver"][1]["mode"].as_str(), Some("pt1"));
        }
        let table = changed("network.jitter={ normal-us = 5 }").unwrap();
        assert_eq!(
            table["network"]["jitter"]["normal-us"].as_integer(),
            Some(5)
        );
    }

    #[test]
    fn what_cannot_be_set_is_explained() {
        for (text, part) in [
            ("seed", "path.to.field=value"),
            ("a..b=1", "single dots"),
            ("receiver.c.mode=1", "expected one of: a, b"),
            ("seed.x=1", "below a plain value"),
        ] {
            let message = format!("{:#}", changed(text).unwrap_err());
            assert!(message.contains(part), "{message}");
        }
    }
}
