//! An axis with its source, among all nodes of a plant.

use coaxle_node::Channel;
use coaxle_node::config::Unit;
use coaxle_topology::{AxisOrigin, PlantAxis, RootMotion, StatedLimits};

use super::{AxisConfig, LimitsConfig, SourceConfig};

impl AxisConfig {
    /// Returns the root of a motion. `field` is its place in the file, `channel` the one on which others can follow it.
    #[must_use]
    pub fn plant_axis(&self, field: String, channel: Option<Channel>) -> PlantAxis {
        PlantAxis {
            name: self.name.clone(),
            field,
            published: channel.map(|channel| (channel, self.id.get())),
            // The default is any unit.
            unit: Some(self.unit.clone()).filter(|unit| *unit != Unit::default()),
            modulo: self.modulo,
            limits: match &self.source {
                SourceConfig::Program(program) => Some(limits_of(&program.limits)),
                // What is measured or replayed keeps none that anybody knows.
                SourceConfig::Encoder(_) | SourceConfig::Replay(_) => None,
            },
            origin: AxisOrigin::Root {
                motion: match self.source {
                    SourceConfig::Program(_) => RootMotion::Program,
                    SourceConfig::Encoder(_) => RootMotion::Encoder,
                    SourceConfig::Replay(_) => RootMotion::Replay,
                },
                present_after: self.present_after(),
                followers: (self.followers.as_ref())
                    .map(|followers| followers.nodes.clone())
                    .unwrap_or_default(),
            },
        }
    }
}

fn limits_of(limits: &LimitsConfig) -> StatedLimits {
    let acceleration = limits.acceleration.get();
    StatedLimits {
        velocity: limits.velocity.get(),
        acceleration,
        deceleration: limits
            .deceleration
            .map_or(acceleration, |limit| limit.get()),
        jerk: Some(limits.jerk.get()),
    }
}
