//! A recorded connection to a third-party server (`tests/gateway/record_ads.py`), replayed without a network: the gateway
//! sends what it sent then, byte for byte, and receives the recorded responses of the server.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use coaxle_axis::{ImageLayout, NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, Instant, Span};

use super::client::{AdsClient, AdsError};
use super::plc::{Polling, Writing};
use super::wire::AdsWire;
use crate::ams::{AmsAddress, Packet, READ, VALUE_BY_HANDLE, WRITE, take_packet};
use crate::config::GatewayConfig;
use crate::host::port::{OutputSlot, StopFlag, rings};
use crate::{PlcSample, Port};

const RECORDED: &str = include_str!("recorded.txt");

/// Config of the recording, except for the PLC's address.
const CONFIG: &str = "
    name = 'plc'
    cycle-time-us = 100000
    [ads]
    address = '127.0.0.1'
    net-id = '127.0.0.1.1.1'
    cycle-index = 'GVL.nCycleIndex'
    [[axis]]
    id = 1
    name = 'conveyor'
    symbol = 'GVL.stConveyor'
    [[output]]
    node = 'saw'
    channel = 'slaves'
    cycle-index = 'GVL.nReceivedIndex'
    [[output.axis]]
    id = 1
    symbol = 'GVL.stCorrected'
    [[output.axis]]
    id = 2
    symbol = 'GVL.stSetValues'
    image = 'external-set-values'
";

/// The velocities of the axis in the server and of the slave, mm/s, and the distance of the axis per cycle, mm.
const VELOCITY: f64 = 500.0;
const SLAVE_VELOCITY: f64 = 250.0;
// 500 mm/s · 100 ms.
const STEP: f64 = 50.0;

/// A recorded packet.
#[derive(Clone, Debug)]
struct RecordedPacket {
    is_of_gateway: bool,
    bytes: Vec<u8>,
}

fn recorded() -> VecDeque<RecordedPacket> {
    let lines = RECORDED.lines().filter(|line| !line.starts_with('#'));
    let packet = |line: &str| {
        let (who, hex) = line.split_once(' ').unwrap();
        let byte = |n: usize| u8::from_str_radix(&hex[2 * n..2 * n + 2], 16).unwrap();
        RecordedPacket {
            is_of_gateway: who == ">",
            bytes: (0..hex.len() / 2).map(byte).collect(),
        }
    };
    lines.map(packet).collect()
}

/// Rest of the recording.
#[derive(Clone)]
struct Tape(Arc<Mutex<VecDeque<RecordedPacket>>>);

impl Tape {
    fn next(&self) -> Option<RecordedPacket> {
        self.0.lock().unwrap().pop_front()
    }

    /// The gateway's request at this place of the rest: command, index group and offset, data behind the length.
    fn request(&self, ahead: usize) -> Option<(u16, [u32; 2], Vec<u8>)> {
        let left = self.0.lock().unwrap();
        let sent = left
            .iter()
            .filter(|packet| packet.is_of_gateway)
            .nth(ahead)?;
        let (packet, _) = take_packet(&sent.bytes).unwrap().unwrap();
        let packet = packet.unwrap();
        let number = |n: usize| {
            let four = packet.data.get(4 * n..4 * n + 4);
            four.map_or(0, |four| u32::from_le_bytes(four.try_into().unwrap()))
        };
        let rest = packet.data.get(12..).unwrap_or_default().to_vec();
        Some((packet.command, [number(0), number(1)], rest))
    }
}

impl AdsWire for Tape {
    fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        let expected = self.next().unwrap();
        assert!(expected.is_of_gateway, "it did not wait for its answer");
        assert_eq!(bytes, expected.bytes);
        Ok(())
    }

    /// In two pieces, as a network may bring it.
    fn receive(&mut self, bytes: &mut [u8], _: Span) -> std::io::Result<usize> {
        let mut left = self.0.lock().unwrap();
        let Some(next) = left.front_mut().filter(|packet| !packet.is_of_gateway) else {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        };
        // Rounded up, so that a single byte is not cut into nothing.
        let length = next.bytes.len().div_ceil(2);
        bytes[..length].copy_from_slice(&next.bytes[..length]);
        next.bytes.drain(..length);
        if next.bytes.is_empty() {
            left.pop_front();
        }
        Ok(length)
    }
}

/// Address of the gateway in the recording, which the first packet has.
fn address_of_gateway(tape: &VecDeque<RecordedPacket>) -> AmsAddress {
    let (packet, _) = take_packet(&tape[0].bytes).unwrap().unwrap();
    packet.unwrap().source
}

/// Next values written: the slaves of one cycle of the receiver, the first as a structure, the second as set values.
fn written(tape: &Tape) -> Option<OutputSlot> {
    let (WRITE, [VALUE_BY_HANDLE, _], image) = tape.request(0)? else {
        return None;
    };
    let carriage = NcToPlcAxis::from_image_slice(ImageLayout::AxisRef, &image).unwrap();
    let (_, _, values) = tape.request(1)?;
    let number = |n: usize| f64::from_le_bytes(values[8 * n..8 * n + 8].try_into().unwrap());
    let blade = NcToPlcAxis {
        set_position: number(0),
        set_velocity: number(1),
        set_acceleration: number(2),
        ..NcToPlcAxis::default()
    };
    let (_, _, index) = tape.request(2)?;
    Some(OutputSlot {
        number: 0,
        index: CycleIndex(u16::from_le_bytes(index.try_into().unwrap())),
        axes: vec![Some(carriage), Some(blade)].into(),
    })
}

#[test]
fn the_gateway_sends_what_it_sent_and_finds_what_the_server_held() {
    let config: GatewayConfig = coaxle_node::config::parse("recorded", CONFIG).unwrap();
    let packets = recorded();
    let own = address_of_gateway(&packets);
    let tape = Tape(Arc::new(Mutex::new(packets)));
    let (mut port, mut end) = rings(&config, Arc::new(StopFlag::default()));
    let ads = config.ads.as_ref().unwrap();
    let mut client = AdsClient::over(Box::new(tape.clone()), own, ads);

    assert_eq!(client.state().unwrap(), 5, "the server runs");
    let mut writings = Writing::prepare(&mut client, &config).unwrap();
    let mut polling = Polling::prepare(&mut client, &config, "GVL.nCycleIndex").unwrap();
    let (mut samples, mut outputs) = (Vec::new(), Vec::new());
    while let Some((command, [group, _], _)) = tape.request(0) {
        match (command, group) {
            (READ, VALUE_BY_HANDLE) => polling.poll(&mut client, &mut end, 1).unwrap(),
            (WRITE, VALUE_BY_HANDLE) => {
                let slot = written(&tape).unwrap();
                writings[0].write(&mut client, &slot).unwrap();
                outputs.push(slot);
            }
            _ => break,
        }
        let mut sample = PlcSample::of_axes(1);
        while port.receive(Instant::EPOCH, &mut sample) {
            samples.push((sample.index, sample.axes[0]));
        }
    }
    client.release_handles();
    assert!(tape.next().is_none(), "all of it was said");

    assert!(samples.len() >= 5, "{}", samples.len());
    for pair in samples.windows(2) {
        let cycles = pair[1].0.steps_since(pair[0].0);
        assert!(cycles >= 1, "{pair:?}");
        let way = pair[1].1.set_position - pair[0].1.set_position;
        // Exact: the server counts in whole cycles, and 50 mm are exact in binary.
        assert_eq!(way, STEP * f64::from(cycles));
    }
    for (_, axis) in &samples {
        assert_eq!(axis.set_velocity, VELOCITY);
        assert_eq!(axis.state_word, StateWord::OPERATIONAL | StateWord::HOMED);
    }
    assert!(outputs.len() >= 5, "{}", outputs.len());
    for slot in &outputs {
        let [carriage, blade] = [0, 1].map(|n| slot.axes[n].unwrap());
        assert_eq!(carriage.axis_id, 1);
        assert!((carriage.set_velocity - SLAVE_VELOCITY).abs() < 1e-9);
        // The second slave runs at twice the speed, backwards.
        assert!((blade.set_velocity + 2.0 * SLAVE_VELOCITY).abs() < 1e-9);
        assert_eq!(blade.set_position, -2.0 * carriage.set_position);
    }
}

#[test]
fn an_answer_of_another_length_is_refused_with_both() {
    let mut packets = recorded();
    let own = address_of_gateway(&packets);
    let config: GatewayConfig = coaxle_node::config::parse("recorded", CONFIG).unwrap();
    let first_value = packets.iter().position(|packet| {
        let (read, _) = take_packet(&packet.bytes).unwrap().unwrap();
        let read = read.unwrap();
        !packet.is_of_gateway && read.command == READ
    });
    let answer = &mut packets[first_value.unwrap()];
    let (read, _) = take_packet(&answer.bytes).unwrap().unwrap();
    let mut shorter = Vec::new();
    // No error, one byte, which is 7.
    let data = [0, 0, 0, 0, 1, 0, 0, 0, 7];
    Packet {
        data: &data,
        ..read.unwrap()
    }
    .write(&mut shorter);
    answer.bytes = shorter;
    let tape = Tape(Arc::new(Mutex::new(packets)));
    let (_port, mut end) = rings(&config, Arc::new(StopFlag::default()));
    let mut client = AdsClient::over(Box::new(tape.clone()), own, config.ads.as_ref().unwrap());
    let _ = client.state().unwrap();
    let _writings = Writing::prepare(&mut client, &config).unwrap();
    let mut polling = Polling::prepare(&mut client, &config, "GVL.nCycleIndex").unwrap();
    let refused = polling.poll(&mut client, &mut end, 1).unwrap_err();
    assert!(
        matches!(
            refused,
            AdsError::Length {
                received: 1,
                expected: 2,
                ..
            }
        ),
        "{refused}"
    );
}
