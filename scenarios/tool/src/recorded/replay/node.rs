//! The receiver that is run again.

use std::io::Write;

use anyhow::Context;
use coaxle_clock::{Instant, Local};
use coaxle_node::{Node, NodeScan};
use coaxle_receiver::{DriveConfig, Drives, Receiver, ReceiverConfig};
use coaxle_recording::{Facts, RowEncoder, Table, Writer};

/// The receiver, and where its rows go.
pub(super) struct ReplayedReceiver<W: Write> {
    receiver: Receiver,
    encoder: RowEncoder,
    writer: Writer<W>,
    cycles: u64,
    /// Times of the first and the newest cycle, ns of the recorded machine.
    span_ns: Option<(i64, i64)>,
    notes: Vec<String>,
}

impl<W: Write> ReplayedReceiver<W> {
    /// The receiver before its first cycle.
    pub(super) fn start(
        config: &ReceiverConfig,
        epoch: u64,
        out: W,
        facts: &Facts,
    ) -> anyhow::Result<Self> {
        // As the host starts the node: its clock begins at the phase of the config.
        let first: Instant<Local> = Instant::EPOCH + config.clock.start_phase();
        // Simulated in any case, because a drive in another process is not there any more.
        let receiver = Receiver::with_drives(config, Drives::simulated(), first, epoch)?;
        let table = Table {
            name: config.name.to_string(),
            role: "receiver".to_owned(),
            instances: config.instances(),
        };
        // The offset of the recording, so that both files have the same times.
        let offset = facts.get("clock-offset-ns").and_then(|ns| ns.parse().ok());
        let mut facts: Facts = facts.clone();
        facts.insert("replayed".to_owned(), env!("CARGO_PKG_VERSION").to_owned());
        let tables = std::slice::from_ref(&table);
        let writer = Writer::create(out, tables, &facts, offset.unwrap_or_default());
        Ok(Self {
            encoder: RowEncoder::of(&table),
            writer: writer.context("the replay")?,
            receiver,
            cycles: 0,
            span_ns: None,
            notes: notes(config),
        })
    }

    /// Reservations about the comparison.
    pub(super) fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Gives the receiver the recorded inputs of a scan, and runs the scan.
    pub(super) fn scan(&mut self, at_ns: i64, woke_ns: i64, scan: &NodeScan) -> anyhow::Result<()> {
        let receiver = &mut self.receiver;
        for received in &scan.received {
            // Messages first, then circles, then orders, then the cycle: the order in which a host hands them over.
            receiver.receive(received.at, received.subscription, &received.message.get());
        }
        for change in &scan.circles {
            receiver.set_circle(*change);
        }
        for order in &scan.orders {
            let _ = receiver.execute(order);
        }
        let _ = receiver.cycle(scan.now);
        // Nobody hears the frames, but the node keeps them until they are fetched.
        while receiver.transmit().is_some() {}
        while receiver.arrival().is_some() {}
        let signals = &receiver.snapshot().signals;
        // The real start of the recorded cycle: a row has both times.
        let row = self.encoder.encode(at_ns, woke_ns, signals)?;
        self.writer.row(0, &row).context("the replay")?;
        self.cycles += 1;
        let (first, _) = self.span_ns.unwrap_or((at_ns, at_ns));
        self.span_ns = Some((first, at_ns));
        Ok(())
    }

    /// Number of cycles, and their time in seconds.
    pub(super) fn finish(self) -> anyhow::Result<(u64, f64)> {
        self.writer.finish().context("the replay")?;
        let seconds = |(first, last): (i64, i64)| last.saturating_sub(first) as f64 * 1e-9;
        Ok((self.cycles, self.span_ns.map_or(0.0, seconds)))
    }
}

/// Notes on drives in other processes, whose responses are in no recording.
fn notes(config: &ReceiverConfig) -> Vec<String> {
    let slaves = config.slaves.iter();
    let is_outside = |drive: &DriveConfig| matches!(drive, DriveConfig::SharedMemory(_));
    slaves
        .filter(|slave| is_outside(&slave.drive))
        .map(|slave| {
            format!(
                "slave {}: its drive was another process; here it is simulated, so what it says differs",
                slave.name
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::Channel;
    use coaxle_node::circles::{CircleChange, CircleState};
    use coaxle_receiver::HealthName;

    #[test]
    fn a_circle_in_which_the_receiver_was_is_replayed() {
        let text = "name = 'a'\ncycle-time-us = 2000\n\
             [[far]]\nnode = 'b'\nchannel = 'slaves'\naxes = [{ id = 1, name = 'far' }]\n\
             [[slave]]\nname = 'loop'\nid = 1\nmaster = 'far'\ncouple = 'off'\n\
             limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }\n";
        let config = coaxle_node::config::parse("a", text).unwrap();
        let mut replayed = ReplayedReceiver::start(&config, 1, Vec::new(), &Facts::new()).unwrap();
        let mut health = |circles: &[CircleState], cycle: i64| {
            let change = |state: &CircleState| CircleChange {
                channel: Channel::Slaves,
                id: 1,
                state: *state,
            };
            let scan = NodeScan {
                circles: circles.iter().map(change).collect(),
                now: Instant::from_nanos(2_000_000 * cycle),
                ..NodeScan::default()
            };
            replayed.scan(0, 0, &scan).unwrap();
            replayed.receiver.snapshot().signals.node.health
        };
        assert_ne!(health(&[], 1), HealthName::Circle);
        assert_eq!(health(&[CircleState::Open], 2), HealthName::Circle);
        assert_eq!(health(&[], 3), HealthName::Circle);
        assert_ne!(health(&[CircleState::None], 4), HealthName::Circle);
    }
}
