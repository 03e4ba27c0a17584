//! Two toy nodes over real Zenoh on loopback. Bounds in time are wide: the machine may be busy.

use std::net::TcpListener;
use std::sync::{Arc, Mutex};

use assert_no_alloc::AllocDisabler;
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_motion::axis::NcToPlcAxis;
use coaxle_motion::slave::Command;
use coaxle_node::command::{SlaveName, Verdict};
use coaxle_node::config::{ClockConfig, LinkConfig, RealTimeConfig, TransportConfig, parse};
use coaxle_node::frame::{FrameHeader, body_capacity, encode_body, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, CommandOrder, Intake};
use serde_json::{Map, Value};
use zenoh::Wait;

use crate::toy::{Toy, ToySnapshot};
use crate::{
    Commander, Ended, Outcome, Publication, Record, Recorder, Setup, Subscription, run,
    zenoh_config,
};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const AXIS: u32 = 7;

/// Remembers the last record and how many there were.
#[derive(Clone, Default)]
struct Memory(Arc<Mutex<Remembered>>);

#[derive(Clone, Copy, Default)]
struct Remembered {
    records: u64,
    in_order: bool,
    last: Option<Record<ToySnapshot>>,
    finished: bool,
}

impl Recorder<ToySnapshot> for Memory {
    fn record(&mut self, record: &Record<ToySnapshot>) {
        let mut memory = self.0.lock().unwrap();
        let later = memory
            .last
            .is_none_or(|last| record.ideal_start > last.ideal_start);
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

/// An endpoint that is free now.
fn endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0")
        .and_then(|listener| listener.local_addr())
        .unwrap()
        .port();
    format!("tcp/127.0.0.1:{port}")
}

fn listening(endpoint: &str) -> TransportConfig {
    parse("test", &format!("listen = [{endpoint:?}]")).unwrap()
}

fn connecting(endpoint: &str) -> TransportConfig {
    parse("test", &format!("connect = [{endpoint:?}]")).unwrap()
}

/// The body of a frame of the node `sender` with the one axis.
fn body(sender: &NodeName, epoch: u64) -> Vec<u8> {
    let header = FrameHeader {
        sender: sender_id(sender),
        epoch,
        index: CycleIndex(1),
        count: 1,
        cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
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
        send_stamps: true,
        publishes: vec![Publication::new(&sender, Channel::Axes)],
        subscriptions: Vec::new(),
        run_for: Some(Span::from_secs(secs)),
        build: Box::new(move |start, epoch| {
            let cycle_time = CycleTime::new(Span::from_millis(2))?;
            Ok(Toy::sending(start, cycle_time, body(&sender, epoch)))
        }),
        recorder: Box::new(memory.clone()),
    }
}

fn following(source: &str, axis: u32, faults: &str) -> Vec<Subscription> {
    let node = name(source);
    vec![Subscription {
        reader: Intake::new(&node.channel_key(Channel::Axes), &node, axis).into(),
        node,
        channel: Channel::Axes,
        faults: parse::<LinkConfig>("test", faults).unwrap(),
    }]
}

fn started(
    setup: impl FnOnce() -> Setup<Toy> + Send + 'static,
) -> std::thread::JoinHandle<Outcome> {
    std::thread::spawn(move || run(setup()).unwrap())
}

/// Collects a node's status until `wanted` says that is enough, for half a minute at most.
fn watch(endpoint: &str, node: &str, wanted: impl Fn(&Value) -> bool) -> Vec<Value> {
    let session = zenoh::open(zenoh_config(&connecting(endpoint)).unwrap())
        .wait()
        .unwrap();
    let statuses = session
        .declare_subscriber(name(node).status_key())
        .wait()
        .unwrap();
    let mut seen = Vec::new();
    for _ in 0..120 {
        let wait = std::time::Duration::from_millis(250);
        if let Ok(Some(sample)) = statuses.recv_timeout(wait) {
            let status = serde_json::from_slice(&sample.payload().to_bytes()).unwrap();
            let enough = wanted(&status);
            seen.push(status);
            if enough {
                break;
            }
        }
    }
    session.close().wait().unwrap();
    seen
}

#[test]
fn frames_arrive_and_both_ends_say_so() {
    let at = endpoint();
    let (sender_memory, memory) = (Memory::default(), Memory::default());
    let sender = {
        let (at, memory) = (at.clone(), sender_memory.clone());
        started(move || setup("belt", listening(&at), 8, &memory))
    };
    let receiver = {
        let (at, memory) = (at.clone(), memory.clone());
        started(move || {
            let mut setup = setup("saw", connecting(&at), 6, &memory);
            setup.publishes.clear();
            setup.subscriptions = following("belt", AXIS, "");
            setup
        })
    };
    let healthy = |status: &Value| status["health"] == "ok";
    let seen = watch(&at, "belt", healthy);
    let last = seen.last().expect("a status came");
    assert_eq!(last["health"], "ok", "{last}");
    assert_eq!(last["followed"], true);

    let (sent, got) = (sender.join().unwrap(), receiver.join().unwrap());
    assert_eq!((sent.ended, got.ended), (Ended::TimeUp, Ended::TimeUp));
    assert!(sent.published > 100 && sent.not_published == 0, "{sent:?}");
    assert!(got.received > 100 && got.refused == 0, "{got:?}");

    let remembered = *memory.0.lock().unwrap();
    assert!(remembered.finished && remembered.in_order);
    assert_eq!(remembered.records + got.telemetry_dropped, got.cycles);
    let samples = remembered.last.unwrap().snapshot.samples;
    assert!(samples > 100 && samples <= got.received, "{samples}");
}

/// A Zenoh router on a free endpoint; it ends with the session.
fn router(endpoint: &str) -> zenoh::Session {
    let mut config = zenoh_config(&listening(endpoint)).unwrap();
    config.insert_json5("mode", "\"router\"").unwrap();
    zenoh::open(config).wait().unwrap()
}

/// A router forwards between clients, and between a client and a peer; never between two peers.
#[test]
fn clients_talk_through_a_router() {
    for sender_mode in ["client", "peer"] {
        let at = endpoint();
        let router = router(&at);
        let through = |mode: &str| -> TransportConfig {
            parse("test", &format!("mode = {mode:?}\nconnect = [{at:?}]")).unwrap()
        };
        let (from, to) = (through(sender_mode), through("client"));
        let sender = started(move || setup("belt", from, 6, &Memory::default()));
        let receiver = started(move || {
            let mut setup = setup("saw", to, 5, &Memory::default());
            setup.publishes.clear();
            setup.subscriptions = following("belt", AXIS, "");
            setup
        });
        let (sent, got) = (sender.join().unwrap(), receiver.join().unwrap());
        assert!(sent.published > 100, "{sender_mode}: {sent:?}");
        assert!(
            got.received > 100 && got.refused == 0,
            "{sender_mode}: {got:?}"
        );
        router.close().wait().unwrap();
    }
}

#[test]
fn a_follower_without_its_source_is_never_healthy() {
    let at = endpoint();
    let memory = Memory::default();
    let lonely = {
        let (at, memory) = (at.clone(), memory.clone());
        started(move || {
            let mut setup = setup("lonely", listening(&at), 7, &memory);
            setup.subscriptions = following("nobody", AXIS, "");
            setup
        })
    };
    let seen = watch(&at, "lonely", |status| status["health"] == "stopped");
    assert!(
        seen.iter().any(|status| status["health"] == "waiting"),
        "{seen:?}"
    );
    assert!(
        seen.iter().all(|status| status["health"] != "ok"),
        "{seen:?}"
    );
    assert_eq!(seen[0]["source"], "nobody");
    assert_eq!(seen[0]["source_alive"], false);
    assert_eq!(lonely.join().unwrap().received, 0);
}

#[test]
fn frames_without_the_axis_are_refused_and_are_no_health() {
    let at = endpoint();
    let (sender_memory, memory) = (Memory::default(), Memory::default());
    let sender = {
        let (at, memory) = (at.clone(), sender_memory.clone());
        started(move || setup("press", listening(&at), 7, &memory))
    };
    let receiver = {
        let (at, memory) = (at.clone(), memory.clone());
        started(move || {
            let mut setup = setup("picky", connecting(&at), 5, &memory);
            setup.publishes.clear();
            setup.subscriptions = following("press", AXIS + 1, "");
            setup
        })
    };
    let got = receiver.join().unwrap();
    sender.join().unwrap();
    assert!(got.refused > 100 && got.received == 0, "{got:?}");
    let rejected = memory.0.lock().unwrap().last.unwrap().snapshot.rejected;
    assert!(rejected > 100, "{rejected}");
}

#[test]
fn faults_over_the_link_lose_and_delay() {
    let at = endpoint();
    let (sender_memory, memory) = (Memory::default(), Memory::default());
    let sender = {
        let (at, memory) = (at.clone(), sender_memory.clone());
        started(move || setup("oven", listening(&at), 7, &memory))
    };
    let receiver = {
        let (at, memory) = (at.clone(), memory.clone());
        started(move || {
            let mut setup = setup("late", connecting(&at), 5, &memory);
            setup.subscriptions = following("oven", AXIS, "latency-us = 30000000\nloss = 0.5");
            setup
        })
    };
    let (sent, got) = (sender.join().unwrap(), receiver.join().unwrap());
    assert!(got.received > 50, "{got:?}");
    assert!(got.received < sent.published * 3 / 4, "{sent:?} {got:?}");
    // The stamp lies half a minute ahead, longer than the whole run.
    let snapshot = memory.0.lock().unwrap().last.unwrap().snapshot;
    assert!(snapshot.last_arrival.since_epoch() > Span::from_secs(25));
}

fn order(slave: &str, command: Command) -> CommandOrder {
    CommandOrder {
        slave: SlaveName::new(slave).unwrap(),
        command,
        dry_run: false,
    }
}

#[test]
fn orders_reach_the_cycle_and_are_answered() {
    let at = endpoint();
    let memory = Memory::default();
    let node = {
        let (at, memory) = (at.clone(), memory.clone());
        started(move || setup("servo", listening(&at), 8, &memory))
    };
    let commander = Commander::open(&connecting(&at)).unwrap();
    let send = |order: &CommandOrder| commander.send(&name("servo"), order).unwrap();
    for (k, position) in [(1, 2.5), (2, -7.0)] {
        let answer = send(&order("toy", Command::Home { position }));
        let Verdict::Accepted { job, axis, .. } = answer.verdict else {
            panic!("{answer:?}");
        };
        assert_eq!((job, axis.position), (Some(k), position));
    }
    let refused = send(&order("toy", Command::Reset {}));
    let Verdict::Refused { code, text, .. } = refused.verdict else {
        panic!("{refused:?}");
    };
    assert_eq!(code, "0x4b09");
    assert!(text.contains("no master"), "{text}");
    let unknown = send(&order("other", Command::Reset {}));
    assert!(!unknown.is_taken(), "{unknown:?}");
    commander.close();

    assert_reason(&at, "coaxle/servo/command", "{ no order }", "malformed");
    let halt = order("toy", Command::Home { position: 9.0 }).to_json();
    assert_reason(&at, "coaxle/*/command", &halt, "malformed");
    node.join().unwrap();
    let snapshot = memory.0.lock().unwrap().last.unwrap().snapshot;
    assert_eq!(snapshot.commands, 2);
}

/// A query as any tool may send it, and the reason it gets as an error reply.
fn assert_reason(endpoint: &str, key: &str, payload: &str, expected: &str) {
    let session = zenoh::open(zenoh_config(&connecting(endpoint)).unwrap())
        .wait()
        .unwrap();
    let mut answers = Vec::new();
    for _ in 0..100 {
        let replies = session.get(key).payload(payload).wait().unwrap();
        while let Ok(reply) = replies.recv() {
            let error = reply.result().expect_err("no slave gets this");
            let payload = error.payload().to_bytes();
            answers.push(serde_json::from_slice::<Value>(&payload).unwrap());
        }
        if !answers.is_empty() {
            break;
        }
        // Not connected yet.
        std::thread::park_timeout(std::time::Duration::from_millis(50));
    }
    assert_eq!(answers[0]["reason"], expected, "{answers:?}");
    session.close().wait().unwrap();
}

#[test]
fn an_order_to_nobody_says_who_was_asked_and_where() {
    let at = endpoint();
    let commander = Commander::open(&listening(&at)).unwrap();
    let halt = order("toy", Command::Reset {});
    let error = commander.send(&name("ghost"), &halt).unwrap_err();
    let message = format!("{error:#}");
    assert!(message.contains("node ghost takes no orders"), "{message}");
    assert!(message.contains("coaxle/ghost/command"), "{message}");
    assert!(message.contains(&at), "{message}");
    commander.close();
}

#[test]
fn a_port_in_use_is_an_error_that_names_it() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let at = format!("tcp/{}", taken.local_addr().unwrap());
    let error = run(setup("second", listening(&at), 5, &Memory::default())).unwrap_err();
    let message = format!("{error:#}");
    assert!(
        message.contains("cannot open the Zenoh session"),
        "{message}"
    );
    assert!(message.contains(&at), "{message}");
    assert!(message.contains("in use"), "{message}");
    assert!(!message.contains(".rs:"), "{message}");
}

#[test]
fn a_wrong_zenoh_setting_is_an_error_that_names_it() {
    let transport = parse("test", "settings = { \"scouting/delay\" = \"soon\" }").unwrap();
    let error = run(setup("wrong", transport, 5, &Memory::default())).unwrap_err();
    let message = format!("{error:#}");
    assert!(
        message.contains("\"scouting/delay\" = \"soon\""),
        "{message}"
    );
}

#[test]
fn a_client_without_its_router_is_an_error() {
    let at = endpoint();
    let transport = parse("test", &format!("mode = \"client\"\nconnect = [{at:?}]")).unwrap();
    let error = run(setup("client", transport, 5, &Memory::default())).unwrap_err();
    let message = format!("{error:#}");
    assert!(
        message.contains("cannot open the Zenoh session"),
        "{message}"
    );
    assert!(message.contains(&at), "{message}");
}

#[test]
fn a_node_that_cannot_be_built_is_an_error_before_anything_opens() {
    let mut setup = setup("broken", TransportConfig::default(), 5, &Memory::default());
    setup.build = Box::new(|_, _| anyhow::bail!("no axis"));
    let message = format!("{:#}", run(setup).unwrap_err());
    assert_eq!(message, "cannot build node broken: no axis");
}

#[test]
fn a_recorder_that_fails_is_an_error_after_a_clean_end() {
    struct Full;
    impl Recorder<ToySnapshot> for Full {
        fn record(&mut self, _: &Record<ToySnapshot>) {}
        fn status(&self) -> Map<String, Value> {
            Map::new()
        }
        fn finish(&mut self) -> anyhow::Result<()> {
            anyhow::bail!("no space left")
        }
    }
    let mut setup = setup("full", TransportConfig::default(), 1, &Memory::default());
    setup.recorder = Box::new(Full);
    let message = format!("{:#}", run(setup).unwrap_err());
    assert_eq!(
        message,
        "the recorder could not keep what it recorded: no space left"
    );
}
