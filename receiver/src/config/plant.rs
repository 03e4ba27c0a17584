//! A receiver among all nodes of a plant.

use coaxle_clock::Span;
use coaxle_clock::far_clock::DelaySource;
use coaxle_node::Channel;
use coaxle_node::config::{LinkConfig, PresentAfterMs};
use coaxle_remote::FilterMode;
use coaxle_topology::{
    AxisOrigin, FarReference, LagRule, PlantAxis, PlantNode, PlantRole, Showing, StatedLimits,
    WayOrigin, WaySource,
};

use super::{FarAxisConfig, FarConfig, Lag, MasterRef, Present, ReceiverConfig};

impl ReceiverConfig {
    /// Describes the receiver for [`coaxle_topology`]: its far axes, virtual axes and slaves, in this order. `file` is what
    /// findings call it.
    #[must_use]
    pub fn plant_node(&self, file: &str) -> PlantNode {
        let far = (0..self.far_axes().count()).filter_map(|axis| self.far_plant_axis(axis));
        let virtual_axes = self.virtual_axes.iter().enumerate();
        let virtual_axes =
            virtual_axes.map(|(n, axis)| axis.plant_axis(format!("virtual-axis[{n}]"), None));
        let slaves = (0..self.slaves.len()).map(|n| self.slave_plant_axis(n));
        PlantNode {
            file: file.to_owned(),
            name: self.name.clone(),
            role: PlantRole::Receiver,
            cycle_time: Some(self.cycle_time_us.0),
            axes: far.chain(virtual_axes).chain(slaves).collect(),
            is_complete: true,
            hold_back: None,
        }
    }

    fn far_plant_axis(&self, number: usize) -> Option<PlantAxis> {
        let (far_number, far, axis) = self.far_axes().nth(number)?;
        let within = number - self.first_axis_of(far_number);
        let published = self.published_far_axes();
        let id = published.iter().position(|published| *published == number);
        let field = format!("far[{far_number}]");
        Some(PlantAxis {
            name: far.axis_name(axis),
            field: format!("{field}.axes[{within}]"),
            // Published ids count from 1, and a frame holds 128 axes.
            published: id.map(|id| (Channel::FarAxes, id as u32 + 1)),
            unit: axis.unit.clone().or(far.unit.clone()),
            modulo: axis.modulo.or(far.modulo),
            limits: None,
            origin: AxisOrigin::Far(FarReference {
                field,
                sources: self.addresses_of(number),
                way: way_of(far),
                showing: showing_of(far, axis),
                measured: None,
            }),
        })
    }

    fn slave_plant_axis(&self, n: usize) -> PlantAxis {
        let slave = &self.slaves[n];
        let far = self.far_axes().count();
        let place = |master| match master {
            MasterRef::Far(axis) => axis,
            MasterRef::Virtual(axis) => far + axis,
            MasterRef::Slave(slave) => far + self.virtual_axes.len() + slave,
        };
        // A slave with invalid masters is refused when the config is read.
        let masters = self.masters_of(n).unwrap_or_default();
        let limits = slave.limits();
        PlantAxis {
            name: slave.name.to_string(),
            field: format!("slave[{n}]"),
            published: Some((Channel::Slaves, self.slave_id(n))),
            unit: slave.unit.clone(),
            modulo: slave.modulo,
            limits: Some(StatedLimits {
                velocity: limits.velocity,
                acceleration: limits.acceleration,
                deceleration: limits.deceleration.unwrap_or(limits.acceleration),
                jerk: Some(limits.jerk).filter(|jerk| jerk.is_finite()),
            }),
            origin: AxisOrigin::Slave {
                masters: masters.into_iter().map(place).collect(),
            },
        }
    }
}

/// The delay that the config knows of a way: that of an injected link, or a stated one.
fn way_of(far: &FarConfig) -> WaySource {
    let constant = |delay: Span| WaySource::Constant {
        delay: delay.max(Span::ZERO),
        origin: WayOrigin::Configured,
    };
    if far.faults != LinkConfig::default() {
        return WaySource::Link(Box::new(far.faults.clone()));
    }
    let offset = far.sync.time_sync.delay_time_offset.to_span();
    match (far.mode, far.delay) {
        (FilterMode::Observer, DelaySource::Fixed(delay)) => constant(delay),
        // The blocks of TS5066 have a parameter of their own.
        (FilterMode::Auto | FilterMode::Time, _) if offset > Span::ZERO => constant(offset),
        _ => WaySource::Unknown,
    }
}

fn showing_of(far: &FarConfig, axis: &FarAxisConfig) -> Showing {
    match (far.mode, far.present) {
        (FilterMode::Bypass | FilterMode::Pt1, _) => Showing::AsReceived,
        (_, Present::Now) => Showing::Now,
        // An axis that the receiver smooths itself is not shown later.
        _ if axis.encoder.is_some() => Showing::Now,
        (_, Present::Auto) => Showing::Later(match far.lag_ms {
            Lag::Full => LagRule::Full,
            Lag::Auto => LagRule::Auto,
            Lag::Fixed(lag) => LagRule::Fixed(PresentAfterMs::span(lag)),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::test_config::config;

    fn far_of(rest: &str) -> FarReference {
        let axes = config(rest).unwrap().plant_node("r.toml").axes;
        let mut far = axes.into_iter().filter_map(|axis| match axis.origin {
            AxisOrigin::Far(far) => Some(far),
            _ => None,
        });
        far.next().unwrap()
    }

    #[test]
    fn masters_are_places_among_all_axes() {
        let text = "publish-far-axes = ['b.7']\n[[far]]\nnode = 'a'\n[[far]]\nnode = 'b'\naxes = [7]\n\
                    [[virtual-axis]]\nid = 1\nname = 'shaft'\n[virtual-axis.program]\n\
                    limits = { velocity = 1, acceleration = 1, jerk = 1 }\n\
                    [[slave]]\nname = 'x'\nid = 5\nmaster = 'shaft'\n\
                    [[slave]]\nname = 'y'\nmaster = 'b.7'\nfurther-masters = ['x']\n";
        let node = config(text).unwrap().plant_node("r.toml");
        let names: Vec<_> = node.axes.iter().map(|axis| axis.name.as_str()).collect();
        assert_eq!(names, ["a.1", "b.7", "shaft", "x", "y"]);
        assert_eq!(node.axes[1].published, Some((Channel::FarAxes, 1)));
        assert_eq!(node.axes[3].published, Some((Channel::Slaves, 5)));
        let masters = vec![1, 3];
        assert_eq!(node.axes[4].origin, AxisOrigin::Slave { masters });
    }

    #[test]
    fn ways_and_lags_are_those_of_the_config() {
        let way = |rest: &str| far_of(&format!("[[far]]\nnode = 'a'\n{rest}")).way;
        let micros = |delay| WaySource::Constant {
            delay: Span::from_micros(delay),
            origin: WayOrigin::Configured,
        };
        assert_eq!(way(""), WaySource::Unknown);
        assert_eq!(way("delay = { fixed-us = 350 }"), micros(350));
        let offset = "sync.time-sync = { delay-time-offset-s = 0.002 }";
        assert_eq!(way(offset), WaySource::Unknown);
        assert_eq!(way(&format!("mode = 'sync'\n{offset}")), micros(2_000));
        let link = way("delay = { fixed-us = 350 }\nfaults = { latency-us = 5000 }");
        assert!(matches!(link, WaySource::Link(_)), "{link:?}");
        let showing = |rest: &str| far_of(&format!("[[far]]\nnode = 'a'\n{rest}")).showing;
        assert_eq!(showing(""), Showing::Later(LagRule::Full));
        assert_eq!(showing("lag-ms = 'auto'"), Showing::Later(LagRule::Auto));
        let fixed = LagRule::Fixed(Span::from_millis(40));
        assert_eq!(showing("lag-ms = 40"), Showing::Later(fixed));
        assert_eq!(showing("present = 'now'"), Showing::Now);
        assert_eq!(showing("mode = 'bypass'"), Showing::AsReceived);
        let encoder = "axes = [{ id = 1, encoder = { increment = 0.1 } }]";
        assert_eq!(showing(encoder), Showing::Now);
    }
}
