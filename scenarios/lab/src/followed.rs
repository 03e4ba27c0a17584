//! The axis that a receiver is judged and drawn by.

use coaxle_node::config::Unit;
use coaxle_receiver::ReceiverConfig;

use crate::topology::{View, Viewed};

/// What is known of it from the config.
pub(crate) struct Followed {
    /// How its set values are calculated: `virtual` where there is nothing to calculate.
    pub(crate) mode: &'static str,
    /// Whether that is to get in sync.
    pub(crate) synchronises: bool,
    /// Which one it is, in the whole scenario.
    pub(crate) name: String,
    /// What its positions are in.
    pub(crate) unit: Unit,
}

impl Followed {
    /// The axis of a view of the receiver with this config.
    pub(crate) fn of(config: &ReceiverConfig, view: &View) -> Self {
        match view.of {
            Viewed::Far { far, axis } => {
                let far = &config.far[far];
                let key = far.node.channel_key(far.channel.into());
                let is_it = config.far_axes().nth(axis);
                let id = is_it.map_or(0, |(_, _, axis)| axis.id);
                Self {
                    mode: far.mode.name(),
                    synchronises: far.mode.synchronises(&far.sync),
                    name: format!("{key}/{id}"),
                    unit: config.far_axis_unit(axis),
                }
            }
            Viewed::Virtual(axis) => Self {
                mode: VIRTUAL,
                synchronises: false,
                name: format!("{}/{}", config.name, config.virtual_axes[axis].name),
                unit: config.virtual_axis_unit(axis),
            },
        }
    }
}

/// In place of the mode of a far node, of a receiver as its own virtual axis leads it.
const VIRTUAL: &str = "virtual";
