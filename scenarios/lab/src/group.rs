//! `[[group]]` of a scenario: similar nodes and the expectations of them, written once.

use std::collections::BTreeMap;

use coaxle_node::config::{ConfigError, Wrong, did_you_mean, from_table};
use coaxle_receiver::ReceiverConfig;
use coaxle_sender::config::SenderConfig;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::event::Event;
use crate::expect::Expectation;
use crate::invariants::Exception;
use crate::overrides;
use crate::router::RouterConfig;

/// Similar nodes, and the expectations of them, written once. Each element of its lists stands for as many of the
/// scenario's own as `count` says; in every text of them `{n}`, or the name of another number in braces, is the element's number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Group {
    /// Number of copies: `count = 64`, and `{n}` goes from 1 to 64; or by several numbers, `count = { hall = 4, line = 8 }`,
    /// for all pairs of `{hall}` and `{line}`, the last name in the alphabet the fastest.
    pub count: Count,
    /// Fields that differ from one to the next, by their paths within the group, as `--set` takes them: evenly from the first
    /// value to the second, such as `{ "sender.0.clock.drift-ppm" = [-100, 100] }`.
    #[serde(default)]
    pub spread: BTreeMap<String, [f64; 2]>,
    /// Routers, as those of the scenario.
    #[serde(rename = "router", default)]
    pub routers: Vec<RouterConfig>,
    /// Senders.
    #[serde(rename = "sender", default)]
    pub senders: Vec<SenderConfig>,
    /// Receivers.
    #[serde(rename = "receiver", default)]
    pub receivers: Vec<ReceiverConfig>,
    /// Events at them.
    #[serde(rename = "event", default)]
    pub events: Vec<Event>,
    /// Expectations of them.
    #[serde(rename = "expect", default)]
    pub expectations: Vec<Expectation>,
    /// Exceptions from the default invariants.
    #[serde(rename = "exception", default)]
    pub exceptions: Vec<Exception>,
}

/// Number of copies of a group.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a whole number from 1 to 1000, or a table of names with such numbers"
)]
pub enum Count {
    /// A number of copies, numbered by `{n}`.
    Of(u32),
    /// Every combination of these numbers, each from 1.
    By(BTreeMap<String, u32>),
}

/// The lists that a group may have.
const LISTS: [&str; 6] = [
    "router",
    "sender",
    "receiver",
    "event",
    "expect",
    "exception",
];

/// Other fields of a group.
const FIELDS: [&str; 2] = ["count", "spread"];

/// Greatest number of copies.
const MOST_COPIES: u64 = 1_000;
/// Most bytes of all groups written out.
// A thousand copies of 16 kB each.
const MOST_BYTES: u64 = 16 << 20;

/// The fields of a group that are no lists of elements.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Head {
    count: Count,
    #[serde(default)]
    spread: BTreeMap<String, [f64; 2]>,
}

/// Origins of those list elements of a scenario that its file has in a group.
#[derive(Debug, Default)]
pub(crate) struct Origins(BTreeMap<&'static str, GroupOrigin>);

/// The elements of one list from `first` on, each by its group and its number there.
#[derive(Debug)]
struct GroupOrigin {
    first: usize,
    from: Vec<(usize, usize)>,
}

impl Origins {
    /// Path of a field in the file: `group[0].sender[1].name` for `sender[37].name`.
    fn called(&self, field: &str) -> Option<String> {
        let (list, rest) = field.split_once('[')?;
        let (number, rest) = rest.split_once(']')?;
        let origin = self.0.get(list)?;
        // Elements before the first one are the scenario's own.
        let place = number.parse::<usize>().ok()?.checked_sub(origin.first)?;
        let (group, element) = origin.from.get(place)?;
        Some(format!("group[{group}].{list}[{element}]{rest}"))
    }

    /// An error of the scenario with its fields as the file has them, once each.
    pub(crate) fn in_file(&self, error: ConfigError) -> ConfigError {
        error.with_fields(|field| self.called(&field).unwrap_or(field))
    }
}

/// Expands the groups of a scenario, behind the present elements of its lists.
///
/// # Errors
/// [`ConfigError`] names the file, the field, what was received and what is expected.
pub(crate) fn expand(file: &str, scenario: &mut Table) -> Result<Origins, ConfigError> {
    let mut origins = Origins::default();
    let Some(Value::Array(groups)) = scenario.get("group") else {
        // A value of another type is reported when it is read by its type.
        return Ok(origins);
    };
    if !groups.iter().all(Value::is_table) {
        return Ok(origins);
    }
    // Cloned, as their elements are appended to the table that holds them.
    let groups = groups.clone();
    let mut bytes = 0;
    for (number, group) in groups.into_iter().enumerate() {
        let within = |wrong: Wrong| wrong.within(format_args!("group[{number}]")).in_file(file);
        let Value::Table(mut group) = group else {
            continue;
        };
        let head = head_of(file, number, &group)?;
        let copies = head.count.copies().map_err(within)?;
        // The rest of the group are its lists alone, which are copied.
        for field in FIELDS {
            group.remove(field);
        }
        // Checked before any copy is made.
        bytes += group.to_string().len() as u64 * copies.len() as u64;
        if bytes > MOST_BYTES {
            let received = format!("{bytes} bytes of TOML once written out");
            let expected = format!("at most {MOST_BYTES}");
            return Err(within(Wrong::of("count", received, expected)));
        }
        for (place, numbers) in copies.iter().enumerate() {
            // Both ends are reached. A single copy has the first value.
            let share = place as f64 / (copies.len() - 1).max(1) as f64;
            let mut copy = group.clone();
            for (field, [from, to]) in &head.spread {
                check_path(field, &copy).map_err(within)?;
                let value = from + (to - from) * share;
                overrides::apply(&mut copy, &format!("{field}={value}"))
                    .map_err(|error| within(Wrong::with_reason("spread", format!("{error:#}"))))?;
            }
            let mut copy = Value::Table(copy);
            // After the spread, whose paths are those of the group as it is written.
            number_texts(&mut copy, numbers);
            append(scenario, copy, number, &mut origins).map_err(within)?;
        }
    }
    scenario.remove("group");
    Ok(origins)
}

/// Checks that a path leads into one of the lists that the group has.
fn check_path(field: &str, group: &Table) -> Result<(), Wrong> {
    let list = field.split('.').next().unwrap_or_default();
    if group.get(list).is_some_and(Value::is_array) {
        return Ok(());
    }
    let known: Vec<_> = group.keys().map(String::as_str).collect();
    let expected = format!("a path into one of its lists: {}", known.join(", "));
    Err(Wrong::of("spread", format_args!("{field:?}"), expected))
}

fn head_of(file: &str, number: usize, group: &Table) -> Result<Head, ConfigError> {
    let mut head = group.clone();
    for list in LISTS {
        head.remove(list);
    }
    let known = || FIELDS.into_iter().chain(LISTS);
    if let Some(unknown) = head.keys().find(|name| !FIELDS.contains(&name.as_str())) {
        let meant = did_you_mean(unknown, known());
        let known = known().collect::<Vec<_>>().join(", ");
        let reason = format!("unknown field `{unknown}`, expected one of: {known}{meant}");
        let field = format!("group[{number}].{unknown}");
        return Err(ConfigError::field(file, field, reason));
    }
    let head = from_table::<Head>(file, head);
    head.map_err(|error| {
        error.with_fields(|field| match field.as_str() {
            "" => format!("group[{number}]"),
            field => format!("group[{number}].{field}"),
        })
    })
}

/// A number that a text may name: name and value.
type Number = (String, u32);

impl Count {
    /// The numbers of each copy.
    fn copies(&self) -> Result<Vec<Vec<Number>>, Wrong> {
        let names: Vec<(&str, u32)> = match self {
            Self::Of(count) => vec![("n", *count)],
            Self::By(counts) => counts.iter().map(|(name, n)| (&**name, *n)).collect(),
        };
        let product = names.iter().map(|(_, count)| u64::from(*count));
        // Saturating: two counts of 32 bits may exceed 64 bits with a third.
        let product = product.fold(1_u64, u64::saturating_mul);
        let product = if names.is_empty() { 0 } else { product };
        if !(1..=MOST_COPIES).contains(&product) {
            let expected = format!("1 to {MOST_COPIES} in all");
            return Err(Wrong::of("count", product, expected));
        }
        let mut copies = vec![Vec::new()];
        for (name, count) in names {
            let longer = |copy: Vec<Number>| {
                (1..=count).map(move |n| {
                    let mut copy = copy.clone();
                    copy.push((name.to_owned(), n));
                    copy
                })
            };
            copies = copies.into_iter().flat_map(longer).collect();
        }
        Ok(copies)
    }
}

/// Puts numbers in the place of their names in braces, in every text.
fn number_texts(value: &mut Value, numbers: &[Number]) {
    match value {
        Value::String(text) => {
            for (name, number) in numbers {
                *text = text.replace(&format!("{{{name}}}"), &number.to_string());
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|one| number_texts(one, numbers)),
        Value::Table(table) => {
            let values = table.iter_mut().map(|(_, value)| value);
            values.for_each(|value| number_texts(value, numbers));
        }
        _ => {}
    }
}

/// Puts the elements of a group's lists behind those of the scenario's.
fn append(
    scenario: &mut Table,
    group: Value,
    number: usize,
    origins: &mut Origins,
) -> Result<(), Wrong> {
    for list in LISTS {
        let Some(added) = group.get(list) else {
            continue;
        };
        let all = scenario
            .entry(list)
            .or_insert_with(|| Value::Array(Vec::new()));
        let (Value::Array(added), Value::Array(all)) = (added, &mut *all) else {
            // The elements of the group, or those of the scenario that they are put behind.
            let wrong = if added.is_array() { all } else { added };
            let received = format!("a value of type {}", wrong.type_str());
            return Err(Wrong::of(list, received, "a list of tables"));
        };
        // The first group to add to a list decides where the scenario's own elements end.
        let origin = origins.0.entry(list).or_insert_with(|| GroupOrigin {
            first: all.len(),
            from: Vec::new(),
        });
        origin.from.extend((0..added.len()).map(|n| (number, n)));
        all.extend(added.iter().cloned());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expanded(text: &str) -> Result<(Table, Origins), String> {
        let mut table: Table = text.parse().unwrap();
        let origins = expand("s.toml", &mut table).map_err(|error| error.to_string())?;
        Ok((table, origins))
    }

    fn names(table: &Table, list: &str) -> Vec<String> {
        let list = table[list].as_array().unwrap().iter();
        list.map(|one| one["name"].as_str().unwrap().to_owned())
            .collect()
    }

    const TWO: &str = "[[sender]]\nname = 'own'\n[[group]]\ncount = { line = 2, hall = 2 }\n\
        spread = { 'sender.0.clock.drift-ppm' = [-30, 30] }\n[[group.sender]]\nname = 'h{hall}-l{line}'\n\
        [[group.sender]]\nname = 'x{line}{hall}{other}'\n[[group]]\ncount = 3\n[[group.receiver]]\nname = 'r-{n}'\n\
        far = [{ node = 'x1{n}' }]\n";

    #[test]
    fn a_group_is_written_out_with_its_numbers() {
        let (table, _) = expanded(TWO).unwrap();
        assert!(table.get("group").is_none());
        let all = [
            "own",
            "h1-l1",
            "x11{other}",
            "h1-l2",
            "x21{other}",
            "h2-l1",
            "x12{other}",
            "h2-l2",
            "x22{other}",
        ];
        assert_eq!(names(&table, "sender"), all);
        assert_eq!(names(&table, "receiver"), ["r-1", "r-2", "r-3"]);
        let far = &table["receiver"][1]["far"][0]["node"];
        assert_eq!(far.as_str(), Some("x12"));
        let drift = |n: usize| {
            let drift = &table["sender"][n]["clock"]["drift-ppm"];
            drift.as_float().or(drift.as_integer().map(|n| n as f64))
        };
        assert_eq!(
            [1, 3, 5, 7].map(drift),
            [-30.0, -10.0, 10.0, 30.0].map(Some)
        );
    }

    #[test]
    fn fields_are_called_as_the_file_has_them() {
        let (_, origins) = expanded(TWO).unwrap();
        for (field, called) in [
            ("sender[0].name", None),
            (
                "sender[8].axis[0].id",
                Some("group[0].sender[1].axis[0].id"),
            ),
            ("receiver[2]", Some("group[1].receiver[0]")),
            ("receiver[3]", None),
            ("network", None),
        ] {
            assert_eq!(origins.called(field).as_deref(), called);
        }
    }

    #[test]
    fn what_is_wrong_with_a_group_is_told() {
        for (text, expected) in [
            ("[[group]]\n", "s.toml: group[0].count: missing"),
            (
                "[[group]]\ncount = 0",
                "group[0].count: received 0, expected 1 to 1000",
            ),
            (
                "[[group]]\ncount = 'x'",
                "group[0].count: expected a whole number",
            ),
            (
                "[[group]]\ncount = 1001",
                "received 1001, expected 1 to 1000",
            ),
            ("[[group]]\ncount = {}", "received 0, expected 1 to 1000"),
            (
                "[[group]]\ncount = { a = 40000, b = 400000 }",
                "received 16000000000, expected 1 to 1000",
            ),
            (
                "[[group]]\ncount = 2\nrouters = 3",
                "group[0].routers: unknown field `routers`, expected one of: count, spread, router",
            ),
            (
                "[[group]]\ncount = 2\nsender = 3",
                "group[0].sender: received a value of type integer, expected a list",
            ),
            (
                "[[group]]\ncount = 2\nspread = { 'sender.0.x' = [1, 2] }\n",
                "group[0].spread: ",
            ),
        ] {
            let error = expanded(text).map(|_| ()).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        let long = format!(
            "[[group]]\ncount = 1000\n[[group.event]]\nx = '{}'",
            "x".repeat(20_000)
        );
        let error = expanded(&long).map(|_| ()).unwrap_err();
        assert!(error.contains("expected at most 16777216"), "{error}");
    }
}
