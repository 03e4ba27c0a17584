//! A sender among all nodes of a plant.

use coaxle_node::Channel;
use coaxle_source::config::AxisConfig;
use coaxle_topology::{AxisOrigin, PlantNode, PlantRole};

use super::SenderConfig;

impl SenderConfig {
    /// Describes the sender for [`coaxle_topology`]; `file` is what findings call it.
    #[must_use]
    pub fn plant_node(&self, file: &str) -> PlantNode {
        let cycle = self.cycle_time_us.0;
        let plant_axis = |(n, axis): (usize, &AxisConfig)| {
            let mut plant = axis.plant_axis(format!("axis[{n}]"), Some(Channel::Axes));
            // A delay that followers decide begins with the cycle time.
            if let AxisOrigin::Root {
                present_after: Some(range),
                ..
            } = &mut plant.origin
            {
                range.least = range.least.max(cycle.span());
            }
            plant
        };
        PlantNode {
            file: file.to_owned(),
            name: self.name.clone(),
            role: PlantRole::Sender,
            cycle_time: Some(cycle),
            axes: self.axes.iter().enumerate().map(plant_axis).collect(),
            is_complete: true,
            hold_back: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::Span;
    use coaxle_node::config::{PresentAfterRange, parse};

    #[test]
    fn a_delay_that_followers_decide_begins_with_the_cycle_time() {
        let config: SenderConfig = parse(
            "s.toml",
            "name = 'a'\ncycle-time-us = 2000\n[[axis]]\nid = 1\nname = 'x'\npresent-after-ms = 'auto'\n\
             followers = { nodes = ['saw'] }\nprogram = { limits = { velocity = 1, acceleration = 1, jerk = 1 } }",
        )
        .unwrap();
        let AxisOrigin::Root { present_after, .. } = config.plant_node("s").axes[0].origin else {
            panic!("no root");
        };
        let range = PresentAfterRange {
            least: Span::from_millis(2),
            most: PresentAfterRange::LONGEST,
        };
        assert_eq!(present_after, Some(range));
    }
}
