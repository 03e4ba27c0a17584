//! Nodes whose scans, publishing and status are called by the test itself at chosen instants: no
//! thread and no clock takes part.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex};

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_node::command::CommandVerdict;
use coaxle_node::config::ClockConfig;
use coaxle_node::wiring::{Publication, Subscription};
use coaxle_node::{Channel, Node};
use coaxle_os::machine::Machine;
use coaxle_slave::Command;
use rtrb::RingBuffer;
use serde_json::{Map, Value};

use super::{AXIS, body, following, name, order, plant};
use crate::client::Commander;
use crate::network::transport::InProcess;
use crate::network::transport::{Declared, Transport};
use crate::node::about::Abouts;
use crate::node::audit::Audit;
use crate::node::circles::CircleSearch;
use crate::node::commands::{CommandServer, commands};
use crate::node::counters::{Counters, count};
use crate::node::cycle::{Cycle, NodeClock};
use crate::node::mailbox::mailbox;
use crate::node::outbox::{OutgoingFrames, outbox};
use crate::node::panics::panics;
use crate::node::publisher::{PublishedChannel, publish_waiting};
use crate::node::session::Session;
use crate::node::status::{Identity, Reporter};
use crate::node::telemetry::{Record, Telemetry, telemetry};
use crate::node::toy::{Toy, ToySnapshot};

/// A network whose clock the test sets.
#[derive(Clone)]
struct Network {
    transport: InProcess,
    now: Arc<AtomicI64>,
}

impl Network {
    fn new() -> Self {
        let now = Arc::new(AtomicI64::new(0));
        let shown = Arc::clone(&now);
        let now_of = move || Instant::from_nanos(shown.load(Ordering::Relaxed));
        Self {
            transport: InProcess::dated_by(now_of),
            now,
        }
    }

    fn now(&self) -> Instant<Machine> {
        Instant::from_nanos(self.now.load(Ordering::Relaxed))
    }

    fn set(&self, now: Instant<Machine>) {
        self.now.store(now.as_nanos(), Ordering::Relaxed);
    }
}

/// A toy with a cycle of 2 ms and all parts of the host except threads.
struct Stepped {
    network: Network,
    cycle: Cycle<Toy>,
    frames: OutgoingFrames,
    channels: Vec<PublishedChannel>,
    telemetry: Telemetry<ToySnapshot>,
    server: CommandServer,
    session: Arc<Session>,
    counters: Arc<Counters>,
    reporter: Reporter,
    statuses: Arc<Mutex<Vec<Value>>>,
    _watched: Declared,
}

impl Stepped {
    /// Creates a node that publishes axes.
    fn sending(node: &str, network: &Network) -> Self {
        let publishes = [Publication::new(&name(node), Channel::Axes)];
        Self::new(node, network, &publishes, &[], false, None)
    }

    /// Creates a node that publishes axes, started for an experiment.
    fn in_lab(node: &str, network: &Network, lab: &str) -> Self {
        let publishes = [Publication::new(&name(node), Channel::Axes)];
        Self::new(node, network, &publishes, &[], false, Some(lab))
    }

    /// Creates a node that publishes axes in a secure network.
    fn sending_securely(node: &str, network: &Network) -> Self {
        let publishes = [Publication::new(&name(node), Channel::Axes)];
        Self::new(node, network, &publishes, &[], true, None)
    }

    /// Creates a node that follows another.
    fn following(node: &str, source: &str, axis: u32, faults: &str, network: &Network) -> Self {
        let subscriptions = following(source, axis, faults);
        Self::new(node, network, &[], &subscriptions, false, None)
    }

    fn new(
        node: &str,
        network: &Network,
        publishes: &[Publication],
        subscriptions: &[Subscription],
        in_secure_network: bool,
        lab: Option<&str>,
    ) -> Self {
        let node = name(node);
        let counters = Arc::new(Counters::default());
        let mut session =
            Session::open(Arc::new(network.transport.clone()), &node, 0xab, panics().0).unwrap();
        let channels = session.publish(publishes, 1).unwrap();
        let audit = Audit::new(&node, 0xab);
        let mut mailboxes = Vec::new();
        for subscription in subscriptions {
            let (inbox, mailbox) = mailbox(64, 64, Arc::clone(&counters.mailbox_dropped));
            session
                .subscribe(subscription, 1, inbox, Arc::clone(&counters))
                .unwrap();
            mailboxes.push(mailbox);
        }
        let (orders, server, requests) = commands(&node, &audit);
        session.serve_audit(&node, audit).unwrap();
        session.take_orders(&node, requests).unwrap();
        session.watch_receivers(&node).unwrap();
        let session = Arc::new(session);
        let (circle_search, circles) =
            CircleSearch::open(&node, subscriptions, server.circles(), &network.transport).unwrap();
        let abouts = Abouts::open(plant(node.as_str()), 0xab, subscriptions, &session).unwrap();
        let (outbox, frames) = outbox(4096);
        // A single place: these tests take no arrivals.
        let (arrivals, arrived) = RingBuffer::new(1);
        let clock = ClockConfig::default();
        let cycle_time = CycleTime::new(Span::from_millis(2)).unwrap();
        let start = NodeClock::first_cycle(&clock);
        let statuses: Arc<Mutex<Vec<Value>>> = Arc::default();
        let kept = Arc::clone(&statuses);
        let keep = move |_, json: &[u8]| {
            kept.lock()
                .unwrap()
                .push(serde_json::from_slice(json).unwrap());
        };
        let identity = Identity {
            name: node.clone(),
            role: "toy",
            epoch: 0xAB,
            sources: subscriptions
                .iter()
                .map(|s| (s.node.clone(), s.node.channel_key(s.channel)))
                .collect(),
            publishes: publishes
                .iter()
                .map(|p| p.node.channel_key(p.channel))
                .collect(),
            in_secure_network,
            lab: lab.map(str::to_owned),
        };
        let toy = Toy::sending(start, cycle_time, body(&node, 1));
        let (records, telemetry) = telemetry(toy.snapshot(), usize::MAX, arrived);
        Self {
            network: network.clone(),
            cycle: Cycle {
                node: toy,
                clock: NodeClock::new(&clock, 1, Instant::EPOCH).unwrap(),
                mailboxes,
                orders,
                outbox,
                records,
                arrivals,
                inputs: None,
                circles,
                counters: Arc::clone(&counters),
            },
            frames,
            channels,
            telemetry,
            server,
            reporter: Reporter::new(
                identity,
                Arc::clone(&session),
                Arc::clone(&counters),
                Arc::default(),
                (circle_search, abouts),
                Instant::EPOCH,
            ),
            session,
            counters,
            statuses,
            _watched: network
                .transport
                .subscribe(&node.status_key(), Box::new(keep))
                .unwrap(),
        }
    }

    /// Runs a scan and the publishing after it.
    fn step(&mut self, now: Instant<Machine>) -> ToySnapshot {
        self.network.set(now);
        self.cycle.scan(now);
        let network = self.network.clone();
        publish_waiting(
            &mut self.frames,
            &mut self.channels,
            None,
            true,
            &self.counters,
            || network.now(),
        );
        let mut taken = None;
        self.telemetry
            .take(|record: &Record<ToySnapshot>| taken = Some(record.snapshot));
        taken.unwrap()
    }

    /// The status that it publishes.
    fn status(&mut self, now: Instant<Machine>) -> Value {
        self.reporter.report(now, Map::new());
        self.statuses.lock().unwrap().pop().expect("a status")
    }

    fn health(&mut self, now: Instant<Machine>) -> String {
        self.status(now)["health"].as_str().unwrap().to_owned()
    }
}

fn at(millis: i64) -> Instant<Machine> {
    Instant::EPOCH + Span::from_millis(millis)
}

#[test]
fn a_frame_is_in_the_next_scan_of_who_follows() {
    let network = Network::new();
    let mut belt = Stepped::sending("belt", &network);
    let mut saw = Stepped::following("saw", "belt", AXIS, "", &network);
    assert_eq!(saw.step(at(0)).samples, 0);
    belt.step(at(2));
    let after = saw.step(at(4));
    assert_eq!(after.samples, 1);
    // The instant of the publication, by the clock of the network.
    assert_eq!(after.last_arrival.since_epoch(), Span::from_millis(2));
    assert_eq!(saw.step(at(6)).samples, 1);
}

#[test]
fn health_goes_with_what_arrives() {
    let network = Network::new();
    let mut saw = Stepped::following("saw", "belt", AXIS, "", &network);
    assert_eq!(saw.health(at(0)), "waiting");
    let mut belt = Stepped::sending("belt", &network);
    assert_eq!(belt.health(at(0)), "ok", "somebody follows");
    assert_eq!(saw.health(at(0)), "no-data");
    belt.step(at(10));
    assert_eq!(saw.health(at(10)), "ok");
    // 500 ms are fresh, a millisecond more is not.
    assert_eq!(saw.health(at(510)), "ok");
    assert_eq!(saw.health(at(511)), "no-data");
    belt.step(at(520));
    drop(belt);
    assert_eq!(saw.health(at(521)), "ok", "frames count");
    // Neither a frame within half a second, nor a token.
    assert_eq!(saw.health(at(1_100)), "waiting");
    drop(saw);
    assert_eq!(
        Stepped::sending("belt", &network).health(at(1_100)),
        "waiting"
    );
}

#[test]
fn who_hears_a_node_says_so_as_long_as_it_does() {
    let network = Network::new();
    let mut belt = Stepped::sending("belt", &network);
    let mut saw = Stepped::following("saw", "belt", AXIS, "", &network);
    let mut press = Stepped::following("press", "belt", AXIS, "", &network);
    let mut told = |saw: &mut Stepped, now| {
        let _ = (saw.status(now), press.status(now));
        belt.step(now);
        belt.status(now)["seen_by"].clone()
    };
    // Each looks at its own status before the first frame is sent.
    assert_eq!(told(&mut saw, at(2)), serde_json::json!([]));
    assert_eq!(told(&mut saw, at(4)), serde_json::json!(["press", "saw"]));
    // No status arrived meanwhile.
    assert_eq!(told(&mut saw, at(600)), serde_json::json!([]));
    assert_eq!(told(&mut saw, at(602)), serde_json::json!(["press", "saw"]));
    drop(saw);
    assert_eq!(
        belt.status(at(604))["seen_by"],
        serde_json::json!(["press"])
    );
}

#[test]
fn a_node_of_a_secure_network_that_nobody_hears_says_so() {
    let network = Network::new();
    let mut belt = Stepped::sending_securely("belt", &network);
    let course = |belt: &mut Stepped, from: i64| -> Vec<String> {
        (from..from + 8)
            .map(|second| belt.health(at(1_000 * second)))
            .collect()
    };
    assert_eq!(course(&mut belt, 0), ["waiting"; 8]);
    let deaf = |_, _: &[u8]| {};
    let subscribed = network
        .transport
        .subscribe("coaxle/belt/axes", Box::new(deaf));
    let ok = ["ok"; 6];
    // Missing for 3 s, confirmed 3 s later: six good seconds.
    assert_eq!(course(&mut belt, 10), [&ok[..], &["refused"; 2]].concat());
    let heard = network
        .transport
        .announce("coaxle/belt/seen-by/saw")
        .unwrap();
    assert_eq!(course(&mut belt, 20), ["ok"; 8]);
    drop(heard);
    assert_eq!(course(&mut belt, 30), [&ok[..], &["refused"; 2]].concat());
    drop(subscribed);
    assert_eq!(course(&mut belt, 40), ["waiting"; 8]);
}

#[test]
fn frames_without_the_axis_are_refused_and_are_no_health() {
    let network = Network::new();
    let mut belt = Stepped::sending("belt", &network);
    let mut picky = Stepped::following("picky", "belt", AXIS + 1, "", &network);
    belt.step(at(2));
    let after = picky.step(at(4));
    assert_eq!((after.samples, after.rejected), (0, 1));
    let status = picky.status(at(4));
    assert_eq!(
        (&status["received"], &status["refused"]),
        (&0.into(), &1.into())
    );
    assert_eq!(status["health"], "no-data");
}

#[test]
fn faults_over_the_link_lose_and_delay() {
    let network = Network::new();
    let mut belt = Stepped::sending("belt", &network);
    // Half a minute of delay, and half of the frames lost.
    let faults = "latency-us = 30000000\nloss = 0.5";
    let mut late = Stepped::following("late", "belt", AXIS, faults, &network);
    for k in 0..50 {
        belt.step(at(2 * k));
    }
    let after = late.step(at(100));
    // Binomial: 25 ± 3.5 of 50, at more than four standard deviations to either side.
    assert!((10..40).contains(&after.samples), "{after:?}");
    // The stamp lies half a minute ahead.
    let last = after.last_arrival.since_epoch();
    assert!(last >= Span::from_secs(30), "{after:?}");
}

#[test]
fn an_order_reaches_the_cycle_and_is_answered() {
    let network = Network::new();
    let mut servo = Stepped::sending("servo", &network);
    let commander = Commander::named(Arc::new(network.transport.clone()), name("anna"));
    let send = move |command| {
        commander
            .send(&name("servo"), &order("toy", command))
            .unwrap()
    };
    let sent =
        std::thread::spawn(move || [Command::Home { position: 2.5 }, Command::Reset {}].map(send));
    let mut now = at(2);
    while !sent.is_finished() {
        servo.server.round(now);
        servo.step(now);
        servo.server.round(now);
        now += Span::from_millis(2);
    }
    let [home, reset] = sent.join().unwrap();
    let CommandVerdict::Accepted { job, axis, .. } = home.verdict else {
        panic!("{home:?}");
    };
    let at = axis.map(|axis| axis.position);
    assert_eq!((job, at), (Some(1), Some(2.5)));
    assert!(
        matches!(reset.verdict, CommandVerdict::Refused { .. }),
        "{reset:?}"
    );
}

#[test]
fn every_field_of_the_status_has_its_own_number() {
    let network = Network::new();
    let mut belt = Stepped::sending("belt", &network);
    let mut saw = Stepped::following("saw", "belt", AXIS, "", &network);
    for node in [&belt, &saw] {
        let Counters {
            cycles,
            published,
            publish_dropped,
            publish_failed,
            received,
            refused,
            exchange_refused,
            mailbox_dropped,
            telemetry_dropped,
            arrivals_dropped,
        } = &*node.counters;
        let all = [
            cycles,
            published,
            publish_dropped,
            publish_failed,
            received,
            refused,
            exchange_refused,
            &**mailbox_dropped,
            telemetry_dropped,
            arrivals_dropped,
        ];
        // Ten, twenty, … : two fields that were mixed up would show.
        for (times, counter) in (1..).map(|n| 10 * n).zip(all) {
            (0..times).for_each(|_| count(counter));
        }
    }
    let expected = serde_json::json!({
        "node": "belt", "role": "toy", "epoch": "00000000000000ab", "uptime_s": 1.5, "health": "ok", "namesakes": 0,
        "cycles": 10, "telemetry_dropped": 90, "exchange_refused": 70,
        "real_time": { "priorities": {}, "denied": [] },
        "published": 20, "publish_dropped": 30, "publish_failed": 40, "followed": true,
        "seen_by": [],
    });
    assert_eq!(belt.status(at(1_500)), expected);
    let frame_at = at(1_400);
    network.set(frame_at);
    belt.step(frame_at);
    // 50 frames of the counter, and the one that arrived in between.
    let expected = serde_json::json!({
        "node": "saw", "role": "toy", "epoch": "00000000000000ab", "uptime_s": 1.5, "health": "ok", "namesakes": 0,
        "cycles": 10, "telemetry_dropped": 90, "exchange_refused": 70,
        "real_time": { "priorities": {}, "denied": [] },
        "sources": { "belt": { "alive": true, "frame_age_ms": 100.0, "unseen": null } },
        "received": 51, "refused": 60, "mailbox_dropped": 80, "arrivals_dropped": 100,
    });
    assert_eq!(saw.status(at(1_500)), expected);
}

#[test]
fn a_node_of_an_experiment_says_so_in_its_status() {
    let network = Network::new();
    let machine = Stepped::sending("belt", &network).status(at(10));
    assert_eq!(machine.get("lab"), None);
    let lab = "lab.clock.drift-ppm = 500";
    let status = Stepped::in_lab("press", &network, lab).status(at(10));
    assert_eq!(status["lab"], lab);
}

#[test]
fn two_nodes_of_one_name_notice_each_other() {
    let network = Network::new();
    let open = |node: &str, epoch| {
        Session::open(
            Arc::new(network.transport.clone()),
            &name(node),
            epoch,
            panics().0,
        )
        .unwrap()
    };
    let first = open("belt", 1);
    let other = open("saw", 3);
    assert_eq!(first.namesakes(), 0);
    let second = open("belt", 2);
    // Each sees the other, and neither itself.
    assert_eq!((first.namesakes(), second.namesakes()), (1, 1));
    drop(second);
    assert_eq!((first.namesakes(), other.namesakes()), (0, 0));

    let mut belt = Stepped::sending("belt", &network);
    assert_eq!(belt.health(at(1)), "name-taken");
    assert_eq!(belt.status(at(2))["namesakes"], 1);
    drop(first);
    assert_eq!(belt.health(at(3)), "waiting");
}

#[test]
fn a_node_that_ends_leaves_nothing_behind() {
    let network = Network::new();
    let belt = Stepped::sending("belt", &network);
    let mut saw = Stepped::following("saw", "belt", AXIS, "", &network);
    assert!(saw.session.contacts()[0].is_alive());
    drop(belt);
    assert!(!saw.session.contacts()[0].is_alive());
    assert_eq!(saw.health(at(1)), "waiting");
    let client = network
        .transport
        .client("coaxle/belt/command", std::time::Duration::from_secs(1))
        .unwrap();
    assert!(!client.has_server());
}
