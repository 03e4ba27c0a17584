//! The network's part: cycles in real time, and the messages received meanwhile.

use coaxle_host::network::transport::{Transport, Urgency};
use coaxle_node::Channel;
use coaxle_os::{Interrupt, machine};
use serde_json::Value;

use super::player::{PlayedRole, Player};
use crate::conform::queue::{MessageQueue, Source};
use crate::conform::rule::RuleFinding;

/// Most messages that wait for the next cycle.
const MOST: usize = 1 << 12;

/// Plays the whole script; none if interrupted.
///
/// # Errors
/// The transport refuses.
pub(super) fn perform(
    transport: &dyn Transport,
    part: PlayedRole,
    interrupt: &Interrupt,
) -> anyhow::Result<Option<Vec<RuleFinding>>> {
    let played = part.played.clone();
    let _alive = transport.announce(&played.alive_key())?;
    let received = MessageQueue::new(transport, MOST, sources(&part))?;
    let publisher = |channel| {
        let key = played.channel_key(channel);
        transport.publisher(&key, Urgency::RealTime)
    };
    let axes = publisher(Channel::Axes)?;
    let responses = publisher(Channel::TimeResponses)?;
    let mut player = Player::new(part, machine::now());
    let mut epoch = player.epoch();
    let mut run = transport.announce(&played.run_key(epoch))?;
    while !player.is_done() {
        if interrupt.is_received() {
            return Ok(None);
        }
        machine::sleep_until(player.due());
        received.hand_over(&mut player);
        for (channel, frame) in player.cycle(machine::now()) {
            let publisher = match channel {
                Channel::Axes => &axes,
                _ => &responses,
            };
            if let Err(error) = publisher.publish(frame) {
                tracing::debug!(%error, "the transport refused a frame");
            }
        }
        if player.epoch() != epoch {
            epoch = player.epoch();
            drop(run);
            run = transport.announce(&played.run_key(epoch))?;
        }
    }
    drop(run);
    Ok(Some(player.findings()))
}

fn sources(part: &PlayedRole) -> [Source<Player>; 3] {
    let (played, receiver) = (&part.played, &part.receiver);
    [
        Source::Messages(
            played.channel_key(Channel::TimeRequests),
            |player, at, bytes, _| player.request(at, bytes),
        ),
        Source::Messages(receiver.status_key(), |player, at, bytes, _| {
            if let Ok(Value::Object(status)) = serde_json::from_slice(bytes) {
                player.status(at, &status);
            }
        }),
        Source::Tokens(played.seen_by_key(receiver), |player, _, is_there| {
            player.seen_by(is_there);
        }),
    ]
}
