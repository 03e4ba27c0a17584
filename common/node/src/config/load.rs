//! Reading a config file.

use std::path::Path;

use coaxle_wire::document::Misread;
use schemars::{JsonSchema, Schema};
use serde::de::DeserializeOwned;

use super::document::{document_of, document_of_table};
use super::schema::{compare, schema_of};
use super::{ConfigError, check_kind};
use crate::text_file::{self, MOST_CONFIG_BYTES};

/// Reads a config file.
///
/// # Errors
/// [`ConfigError`], naming the file and the field.
pub fn load<T: DeserializeOwned + JsonSchema>(path: &Path) -> Result<T, ConfigError> {
    let text = text_file::read(path, MOST_CONFIG_BYTES)?;
    parse(&path.display().to_string(), &text)
}

/// Reads a config from text; `file` is its name in errors.
///
/// # Errors
/// [`ConfigError`], naming the file and the field.
pub fn parse<T: DeserializeOwned + JsonSchema>(file: &str, text: &str) -> Result<T, ConfigError> {
    let read = from_table(file, parse_table(file, text)?);
    read.map_err(|error| error.in_text(file, text))
}

/// Reads a table from text, with errors of one line; `file` is its name in errors.
///
/// # Errors
/// [`ConfigError`] with the line and the column.
pub fn parse_table(file: &str, text: &str) -> Result<toml::Table, ConfigError> {
    text.parse()
        .map_err(|error| ConfigError::syntax(file, text, &error))
}

/// Reads a config from a table, for example one with some values overridden.
/// [`ConfigError::in_text`] adds lines to its errors.
///
/// # Errors
/// [`ConfigError`], naming the file and the field.
pub fn from_table<T: DeserializeOwned + JsonSchema>(
    file: &str,
    table: toml::Table,
) -> Result<T, ConfigError> {
    T::deserialize(&document_of_table(&table)).map_err(|misread| {
        // Nine unknown fields say less than that it is a sender's config.
        check_kind(file, &schema_of::<T>(), &table)
            .err()
            .unwrap_or_else(|| error_in_part(file, "", &misread, &table, schema_of::<T>))
    })
}

/// Reads an element that is a value of its own, such as one of several forms in a list.
///
/// # Errors
/// [`Misread`] with the field of the element.
pub fn from_value<T: DeserializeOwned>(value: &toml::Value) -> Result<T, Misread> {
    T::deserialize(&document_of(value))
}

/// The error of the part of a whole document that is at `path`. It names all fields that are missing or unknown in the whole.
pub(crate) fn error_in_part(
    file: &str,
    path: &str,
    misread: &Misread,
    whole: &toml::Table,
    schema_of_whole: fn() -> Schema,
) -> ConfigError {
    let field = match (path, misread.field().as_str()) {
        // The path of the part itself.
        (path, ".") => path.to_owned(),
        ("", field) => field.to_owned(),
        (path, field) => format!("{path}.{field}"),
    };
    // Only after an error: a comparison with the schema costs more than reading.
    let findings = compare(schema_of_whole().as_value(), whole);
    ConfigError::read(file, &field, misread.reason(), findings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ClockConfig, LinkConfig};

    fn refusal<T: DeserializeOwned + JsonSchema + std::fmt::Debug>(text: &str) -> String {
        parse::<T>("test.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_field_is_named_with_the_known_ones() {
        let message = refusal::<ClockConfig>("drift = 3.0");
        assert!(message.starts_with("test.toml:"), "{message}");
        assert!(message.contains("`drift`"), "{message}");
        assert!(message.contains("drift-ppm"), "{message}");
    }

    #[test]
    fn a_value_out_of_range_says_what_came_and_what_fits() {
        let message = refusal::<LinkConfig>("loss = 1.5");
        assert_eq!(
            message,
            "test.toml:1:8: loss: received 1.5, expected a number from 0 to 1"
        );
        let nested = refusal::<LinkConfig>("[[partitions]]\nat-s = 1\nfor-s = -2");
        assert_eq!(
            nested,
            "test.toml:3:9: partitions[0].for-s: received -2, expected a number from 0 to 1000000000"
        );
    }

    #[test]
    fn no_fault_is_beyond_what_a_machine_can_have() {
        for clock in [
            // Beyond each range by a decade or more: no slip of a digit.
            "drift-ppm = 1e308",
            "drift-ppm = -2e6",
            "random-walk-ppm = 1e4",
            "start-phase-us = 1e10",
            "sine = { amplitude-ppm = 1e6, period-s = 1 }",
            "sine = { amplitude-ppm = 1, period-s = 1e-300 }",
            "steps = [{ at-s = 1e12, drift-ppm = 1 }]",
            "steps = [{ at-s = 1, phase-us = 1e300 }]",
            "jitter = { normal-us = 1e9 }",
        ] {
            let message = refusal::<ClockConfig>(clock);
            assert!(message.contains("expected a number from"), "{message}");
        }
        for link in [
            "latency-us = 1e300",
            "jitter = { exponential-us = nan }",
            "spikes = { share = 2, from-us = 1, to-us = 2 }",
            "reorder-us = 1e18",
            "delay-steps = [{ at-s = 1, by-us = -1e300 }]",
            "partitions = [{ at-s = 1, for-s = 1e300 }]",
            "faults-until-s = -1",
        ] {
            let message = refusal::<LinkConfig>(link);
            assert!(message.contains("expected a number from"), "{message}");
        }
    }

    #[test]
    fn a_first_count_is_one_that_far_time_holds() {
        let clock: ClockConfig = parse("t", "first-count = 40000000000").unwrap();
        // The limit itself is allowed.
        assert_eq!(clock.first_count.get(), 40_000_000_000);
        for (count, expected) in [
            (
                "40000000001",
                "received 40000000001, expected a count of at most 40000000000",
            ),
            ("-1", "received -1, expected a whole number of at least 0"),
        ] {
            let message = refusal::<ClockConfig>(&format!("first-count = {count}"));
            assert_eq!(message, format!("test.toml:1:15: first-count: {expected}"));
        }
    }

    #[test]
    fn a_decimal_comma_is_understood() {
        for text in [
            "loss = 0,25",
            "spikes = { share = 0,25 }",
            "loss = 0,25\nseed = 3",
        ] {
            let message = refusal::<LinkConfig>(text);
            assert!(message.ends_with("; did you mean 0.25?"), "{message}");
        }
        // Lists, two values, no digits, and a blank behind the comma: no decimal commas.
        for text in ["a = [1,2", "loss = 1 2", "loss = , 1", "loss = 1, 2"] {
            let message = refusal::<LinkConfig>(text);
            assert!(!message.contains("did you mean"), "{message}");
        }
    }

    #[test]
    fn broken_toml_says_where() {
        // Column 8: the second equals sign.
        let message = refusal::<LinkConfig>("loss = = 1");
        assert!(
            message.starts_with("test.toml:1:8: is not valid TOML: "),
            "{message}"
        );
    }
}
