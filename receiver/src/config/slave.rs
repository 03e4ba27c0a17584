//! `[[slave]]`: what a slave follows, what it can do, and what it does.

use std::path::Path;

use coaxle_axis::Modulo;
use coaxle_cam::CamIn;
use coaxle_node::config::{Positive, Unit};
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
    /// Its name among the slaves.
    #[serde(default = "slave")]
    pub name: NodeName,
    /// Its axis id, under which other receivers can follow it. Its place in the list by default,
    /// from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<u32>,
    /// Its master: a far axis, by its name or as `node.id`, a virtual axis or another slave, by its name.
    /// If empty, the far axis where there is but one; where there is none, the one virtual axis.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub master: String,
    /// What its position is in; the unit of its master by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// The length of its modulo turn, u, say 360 for a rotary knife; none for a slave that does not turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modulo: Option<Modulo>,
    /// Up to three more, named likewise, for couplings to several masters: their numbers 2 to 4.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_masters: Vec<String>,
    /// What it can do. Without, as much as its simulated drive, and it follows its master whatever becomes of
    /// that: see [`SlaveConfig::limits`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<SlaveParameters>,
    /// What follows its set values.
    #[serde(default)]
    pub drive: DriveConfig,
    /// What couples it from the start. The gear by default, nothing if it has a program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub couple: Option<CoupleConfig>,
    /// The gear that couples it from the start.
    #[serde(default)]
    pub gear: GearConfig,
    /// Cam plates that it can be coupled by, as those of the receiver's own `cams`: so can all other slaves of the
    /// receiver, by their numbers, each of which there is once in a receiver.
    #[doc(alias = "MC_CamTableSelect")]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cams: Vec<CamSource>,
    /// Registration marks on the material that its master moves, and the sensor that sees them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marks: Option<MarksConfig>,
    /// What it cuts with.
    #[serde(default, skip_serializing_if = "is_default")]
    pub tool: ToolConfig,
    /// Its program.
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
            couple: None,
            gear: GearConfig::default(),
            cams: Vec::new(),
            marks: None,
            tool: ToolConfig::default(),
            steps: Vec::new(),
        }
    }
}

/// What a simulated drive can do that is not told its highest velocity, u/s.
const FASTEST: f64 = 10_000.0;
/// The shortest lag of a drive that makes a difference, s.
const SHORTEST_LAG: f64 = 1e-4;

impl SlaveConfig {
    /// What it can do. Where the config does not say: as much as its drive. A velocity controller with a lag
    /// turns its highest velocity round with twice that per lag, and the acceleration likewise; it goes on following
    /// a master that is lost or in error, and the drive's window of the following error is the only one.
    #[must_use]
    pub fn limits(&self) -> SlaveParameters {
        self.limits.unwrap_or_else(|| {
            let drive = self.drive.simulated();
            let velocity = match drive.max_velocity {
                0.0 => FASTEST,
                most => most,
            };
            let turns = 2.0 / drive.velocity_lag.max(SHORTEST_LAG);
            let acceleration = turns * velocity;
            SlaveParameters {
                on_master_loss: OnMasterLoss::Follow,
                distance: DistanceParameters {
                    window: Some(0.0),
                    ..DistanceParameters::default()
                },
                ..SlaveParameters::new(velocity, acceleration, turns * acceleration)
            }
        })
    }

    /// What couples it from the start.
    #[must_use]
    pub fn couple(&self) -> CoupleConfig {
        self.couple.unwrap_or(if self.steps.is_empty() {
            CoupleConfig::Gear
        } else {
            CoupleConfig::Off
        })
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

/// What couples a slave from the start, as soon as there is a master.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CoupleConfig {
    /// Its gear.
    Gear,
    /// A cam plate. The slave is where it puts it.
    Cam(CamIn),
    /// Nothing: it has no power until it is commanded.
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

/// What a slave cuts the material with: itself, wherever it passes a multiple of something, as a
/// rotary knife does; or by steps of its program, as a saw does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct ToolConfig {
    /// It cuts wherever its set position passes a multiple of this, u, while it moves with its
    /// master. Such a cut is where the material is at the slave's position 0.
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
