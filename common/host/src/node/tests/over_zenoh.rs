//! Over real Zenoh on loopback. Bounds in time are wide: the machine may be busy.

use std::net::TcpListener;

use coaxle_node::CommandOrder;
use coaxle_node::command::CommandVerdict;
use coaxle_node::config::{TransportConfig, parse};
use coaxle_os::EndReason;
use coaxle_slave::Command;
use serde_json::Value;
use zenoh::Wait;

use super::{AXIS, Memory, following, name, order, setup};
use crate::client::Commander;
use crate::network::transport::zenoh_config;
use crate::node::toy::Toy;
use crate::node::{Outcome, Setup, run};

/// An endpoint that is free now.
fn endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0")
        .and_then(|listener| listener.local_addr())
        .unwrap()
        .port();
    // The listener is dropped, so that the port is free again for the test.
    format!("tcp/127.0.0.1:{port}")
}

fn listening(endpoint: &str) -> TransportConfig {
    parse("test", &format!("listen = [{endpoint:?}]")).unwrap()
}

fn connecting(endpoint: &str) -> TransportConfig {
    parse("test", &format!("connect = [{endpoint:?}]")).unwrap()
}

fn started(
    setup: impl FnOnce() -> Setup<Toy> + Send + 'static,
) -> std::thread::JoinHandle<Outcome> {
    std::thread::spawn(move || run(setup()).unwrap())
}

/// Collects a node's status until `wanted` returns true, for half a minute at most.
fn watch(endpoint: &str, node: &str, wanted: impl Fn(&Value) -> bool) -> Vec<Value> {
    let session = zenoh::open(zenoh_config(&connecting(endpoint)).unwrap())
        .wait()
        .unwrap();
    let statuses = session
        .declare_subscriber(name(node).status_key())
        .wait()
        .unwrap();
    let mut seen = Vec::new();
    // 120 waits of a quarter second.
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
        // Two seconds longer than the receiver, which connects to it.
        started(move || setup("belt", listening(&at), 8, &memory))
    };
    let receiver = {
        let (at, memory) = (at.clone(), memory.clone());
        started(move || {
            let mut setup = setup("saw", connecting(&at), 6, &memory);
            setup.wiring.publications.clear();
            setup.wiring.subscriptions = following("belt", AXIS, "");
            setup
        })
    };
    let healthy = |status: &Value| status["health"] == "ok";
    let seen = watch(&at, "belt", healthy);
    let last = seen.last().expect("a status came");
    assert_eq!(last["health"], "ok", "{last}");
    assert_eq!(last["followed"], true);

    let (sent, got) = (sender.join().unwrap(), receiver.join().unwrap());
    assert_eq!(
        (sent.ended, got.ended),
        (EndReason::TimeUp, EndReason::TimeUp)
    );
    // Six seconds at 2 ms are 3000 frames.
    assert!(sent.published > 100 && sent.not_published == 0, "{sent:?}");
    assert!(got.received > 100 && got.refused == 0, "{got:?}");

    let remembered = memory.get();
    assert!(remembered.finished && remembered.in_order);
    assert_eq!(remembered.records + got.telemetry_dropped, got.cycles);
    let samples = remembered.last.unwrap().snapshot.samples;
    assert!(samples > 100 && samples <= got.received, "{samples}");
}

/// Starts a Zenoh router on a free endpoint; it ends with the session.
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
            setup.wiring.publications.clear();
            setup.wiring.subscriptions = following("belt", AXIS, "");
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
        let CommandVerdict::Accepted { job, axis, .. } = answer.verdict else {
            panic!("{answer:?}");
        };
        let at = axis.map(|axis| axis.position);
        assert_eq!((job, at), (Some(k), Some(position)));
    }
    let refused = send(&order("toy", Command::Reset {}));
    let CommandVerdict::Refused { code, text, .. } = refused.verdict else {
        panic!("{refused:?}");
    };
    assert_eq!(code, "0x4b09");
    assert!(text.contains("no master"), "{text}");
    let unknown = send(&order("other", Command::Reset {}));
    assert!(!unknown.is_taken(), "{unknown:?}");
    commander.close();

    assert_reason(&at, "coaxle/servo/command", "{ no order }", "malformed");
    let halt = order("toy", Command::Home { position: 9.0 }).to_json();
    // A key with a wildcard would command every node of the network.
    assert_reason(&at, "coaxle/*/command", &halt, "malformed");
    node.join().unwrap();
    let snapshot = memory.get().last.unwrap().snapshot;
    assert_eq!(snapshot.commands, 2);
}

/// Asserts the reason in the error reply to a query that any tool may send.
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
    // No place in Zenoh's source.
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
