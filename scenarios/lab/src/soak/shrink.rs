//! Shrinks a failing scenario as long as it fails.

use toml::{Table, Value};

/// Most runs for one failure.
// A schedule takes 0.2 s of a processor (10 h in 90 s on two): the worst failure takes 80 s.
const MOST_RUNS: u32 = 400;

/// The smallest scenario found that still fails while `goes_on` holds, with its faults.
pub(super) fn shrunk(
    text: String,
    wrong: Vec<String>,
    goes_on: &dyn Fn() -> bool,
) -> (String, Vec<String>) {
    // Text that is no TOML fails as it is.
    let Ok(mut table) = text.parse::<Table>() else {
        return (text, wrong);
    };
    let mut runs = 0;
    let mut smallest = (text, wrong);
    let mut place = 0;
    while let Some(smaller) = without(&table, place) {
        runs += 1;
        if runs > MOST_RUNS || !goes_on() {
            break;
        }
        let text = smaller.to_string();
        let wrong = super::faults_of(&text);
        if fails_alike(&smallest.1, &wrong) {
            // The next part has moved up to this place, so the place stays.
            (table, smallest) = (smaller, (text, wrong));
        } else {
            place += 1;
        }
    }
    smallest
}

/// True if a fault of an earlier kind remains, and the scenario can still be run.
fn fails_alike(before: &[String], now: &[String]) -> bool {
    let kinds = |wrong: &[String]| -> Vec<String> { wrong.iter().map(|line| kind(line)).collect() };
    let before = kinds(before);
    // Another failure, such as a scenario that can no longer be run, would lead away from the one that was found.
    kinds(now).iter().any(|kind| before.contains(kind))
}

/// Kind of a fault: its part and condition, without time and amount.
fn kind(line: &str) -> String {
    line.split(" at ").next().unwrap_or(line).to_owned()
}

/// The table without its n-th removable part; none beyond the last.
fn without(table: &Table, place: usize) -> Option<Table> {
    let mut places = Vec::new();
    // Whole receivers before their parts: a part that is gone with its receiver costs no run.
    for (list, inner, maps) in [
        ("receiver", &["slave"][..], &["faults", "clock"][..]),
        ("sender", &[][..], &["clock"][..]),
        ("event", &[][..], &[][..]),
    ] {
        for (number, value) in list_of(table, list).iter().enumerate() {
            places.push(vec![ShrinkStep::Key(list), ShrinkStep::At(number)]);
            let Some(one) = value.as_table() else {
                continue;
            };
            for name in inner {
                for at in 0..list_of(one, name).len() {
                    let path = [
                        ShrinkStep::Key(list),
                        ShrinkStep::At(number),
                        ShrinkStep::Key(name),
                        ShrinkStep::At(at),
                    ];
                    places.push(path.to_vec());
                }
            }
            // In the long form faults belong to a followed node.
            for at in 0..list_of(one, "far").len() {
                let far = [
                    ShrinkStep::Key(list),
                    ShrinkStep::At(number),
                    ShrinkStep::Key("far"),
                    ShrinkStep::At(at),
                ];
                let faults = list_of(one, "far")[at].get("faults");
                for (key, _) in faults.and_then(Value::as_table).into_iter().flatten() {
                    let mut path = far.to_vec();
                    path.push(ShrinkStep::Key("faults"));
                    path.push(ShrinkStep::Owned(key.clone()));
                    places.push(path);
                }
            }
            for name in maps {
                let keys = one.get(*name).and_then(Value::as_table).into_iter();
                // Without a drift there are no beats, and TS5066 has nothing to synchronise by.
                for (key, _) in keys.flatten().filter(|(key, _)| *key != "drift-ppm") {
                    let path = [
                        ShrinkStep::Key(list),
                        ShrinkStep::At(number),
                        ShrinkStep::Key(name),
                    ];
                    let mut path = path.to_vec();
                    path.push(ShrinkStep::Owned(key.clone()));
                    places.push(path);
                }
            }
        }
    }
    let path = places.get(place)?;
    let mut smaller = Value::Table(table.clone());
    remove(&mut smaller, path);
    match smaller {
        Value::Table(table) => Some(table),
        _ => None,
    }
}

#[derive(Clone, Debug)]
enum ShrinkStep {
    Key(&'static str),
    Owned(String),
    At(usize),
}

fn list_of<'a>(table: &'a Table, name: &str) -> &'a [Value] {
    let list = table.get(name).and_then(Value::as_array);
    list.map_or(&[], Vec::as_slice)
}

fn remove(value: &mut Value, path: &[ShrinkStep]) {
    let Some((first, rest)) = path.split_first() else {
        return;
    };
    let key = match first {
        ShrinkStep::Key(key) => key,
        ShrinkStep::Owned(key) => key.as_str(),
        ShrinkStep::At(number) => {
            let Some(list) = value.as_array_mut() else {
                return;
            };
            if rest.is_empty() {
                list.remove(*number);
            } else {
                remove(&mut list[*number], rest);
            }
            return;
        }
    };
    let Some(table) = value.as_table_mut() else {
        return;
    };
    if rest.is_empty() {
        table.remove(key);
    } else if let Some(inner) = table.get_mut(key) {
        remove(inner, rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_that_can_be_left_out_is_tried_once() {
        let table: Table = "duration-s = 3\n\
             [[sender]]\nname = 's'\nclock = { drift-ppm = 3, start-phase-us = 1 }\n\
             [[receiver]]\nname = 'r'\nfaults = { loss = 0.5 }\n\
             [[receiver.far]]\nnode = 's'\nfaults = { reorder = 0.5 }\n\
             [[receiver.slave]]\nname = 'a'\n[[receiver.slave]]\nname = 'b'\n\
             [[event]]\nat-s = 1\n[[event]]\nat-s = 2\n"
            .parse()
            .unwrap();
        let smaller: Vec<_> = (0..).map_while(|place| without(&table, place)).collect();
        // A receiver, its two slaves and its two faults; a sender and its phase, not its drift; two events.
        assert_eq!(smaller.len(), 9);
        for one in &smaller {
            assert_ne!(*one, table);
        }
        assert_eq!(list_of(&smaller[0], "receiver").len(), 0);
        assert_eq!(list_of(&smaller[8], "event").len(), 1);
    }

    #[test]
    fn the_same_failure_at_another_time_is_the_same() {
        let before = ["a.b.jerk at 3.1 s, cycle 3100, is 7, expected at most 5".to_owned()];
        let later = ["a.b.jerk at 9.5 s, cycle 9500, is 6, expected at most 5".to_owned()];
        let other = ["a.b.velocity at 9.5 s, cycle 9500, is 6, expected at most 5".to_owned()];
        assert!(fails_alike(&before, &later));
        assert!(!fails_alike(&before, &other));
        assert!(!fails_alike(
            &before,
            &["schedule.toml: no sender".to_owned()]
        ));
    }
}
