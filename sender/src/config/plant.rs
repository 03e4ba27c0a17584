//! A sender among all nodes of a plant.

use coaxle_node::Channel;
use coaxle_topology::{PlantNode, PlantRole};

use super::SenderConfig;

impl SenderConfig {
    /// Describes the sender for [`coaxle_topology`]; `file` is what findings call it.
    #[must_use]
    pub fn plant_node(&self, file: &str) -> PlantNode {
        let axes = self.axes.iter().enumerate();
        PlantNode {
            file: file.to_owned(),
            name: self.name.clone(),
            role: PlantRole::Sender,
            cycle_time: Some(self.cycle_time_us.0),
            axes: axes
                .map(|(n, axis)| axis.plant_axis(format!("axis[{n}]"), Some(Channel::Axes)))
                .collect(),
            is_complete: true,
            hold_back: None,
        }
    }
}
