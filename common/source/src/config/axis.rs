//! Config of an axis and of its source.

use std::num::{NonZeroU16, NonZeroU32};
use std::path::{Path, PathBuf};

use coaxle_axis::Modulo;
use coaxle_clock::Span;
use coaxle_node::config::{
    Increment, LeadMs, PresentAfterChoice, PresentAfterLimits, PresentAfterRange, Unit, Wrong,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::followers::FollowersConfig;
use super::program::ProgramConfig;

/// An axis and its source.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Written", into = "Written")]
pub struct AxisConfig {
    /// The axis id, 1 or more; receivers pick a sender's axis by it.
    pub id: NonZeroU32,
    /// Name for people: 1 to 64 characters.
    pub name: String,
    /// Unit of its position; `u` by default.
    pub unit: Unit,
    /// The length of a modulo turn in u, say 360 for degrees; none for a non-modulo axis.
    pub modulo: Option<Modulo>,
    /// Time after its generation at which it is shown, ms; none where followers move the newest values to now.
    pub present_after_ms: Option<PresentAfterChoice>,
    /// Limits of that time where followers decide it.
    pub present_after_limits: Option<PresentAfterLimits>,
    /// Time by which its motion is decided and promised ahead, ms; none for that of its presentation.
    pub lead_ms: Option<LeadMs>,
    /// Followers that it waits for, stops with, and whose limits it keeps; none of an axis that leads without asking.
    pub followers: Option<FollowersConfig>,
    /// Source of its motion.
    pub source: SourceConfig,
}

impl AxisConfig {
    /// Returns the time by which its motion is decided and promised ahead: that of its presentation by default, and none
    /// for a motion that is not generated in pieces of constant jerk.
    #[must_use]
    pub fn lead(&self) -> Span {
        let SourceConfig::Program(_) = self.source else {
            return Span::ZERO;
        };
        // A delay that followers decide is none to rely on.
        let as_shown = || match self.present_after_ms {
            Some(PresentAfterChoice::Fixed(delay)) => delay.span(),
            Some(PresentAfterChoice::Auto) | None => Span::ZERO,
        };
        self.lead_ms.map_or_else(as_shown, LeadMs::span)
    }

    /// Returns the delays by which it may be shown later; none where followers move the newest values to now.
    #[must_use]
    pub fn present_after(&self) -> Option<PresentAfterRange> {
        // Checked on reading.
        self.present_after_ms?
            .within(self.present_after_limits)
            .ok()
    }

    /// Resolves a relative path in its source against `folder`, say the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        if let SourceConfig::Replay(replay) = &mut self.source {
            replay.file = folder.join(&replay.file);
        }
    }
}

/// Source of the motion of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceConfig {
    /// `program`: a virtual axis that runs a program.
    Program(ProgramConfig),
    /// `encoder`: a virtual axis measured by an encoder.
    Encoder(EncoderConfig),
    /// `replay`: a recorded motion.
    Replay(ReplayConfig),
}

/// An axis that is only measured: its position comes in increments.
///
/// Its velocity is differentiated, and its acceleration, if there is one at all, is too coarse for
/// extrapolation: receivers of such an axis must not use it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct EncoderConfig {
    /// Length of one increment, u.
    pub resolution: Increment,
    /// Number of cycles over which the velocity is differentiated: more are smoother and later. 8 by
    /// default.
    #[serde(default = "default_window")]
    pub velocity_window_cycles: NonZeroU16,
    /// Differentiate the velocity once more, over an equal number of cycles; otherwise the acceleration
    /// is zero. Off by default.
    #[serde(default)]
    pub differentiate_acceleration: bool,
    /// Actual motion of the measured axis.
    pub program: ProgramConfig,
}

const fn default_window() -> NonZeroU16 {
    NonZeroU16::new(8).expect("8 is not zero")
}

/// A recorded motion: a CSV file with the columns `time_s`, `position` and, if recorded,
/// `velocity` and `acceleration`; or an axis of a recording in MCAP.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct ReplayConfig {
    /// The file.
    pub file: PathBuf,
    /// Axis of a recording, `*.mcap`: its name there, `table` or `press/table`. Its motion begins with
    /// the first cycle in which its position is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<String>,
    /// Begin again after the last row; each pass continues where the last one ended. Otherwise the axis
    /// stands still from then on, the default.
    #[serde(default)]
    pub repeat: bool,
    /// Interpolation between two rows.
    #[serde(default)]
    pub interpolation: Interpolation,
}

/// Interpolation of a recorded motion between two rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "ReplayInterpolation")]
pub enum Interpolation {
    /// A cubic through both positions and velocities: the velocity has no steps.
    #[default]
    Cubic,
    /// A straight line: the velocity steps at each row unless it was recorded.
    Linear,
}

/// The axis as written: one table for each kind of source, of which exactly one is present.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Written {
    /// The axis id, 1 or more; receivers pick a sender's axis by it.
    id: NonZeroU32,
    /// Name for people: 1 to 64 characters.
    name: String,
    /// Unit of its position; `u` by default.
    #[serde(default)]
    unit: Unit,
    /// The length of a modulo turn in u, say 360 for degrees; none for a non-modulo axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    modulo: Option<Modulo>,
    /// Time after its generation at which everybody shows it, ms; one for all axes of a sender, of its cycle time or more. With `"auto"` as long as the followers of
    /// its axes need. By default there is none: followers move the newest values to now.
    #[serde(skip_serializing_if = "Option::is_none")]
    present_after_ms: Option<PresentAfterChoice>,
    /// Limits of a time that is `"auto"`; those of every such time by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    present_after_limits: Option<PresentAfterLimits>,
    /// Time by which the steps of its program are decided ahead, ms: a sender promises the motion until then, and followers
    /// know it where frames are missing. `present-after-ms` by default, 0 if that is `"auto"`; 0: no promise.
    #[serde(skip_serializing_if = "Option::is_none")]
    lead_ms: Option<LeadMs>,
    /// Followers that its program waits for, stops with, and whose limits it keeps. By default it leads without asking.
    #[serde(skip_serializing_if = "Option::is_none")]
    followers: Option<FollowersConfig>,
    /// A virtual axis that runs a program. One of program, encoder and replay.
    #[serde(skip_serializing_if = "Option::is_none")]
    program: Option<ProgramConfig>,
    /// A virtual axis measured by an encoder.
    #[serde(skip_serializing_if = "Option::is_none")]
    encoder: Option<EncoderConfig>,
    /// A recorded motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    replay: Option<ReplayConfig>,
}

impl TryFrom<Written> for AxisConfig {
    type Error = Wrong;

    fn try_from(written: Written) -> Result<Self, Wrong> {
        let Written {
            id,
            name,
            unit,
            modulo,
            present_after_ms,
            present_after_limits,
            lead_ms,
            followers,
            ..
        } = written;
        // Characters, not bytes: a name in any script has the same room.
        if !(1..=64).contains(&name.chars().count()) {
            return Err(Wrong::of(
                "name",
                format_args!("{name:?}"),
                "1 to 64 characters",
            ));
        }
        // A table per kind reads better than a tagged one, but types cannot say "exactly one": checked here.
        let source = match (written.program, written.encoder, written.replay) {
            (Some(program), None, None) => SourceConfig::Program(program),
            (None, Some(encoder), None) => SourceConfig::Encoder(encoder),
            (None, None, Some(replay)) => SourceConfig::Replay(replay),
            (program, encoder, replay) => {
                return Err(not_one_source(&[
                    ("`program`", program.is_some()),
                    ("`encoder`", encoder.is_some()),
                    ("`replay`", replay.is_some()),
                ]));
            }
        };
        check_limits(present_after_ms, present_after_limits)
            .map_err(|wrong| wrong.within("present-after-limits"))?;
        check_lead(lead_ms, &source)?;
        check_followers(followers.as_ref(), &source)?;
        Ok(Self {
            id,
            name,
            unit,
            modulo,
            present_after_ms,
            present_after_limits,
            lead_ms,
            followers,
            source,
        })
    }
}

/// Checks that limits belong to a time that followers decide, and that there is one between them.
fn check_limits(
    choice: Option<PresentAfterChoice>,
    limits: Option<PresentAfterLimits>,
) -> Result<(), Wrong> {
    match (choice, limits) {
        (Some(choice), limits) => choice.within(limits).map(drop),
        (None, Some(_)) => Err(Wrong::value(
            "limits",
            "present-after-ms = \"auto\" with limits",
        )),
        (None, None) => Ok(()),
    }
}

/// Checks that only the motion of a program is promised: nobody knows ahead what is measured, and a recorded motion has no
/// pieces of constant jerk.
fn check_lead(lead_ms: Option<LeadMs>, source: &SourceConfig) -> Result<(), Wrong> {
    let kind = match source {
        SourceConfig::Program(_) => return Ok(()),
        SourceConfig::Encoder(_) => "an encoder",
        SourceConfig::Replay(_) => "a replay",
    };
    match lead_ms.map(LeadMs::get).filter(|ms| *ms > 0.0) {
        Some(ms) => {
            let expected =
                format!("0 or none for {kind}: only the motion of a program is known ahead");
            Err(Wrong::of("lead-ms", ms, expected))
        }
        None => Ok(()),
    }
}

/// Checks that only a program reacts to followers, and that there are some if it does.
fn check_followers(
    followers: Option<&FollowersConfig>,
    source: &SourceConfig,
) -> Result<(), Wrong> {
    let kind = match (source, followers) {
        (SourceConfig::Program(_), Some(followers)) => {
            return followers.check().map_err(|wrong| wrong.within("followers"));
        }
        (SourceConfig::Program(program), None) => return program.check_no_followers(),
        (SourceConfig::Encoder(encoder), None) => {
            let checked = encoder.program.check_no_followers();
            return checked.map_err(|wrong| wrong.within("encoder"));
        }
        (SourceConfig::Replay(_), None) => return Ok(()),
        (SourceConfig::Encoder(_), Some(_)) => "an encoder",
        (SourceConfig::Replay(_), Some(_)) => "a replay",
    };
    let expected = format!("none for {kind}: only a program waits and stops");
    Err(Wrong::of("followers", "a table", expected))
}

fn not_one_source(sources: &[(&str, bool)]) -> Wrong {
    let given: Vec<&str> = sources
        .iter()
        .filter_map(|(name, given)| given.then_some(*name))
        .collect();
    let received = if given.is_empty() {
        "no source".to_owned()
    } else {
        given.join(" and ")
    };
    Wrong::value(received, "one of `program`, `encoder` and `replay`")
}

impl From<AxisConfig> for Written {
    fn from(axis: AxisConfig) -> Self {
        // Named completely, so that a new field cannot be forgotten on writing.
        let AxisConfig {
            id,
            name,
            unit,
            modulo,
            present_after_ms,
            present_after_limits,
            lead_ms,
            followers,
            source,
        } = axis;
        let mut written = Self {
            id,
            name,
            unit,
            modulo,
            present_after_ms,
            present_after_limits,
            lead_ms,
            followers,
            program: None,
            encoder: None,
            replay: None,
        };
        match source {
            SourceConfig::Program(program) => written.program = Some(program),
            SourceConfig::Encoder(encoder) => written.encoder = Some(encoder),
            SourceConfig::Replay(replay) => written.replay = Some(replay),
        }
        written
    }
}
