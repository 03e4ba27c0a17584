//! `limits` of a far axis.

use coaxle_axis::guard;
use coaxle_curve::profile::Limits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Limits kept by the corrected set values of a far axis, by the differences of their positions,
/// independent of its node and the network.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "InFile", into = "InFile")]
pub struct FarLimits(Limits);

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct InFile {
    /// Highest velocity, u/s.
    velocity: f64,
    /// Highest acceleration, u/s².
    acceleration: f64,
    /// Highest deceleration, u/s²; the acceleration by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    deceleration: Option<f64>,
    /// Highest jerk, u/s³.
    jerk: f64,
}

impl FarLimits {
    /// The limits.
    #[must_use]
    pub const fn get(&self) -> &Limits {
        &self.0
    }
}

impl TryFrom<InFile> for FarLimits {
    type Error = guard::GuardRefusal;

    fn try_from(file: InFile) -> Result<Self, Self::Error> {
        let deceleration = file.deceleration.unwrap_or(file.acceleration);
        guard::limits([file.velocity, file.acceleration, deceleration, file.jerk]).map(Self)
    }
}

impl From<FarLimits> for InFile {
    fn from(FarLimits(limits): FarLimits) -> Self {
        let deceleration = limits.deceleration();
        Self {
            velocity: limits.velocity(),
            acceleration: limits.acceleration(),
            // Only where it differs, so that the default is not written.
            deceleration: (deceleration != limits.acceleration()).then_some(deceleration),
            jerk: limits.jerk(),
        }
    }
}
