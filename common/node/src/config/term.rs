//! Terms of a sum for a drift or a delay.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use super::checked::{FaultSeconds, Fraction, PeriodSeconds, Ppm};
use super::list::at_most;
use super::wrong::Wrong;

/// Most terms of a sum.
// Each is evaluated for every message, and for every 10 ms of a clock.
pub(super) const MOST_TERMS: usize = 16;

/// Limit of the sum of the drift terms, ppm. With a drift and a sine in addition a clock still runs
/// at half its rate.
const MOST_DRIFT_PPM: f64 = 300_000.0;

/// A term of a sum, over the time since the start. Its values are in the unit of its list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case",
    deny_unknown_fields,
    bound(deserialize = "V: Deserialize<'de> + Copy + Into<f64>")
)]
#[schemars(rename = "TermOf{V}")]
pub enum Term<V> {
    /// A constant value.
    Constant(V),
    /// `amplitude · sin(2π·(t/period + phase))`.
    Sine(Wave<V>),
    /// A triangle between `±amplitude`; it begins at zero, upwards.
    Triangle(Wave<V>),
    /// Rectangular: `height` for the first part of each period, otherwise zero.
    Pulse {
        /// Height of the pulse.
        height: V,
        /// Time from one pulse to the next, s.
        period_s: PeriodSeconds,
        /// The share of the period that a pulse takes.
        duty: Fraction,
        /// The share of a period that is over at the start.
        #[serde(default)]
        phase: Fraction,
    },
    /// A lasting change: at once, or evenly over a time, which makes it a ramp.
    Step {
        /// Start, s after the start of the run.
        at_s: FaultSeconds,
        /// Added value.
        by: V,
        /// Duration of the change, s.
        #[serde(default)]
        over_s: FaultSeconds,
    },
    /// Noise, uniform between two bounds.
    Uniform {
        /// The one bound.
        from: V,
        /// The other.
        to: V,
    },
    /// Noise, exponential: its mean, which may be below zero.
    Exponential(V),
    /// Noise, Gaussian around zero: its standard deviation.
    Normal(#[serde(deserialize_with = "not_negative")] V),
    /// Values of a table: CSV of two columns, seconds since the start and value. Before its first
    /// row and after its last one these hold.
    File {
        /// The table.
        path: PathBuf,
        /// Interpolation between two rows.
        #[serde(default)]
        between: Between,
    },
}

/// A periodic term around zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "WaveOf{V}")]
pub struct Wave<V> {
    /// The largest value.
    pub amplitude: V,
    /// Length of a period, s.
    pub period_s: PeriodSeconds,
    /// The share of a period that is over at the start.
    #[serde(default)]
    pub phase: Fraction,
}

/// Interpolation of a table between two rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Between {
    /// On a straight line.
    #[default]
    Linear,
    /// With the value of the row before.
    Held,
}

impl<V> Term<V> {
    /// Resolves the relative path of its file from `folder`, for example the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        if let Self::File { path, .. } = self {
            *path = folder.join(&*path);
        }
    }
}

impl Term<Ppm> {
    /// Greatest distance from zero; for noise, exceeded by two values in a thousand million.
    fn most(&self) -> f64 {
        match self {
            Self::Constant(value) => value.get().abs(),
            Self::Sine(wave) | Self::Triangle(wave) => wave.amplitude.get().abs(),
            Self::Pulse { height, .. } => height.get().abs(),
            Self::Step { by, .. } => by.get().abs(),
            Self::Uniform { from, to } => from.get().abs().max(to.get().abs()),
            // e⁻²⁰ is 2·10⁻⁹.
            Self::Exponential(mean) => 20.0 * mean.get().abs(),
            // Beyond 6 σ to either side lie 2·10⁻⁹.
            Self::Normal(sigma) => 6.0 * sigma.get(),
            // The values in the file are checked when it is read.
            Self::File { .. } => Ppm::MOST,
        }
    }
}

/// Reads terms of a drift with which a clock keeps running: for serde's `deserialize_with`.
pub(super) fn drift_terms<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<Term<Ppm>>, D::Error> {
    let terms = at_most::<MOST_TERMS, Term<Ppm>, _>(deserializer)?;
    let sum: f64 = terms.iter().map(Term::most).sum();
    if sum <= MOST_DRIFT_PPM {
        return Ok(terms);
    }
    let received = format!("terms that come to {sum} in sum");
    let expected = format!("at most {MOST_DRIFT_PPM}");
    Err(D::Error::custom(Wrong::value(received, expected)))
}

fn not_negative<'de, D, V>(deserializer: D) -> Result<V, D::Error>
where
    D: Deserializer<'de>,
    V: Deserialize<'de> + Copy + Into<f64>,
{
    let value = V::deserialize(deserializer)?;
    let number = value.into();
    // A deviation is drawn with a sign already.
    if number >= 0.0 {
        return Ok(value);
    }
    let expected = "a number of at least 0";
    Err(D::Error::custom(Wrong::value(number, expected)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ClockConfig, LinkConfig, parse};

    fn refusal<T: serde::de::DeserializeOwned + JsonSchema + std::fmt::Debug>(
        text: &str,
    ) -> String {
        parse::<T>("t.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn every_kind_survives_being_written_and_read() {
        let terms = "[
            { constant = -3 }, { sine = { amplitude = 2, period-s = 9, phase = 0.25 } },
            { triangle = { amplitude = 2, period-s = 9 } },
            { pulse = { height = 4, period-s = 3, duty = 0.1, phase = 0.5 } },
            { step = { at-s = 3, by = -5 } }, { step = { at-s = 3, by = -5, over-s = 2 } },
            { uniform = { from = -1, to = 2 } }, { exponential = 3 }, { normal = 0.5 },
            { file = { path = 'a.csv' } }, { file = { path = 'b.csv', between = 'held' } },
        ]";
        let clock: ClockConfig = parse("t", &format!("drift-terms-ppm = {terms}")).unwrap();
        let again = toml::to_string(&clock).unwrap();
        assert_eq!(parse::<ClockConfig>("t", &again).unwrap(), clock);
        let link: LinkConfig = parse("t", &format!("delay-terms-us = {terms}")).unwrap();
        let again = toml::to_string(&link).unwrap();
        assert_eq!(parse::<LinkConfig>("t", &again).unwrap(), link);
    }

    #[test]
    fn what_no_clock_has_is_refused_by_its_field() {
        for (terms, expected) in [
            (
                "[{ constant = 1 }, { sine = { amplitude = 2e5, period-s = 1 } }]",
                ": drift-terms-ppm[1].sine.amplitude: received 200000, expected a number from -100000 to 100000",
            ),
            (
                "[{ triangle = { amplitude = 1, period-s = 0 } }]",
                ": drift-terms-ppm[0].triangle.period-s: received 0, expected a number from 0.000001 to 1000000000",
            ),
            (
                "[{ pulse = { height = 1, period-s = 1, duty = 1.5 } }]",
                ": drift-terms-ppm[0].pulse.duty: received 1.5, expected a number from 0 to 1",
            ),
            (
                "[{ normal = -1 }]",
                ": drift-terms-ppm[0].normal: received -1, expected a number of at least 0",
            ),
            (
                "[{ step = { at-s = -1, by = 1 } }]",
                ": drift-terms-ppm[0].step.at-s: received -1, expected a number from 0 to 1000000000",
            ),
            (
                // 1e5 three times, and 6 · 0.5.
                "[{ constant = 1e5 }, { step = { at-s = 1, by = -1e5 } }, { constant = -1e5 }, { normal = 0.5 }]",
                ": drift-terms-ppm: received terms that come to 300003 in sum, expected at most 300000",
            ),
            (
                // 20 · 2e4.
                "[{ exponential = 2e4 }]",
                ": drift-terms-ppm: received terms that come to 400000 in sum, expected at most 300000",
            ),
        ] {
            let message = refusal::<ClockConfig>(&format!("drift-terms-ppm = {terms}"));
            assert!(
                message.starts_with("t.toml:1:") && message.ends_with(expected),
                "{message}"
            );
        }
        // A term beyond the most.
        let many = "{ constant = 1 }, ".repeat(MOST_TERMS + 1);
        for (config, list) in [
            (
                refusal::<ClockConfig>(&format!("drift-terms-ppm = [{many}]")),
                "drift-terms-ppm",
            ),
            (
                refusal::<LinkConfig>(&format!("delay-terms-us = [{many}]")),
                "delay-terms-us",
            ),
        ] {
            assert_eq!(
                config,
                format!(
                    "t.toml:1:{}: {list}: received more than 16, expected at most that many",
                    // The value begins behind ` = `, in column length + 4.
                    list.len() + 4
                )
            );
        }
    }
}
