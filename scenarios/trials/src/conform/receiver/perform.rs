//! The network's part: cycles in real time, and the messages received meanwhile.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use coaxle_clock::Instant;
use coaxle_host::network::transport::{Declared, Publisher, Transport, Urgency};
use coaxle_node::Channel;
use coaxle_os::{Interrupt, Machine, machine};
use serde_json::{Map, Value};

use super::player::{PlayedRole, Player};
use crate::conform::rule::RuleFinding;

/// Most messages that wait for the next cycle.
const MOST: usize = 1 << 12;

enum ReceivedMessage {
    Request(Instant<Machine>, Vec<u8>),
    Status(Instant<Machine>, Map<String, Value>),
    SeenBy(bool),
}

/// Plays the whole script; none if interrupted.
///
/// # Errors
/// The transport refuses.
pub(super) fn perform(
    transport: &dyn Transport,
    part: PlayedRole,
    interrupt: &Interrupt,
) -> anyhow::Result<Option<Vec<RuleFinding>>> {
    let (queue, came) = sync_channel(MOST);
    let _declared = declare(transport, &part, &Arc::new(queue))?;
    let publisher = |channel| {
        let key = part.played.channel_key(channel);
        transport.publisher(&key, Urgency::RealTime)
    };
    let (axes, responses) = (
        publisher(Channel::Axes)?,
        publisher(Channel::TimeResponses)?,
    );
    let played = part.played.clone();
    let mut player = Player::new(part, machine::now());
    let mut epoch = player.epoch();
    let mut run = transport.announce(&played.run_key(epoch))?;
    while !player.is_done() {
        if interrupt.is_received() {
            return Ok(None);
        }
        machine::sleep_until(player.due());
        hand_in(&came, &mut player);
        for (channel, frame) in player.cycle(machine::now()) {
            let publisher = if channel == Channel::Axes {
                &axes
            } else {
                &responses
            };
            send(&**publisher, frame);
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

fn hand_in(came: &Receiver<ReceivedMessage>, player: &mut Player) {
    for came in came.try_iter() {
        match came {
            ReceivedMessage::Request(at, bytes) => player.request(at, &bytes),
            ReceivedMessage::Status(at, status) => player.status(at, &status),
            ReceivedMessage::SeenBy(is_seen) => player.seen_by(is_seen),
        }
    }
}

fn send(publisher: &dyn Publisher, frame: Vec<u8>) {
    if let Err(error) = publisher.publish(frame) {
        tracing::debug!(%error, "the transport refused a frame");
    }
}

fn declare(
    transport: &dyn Transport,
    part: &PlayedRole,
    queue: &Arc<SyncSender<ReceivedMessage>>,
) -> anyhow::Result<Vec<Declared>> {
    // Messages that find no room are dropped.
    let (requests, statuses, seen) = (Arc::clone(queue), Arc::clone(queue), Arc::clone(queue));
    let on_request = move |at, bytes: &[u8]| {
        let _ = requests.try_send(ReceivedMessage::Request(at, bytes.to_vec()));
    };
    let on_status = move |at, bytes: &[u8]| {
        if let Ok(Value::Object(status)) = serde_json::from_slice(bytes) {
            let _ = statuses.try_send(ReceivedMessage::Status(at, status));
        }
    };
    let on_seen = move |_: &str, is_there| {
        let _ = seen.try_send(ReceivedMessage::SeenBy(is_there));
    };
    let PlayedRole {
        played, receiver, ..
    } = part;
    let requests = played.channel_key(Channel::TimeRequests);
    Ok(vec![
        transport.announce(&played.alive_key())?,
        transport.subscribe(&requests, Box::new(on_request))?,
        transport.subscribe(&receiver.status_key(), Box::new(on_status))?,
        transport.watch(&played.seen_by_key(receiver), Box::new(on_seen))?,
    ])
}
