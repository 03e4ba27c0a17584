//! The program of a virtual axis.

mod check;

use std::fmt;
use std::num::NonZeroU32;

use coaxle_curve::profile::Limits;
use coaxle_node::config::{AtLeastZero, AxisLimit, Coordinate, Wrong};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// Greatest depth of nested loops.
pub const MAX_LOOP_DEPTH: usize = 8;

/// Program of a virtual axis, step by step.
///
/// Steps follow each other without a gap, at the instant at which the previous one ends, whether or not
/// that is the start of a cycle. After the last step the axis stays in its state: at standstill, or at
/// constant velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Written", into = "Written")]
pub struct ProgramConfig {
    /// Position of the axis at the start, u.
    pub start_position: Coordinate,
    /// Velocity of the axis at the start, u/s. An axis that moves at the start is enabled from the start.
    pub start_velocity: Coordinate,
    /// Limits of all its motions.
    pub limits: LimitsConfig,
    /// Number of runs of the steps.
    pub repeat: Repeat,
    /// The steps. Without any, the axis keeps its start velocity.
    pub steps: Vec<StepConfig>,
}

/// Limits of all motions of a program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct LimitsConfig {
    /// Greatest speed, u/s.
    pub velocity: AxisLimit,
    /// Greatest acceleration, u/s².
    pub acceleration: AxisLimit,
    /// Greatest deceleration, u/s². Equal to the acceleration by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deceleration: Option<AxisLimit>,
    /// Greatest jerk, u/s³.
    pub jerk: AxisLimit,
}

impl LimitsConfig {
    /// Returns the limits for the planners.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits::new(
            self.velocity.get(),
            self.acceleration.get(),
            self.deceleration.unwrap_or(self.acceleration).get(),
            self.jerk.get(),
        )
        // The types of the fields admit only such numbers, so that this cannot fail.
        .expect("positive numbers are valid limits")
    }
}

/// Step of a program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case",
    deny_unknown_fields
)]
#[schemars(rename = "ProgramStep")]
pub enum StepConfig {
    /// `MC_Power`: makes the axis ready for motions, or disables it after halting it.
    #[doc(alias = "MC_Power")]
    Enable(bool),
    /// `MC_MoveAbsolute`: moves to a position.
    #[doc(alias = "MC_MoveAbsolute")]
    MoveAbsolute {
        /// Target position, u.
        position: Coordinate,
        /// Greatest speed on the way, u/s; that of the limits by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        velocity: Option<AxisLimit>,
    },
    /// `MC_MoveRelative`: travels a distance from the position at the begin of the step.
    #[doc(alias = "MC_MoveRelative")]
    MoveRelative {
        /// Distance, u.
        distance: Coordinate,
        /// Greatest speed on the way, u/s; that of the limits by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        velocity: Option<AxisLimit>,
    },
    /// `MC_MoveVelocity`: ramps to a velocity and keeps it.
    #[doc(alias = "MC_MoveVelocity")]
    Velocity {
        /// The velocity, u/s.
        value: Coordinate,
        /// Time at the velocity before the next step begins, s. 0 by default.
        #[serde(default)]
        for_s: AtLeastZero,
    },
    /// `MC_Halt`: comes to a standstill.
    #[doc(alias = "MC_Halt")]
    Halt {},
    /// Waits for the followers of the axis. A moving axis keeps moving.
    When {
        /// State to wait for.
        followers: FollowersState,
    },
    /// Waits. A moving axis keeps moving.
    Dwell {
        /// Time, s.
        for_s: AtLeastZero,
    },
    /// Runs steps several times. Loops may be nested up to [`MAX_LOOP_DEPTH`] deep.
    Loop {
        /// Number of passes.
        count: NonZeroU32,
        /// The steps.
        steps: Vec<StepConfig>,
    },
}

/// State of the followers of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FollowersState {
    /// Each of them has slaves of the axis, and all of these are in sync.
    InSync,
}

impl ProgramConfig {
    /// Checks that no step waits for followers, in the program of an axis without any.
    pub(super) fn check_no_followers(&self) -> Result<(), Wrong> {
        check::no_followers("program.steps", &self.steps)
    }
}

/// Number of runs of a program: `true` for ever, `false` once, or a count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeat {
    /// For ever.
    Forever,
    /// Number of runs.
    Times(NonZeroU32),
}

impl Repeat {
    /// Once, the default.
    pub const ONCE: Self = Self::Times(NonZeroU32::MIN);
}

impl Default for Repeat {
    fn default() -> Self {
        Self::ONCE
    }
}

impl Serialize for Repeat {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Forever => serializer.serialize_bool(true),
            // Before the count: once is also a count of 1, and is written as the default.
            &Self::ONCE => serializer.serialize_bool(false),
            Self::Times(count) => count.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Repeat {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // The key takes a flag or a number: only the value itself shows which.
        deserializer.deserialize_any(RepeatVisitor)
    }
}

impl JsonSchema for Repeat {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Repeat".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "type": "boolean" },
                { "type": "integer", "minimum": 1, "maximum": u32::MAX },
            ],
        })
    }
}

struct RepeatVisitor;

impl de::Visitor<'_> for RepeatVisitor {
    type Value = Repeat;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("true, false, or a count from 1 to 4294967295")
    }

    fn visit_bool<E: de::Error>(self, forever: bool) -> Result<Repeat, E> {
        Ok(if forever {
            Repeat::Forever
        } else {
            Repeat::ONCE
        })
    }

    fn visit_i64<E: de::Error>(self, count: i64) -> Result<Repeat, E> {
        u32::try_from(count)
            .ok()
            .and_then(NonZeroU32::new)
            .map(Repeat::Times)
            .ok_or_else(|| E::invalid_value(de::Unexpected::Signed(count), &self))
    }

    fn visit_u64<E: de::Error>(self, count: u64) -> Result<Repeat, E> {
        // Beyond i64 it is beyond u32 as well, and refused there with the same words.
        self.visit_i64(i64::try_from(count).unwrap_or(i64::MAX))
    }
}

/// The program as written, before its steps are checked against each other.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Written {
    /// Position of the axis at the start, u.
    #[serde(default)]
    start_position: Coordinate,
    /// Velocity of the axis at the start, u/s. An axis that moves at the start is enabled from the start.
    #[serde(default)]
    start_velocity: Coordinate,
    /// Limits of all its motions.
    limits: LimitsConfig,
    /// Number of runs of the steps: true for ever, false once, or a count.
    #[serde(default)]
    repeat: Repeat,
    /// The steps. Without any, the axis keeps its start velocity.
    #[serde(default)]
    steps: Vec<StepConfig>,
}

impl TryFrom<Written> for ProgramConfig {
    type Error = Wrong;

    fn try_from(written: Written) -> Result<Self, Wrong> {
        let program = Self {
            start_position: written.start_position,
            start_velocity: written.start_velocity,
            limits: written.limits,
            repeat: written.repeat,
            steps: written.steps,
        };
        // Every way into the type leads through the check: a program that exists can be run.
        check::program(&program)?;
        Ok(program)
    }
}

impl From<ProgramConfig> for Written {
    fn from(program: ProgramConfig) -> Self {
        Self {
            start_position: program.start_position,
            start_velocity: program.start_velocity,
            limits: program.limits,
            repeat: program.repeat,
            steps: program.steps,
        }
    }
}
