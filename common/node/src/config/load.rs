//! Reading a config file.

use std::path::Path;

use coaxle_wire::one_line;
use serde::de::DeserializeOwned;

use crate::text_file::{self, MOST_CONFIG_BYTES, Unreadable};

/// Why a config was refused, on one line: the file, the field and what is wrong with it.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file could not be read.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// The file is no TOML.
    #[error("{file}: is not valid TOML: {reason}")]
    Syntax {
        /// The file.
        file: String,
        /// Where and why.
        reason: String,
    },
    /// A field holds what it must not.
    #[error("{file}: {field}: {reason}")]
    Field {
        /// The file.
        file: String,
        /// The field, as a path.
        field: String,
        /// What was received and what is expected.
        reason: String,
    },
    /// Every field is fine, but what they describe together cannot be.
    #[error("{file}: {reason}")]
    Whole {
        /// The file.
        file: String,
        /// Which fields, what was received and what is expected.
        reason: String,
    },
}

impl ConfigError {
    /// An error of one field, found by a check of its own.
    pub fn field(file: &str, field: impl AsRef<str>, reason: impl ToString) -> Self {
        Self::Field {
            file: one_line(file),
            field: one_line(field.as_ref()),
            reason: one_line(&reason.to_string()),
        }
    }

    /// An error of the config as a whole, which names its fields itself.
    pub fn whole(file: &str, reason: impl ToString) -> Self {
        Self::Whole {
            file: one_line(file),
            reason: one_line(&reason.to_string()),
        }
    }
}

/// Reads a config file.
///
/// # Errors
/// [`ConfigError`], naming the file and the field.
pub fn load<T: DeserializeOwned>(path: &Path) -> Result<T, ConfigError> {
    let text = text_file::read(path, MOST_CONFIG_BYTES)?;
    parse(&path.display().to_string(), &text)
}

/// Reads a config from text; `file` is what the errors call it.
///
/// # Errors
/// [`ConfigError`], naming the file and the field.
pub fn parse<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, ConfigError> {
    from_table(file, parse_table(file, text)?)
}

/// Reads a table from text, with errors of one line; `file` is what they call it.
///
/// # Errors
/// [`ConfigError::Syntax`] with the line.
pub fn parse_table(file: &str, text: &str) -> Result<toml::Table, ConfigError> {
    text.parse().map_err(|error: toml::de::Error| {
        let before = error.span().and_then(|span| text.get(..span.start));
        let line = before.unwrap_or_default().lines().count().max(1);
        let message = one_line(error.message());
        ConfigError::Syntax {
            file: one_line(file),
            reason: format!("line {line}: {message}"),
        }
    })
}

/// Reads a config from a table, say one with some values overridden.
///
/// # Errors
/// [`ConfigError`], naming the file and the field.
pub fn from_table<T: DeserializeOwned>(file: &str, table: toml::Table) -> Result<T, ConfigError> {
    serde_path_to_error::deserialize(table).map_err(|error| {
        let field = error.path().to_string();
        let reason = error.into_inner().message().to_owned();
        ConfigError::field(file, field, reason.trim())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ClockConfig, LinkConfig};

    fn refusal<T: DeserializeOwned + std::fmt::Debug>(text: &str) -> String {
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
            "test.toml: loss: received 1.5, expected a number from 0 to 1"
        );
        let nested = refusal::<LinkConfig>("[[partitions]]\nat-s = 1\nfor-s = -2");
        assert_eq!(
            nested,
            "test.toml: partitions[0].for-s: received -2, expected a number from 0 to 1000000000"
        );
    }

    #[test]
    fn no_fault_is_beyond_what_a_machine_can_have() {
        for clock in [
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
        assert_eq!(clock.first_count.get(), 40_000_000_000);
        for (count, expected) in [
            (
                "40000000001",
                "received 40000000001, expected a count of at most 40000000000",
            ),
            ("-1", "invalid value: integer `-1`, expected u64"),
        ] {
            let message = refusal::<ClockConfig>(&format!("first-count = {count}"));
            assert_eq!(message, format!("test.toml: first-count: {expected}"));
        }
    }

    #[test]
    fn broken_toml_says_where() {
        let message = refusal::<LinkConfig>("loss = = 1");
        assert!(message.contains("line 1"), "{message}");
    }
}
