//! `publish-far-axes`: the far axes that a receiver publishes as corrected.

use coaxle_node::config::Wrong;
use coaxle_node::frame::MAX_AXES;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Value;

use super::ReceiverConfig;
use super::masters::listed;

/// Far axes published as corrected: `true`, `false` (default), or a list of their names.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Value", into = "Value")]
pub enum PublishFarAxes {
    /// No far axis.
    #[default]
    No,
    /// Every far axis, numbered from 1 in the order of the config.
    All,
    /// Listed axes, numbered from 1 in this order.
    These(Vec<String>),
}

impl PublishFarAxes {
    /// True if no far axis is published.
    #[must_use]
    pub const fn is_none(&self) -> bool {
        matches!(self, Self::No)
    }
}

impl ReceiverConfig {
    /// The far axes published as corrected, by their numbers. The first one has the axis id 1
    /// there, the next one 2.
    #[must_use]
    pub fn published_far_axes(&self) -> Vec<usize> {
        match &self.publish_far_axes {
            PublishFarAxes::No => Vec::new(),
            PublishFarAxes::All => (0..self.far_axes().count()).collect(),
            PublishFarAxes::These(names) => {
                let number = |name: &String| self.far_axis_called(name);
                // Unknown names are refused before anything uses this list.
                names.iter().filter_map(number).collect()
            }
        }
    }

    pub(super) fn check_published(&self) -> Result<(), Wrong> {
        const FIELD: &str = "publish-far-axes";
        let axes = self.published_far_axes();
        // Checked for every form: with `true` a receiver of many nodes may have more axes than a frame holds.
        if axes.len() > MAX_AXES {
            let received = format!("{} far axes", axes.len());
            let expected =
                format!("at most {MAX_AXES}, which a frame holds: a list of their names");
            return Err(Wrong::of(FIELD, received, expected));
        }
        let PublishFarAxes::These(names) = &self.publish_far_axes else {
            return Ok(());
        };
        for (n, name) in names.iter().enumerate() {
            let Some(axis) = self.far_axis_called(name) else {
                let expected = format!("some of: {}", listed(name, self.far_axis_names()));
                return Err(Wrong::of(FIELD, format_args!("{name:?}"), expected));
            };
            // By numbers: a far axis may be listed by both of its names.
            if axes[..n].contains(&axis) {
                return Err(Wrong::of(
                    FIELD,
                    format_args!("{name:?} twice"),
                    "each once",
                ));
            }
        }
        Ok(())
    }
}

impl JsonSchema for PublishFarAxes {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PublishFarAxes".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "type": "boolean" },
                { "type": "array", "items": { "type": "string" } },
            ],
        })
    }
}

impl TryFrom<Value> for PublishFarAxes {
    type Error = Wrong;

    fn try_from(value: Value) -> Result<Self, Wrong> {
        let received = value.to_string();
        let wrong = || Wrong::value(received, "true, false, or a list of names of far axes");
        match value {
            Value::Boolean(true) => Ok(Self::All),
            Value::Boolean(false) => Ok(Self::No),
            names @ Value::Array(_) => Ok(Self::These(names.try_into().map_err(|_| wrong())?)),
            _ => Err(wrong()),
        }
    }
}

impl From<PublishFarAxes> for Value {
    fn from(publish: PublishFarAxes) -> Self {
        match publish {
            PublishFarAxes::No => Self::Boolean(false),
            PublishFarAxes::All => Self::Boolean(true),
            PublishFarAxes::These(names) => names.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(publish: &str) -> Result<ReceiverConfig, String> {
        let text = format!(
            "name = 'r'\ncycle-time-us = 1000\npublish-far-axes = {publish}\n[[far]]\nnode = 'a'\n\
             axes = ['1-2']\n[[far]]\nnode = 'b'\naxes = [{{ id = 2, name = 'belt' }}]"
        );
        coaxle_node::config::parse("r.toml", &text).map_err(|error| error.to_string())
    }

    #[test]
    fn all_of_them_or_some_by_name() {
        for (publish, expected) in [
            ("true", vec![0, 1, 2]),
            ("false", vec![]),
            ("['belt', 'a.1']", vec![2, 0]),
            ("['b.2']", vec![2]),
        ] {
            let config = config(publish).expect("a config");
            assert_eq!(config.published_far_axes(), expected);
            let written = toml::to_string(&config).expect("a text");
            let read = coaxle_node::config::parse::<ReceiverConfig>("r.toml", &written);
            assert_eq!(read.expect("a config"), config);
        }
    }

    #[test]
    fn what_cannot_be_published_is_refused_by_name() {
        for (publish, expected) in [
            (
                "1",
                "received 1, expected true, false, or a list of names of far axes",
            ),
            ("[1]", "received [1], expected true, false, or a list"),
            (
                "['belt', 'c.1']",
                "publish-far-axes: received \"c.1\", expected some of: a.1, a.2, belt",
            ),
            (
                "['belt', 'b.2']",
                "publish-far-axes: received \"b.2\" twice, expected each once",
            ),
        ] {
            let error = config(publish).expect_err("refused");
            assert!(error.contains(expected), "{error}");
        }
        let text = "name = 'r'\ncycle-time-us = 1000\npublish-far-axes = true\n[[far]]\nnode = 'a'\n\
                    axes = ['1-100']\n[[far]]\nnode = 'b'\naxes = ['1-100']";
        let error =
            coaxle_node::config::parse::<ReceiverConfig>("r.toml", text).expect_err("refused");
        let expected = "publish-far-axes: received 200 far axes, expected at most 128";
        assert!(error.to_string().contains(expected), "{error}");
    }
}
