//! The axis that a receiver is judged and drawn by.

use coaxle_node::config::Unit;
use coaxle_receiver::ReceiverConfig;

use crate::topology::{ReceiverAxis, View};

/// Properties of the axis, from the config.
pub(crate) struct JudgedAxis {
    /// Mode of calculating its set values: `virtual` for a virtual axis.
    pub(crate) mode: &'static str,
    /// True if that mode synchronises.
    pub(crate) synchronises: bool,
    /// Name of the axis, in the whole scenario.
    pub(crate) name: String,
    /// Unit of its positions.
    pub(crate) unit: Unit,
}

impl JudgedAxis {
    /// The axis of a view of the receiver with this config.
    pub(crate) fn of(config: &ReceiverConfig, view: &View) -> Self {
        match view.of {
            ReceiverAxis::Far { far, axis } => {
                let far = &config.far[far];
                let key = far.node.channel_key(far.channel.into());
                let is_it = config.far_axes().nth(axis);
                // Ids begin at 1, so 0 names no axis.
                let id = is_it.map_or(0, |(_, _, axis)| axis.id);
                Self {
                    mode: far.mode.name(),
                    synchronises: far.mode.synchronises(&far.sync),
                    name: format!("{key}/{id}"),
                    unit: config.far_axis_unit(axis),
                }
            }
            ReceiverAxis::Virtual(axis) => Self {
                // No far node makes its set values, and so none of the modes.
                mode: VIRTUAL,
                synchronises: false,
                name: format!("{}/{}", config.name, config.virtual_axes[axis].name),
                unit: config.virtual_axis_unit(axis),
            },
        }
    }
}

/// Mode of a virtual axis, in place of a far node's.
const VIRTUAL: &str = "virtual";
