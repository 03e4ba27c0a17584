//! `[[slave]]`: masters, limits and commands of a slave.

use std::path::Path;

use coaxle_axis::Modulo;
use coaxle_cam::CamIn;
use coaxle_clock::Span;
use coaxle_node::config::{DeadTimeMicros, Positive, Unit, Wrong};
use coaxle_node::keys::NodeName;
use coaxle_slave::{DistanceParameters, OnMasterLoss, SlaveParameters};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::drive::DriveConfig;
use crate::cam_source::CamSource;
use crate::marks::MarksConfig;
use crate::program::StepConfig;

/// A slave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct SlaveConfig {
    /// Name among the slaves.
    #[serde(default = "slave")]
    pub name: NodeName,
    /// Axis id, under which other receivers can follow it. Its place in the list by default, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<u32>,
    /// Master: a far axis, by its name or as `node.id`, a virtual axis or another slave, by its
    /// name. If empty, the only far axis; without any, the only virtual axis.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub master: String,
    /// Unit of its position; that of its master by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Length of its modulo period, u, for example 360 for a rotary knife; none for a slave without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modulo: Option<Modulo>,
    /// Up to three further masters, named likewise, for couplings to several masters: their numbers
    /// 2 to 4.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_masters: Vec<String>,
    /// Dynamic limits. Without them, those of its simulated drive, and it follows its master even
    /// if that is lost or in error: see [`SlaveConfig::limits`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<SlaveParameters>,
    /// Drive that follows its set values.
    #[serde(default)]
    pub drive: DriveConfig,
    /// Dead time of its drive, µs: the time after which a set value that it is given is its position, for example that of the fieldbus and of
    /// the drive's interpolator. It is given its set values that much earlier.
    #[serde(default, skip_serializing_if = "DeadTimeMicros::is_zero")]
    pub dead_time_us: DeadTimeMicros,
    /// Coupling from the start. The gear by default, none if it has a program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub couple: Option<CoupleConfig>,
    /// The gear that couples it from the start.
    #[serde(default)]
    pub gear: GearConfig,
    /// Cam plates that can couple it, in addition to those of the receiver's `cams`; all slaves of
    /// the receiver can use them, by their numbers, which are unique in a receiver.
    #[doc(alias = "MC_CamTableSelect")]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cams: Vec<CamSource>,
    /// Registration marks on the material that its master moves, and the sensor that sees them. Both are simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-lab" = "[[lab.slave]] with its name and marks = {}"))]
    pub marks: Option<MarksConfig>,
    /// Cutting tool.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("x-lab" = "[[lab.slave]] with its name and tool = {}"))]
    pub tool: ToolConfig,
    /// Program of the slave.
    #[serde(rename = "step", default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<StepConfig>,
}

fn is_default(tool: &ToolConfig) -> bool {
    *tool == ToolConfig::default()
}

fn slave() -> NodeName {
    NodeName::new("slave").expect("a valid name")
}

impl Default for SlaveConfig {
    fn default() -> Self {
        Self {
            name: slave(),
            id: None,
            master: String::new(),
            unit: None,
            modulo: None,
            further_masters: Vec::new(),
            limits: None,
            drive: DriveConfig::default(),
            dead_time_us: DeadTimeMicros::default(),
            couple: None,
            gear: GearConfig::default(),
            cams: Vec::new(),
            marks: None,
            tool: ToolConfig::default(),
            steps: Vec::new(),
        }
    }
}

/// Highest velocity of a simulated drive without a configured one, u/s.
const FASTEST: f64 = 10_000.0;
/// The shortest lag of a drive that has an effect, s.
// The shortest cycle time: a shorter lag ends within any cycle.
const SHORTEST_LAG: f64 = 1e-4;

impl SlaveConfig {
    /// Dynamic limits. Without configured ones, those of its drive: a velocity controller with a
    /// lag reverses its highest velocity with twice that per lag, and the acceleration likewise;
    /// the slave continues to follow a master that is lost or in error, and the drive's window of
    /// the following error is the only one.
    #[must_use]
    pub fn limits(&self) -> SlaveParameters {
        self.limits.unwrap_or_else(|| {
            let drive = self.drive.simulated();
            let velocity = match drive.max_velocity {
                0.0 => FASTEST,
                most => most,
            };
            // dv/dt = (v_set − v)/lag. From −v to +v that is 2·v/lag, the steepest that the drive can follow.
            let turns = 2.0 / drive.velocity_lag.max(SHORTEST_LAG);
            let acceleration = turns * velocity;
            SlaveParameters {
                on_master_loss: OnMasterLoss::Follow,
                distance: DistanceParameters {
                    // Not monitored: the drive has a window of its own.
                    window: Some(0.0),
                    ..DistanceParameters::default()
                },
                ..SlaveParameters::new(velocity, acceleration, turns * acceleration)
            }
        })
    }

    /// Dead time of its drive, where that is simulated.
    #[must_use]
    pub fn simulated_dead_time(&self) -> Span {
        match &self.drive {
            DriveConfig::Simulated(drive) => drive.dead_time.span(),
            // What replaces it has the one that it is said to have.
            DriveConfig::SharedMemory(_) => self.dead_time_us.span(),
        }
    }

    /// Coupling from the start.
    #[must_use]
    pub fn couple(&self) -> CoupleConfig {
        self.couple.unwrap_or(if self.steps.is_empty() {
            CoupleConfig::Gear
        } else {
            CoupleConfig::Off
        })
    }

    /// Checks that the tool can cut.
    pub(crate) fn check_tool(&self) -> Result<(), Wrong> {
        let ratio = self.tool.ratio;
        // The position on the material is a quotient by it.
        if !ratio.is_finite() || ratio == 0.0 {
            return Err(Wrong::of("tool.ratio", ratio, "a number other than 0"));
        }
        // Each cut would count twice.
        if self.tool.cuts_every.is_some() && self.steps.iter().any(|step| step.cut) {
            let (received, expected) = ("one beside steps that cut", "one or the other");
            return Err(Wrong::of("tool.cuts-every", received, expected));
        }
        Ok(())
    }

    pub(super) fn relative_to(&mut self, folder: &Path) {
        if let DriveConfig::SharedMemory(drive) = &mut self.drive {
            drive.path = folder.join(&drive.path);
        }
        let of_steps = self.steps.iter_mut().filter_map(StepConfig::plate_mut);
        for cam in self.cams.iter_mut().chain(of_steps) {
            cam.relative_to(folder);
        }
    }
}

/// Coupling of a slave from the start, as soon as there is a master.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CoupleConfig {
    /// The slave's gear.
    Gear,
    /// A cam plate. The slave starts at the plate's position.
    Cam(CamIn),
    /// No coupling: no power until it is commanded.
    Off,
}

/// A linear gear: slave = ratio · master + offset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct GearConfig {
    /// Slave units per master unit, not 0.
    pub ratio: f64,
    /// The slave's position at master position 0, u.
    pub offset: f64,
}

impl Default for GearConfig {
    fn default() -> Self {
        Self {
            ratio: 1.0,
            offset: 0.0,
        }
    }
}

/// Cutting of the material by a slave: by the slave itself at multiples of a distance, like a
/// rotary knife; or by steps of its program, like a saw.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct ToolConfig {
    /// Distance of the cuts, u: a cut is made at each multiple of it that the set position passes
    /// while the slave moves with its master. Such a cut is where the material is at the slave's
    /// position 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cuts_every: Option<Positive>,
    /// Slave units per master unit with which it moves along the material, not 0: a cut by a step
    /// is `position / ratio` further along the material.
    pub ratio: f64,
}

impl Default for ToolConfig {
    fn default() -> Self {
        Self {
            cuts_every: None,
            ratio: 1.0,
        }
    }
}
