//! `axes` of a far node: `[1, 2]`, `["1-32"]`, `[{ id = 3, name = "belt", unit = "mm", encoder = { … } }]`, in any
//! mixture.

use coaxle_axis::Modulo;
use coaxle_node::config::{Unit, Wrong, from_value};
use coaxle_node::frame::MAX_AXES;
use coaxle_node::keys::NodeName;
use coaxle_remote::EncoderParameters;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Value;

use super::far_limits::FarLimits;
use super::positions::Positions;

/// A followed axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "FarAxis")]
pub struct FarAxisConfig {
    /// Axis id.
    pub id: u32,
    /// Name in this node; node and id by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<NodeName>,
    /// Unit of its position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Length of its modulo period, u.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modulo: Option<Modulo>,
    /// Count of its set position: continuous or within the modulo period.
    #[serde(default, skip_serializing_if = "Positions::is_default")]
    pub position: Positions,
    /// Smoothing of the increments of an encoder axis; given if the axis is only measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoder: Option<EncoderParameters>,
    /// Limits kept by its corrected set values. No limits by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<FarLimits>,
}

impl FarAxisConfig {
    /// True if it moves as its node plans it: an axis that is smoothed here, or whose positions begin again with each turn,
    /// does not.
    #[must_use]
    pub fn uses_plans(&self) -> bool {
        self.encoder.is_none() && self.position != Positions::WithinTurn
    }

    /// Creates the axis with an id and defaults.
    #[must_use]
    pub const fn with_id(id: u32) -> Self {
        Self {
            id,
            name: None,
            unit: None,
            modulo: None,
            position: Positions::Continuous,
            encoder: None,
            limits: None,
        }
    }
}

/// The followed axes of a far node, at least one, without duplicates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<Value>", into = "Vec<Value>")]
#[schemars(with = "Vec<AxesInFile>", inline, extend("minItems" = 1))]
pub struct AxisList(Vec<FarAxisConfig>);

impl AxisList {
    /// # Errors
    /// [`Wrong`]: no axis, too many of them, or one twice.
    pub fn new(axes: Vec<FarAxisConfig>) -> Result<Self, Wrong> {
        if axes.is_empty() {
            return Err(Wrong::value("no axis", "at least one"));
        }
        if axes.len() > MAX_AXES {
            let received = format!("{} axes", axes.len());
            let expected = format!("at most {MAX_AXES}: a frame holds no more");
            return Err(Wrong::value(received, expected));
        }
        // Quadratic in at most 128 axes, without a set beside them.
        for (n, axis) in axes.iter().enumerate() {
            if axes[..n].iter().any(|other| other.id == axis.id) {
                let received = format!("the id {} twice", axis.id);
                return Err(Wrong::value(received, "each once"));
            }
        }
        Ok(Self(axes))
    }

    /// A list of a single axis.
    #[must_use]
    pub fn one(axis: FarAxisConfig) -> Self {
        Self(vec![axis])
    }

    /// The axes, in list order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &FarAxisConfig> {
        self.0.iter()
    }

    /// Sets the unit of the n-th axis, unless it has one.
    pub(crate) fn set_default_unit(&mut self, n: usize, unit: Unit) {
        self.0[n].unit.get_or_insert(unit);
    }

    /// Number of axes.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.0.len()
    }

    /// Ids of the axes, in list order.
    #[must_use]
    pub fn ids(&self) -> Vec<u32> {
        self.iter().map(|axis| axis.id).collect()
    }
}

impl Default for AxisList {
    fn default() -> Self {
        Self::one(FarAxisConfig::with_id(1))
    }
}

/// An element of the list, for the schema.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "it is read by hand, for better errors")]
#[schemars(rename = "FarAxes")]
enum AxesInFile {
    /// An axis id.
    Id(u32),
    /// A range of ids: "1-32".
    Range(#[schemars(regex(pattern = "^ *[0-9]+ *- *[0-9]+ *$"))] String),
    /// An axis id with further fields.
    Described(FarAxisConfig),
}

impl TryFrom<Vec<Value>> for AxisList {
    type Error = Wrong;
    fn try_from(entries: Vec<Value>) -> Result<Self, Wrong> {
        let mut axes = Vec::new();
        for entry in entries {
            let received = entry.to_string();
            let wrong = |reason| {
                let expected = "an id, a range such as \"1-32\", or { id = 1, name = \"belt\" }";
                Wrong::value(received, format_args!("{expected}{reason}"))
            };
            axes.extend(axes_of(entry).map_err(wrong)?);
            // Refused in any case: reading on could only fill the memory.
            if axes.len() > 2 * MAX_AXES {
                break;
            }
        }
        Self::new(axes)
    }
}

/// The axes of an entry; otherwise a further reason, or an empty text.
fn axes_of(entry: Value) -> Result<Vec<FarAxisConfig>, String> {
    match entry {
        described @ Value::Table(_) => match from_value(&described) {
            Ok(axis) => Ok(vec![axis]),
            Err(misread) => Err(format!(": {}", misread.reason())),
        },
        entry => ids_of(entry).ok_or_else(String::new),
    }
}

fn ids_of(entry: Value) -> Option<Vec<FarAxisConfig>> {
    match entry {
        Value::Integer(id) => Some(vec![FarAxisConfig::with_id(u32::try_from(id).ok()?)]),
        Value::String(range) => {
            let (first, last) = range.split_once('-')?;
            let (first, last): (u32, u32) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
            // Ids beyond any valid list are not enumerated.
            let last = last.min(first.saturating_add(2 * MAX_AXES as u32));
            // A range that runs backwards would be an empty list.
            (first <= last).then(|| (first..=last).map(FarAxisConfig::with_id).collect())
        }
        _ => None,
    }
}

impl From<AxisList> for Vec<Value> {
    fn from(axes: AxisList) -> Self {
        let entry = |axis: FarAxisConfig| {
            let id = Value::Integer(axis.id.into());
            match axis == FarAxisConfig::with_id(axis.id) {
                // Written back as short as it may have been read.
                true => id,
                // Every field of an axis exists in TOML.
                false => Value::try_from(axis).unwrap_or(id),
            }
        };
        axes.0.into_iter().map(entry).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Serialize, Deserialize, schemars::JsonSchema)]
    struct Axes {
        axes: AxisList,
    }

    fn axes(text: &str) -> Result<AxisList, String> {
        let axes = coaxle_node::config::parse::<Axes>("f", &format!("axes = {text}"));
        axes.map(|axes| axes.axes)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn ids_ranges_and_names_mix() {
        let text = "[7, \"1-3\", { id = 5, name = \"belt\" }, { id = 9, unit = \"mm\", modulo = 600, position = \"within-turn\" }, \
            { id = 11, encoder = { increment = 0.05, smoothing = 0.02 } }]";
        let list = axes(text).unwrap();
        assert_eq!(list.ids(), [7, 1, 2, 3, 5, 9, 11]);
        let units: Vec<_> = list.iter().filter_map(|axis| axis.unit.clone()).collect();
        assert_eq!(units, [Unit::new("mm").unwrap()]);
        let turns: Vec<_> = list.iter().filter_map(|axis| axis.modulo).collect();
        assert_eq!(turns, [Modulo::new(600.0).unwrap()]);
        let names: Vec<_> = list.iter().filter_map(|axis| axis.name.clone()).collect();
        assert_eq!(names, [NodeName::new("belt").unwrap()]);
        let written = toml::to_string(&Axes { axes: list.clone() }).unwrap();
        assert_eq!(
            coaxle_node::config::parse::<Axes>("f", &written)
                .unwrap()
                .axes,
            list
        );
    }

    #[test]
    fn lists_that_cannot_be_followed_are_refused() {
        for (text, expected) in [
            ("[]", "received no axis, expected at least one"),
            (
                "[1, \"1-2\"]",
                "received the id 1 twice, expected each once",
            ),
            (
                "[\"1-129\"]",
                "received 129 axes, expected at most 128: a frame holds no more",
            ),
            ("[-1]", "received -1, expected an id, a range"),
            ("[\"belt\"]", "received \"belt\", expected an id, a range"),
            ("[{ id = 1, nam = \"x\" }]", "expected an id, a range"),
            ("[{ id = 1, nam = \"x\" }]", "unknown field `nam`"),
            (
                "[{ id = 1, modulo = 0 }]",
                "received 0, expected a finite number above 0",
            ),
            (
                "[{ id = 1, encoder = { increments = 1 } }]",
                "unknown field `increments`, expected one of `increment`",
            ),
            (
                "[{ id = 1, encoder = { increment = 1, smoothing = \"some\" } }]",
                "\"auto\" or a time in seconds",
            ),
        ] {
            let error = axes(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
        assert!(axes("[\"0-4294967295\"]").is_err());
    }
}
