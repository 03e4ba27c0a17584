//! Smoothing of the counts of an encoder.

use coaxle_clock::Seconds;
use coaxle_clock::time_sync::WrongParameter;

/// The smoothing of an encoder master: in a config `"auto"`, or a time in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Smoothing {
    /// The best for the increment, the sampling time and the jerk limit.
    #[default]
    Auto,
    /// A time constant, s. At least 1/0.35 sampling times, at most 0.2 s.
    Time(Seconds),
}

/// The estimator's poles stay well below the sampling frequency, rad.
const MOST_PER_SAMPLE: f64 = 0.35;
/// Lower limit of the tracker's bandwidth too, rad/s.
pub(super) const LEAST_BANDWIDTH: f64 = 5.0;

impl Smoothing {
    /// The bandwidth, rad/s, for a noise in u²s.
    pub(super) fn bandwidth(
        self,
        sampling: f64,
        noise: f64,
        jerk_limit: f64,
    ) -> Result<f64, WrongParameter> {
        let most = MOST_PER_SAMPLE / sampling;
        match self {
            // The motion of the axis is modelled as a random jerk with a density proportional to
            // the limit: 1e4 for 1e5 u/s³. The best bandwidth for that is proportional to this
            // power of signal to noise.
            Self::Auto => {
                let best = libm::pow(0.1 * jerk_limit / libm::sqrt(noise), 2.0 / 7.0);
                // The floor comes last: at a sampling time of 0.1 s the ceiling of 3.5 rad/s is below it.
                Ok(best.min(most).max(LEAST_BANDWIDTH))
            }
            // Written so that NaN fails both comparisons and is refused.
            Self::Time(Seconds(time)) if time * most >= 1.0 && time * LEAST_BANDWIDTH <= 1.0 => {
                Ok(1.0 / time)
            }
            Self::Time(Seconds(received)) => Err(WrongParameter {
                parameter: "smoothing",
                received,
                expected: "\"auto\", or 2.86 sampling times to 0.2 s",
            }),
        }
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Smoothing {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> alloc::borrow::Cow<'static, str> {
        "Smoothing".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "\"auto\", or a time constant, s: 2.86 sampling times to 0.2 s.",
            "anyOf": [{ "const": "auto" }, { "type": "number", "exclusiveMinimum": 0, "maximum": 0.2 }],
        })
    }
}

#[cfg(feature = "serde")]
mod in_a_config {
    use core::fmt;

    use serde::de::{Error, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{Seconds, Smoothing};

    const AUTO: &str = "auto";

    impl Serialize for Smoothing {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match self {
                Self::Auto => serializer.serialize_str(AUTO),
                Self::Time(Seconds(time)) => serializer.serialize_f64(*time),
            }
        }
    }

    impl<'de> Deserialize<'de> for Smoothing {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_any(AutoOrTime)
        }
    }

    struct AutoOrTime;

    impl Visitor<'_> for AutoOrTime {
        type Value = Smoothing;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("\"auto\" or a time in seconds")
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Smoothing, E> {
            match text {
                AUTO => Ok(Smoothing::Auto),
                _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
            }
        }

        // TOML and JSON write 1 as an integer and 0.02 as a float: a time may come as any of them.
        fn visit_f64<E: Error>(self, time: f64) -> Result<Smoothing, E> {
            Ok(Smoothing::Time(Seconds(time)))
        }

        fn visit_i64<E: Error>(self, time: i64) -> Result<Smoothing, E> {
            self.visit_f64(time as f64)
        }

        fn visit_u64<E: Error>(self, time: u64) -> Result<Smoothing, E> {
            self.visit_f64(time as f64)
        }
    }
}
