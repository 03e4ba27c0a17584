//! The list of outputs, with a clear error for older configs with a single one.

use std::fmt;

use coaxle_node::config::Wrong;
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::OutputConfig;

pub(super) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<OutputConfig>, D::Error> {
    // Any kind: a table is what older configs have, and gets the text of `visit_map`.
    deserializer.deserialize_any(OutputsVisitor)
}

struct OutputsVisitor;

impl<'de> Visitor<'de> for OutputsVisitor {
    type Value = Vec<OutputConfig>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list, each with its own [[output]]")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, outputs: A) -> Result<Self::Value, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(outputs))
    }

    fn visit_map<A: MapAccess<'de>>(self, _: A) -> Result<Self::Value, A::Error> {
        let expected = "a list: [[output]], and [[output.axis]] for its axes as before";
        let wrong = Wrong::value("one table [output]", expected);
        Err(A::Error::custom(wrong))
    }
}
