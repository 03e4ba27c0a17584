//! A field and its values, and the points that several of them span.

use coaxle_os::exit::wrong_argument;

use crate::scenario::GridAxis;

/// A field and its values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepAxis {
    /// The path of the field, as `--set` takes it.
    pub field: String,
    /// The values, in the order they are run.
    pub values: Vec<String>,
}

impl SweepAxis {
    /// Values as numbers, if all of them are finite ones.
    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        let numbers = self.values.iter().map(|value| number(value));
        numbers.collect()
    }
}

/// The number in a value; none if it is no number, or not finite.
pub(super) fn number(value: &str) -> Option<f64> {
    // TOML allows underscores in numbers, and Rust does not.
    let number: Option<f64> = value.replace('_', "").parse().ok();
    number.filter(|number| number.is_finite())
}

impl std::str::FromStr for SweepAxis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("received {text:?}, expected path.to.field=a,b,c");
        let (field, values) = text.split_once('=').ok_or_else(expected)?;
        let values: Vec<String> = split_values(values);
        if field.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err(expected());
        }
        Ok(Self {
            field: field.trim().to_owned(),
            values,
        })
    }
}

impl From<&GridAxis> for SweepAxis {
    fn from(axis: &GridAxis) -> Self {
        Self {
            field: axis.field.clone(),
            values: axis.values.iter().map(ToString::to_string).collect(),
        }
    }
}

/// Splits at commas, but not within brackets, braces or quotes: tables and lists are values too.
fn split_values(text: &str) -> Vec<String> {
    let mut values = vec![String::new()];
    let (mut depth, mut quote) = (0_u32, None);
    for c in text.chars() {
        match (c, quote) {
            // Basic and literal strings of TOML; either may hold the other's quote.
            ('"' | '\'', None) => quote = Some(c),
            (_, Some(begun)) if c == begun => quote = None,
            ('[' | '{', None) => depth += 1,
            // A bracket too many is left to TOML, which names it.
            (']' | '}', None) => depth = depth.saturating_sub(1),
            (',', None) if depth == 0 => {
                values.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(value) = values.last_mut() {
            value.push(c);
        }
    }
    values.iter().map(|value| value.trim().to_owned()).collect()
}

/// Runs of a sweep at most, points times seeds: more is a mistake.
pub const MOST_RUNS: usize = 10_000;

/// Every combination, the last axis running fastest; each is to be run with this many seeds.
///
/// # Errors
/// Too many runs, a duplicate value or axis, or several seeds where they are an axis already.
pub(super) fn points(axes: &[SweepAxis], seeds: usize) -> anyhow::Result<Vec<Vec<String>>> {
    let runs = axes.iter().try_fold(seeds, |runs, axis| {
        // Before any point is made, and step by step: the product of long lists may not fit into a usize.
        let runs = runs.checked_mul(axis.values.len());
        runs.filter(|runs| *runs <= MOST_RUNS)
    });
    if runs.is_none_or(|runs| runs > MOST_RUNS) {
        return wrong_argument(format!(
            "sweep: received a grid of more than {MOST_RUNS} points, expected fewer values"
        ));
    }
    for (n, SweepAxis { field, values }) in axes.iter().enumerate() {
        if axes[..n].iter().any(|before| before.field == *field) {
            return wrong_argument(format!(
                "sweep: received the field {field} twice, expected each once"
            ));
        }
        // A value that comes twice would be run once and counted twice, as both share a record.
        if let Some((_, twice)) =
            (values.iter().enumerate()).find(|(n, v)| values[..*n].iter().any(|o| is_same(o, v)))
        {
            return wrong_argument(format!(
                "sweep: received {field}={twice} twice, expected each value once"
            ));
        }
        if field == SEED && seeds > 1 {
            return wrong_argument(
                "sweep: received several seeds and an axis of seeds, expected one of them",
            );
        }
    }
    let mut points = vec![Vec::new()];
    for axis in axes {
        points = points
            .iter()
            .flat_map(|point: &Vec<String>| {
                axis.values.iter().map(|value| {
                    let mut longer = point.clone();
                    longer.push(value.clone());
                    longer
                })
            })
            .collect();
    }
    Ok(points)
}

/// True if two values set a field to the same: numbers may be written in several ways.
fn is_same(one: &str, other: &str) -> bool {
    one == other || number(one).is_some_and(|one| Some(one) == number(other))
}

/// The field of a scenario that its seed is in.
pub(super) const SEED: &str = "seed";

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(texts: &[&str]) -> Vec<SweepAxis> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn values_may_be_tables() {
        let axis: SweepAxis = "network.jitter={ normal-us = 5 },{ exponential-us = [1, 2] },3"
            .parse()
            .unwrap();
        assert_eq!(
            axis.values,
            ["{ normal-us = 5 }", "{ exponential-us = [1, 2] }", "3"]
        );
        assert_eq!(axis.numbers(), None);
        let quoted: SweepAxis = r#"a='x,y',"z,'w","v""#.parse().unwrap();
        assert_eq!(quoted.values, ["'x,y'", "\"z,'w\"", "\"v\""]);
        assert!("seed".parse::<SweepAxis>().is_err());
        assert!("seed=1,,2".parse::<SweepAxis>().is_err());
    }

    #[test]
    fn numbers_are_told_from_words() {
        let numbers = |text: &str| text.parse::<SweepAxis>().unwrap().numbers();
        assert_eq!(numbers("a=-1,2.5,1_000"), Some(vec![-1.0, 2.5, 1000.0]));
        assert_eq!(numbers("a=1,inf"), None);
        assert_eq!(numbers("a=pt1,sync"), None);
    }

    #[test]
    fn the_last_axis_runs_fastest() {
        let points = points(&axes(&["a=1,2", "b=x,y"]), 3).unwrap();
        assert_eq!(points, [["1", "x"], ["1", "y"], ["2", "x"], ["2", "y"]]);
    }

    #[test]
    fn what_would_be_run_twice_or_too_often_is_refused() {
        for (texts, seeds, part) in [
            (&["a=1,2,1"][..], 1, "received a=1 twice"),
            (&["a=0.1,0.10"], 1, "received a=0.10 twice"),
            (&["a=1", "a=2"], 1, "the field a twice"),
            (&["seed=1,2"], 2, "an axis of seeds"),
            (&["a=1,2"], 5_001, "more than 10000 points"),
            (&[], 10_001, "more than 10000 points"),
        ] {
            let error = points(&axes(texts), seeds).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        assert_eq!(points(&axes(&["seed=1,2"]), 1).unwrap().len(), 2);
    }
}
