//! `MC_ValueSelectType` as JSON.

use coaxle_plate::ValueSelect;
use serde::{Deserialize, Serialize};

/// Selected values of the slave: their names, or the PLC's sum of their bits.
#[doc(alias = "MC_ValueSelectType")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "OnWire", into = "OnWire")]
pub struct SelectedValues(pub ValueSelect);

/// The position alone.
impl Default for SelectedValues {
    fn default() -> Self {
        Self(ValueSelect::POSITION)
    }
}

impl SelectedValues {
    /// The names of all, in the order of their bits.
    pub const NAMES: [&str; 4] = ["position", "velocity", "acceleration", "jerk"];

    /// Returns the names of the selected values.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        (0..4)
            .filter(move |bit| self.0.bits() >> bit & 1 == 1)
            .map(|bit| Self::NAMES[bit])
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for SelectedValues {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "SelectedValues".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        OnWire::json_schema(generator)
    }
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum OnWire {
    /// 1 position, 2 velocity, 4 acceleration, 8 jerk.
    Mask(u16),
    /// Names among position, velocity, acceleration and jerk.
    Names(Vec<String>),
}

impl TryFrom<OnWire> for SelectedValues {
    type Error = String;

    fn try_from(written: OnWire) -> Result<Self, String> {
        let names = match written {
            OnWire::Mask(bits) => return Ok(Self(ValueSelect::from_bits_retain(bits))),
            OnWire::Names(names) => names,
        };
        let mut selected = ValueSelect::empty();
        for name in names {
            let bit = Self::NAMES.iter().position(|known| *known == name);
            let bit = bit.ok_or_else(|| {
                format!("received {name:?}, expected position, velocity, acceleration or jerk")
            })?;
            selected |= ValueSelect::from_bits_retain(1 << bit);
        }
        Ok(Self(selected))
    }
}

impl From<SelectedValues> for OnWire {
    fn from(selected: SelectedValues) -> Self {
        if ValueSelect::all().contains(selected.0) {
            Self::Names(selected.names().map(str::to_owned).collect())
        } else {
            Self::Mask(selected.0.bits())
        }
    }
}
