//! A gateway among all nodes of a plant.

use coaxle_node::Channel;
use coaxle_node::circles::AxisAddress;
use coaxle_node::config::Unit;
use coaxle_topology::{
    AxisOrigin, FarReference, PlantAxis, PlantNode, PlantRole, RootMotion, Showing, WaySource,
};

use super::{GatewayConfig, OutputConfig};

impl GatewayConfig {
    /// Describes the gateway for [`coaxle_topology`]: the axes of its PLC, and those that the PLC gets. `file` is what findings
    /// call it.
    #[must_use]
    pub fn plant_node(&self, file: &str) -> PlantNode {
        let axes = self.axes.iter().enumerate();
        let axes = axes.map(|(n, axis)| PlantAxis {
            name: axis.name.to_string(),
            field: format!("axis[{n}]"),
            published: Some((Channel::Axes, axis.id.get())),
            unit: Some(axis.unit.clone()).filter(|unit| *unit != Unit::default()),
            modulo: None,
            limits: None,
            origin: AxisOrigin::Root {
                motion: RootMotion::Plc,
                present_after: None,
                followers: Vec::new(),
            },
        });
        let outputs = self.outputs.iter().enumerate();
        PlantNode {
            file: file.to_owned(),
            name: self.name.clone(),
            role: PlantRole::Gateway,
            cycle_time: Some(self.cycle_time_us.0),
            axes: axes
                .chain(outputs.flat_map(|(n, output)| output.plant_axes(n)))
                .collect(),
            is_complete: true,
            hold_back: None,
        }
    }
}

impl OutputConfig {
    fn plant_axes(&self, n: usize) -> Vec<PlantAxis> {
        let axes = self.axes.iter().enumerate();
        axes.map(|(k, axis)| PlantAxis {
            name: format!("{}.{}", self.node, axis.id),
            field: format!("output[{n}].axis[{k}]"),
            published: None,
            unit: None,
            modulo: None,
            limits: None,
            origin: AxisOrigin::Output(FarReference {
                field: format!("output[{n}]"),
                sources: vec![AxisAddress {
                    node: self.node.clone(),
                    channel: self.channel.into(),
                    id: axis.id.get(),
                }],
                // A PLC takes what has arrived: no figure of it is known.
                way: WaySource::Unknown,
                showing: Showing::AsReceived,
                measured: None,
            }),
        })
        .collect()
    }
}
