//! Input from the network to a running receiver: its far node's messages, and orders to its slaves.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::config::parse;
use coaxle_node::{Channel, CommandAnswer, CommandOrder, Node, Reader};
use coaxle_receiver::{Drives, Receiver, ReceiverConfig};

use crate::Outcome;
use crate::node::scan;
use crate::wire::{far, near, with_checksum};

/// Follows a conveyor with a gear, and drives a carriage that is commanded by a line shaft of its own.
const CONFIG: &str = r#"
name = "saw"
cycle-time-us = 1000
publish-far-axes = true

[[far]]
node = "conveyor"
axes = [1, 2, 7]

[[virtual-axis]]
id = 1
name = "shaft"
[virtual-axis.program]
start-velocity = 100.0
limits = { velocity = 200, acceleration = 1000, jerk = 10000 }

[[slave]]
name = "follower"
master = "conveyor.1"

[[slave]]
name = "carriage"
master = "shaft"
further-masters = ["conveyor.2", "follower"]
couple = "off"
modulo = 360
limits = { velocity = 2000, acceleration = 20000, jerk = 1000000 }

[[slave.cams]]
table-id = 1
course = "cyclic"
[[slave.cams.point]]
law = "polynom5"
master = 0
slave = 0
[[slave.cams.point]]
law = "polynom5"
master = 180
slave = 50
[[slave.cams.point]]
master = 360
slave = 0

[[slave.cams]]
table-id = 2
[slave.cams.table]
interpolation = "spline"
rows = [[0, 0], [100, 10], [200, 15], [300, 70]]
"#;

fn receiver() -> (ReceiverConfig, Receiver) {
    let config: ReceiverConfig = parse("saw.toml", CONFIG).expect("a good config");
    let built = Receiver::with_drives(&config, Drives::simulated(), Instant::EPOCH, 1);
    (config, built.expect("a good config"))
}

/// Most cycles that a stream of messages is run for.
const MOST_CYCLES: usize = 1_000;
/// Unit of the time between two messages of a stream.
const STEP: Span = Span::from_micros(100);

/// Messages to a receiver, one after the other, with its cycles between them. Each consists of a byte with the number of its
/// subscription, whose highest bit requests a corrected check sum; a byte with the time since the one before, in 100 µs; its
/// length, as two bytes, the lower one first; and its content.
pub(crate) fn arrivals(data: &[u8]) -> Outcome {
    let (config, mut receiver) = receiver();
    let wiring = config.wiring();
    let mut readers: Vec<Reader> = wiring
        .subscriptions
        .iter()
        .map(|s| s.reader.clone())
        .collect();
    let (mut rest, mut at, mut cycles) = (data, Instant::<Local>::EPOCH, 0);
    while let [by, later, low, high, more @ ..] = rest {
        let (payload, after) = more.split_at(
            more.len()
                .min(usize::from(u16::from_le_bytes([*low, *high]))),
        );
        rest = after;
        at += Span::from_nanos(STEP.as_nanos() * i64::from(*later));
        // Bounded: the input states the times, and 25 ms a message would be many cycles.
        while receiver.next_cycle() < at && cycles < MOST_CYCLES {
            scan(&mut receiver, &config.name, 1);
            cycles += 1;
        }
        // Any byte is a subscription, so that no input is wasted.
        let place = usize::from(by & 0x7f) % readers.len();
        let subscription = &wiring.subscriptions[place];
        let key = subscription.node.channel_key(subscription.channel);
        let sealed = match by & 0x80 {
            // Unchanged bytes are refused by their check sum in almost all cases.
            0 => payload.to_vec(),
            _ => with_checksum(&key, payload),
        };
        readers[place].read(&sealed, |message| receiver.receive(at, place, message));
    }
    scan(&mut receiver, &config.name, 100);
    Ok(())
}

/// The number of a subscription of the receiver.
pub(crate) fn subscription_to(channel: Channel) -> u8 {
    let (config, _) = receiver();
    let node = if channel == Channel::TimeRequests {
        near()
    } else {
        far()
    };
    let subscriptions = config.wiring().subscriptions;
    let is_it = |s: &coaxle_node::wiring::Subscription| s.channel == channel && s.node == node;
    let place = subscriptions
        .iter()
        .position(is_it)
        .expect("the receiver hears it");
    u8::try_from(place).expect("a handful")
}

/// Cycles before an order, in which the slave is ready.
const CYCLES_BEFORE: usize = 20;
/// Cycles after it.
const CYCLES_AFTER: usize = 50;

/// An order, read, executed by a running receiver, with its response.
pub(crate) fn order(data: &[u8]) -> Outcome {
    let order = CommandOrder::from_json(data).map_err(|error| error.to_string())?;
    let written = order.to_json();
    CommandOrder::from_json(written.as_bytes()).expect("an order that is written can be read");
    let (config, mut receiver) = receiver();
    let power = br#"{ "version": 1, "slave": "carriage", "command": { "power": true } }"#;
    let power = CommandOrder::from_json(power).expect("a good order");
    scan(&mut receiver, &config.name, 1);
    // Without power nearly every command is refused before it is looked at.
    let _ = receiver.execute(&power);
    scan(&mut receiver, &config.name, CYCLES_BEFORE);
    let mut cargo = order.cargo();
    let outcome = receiver.execute_with(&order, &mut cargo);
    let answer = CommandAnswer::with_cargo(&order, &outcome, &cargo).to_json();
    CommandAnswer::from_json(answer.as_bytes()).expect("an answer can be read");
    scan(&mut receiver, &config.name, CYCLES_AFTER);
    Ok(())
}
