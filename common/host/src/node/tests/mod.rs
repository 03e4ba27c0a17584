//! Nodes of the smallest kind on a transport.

mod in_process;
mod over_zenoh;
mod stepped;

use std::sync::{Arc, Mutex};

use assert_no_alloc::AllocDisabler;
use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_node::command::{SlaveName, SlaveOrder};
use coaxle_node::config::{
    ClockConfig, LinkConfig, RealTimeConfig, TimingEndpoints, TransportConfig, parse,
};
use coaxle_node::frame::{FrameHeader, body_capacity, encode_body, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{Publication, Subscription, Wiring};
use coaxle_node::{Channel, CommandOrder, Intake};
use coaxle_slave::Command;
use coaxle_topology::{PlantNode, PlantRole};
use serde_json::{Map, Value};

use crate::node::toy::{Toy, ToySnapshot};
use crate::node::{Record, Recorder, Setup};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const AXIS: u32 = 7;

/// Remembers the last record and the number of records.
#[derive(Clone, Default)]
struct Memory(Arc<Mutex<Remembered>>);

#[derive(Clone, Copy, Default)]
struct Remembered {
    records: u64,
    in_order: bool,
    last: Option<Record<ToySnapshot>>,
    finished: bool,
}

impl Memory {
    fn get(&self) -> Remembered {
        *self.0.lock().unwrap()
    }
}

impl Recorder<ToySnapshot> for Memory {
    fn record(&mut self, record: &Record<ToySnapshot>) {
        let mut memory = self.0.lock().unwrap();
        let later = memory
            .last
            .is_none_or(|last| record.ideal_start > last.ideal_start);
        // Latches: a single step back makes the flag false for good.
        memory.in_order = later && (memory.in_order || memory.records == 0);
        memory.records += 1;
        memory.last = Some(*record);
    }

    fn status(&self) -> Map<String, Value> {
        Map::new()
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.0.lock().unwrap().finished = true;
        Ok(())
    }
}

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

/// The body of a frame of the node `sender` with one axis.
fn body(sender: &NodeName, epoch: u64) -> Vec<u8> {
    let header = FrameHeader {
        sender: sender_id(sender),
        epoch,
        index: CycleIndex(1),
        count: 1,
        cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
        present_after: None,
        send_stamp: None,
    };
    let axis = NcToPlcAxis {
        axis_id: AXIS,
        ..NcToPlcAxis::default()
    };
    let mut body = vec![0; body_capacity(1)];
    let length = encode_body(&header, &[axis], &mut body).unwrap();
    body.truncate(length);
    body
}

fn setup(node: &str, transport: TransportConfig, secs: i64, memory: &Memory) -> Setup<Toy> {
    let sender = name(node);
    Setup {
        name: name(node),
        role: "toy",
        transport,
        real_time: RealTimeConfig::default(),
        clock: ClockConfig::default(),
        seed: 1,
        lab: None,
        send_stamps: true,
        wiring: Wiring {
            node: name(node),
            publications: vec![Publication::new(&sender, Channel::Axes)],
            subscriptions: Vec::new(),
        },
        plant: plant(node),
        timing: TimingEndpoints::default(),
        run_for: Some(Span::from_secs(secs)),
        build: Box::new(move |start, epoch| {
            let cycle_time = CycleTime::new(Span::from_millis(2))?;
            Ok(Toy::sending(start, cycle_time, body(&sender, epoch)))
        }),
        recorder: Box::new(memory.clone()),
        transport_service: None,
    }
}

/// A node that says nothing of its axes.
fn plant(node: &str) -> PlantNode {
    PlantNode {
        file: node.to_owned(),
        name: name(node),
        role: PlantRole::Unknown,
        cycle_time: CycleTime::new(Span::from_millis(2)).ok(),
        axes: Vec::new(),
        is_complete: true,
        hold_back: None,
    }
}

fn following(source: &str, axis: u32, faults: &str) -> Vec<Subscription> {
    let node = name(source);
    vec![Subscription {
        reader: Intake::new(&node.channel_key(Channel::Axes), &node, &[axis]).into(),
        node,
        channel: Channel::Axes,
        far: 0,
        faults: parse::<LinkConfig>("test", faults).unwrap(),
    }]
}

fn order(slave: &str, command: Command) -> CommandOrder {
    let slave = SlaveName::new(slave).unwrap();
    let dry_run = false;
    SlaveOrder {
        addressee: slave,
        command,
        dry_run,
    }
    .into()
}
