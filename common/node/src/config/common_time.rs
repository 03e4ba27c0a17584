//! A clock that several PCs have in common.

use std::fmt;

use coaxle_clock::Span;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checked::{ChangeMicros, CommonBoundMicros, FaultMicros, FaultSeconds, Ppm};
use super::list::at_most;
use super::wrong::Wrong;

/// Clock that this PC has in common with others: International Atomic Time as the operating system keeps it (`CLOCK_TAI`),
/// disciplined by PTP or by another service.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "CommonTimeForm", into = "CommonTimeForm")]
pub struct CommonTimeConfig {
    /// Source of the grandmaster's identity.
    pub stated_by: StatedBy,
    /// Greatest error of the clock against the grandmaster, beside what the service reports.
    pub bound_us: CommonBoundMicros,
}

/// Source of the grandmaster's identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatedBy {
    /// The PTP service of this PC, while it runs.
    Service,
    /// The config.
    Config(GrandmasterId),
}

/// A common time as written.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "CommonTime")]
struct CommonTimeForm {
    /// Source of the grandmaster's identity and of the error: `auto` asks the PTP service of this PC (`ptp4l`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ptp: Option<PtpSource>,
    /// Identity of the grandmaster where another service keeps the clock: 8 bytes in hexadecimal digits, such as
    /// `00:1b:21:ff:fe:3c:04:e5`. Only nodes with the same one have a time in common.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    grandmaster: Option<GrandmasterId>,
    /// Greatest error of the clock against the grandmaster, µs, beside what the service reports. 1 by default.
    #[serde(default)]
    bound_us: CommonBoundMicros,
}

/// Service that knows the state of a common time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum PtpSource {
    /// The PTP service of this PC.
    Auto,
}

impl TryFrom<CommonTimeForm> for CommonTimeConfig {
    type Error = Wrong;

    fn try_from(form: CommonTimeForm) -> Result<Self, Wrong> {
        let expected = "either ptp = \"auto\" or the identity of a grandmaster";
        let stated_by = match (form.ptp, form.grandmaster) {
            (Some(PtpSource::Auto), None) => StatedBy::Service,
            (None, Some(grandmaster)) => StatedBy::Config(grandmaster),
            (None, None) => return Err(Wrong::value("none of both", expected)),
            (Some(_), Some(_)) => return Err(Wrong::value("both", expected)),
        };
        Ok(Self {
            stated_by,
            bound_us: form.bound_us,
        })
    }
}

impl From<CommonTimeConfig> for CommonTimeForm {
    fn from(config: CommonTimeConfig) -> Self {
        let (ptp, grandmaster) = match config.stated_by {
            StatedBy::Service => (Some(PtpSource::Auto), None),
            StatedBy::Config(grandmaster) => (None, Some(grandmaster)),
        };
        Self {
            ptp,
            grandmaster,
            bound_us: config.bound_us,
        }
    }
}

/// Identity of a grandmaster: 8 bytes, as in IEEE 1588.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String")]
pub struct GrandmasterId(u64);

impl GrandmasterId {
    /// The identity as a number, most significant byte first.
    #[must_use]
    pub const fn number(self) -> u64 {
        self.0
    }
}

impl From<u64> for GrandmasterId {
    fn from(number: u64) -> Self {
        Self(number)
    }
}

impl fmt::Display for GrandmasterId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, byte) in self.0.to_be_bytes().iter().enumerate() {
            let colon = if n == 0 { "" } else { ":" };
            write!(f, "{colon}{byte:02x}")?;
        }
        Ok(())
    }
}

impl From<GrandmasterId> for String {
    fn from(id: GrandmasterId) -> Self {
        id.to_string()
    }
}

impl TryFrom<String> for GrandmasterId {
    type Error = Wrong;

    fn try_from(text: String) -> Result<Self, Wrong> {
        // ptp4l writes it as 001b21.fffe.3c04e5, most others with a colon or a dash between bytes.
        let digits: String = text.chars().filter(|c| !":.-".contains(*c)).collect();
        let is_right = digits.len() == 16 && digits.chars().all(|c| c.is_ascii_hexdigit());
        let number = u64::from_str_radix(&digits, 16).ok();
        number.filter(|_| is_right).map(Self).ok_or_else(|| {
            let expected = "8 bytes in hexadecimal digits, such as 00:1b:21:ff:fe:3c:04:e5";
            Wrong::value(format!("{text:?}"), expected)
        })
    }
}

/// Most changes of a common time.
const MOST_CHANGES: usize = 32;

/// Faults injected into the common time that a node reads. None by default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct CommonTimeFaults {
    /// Standard deviation of each reading, µs.
    pub noise_us: FaultMicros,
    /// Changes at set times.
    #[serde(
        deserialize_with = "at_most::<MOST_CHANGES, _, _>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub changes: Vec<CommonTimeChange>,
}

/// A change of the common time that a node reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CommonTimeChange {
    /// Time of the change, s after the start.
    pub at_s: FaultSeconds,
    /// Leap, µs.
    #[serde(default)]
    pub offset_us: ChangeMicros,
    /// Added drift from then on, ppm: a clock in free run.
    #[serde(default)]
    pub drift_ppm: Ppm,
    /// True if it is lost from then on, false if it is there again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost: Option<bool>,
    /// Another grandmaster from then on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grandmaster: Option<GrandmasterId>,
}

impl CommonTimeFaults {
    /// True if nothing is injected.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl Default for CommonBoundMicros {
    fn default() -> Self {
        Self::USUAL
    }
}

impl CommonBoundMicros {
    /// The bound as a span.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_secs_f64(self.get() * 1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    fn config(text: &str) -> Result<StatedBy, String> {
        let config: Result<CommonTimeConfig, _> = parse("test", text);
        let config = config.map_err(|error| error.to_string())?;
        Ok(config.stated_by)
    }

    #[test]
    fn either_the_service_or_the_config_states_the_grandmaster() {
        assert_eq!(config("ptp = 'auto'"), Ok(StatedBy::Service));
        let id = GrandmasterId::from(0x001b_21ff_fe3c_04e5);
        for text in [
            "00:1b:21:ff:fe:3c:04:e5",
            "001b21.fffe.3c04e5",
            "001B21FFFE3C04E5",
        ] {
            assert_eq!(
                config(&format!("grandmaster = '{text}'")),
                Ok(StatedBy::Config(id))
            );
        }
        assert_eq!(id.to_string(), "00:1b:21:ff:fe:3c:04:e5");
        for (text, expected) in [
            ("", "either ptp = \"auto\" or"),
            (
                "ptp = 'auto'\ngrandmaster = '001b21fffe3c04e5'",
                "either ptp = \"auto\" or",
            ),
            ("grandmaster = '1b:21'", "8 bytes in hexadecimal digits"),
            (
                "grandmaster = 'zz1b21fffe3c04e5'",
                "8 bytes in hexadecimal digits",
            ),
            ("ptp = 'auto'\nbound-us = 0", "bound-us"),
        ] {
            let error = config(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
