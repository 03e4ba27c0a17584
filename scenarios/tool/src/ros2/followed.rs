//! A node of Coaxle that is followed: its frames on all channels that carry axes, and the names of its axes.

use std::collections::BTreeSet;

use coaxle_clock::{Instant, Local, Span};
use coaxle_host::client::SeenNode;
use coaxle_node::Channel;
use coaxle_node::keys::NodeName;
use coaxle_ros::catalog::Catalog;
use coaxle_ros::message::JointState;
use coaxle_ros::source::{FrameSource, PublishedValues, SlaveMotion};
use coaxle_ros::trajectory::Address;
use coaxle_ros::unit::KNOWN;

/// The channels that carry axes; that of the slaves is the second.
pub(super) const CHANNELS: [Channel; 3] = [Channel::Axes, Channel::Slaves, Channel::FarAxes];
const SLAVES: usize = 1;

/// A slave whose newest frame is older takes no orders from here.
// A node that has been frozen or cut off for a second must not be sent to a place of before.
const OLDEST: Span = Span::from_secs(1);

/// State of a followed node.
pub(super) struct FollowedNode {
    pub(super) name: NodeName,
    catalog: Catalog,
    sources: [FrameSource; 3],
    /// Warnings already logged.
    logged: BTreeSet<String>,
}

impl FollowedNode {
    pub(super) fn new(name: &NodeName) -> Self {
        Self {
            name: name.clone(),
            catalog: Catalog::default(),
            sources: CHANNELS.map(|channel| FrameSource::new(name.clone(), channel)),
            logged: BTreeSet::new(),
        }
    }

    /// Reads the axes from its status.
    pub(super) fn refresh(&mut self, seen: &SeenNode) {
        let Some((_, status)) = &seen.status else {
            return;
        };
        let catalog = Catalog::of_status(&self.name, status);
        // Statuses come four times a second and name the same axes nearly always.
        if catalog == self.catalog {
            return;
        }
        self.catalog = catalog;
        for joint in self.catalog.unknown_units() {
            let unit = joint.unit.as_deref().unwrap_or_default();
            let name = &joint.name;
            // Once for each axis and unit, as the warning would repeat with every other change.
            if self.logged.insert(format!("{name} {unit}")) {
                tracing::warn!(
                    "{name}: received the unit {unit:?}, expected one of {KNOWN}: its values are passed on as they are"
                );
            }
        }
    }

    /// A frame of one of its [`CHANNELS`] came.
    pub(super) fn frame(&mut self, channel: usize, came: Instant<Local>, payload: &[u8]) {
        let Err(reason) = self.sources[channel].frame(came, payload) else {
            return;
        };
        let key = self.name.channel_key(CHANNELS[channel]);
        // Frames come at the rate of the cycle.
        if self.logged.insert(format!("{key} {reason:?}")) {
            tracing::warn!("{key}: a frame is refused: {reason}");
        }
    }

    /// Joint states received since the last call.
    pub(super) fn joint_states(
        &mut self,
        now: Instant<Local>,
        values: PublishedValues,
        unix: Span,
    ) -> impl Iterator<Item = JointState> {
        let catalog = &self.catalog;
        let sources = self.sources.iter_mut();
        sources.filter_map(move |source| source.joint_state(now, catalog, values, unix))
    }

    /// Addresses of its slaves with recent frames.
    pub(super) fn addresses(&self, now: Instant<Local>) -> impl Iterator<Item = Address> {
        self.catalog.slaves().filter_map(move |(axis_id, joint)| {
            // A slave without recent frames is left out: a plan needs its position.
            self.motion(axis_id, now)?;
            Some(Address {
                joint: joint.name.clone(),
                node: self.name.clone(),
                slave: joint.slave?,
                axis_id,
                scale: joint.scale(),
            })
        })
    }

    /// Motion of a slave, if its frames are recent.
    pub(super) fn motion(&self, axis_id: u32, now: Instant<Local>) -> Option<SlaveMotion> {
        let (came, motion) = self.sources[SLAVES].motion(axis_id)?;
        // By the arrival here, so that clocks of other PCs do not matter.
        (now - came <= OLDEST).then_some(motion)
    }
}
