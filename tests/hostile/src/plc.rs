//! Input from a PLC to a gateway: by ADS, as datagrams, as lines on a pipe; up to the frames that it publishes.

use std::collections::VecDeque;

use coaxle_axis::{IMAGE_LEN, ImageLayout, NcToPlcAxis};
use coaxle_clock::{CycleIndex, Instant, Local, Span};
use coaxle_gateway::ams::{NOTIFICATION, READ, REPLY, notified, read_bytes, result, take_packet};
use coaxle_gateway::assembly::Assembly;
use coaxle_gateway::config::{GatewayConfig, ImageKind};
use coaxle_gateway::record::{read_record, record_len, write_image};
use coaxle_gateway::record_line::{head_line, read_line};
use coaxle_gateway::{Gateway, LinkState, PlcOutput, PlcSample, Port};
use coaxle_node::frame::KeySeal;
use coaxle_node::{Channel, Intake, Node};

use crate::Outcome;
use crate::seeds::root;

const CONFIG: &str =
    "name = 'plc'\ncycle-time-us = 1000\n[pipe]\n[[axis]]\nid = 7\nname = 'belt'\n";
/// Cycle time of the PLC.
const CYCLE: Span = Span::from_millis(1);
/// The axis of that.
const ID: u32 = 7;
/// Number of good cycles before the input, after which the PLC's clock is known.
const CYCLES_BEFORE: u16 = 400;
/// Bytes of a cycle index.
const INDEX_LEN: usize = 2;
/// Most samples that a gateway is run for.
const MOST_SAMPLES: usize = 1_000;
/// Path of the recording of a connection, whose responses are good input.
const RECORDED: &str = "common/gateway/src/host/ads/recorded.txt";

/// Samples that came, one for each cycle of the PLC.
#[derive(Default)]
struct ReceivedSamples {
    samples: VecDeque<PlcSample>,
    /// Time at which the newest was taken.
    taken: Option<Instant<Local>>,
}

impl ReceivedSamples {
    fn push(&mut self, index: CycleIndex, axis: NcToPlcAxis) {
        self.samples.push_back(PlcSample {
            at: Instant::EPOCH,
            index,
            connection: 1,
            axes: vec![axis].into(),
        });
    }

    /// Has a gateway that knows its PLC publish every sample: receivers must take finite numbers from its frames.
    fn publish(mut self) {
        let config: GatewayConfig =
            coaxle_node::config::parse("plc.toml", CONFIG).expect("a config");
        self.samples.truncate(MOST_SAMPLES);
        let mut before = Self::default();
        for cycle in 0..CYCLES_BEFORE {
            // From 65 000 on, so that the input finds an index close to its wrap.
            before.push(CycleIndex(65_000 + cycle), moving(cycle));
        }
        before.samples.append(&mut self.samples);
        // Twice as many cycles as samples, since a gateway takes at most one per cycle and may wait for some.
        let scans = 2 * before.samples.len() + 10;
        let key = config.name.channel_key(Channel::Axes);
        let mut intake = Intake::new(&key, &config.name, &[ID]);
        let mut gateway = Gateway::new(&config, before, Instant::EPOCH, 1);
        let (mut sealed, mut frames) = (Vec::new(), 0);
        for _ in 0..scans {
            let now = gateway.next_cycle();
            gateway.cycle(now);
            while let Some(outgoing) = gateway.transmit() {
                if !outgoing.channel.carries_axes() {
                    continue;
                }
                frames += 1;
                KeySeal::new(&key).seal(outgoing.body, None, &mut sealed);
                if let Ok(frame) = intake.accept(&sealed) {
                    let mut taken = frame.axes.iter().flatten();
                    assert!(taken.all(|axis| axis.set.position.is_finite()));
                }
            }
        }
        assert!(frames > 0, "it published what came before");
    }
}

impl Port for ReceivedSamples {
    fn receive(&mut self, now: Instant<Local>, sample: &mut PlcSample) -> bool {
        // A sample per cycle of the PLC: a burst would be a fault of its own.
        if self.taken.is_some_and(|taken| now < taken + CYCLE) {
            return false;
        }
        let Some(next) = self.samples.pop_front() else {
            return false;
        };
        self.taken = Some(now);
        sample.replace(&next);
        sample.at = now;
        true
    }

    fn send(&mut self, _: &PlcOutput<'_>) {}

    fn state(&self) -> LinkState {
        LinkState {
            is_up: true,
            connections: 1,
            ..LinkState::default()
        }
    }
}

/// Input of a PLC over an ADS connection, as its gateway takes it: responses with an index or an image, and notifications.
pub(crate) fn ads(data: &[u8]) -> Outcome {
    let (mut rest, mut came, mut index) = (data, ReceivedSamples::default(), CycleIndex(0));
    let mut assembly = Assembly::of(&[INDEX_LEN, IMAGE_LEN]);
    let mut ended = Ok(());
    loop {
        let (packet, end) = match take_packet(rest) {
            Ok(Some(taken)) => taken,
            Ok(None) => break,
            Err(error) => {
                ended = Err(error.to_string());
                break;
            }
        };
        // Otherwise this loop would never end.
        assert!(end > 0, "a packet of nothing");
        rest = &rest[end..];
        let Some(packet) = packet else { continue };
        match (packet.command, packet.flags) {
            (NOTIFICATION, _) => {
                let is_whole = notified(packet.data, |sample| {
                    // Index and image differ by their lengths, which are those of the assembly.
                    let part = usize::from(sample.data.len() == IMAGE_LEN);
                    if let Ok(true) = assembly.take(sample.stamp, part, sample.data) {
                        let [number, image] = assembly.parts() else {
                            return;
                        };
                        take_value(number, &mut index, &mut came);
                        take_value(image, &mut index, &mut came);
                    }
                });
                if !is_whole {
                    ended = Err("a notification of the PLC ends in the middle of a sample".into());
                    break;
                }
            }
            (READ, REPLY) => match result(packet.data) {
                Ok(value) => {
                    take_value(read_bytes(value).unwrap_or_default(), &mut index, &mut came);
                }
                Err(refusal) => ended = Err(refusal.to_string()),
            },
            _ => {}
        }
    }
    came.publish();
    ended
}

/// A value of two bytes is the index, and one as long as an image is the axis of it.
fn take_value(value: &[u8], index: &mut CycleIndex, came: &mut ReceivedSamples) {
    if let [low, high] = value {
        *index = CycleIndex(u16::from_le_bytes([*low, *high]));
    } else if let Ok(axis) = NcToPlcAxis::from_image_slice(ImageLayout::AxisRef, value) {
        came.push(*index, axis);
    }
}

/// The responses of the recorded connection.
pub(crate) fn recorded() -> Vec<(String, Vec<u8>)> {
    let text = std::fs::read_to_string(root().join(RECORDED)).expect("the recording");
    let answers = text.lines().filter_map(|line| line.strip_prefix("< "));
    let bytes = |hex: &str| -> Vec<u8> {
        let byte = |n| u8::from_str_radix(&hex[n..n + 2], 16).expect("two digits");
        (0..hex.len()).step_by(2).map(byte).collect()
    };
    vec![("recorded".to_owned(), answers.flat_map(bytes).collect())]
}

/// Datagrams, each as its length in two bytes and its content, in both layouts.
pub(crate) fn datagrams(data: &[u8]) -> Outcome {
    let mut outcome = Ok(());
    // Both layouts read the same bytes: each refuses what only the other knows.
    for layout in [ImageLayout::TwinCat2, ImageLayout::AxisRef] {
        let (mut rest, mut came) = (data, ReceivedSamples::default());
        while let [low, high, more @ ..] = rest {
            let length = usize::from(u16::from_le_bytes([*low, *high]));
            let (datagram, after) = more.split_at(more.len().min(length));
            rest = after;
            let mut axes = [NcToPlcAxis::default()];
            match read_record(layout, datagram, &mut axes) {
                Ok(index) => came.push(index, axes[0]),
                Err(error) => outcome = Err(error.to_string()),
            }
        }
        came.publish();
    }
    outcome
}

/// An axis that goes on, as its PLC sends it.
pub(crate) fn good_datagrams() -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for cycle in 0..60_u16 {
        let mut record = index_of(cycle).to_le_bytes().to_vec();
        write_image(
            ImageKind::NcToPlc,
            ImageLayout::TwinCat2,
            &moving(cycle),
            &mut record,
        );
        let length = u16::try_from(record_len(1)).expect("a short record");
        all.extend_from_slice(&length.to_le_bytes());
        all.extend_from_slice(&record);
    }
    vec![("moving".to_owned(), all)]
}

/// Lines of a pipe, each a record; the first may name the columns.
pub(crate) fn lines(data: &[u8]) -> Outcome {
    let text = std::str::from_utf8(data).map_err(|error| error.to_string())?;
    let (mut came, mut outcome) = (ReceivedSamples::default(), Ok(()));
    let head = head_line(["belt"].into_iter());
    for line in text.lines().filter(|line| *line != head) {
        let mut axes = [NcToPlcAxis::default()];
        match read_line(line, &mut axes) {
            Ok(index) => came.push(index, axes[0]),
            Err(error) => outcome = Err(error.to_string()),
        }
    }
    came.publish();
    outcome
}

/// The moving axis as lines.
pub(crate) fn good_lines() -> Vec<(String, Vec<u8>)> {
    let mut text = head_line(["belt"].into_iter()) + "\n";
    for cycle in 0..60_u16 {
        let axis = moving(cycle);
        let index = index_of(cycle);
        text += &format!("{index},{},{},0\n", axis.set_position, axis.set_velocity);
    }
    vec![("moving".to_owned(), text.into_bytes())]
}

/// Index of a cycle, after those of the good cycles before.
const fn index_of(cycle: u16) -> u16 {
    65_000_u16.wrapping_add(CYCLES_BEFORE + cycle)
}

fn moving(cycle: u16) -> NcToPlcAxis {
    NcToPlcAxis {
        set_position: 0.5 * f64::from(cycle),
        set_velocity: 500.0,
        ..NcToPlcAxis::default()
    }
}
