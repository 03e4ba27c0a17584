//! Blending between modes of a far axis.

use coaxle_node::command::{CommandOrder, FarCommand};
use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::config::FarConfig;

use crate::event::{Event, EventKind};

/// Longest blending time that a far node has during a run, s: that of its config, or of an order.
pub(super) fn longest_blending(
    receiver: &ReceiverConfig,
    far: &FarConfig,
    events: &[Event],
) -> f64 {
    let ordered = events
        .iter()
        .filter(|event| event.node == receiver.name)
        .filter_map(|event| match &event.what {
            EventKind::Command(command) => blending_of(&command.order),
            EventKind::Away { .. } => None,
        });
    let configured = far.sync.extrapolate.blending_time.0;
    ordered.fold(configured, f64::max)
}

/// Blending time that an order sets, s.
fn blending_of(order: &CommandOrder) -> Option<f64> {
    let CommandOrder::Far(order) = order else {
        return None;
    };
    let FarCommand::SetParameters(changes) = &order.command else {
        return None;
    };
    Some(changes.extrapolate.blending_time?.0)
}
