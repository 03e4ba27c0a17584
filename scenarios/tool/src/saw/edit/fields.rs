//! The numbers of a saw file that the page moves.

use toml_edit::DocumentMut;

use serde_json::{Value, json};

/// Unit of a number.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Measure {
    Position,
    Velocity,
    Acceleration,
    Jerk,
    Plain,
}

/// A number of the file.
struct SawField {
    path: &'static str,
    label: &'static str,
    measure: Measure,
    /// True if values below zero are allowed.
    is_signed: bool,
    /// True if the field may be left out.
    is_optional: bool,
}

const fn field(
    path: &'static str,
    label: &'static str,
    measure: Measure,
    is_signed: bool,
    is_optional: bool,
) -> SawField {
    SawField {
        path,
        label,
        measure,
        is_signed,
        is_optional,
    }
}

/// Fields outside of the command.
const MOMENT: [SawField; 11] = [
    field(
        "master.position",
        "Master is at",
        Measure::Position,
        true,
        false,
    ),
    field(
        "master.velocity",
        "Master velocity",
        Measure::Velocity,
        true,
        false,
    ),
    field(
        "slave.position",
        "Slave is at",
        Measure::Position,
        true,
        false,
    ),
    field(
        "slave.velocity",
        "Slave velocity",
        Measure::Velocity,
        true,
        false,
    ),
    field(
        "axis.velocity",
        "Axis: highest velocity",
        Measure::Velocity,
        false,
        false,
    ),
    field(
        "axis.acceleration",
        "Axis: acceleration",
        Measure::Acceleration,
        false,
        false,
    ),
    field(
        "axis.deceleration",
        "Axis: deceleration",
        Measure::Acceleration,
        false,
        true,
    ),
    field("axis.jerk", "Axis: jerk", Measure::Jerk, false, false),
    field(
        "axis.min-position",
        "Axis: lower limit",
        Measure::Position,
        true,
        true,
    ),
    field(
        "axis.max-position",
        "Axis: upper limit",
        Measure::Position,
        true,
        true,
    ),
    field(
        "angle-degrees",
        "Angle of the saw, °",
        Measure::Plain,
        true,
        true,
    ),
];

/// Fields of either command, behind its name.
const COMMAND: [SawField; 7] = [
    field("ratio.numerator", "Ratio", Measure::Plain, true, false),
    field(
        "limits.velocity",
        "Command: highest velocity",
        Measure::Velocity,
        false,
        true,
    ),
    field(
        "limits.acceleration",
        "Command: acceleration",
        Measure::Acceleration,
        false,
        true,
    ),
    field(
        "limits.deceleration",
        "Command: deceleration",
        Measure::Acceleration,
        false,
        true,
    ),
    field("limits.jerk", "Command: jerk", Measure::Jerk, false, true),
    field(
        "limits.min-position",
        "Command: lower limit",
        Measure::Position,
        true,
        true,
    ),
    field(
        "limits.max-position",
        "Command: upper limit",
        Measure::Position,
        true,
        true,
    ),
];

/// Fields of a synchronisation to positions.
const TO_POSITIONS: [SawField; 3] = [
    field(
        "master-sync-position",
        "Synchronous: master at",
        Measure::Position,
        true,
        false,
    ),
    field(
        "slave-sync-position",
        "Synchronous: slave at",
        Measure::Position,
        true,
        false,
    ),
    field(
        "master-start-distance",
        "Start distance",
        Measure::Position,
        false,
        true,
    ),
];

/// Fields that are no numbers.
const WORDS: [&str; 3] = ["title", "master-unit", "slave-unit"];
const COMMAND_WORDS: [&str; 3] = ["sync-mode.mask", "sync-mode.base", "strategy"];
const COMMANDS: [&str; 2] = ["gear-in-pos", "gear-in-velo"];

/// True if the page may change the field.
pub(super) fn is_known(path: &str) -> bool {
    let in_command = COMMANDS
        .iter()
        .find_map(|command| path.strip_prefix(command)?.strip_prefix('.'));
    match in_command {
        // Fields of both commands are known under either: a field that does not fit is refused with the file.
        Some(rest) => {
            let mut fields = COMMAND.iter().chain(&TO_POSITIONS);
            fields.any(|field| field.path == rest) || COMMAND_WORDS.contains(&rest)
        }
        None => MOMENT.iter().any(|field| field.path == path) || WORDS.contains(&path),
    }
}

/// Every field with its value and the range of its slider.
pub(super) fn sliders(document: &DocumentMut, command: &str) -> Value {
    // A synchronisation to a velocity has no place to be at.
    let to_positions: &[SawField] = if command == "gear-in-pos" {
        &TO_POSITIONS
    } else {
        &[]
    };
    let of_command = COMMAND.iter().chain(to_positions);
    let of_command = of_command.map(|field| (format!("{command}.{}", field.path), field));
    let all = MOMENT
        .iter()
        .map(|field| (field.path.to_owned(), field))
        .chain(of_command);
    let all: Vec<_> = all
        .map(|(path, field)| {
            let value = value_at(document, &path);
            (path, field, value)
        })
        .collect();
    let sliders = all.iter().map(|(path, field, value)| {
        // A field that is missing or zero takes the largest range of its measure.
        let alike = all
            .iter()
            .filter(|(_, other, _)| other.measure == field.measure);
        let largest = alike
            .filter_map(|(_, _, value)| *value)
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        let own = value.unwrap_or_default().abs();
        // Positions share a range: a slider that is at 1 of 500 would otherwise be as long as one at 500.
        let reach = nice(if own > 0.0 && field.measure != Measure::Position {
            own
        } else {
            // With all of them 0 or missing, a range is still needed.
            largest.max(1.0)
        });
        let least = if field.is_signed { -reach } else { 0.0 };
        json!({
            "path": path,
            "label": field.label,
            "value": value,
            "least": least,
            "most": reach,
            // Finer than the pixels of a slider.
            "step": reach / 500.0,
            "is_optional": field.is_optional,
            "is_above_zero": !field.is_signed,
        })
    });
    sliders.collect()
}

fn value_at(document: &DocumentMut, path: &str) -> Option<f64> {
    let mut item = document.as_item();
    for name in path.split('.') {
        item = item.get(name)?;
    }
    item.as_float()
        // People write `500` as well as `500.0`.
        .or_else(|| item.as_integer().map(|whole| whole as f64))
}

/// Twice as much, up to 1, 2 or 5 times a power of ten.
fn nice(value: f64) -> f64 {
    let wanted = 2.0 * value;
    let power = 10_f64.powf(wanted.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        // 10 always is enough, except for rounding in `log10`, which `unwrap_or` covers.
        .find(|factor| factor * power >= wanted);
    factor.unwrap_or(10.0) * power
}
