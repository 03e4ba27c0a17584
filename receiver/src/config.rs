//! The receiver's config file. A file of its own, which a [`NodeFile`](coaxle_node::lab::NodeFile) reads, has what is injected
//! or simulated in a table `[lab]`; a scenario has it in its places.

mod axes;
mod common_time;
mod drive;
mod encoders;
mod far;
mod far_limits;
mod followers;
mod form;
mod held_back;
mod lab;
mod lag;
mod lock_cycle;
mod masters;
mod names;
mod notes;
mod plant;
mod positions;
mod publish;
mod slave;
mod standby;
#[cfg(test)]
mod test_config;
mod virtual_axes;

use std::path::Path;

use coaxle_node::config::{
    ClockConfig, CommonTimeConfig, CommonTimeSetup, CycleMicros, RealTimeConfig, TimingEndpoints,
    TimingLinkConfig, TimingServerConfig, TransportConfig, Wrong,
};
use coaxle_node::faults::check_clock;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{Publication, Subscription, Wiring};
use coaxle_node::{Channel, Intake, PlanIntake, Reader};
use coaxle_source::config::AxisConfig;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::cam_source::CamSource;
pub use crate::marks::{MarksConfig, SpacingSwing};
pub use axes::{AxisList, FarAxisConfig};
pub use drive::{DriveConfig, SharedMemoryConfig, SimulatedConfig};
pub use far::{AsymmetryConfig, FarChannel, FarConfig, Present};
pub use far_limits::FarLimits;
pub use lab::{FarLab, ReceiverLab, SlaveLab};
pub use lag::Lag;
pub use lock_cycle::LockCycleConfig;
pub use masters::MasterRef;
pub use positions::Positions;
pub use publish::PublishFarAxes;
pub use slave::{CoupleConfig, GearConfig, SlaveConfig, ToolConfig};
pub use standby::ReceivedNode;

/// A receiver: the axes it follows, the way it follows them, its own virtual axes, and its slaves.
/// A file has a list of far nodes, or one master in the short form (`master`, with `mode`, `sync`,
/// `observer`, `delay` and `faults` next to it).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", try_from = "form::Form")]
pub struct ReceiverConfig {
    /// The node's name.
    pub name: NodeName,
    /// Nominal cycle time, µs.
    pub cycle_time_us: CycleMicros,
    /// Lock of its cycle to that of a node that it follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lock_cycle: Option<LockCycleConfig>,
    /// Seed of all its randomness.
    pub seed: u64,
    /// The nodes that it follows.
    pub far: Vec<FarConfig>,
    /// Far axes that it publishes as corrected.
    #[serde(skip_serializing_if = "PublishFarAxes::is_none")]
    pub publish_far_axes: PublishFarAxes,
    /// Virtual axes of its own, which its slaves can follow, for example a local line shaft.
    #[serde(rename = "virtual-axis", skip_serializing_if = "Vec::is_empty")]
    pub virtual_axes: Vec<AxisConfig>,
    /// The cam plates that can couple all of its slaves.
    #[doc(alias = "MC_CamTableSelect")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cams: Vec<CamSource>,
    /// The slaves.
    #[serde(rename = "slave")]
    pub slaves: Vec<SlaveConfig>,
    /// The node's clock.
    pub clock: ClockConfig,
    /// Connection to other nodes.
    pub transport: TransportConfig,
    /// The timing channel to itself, for those who follow its slaves or far axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing_server: Option<TimingServerConfig>,
    /// Time that this PC has in common with others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<CommonTimeConfig>,
    /// Settings requested from the operating system.
    pub real_time: RealTimeConfig,
}

impl ReceiverConfig {
    /// Resolves the relative paths of the config's files from `folder`, for example the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        for axis in &mut self.virtual_axes {
            axis.relative_to(folder);
        }
        for cam in &mut self.cams {
            cam.relative_to(folder);
        }
        for slave in &mut self.slaves {
            slave.relative_to(folder);
        }
        for far in &mut self.far {
            far.relative_to(folder);
        }
        self.clock.relative_to(folder);
    }

    /// Checks the files that its clock and its faults name, as at its start.
    ///
    /// # Errors
    /// [`Wrong`] names the field and the file.
    pub fn check_files(&self) -> Result<(), Wrong> {
        check_clock(&self.clock).map_err(|wrong| wrong.within("clock"))?;
        for (n, far) in self.far.iter().enumerate() {
            far.check_files().map_err(|wrong| match self.far.len() {
                1 => wrong,
                _ => wrong.within(format_args!("far[{n}]")),
            })?;
        }
        Ok(())
    }

    /// The axis id of the n-th slave.
    #[must_use]
    pub fn slave_id(&self, n: usize) -> u32 {
        // A file of at most 1 MiB has far fewer slaves than a u32 can count.
        let counted = (n + 1) as u32;
        self.slaves.get(n).and_then(|s| s.id).unwrap_or(counted)
    }

    /// The number of the slave with an axis id.
    #[must_use]
    pub fn slave_with_id(&self, id: u32) -> Option<usize> {
        (0..self.slaves.len()).find(|n| self.slave_id(*n) == id)
    }

    /// The resulting gear from the axis at its root to the n-th slave, if gears alone couple them
    /// from the start.
    #[must_use]
    pub fn gear_to(&self, n: usize) -> Option<GearConfig> {
        let mut number = n;
        let mut whole = GearConfig::default();
        // At most as many steps as there are slaves, which may follow each other in a circle.
        for _ in 0..self.slaves.len() {
            let slave = self.slaves.get(number)?;
            // A program may uncouple the slave, and the gear would hold for a while only.
            if slave.couple() != CoupleConfig::Gear || !slave.steps.is_empty() {
                return None;
            }
            whole = GearConfig {
                ratio: whole.ratio * slave.gear.ratio,
                // R·(r·m + o) + O: the offset of an inner gear passes through all outer ratios.
                offset: whole.ratio * slave.gear.offset + whole.offset,
            };
            match self.master_of(number).ok()? {
                MasterRef::Far(_) | MasterRef::Virtual(_) => return Some(whole),
                MasterRef::Slave(master) => number = master,
            }
        }
        None
    }

    /// Publications and subscriptions of the node.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        let own = [Channel::Slaves, Channel::TimeResponses];
        // Slaves and time responses are published in any case, and far axes on request.
        let far_axes = (!self.publish_far_axes.is_none()).then_some(Channel::FarAxes);
        let own = own.into_iter().chain(far_axes);
        let mut publications: Vec<_> = own.map(|c| Publication::new(&self.name, c)).collect();
        let mut subscriptions = Vec::new();
        let mut plans = Vec::new();
        for (number, ReceivedNode { far, node, .. }) in
            self.received_nodes().into_iter().enumerate()
        {
            let config = &self.far[far];
            let channel = Channel::from(config.channel);
            let mut hear = |channel, reader| {
                subscriptions.push(Subscription {
                    node: node.clone(),
                    channel,
                    reader,
                    faults: config.faults.clone(),
                    far: number,
                });
            };
            let axes = Intake::new(&node.channel_key(channel), node, &config.axes.ids());
            hear(channel, axes.into());
            // Subscribed always: time requests can be switched on while the node runs.
            hear(
                Channel::TimeResponses,
                Reader::time_responses_of(node, &self.name),
            );
            if config.uses_plans() {
                plans.push((number, node, config));
            }
            publications.push(Publication {
                faults: config.faults_of_requests().clone(),
                far: number,
                ..Publication::new(node, Channel::TimeRequests)
            });
        }
        publications.extend(self.publication_of_reports());
        subscriptions.push(Subscription::time_requests_to(&self.name));
        // After all others, whose numbers they leave as they are.
        subscriptions.extend(plans.into_iter().map(|(far, node, config)| Subscription {
            node: node.clone(),
            channel: Channel::Plans,
            reader: PlanIntake::new(node, &config.axes.ids()).into(),
            faults: config.faults.clone(),
            far,
        }));
        let mut wiring = Wiring {
            node: self.name.clone(),
            publications,
            subscriptions,
        };
        for (number, node, timing) in self.timing_links() {
            wiring = wiring.with_timing_link(node, number, &timing.faults);
        }
        match &self.timing_server {
            Some(_) => wiring.with_timing_server(),
            None => wiring,
        }
    }

    /// Reports on its slaves, if there are any. All nodes get the same ones, with the faults of the way to the first.
    fn publication_of_reports(&self) -> Option<Publication> {
        let first = self.far.first().filter(|_| self.reports())?;
        Some(Publication {
            faults: first.faults_of_requests().clone(),
            ..Publication::new(&self.name, Channel::Followers)
        })
    }

    /// The far nodes with a timing channel, with their numbers among all that it receives from; not
    /// the standbys.
    fn timing_links(&self) -> impl Iterator<Item = (usize, &NodeName, &TimingLinkConfig)> {
        let heard = self.received_nodes().into_iter().enumerate();
        heard.filter_map(|(number, ReceivedNode { far, node, place })| {
            let timing = self.far[far].timing.as_ref().filter(|_| place == 0)?;
            Some((number, node, timing))
        })
    }

    /// Addresses on which it responds to beacons, and those that it sends them to.
    #[must_use]
    pub fn timing_endpoints(&self) -> TimingEndpoints {
        let links = self.timing_links();
        TimingEndpoints {
            listen: self.timing_server.as_ref().map(|server| server.listen),
            nodes: links
                .map(|(number, _, timing)| (number, timing.connect))
                .collect(),
            common_time: CommonTimeSetup::of(self.time.as_ref(), &self.clock),
        }
    }
}
