//! Two receivers that follow each other, as processes over Zenoh: `far-axis/circle-a.toml` and `circle-b.toml`.
//!
//! The tests judge the reports and traces of the nodes: a busy machine changes only their duration.

use std::path::Path;
use std::process::Command;

use coaxle_clock::Span;
use coaxle_gear::GearIn;
use coaxle_host::client::{Commander, SeenNode, Watcher};
use coaxle_node::command::{CommandVerdict, SlaveName, SlaveOrder};
use coaxle_node::config::{TransportConfig, parse};
use coaxle_node::keys::NodeName;
use coaxle_os::ClaimedPort;
use coaxle_test_process::{Process, WAIT_TIMEOUT};
use serde_json::Value;

/// Config of a node with a slave `loop` that can follow that of the other node.
fn config(node: &str, other: &str, [own, others]: [u16; 2]) -> String {
    // 250 cycles of 2 ms: a busy machine may stop a node for half a second.
    format!(
        "name = '{node}'\ncycle-time-us = 2000\n\
         [transport]\nlisten = ['tcp/127.0.0.1:{own}']\nconnect = ['tcp/127.0.0.1:{others}']\n\
         [[far]]\nnode = '{other}'\nchannel = 'slaves'\naxes = [{{ id = 1, name = 'far' }}]\n\
         sync.time-sync = {{ age-of-data-limit = 250, max-cycle-index-difference = 250 }}\n\
         [[virtual-axis]]\nid = 1\nname = 'shaft'\n[virtual-axis.program]\n\
         limits = {{ velocity = 100, acceleration = 100, jerk = 1000 }}\n\
         steps = [{{ enable = true }}, {{ velocity = {{ value = 10 }} }}]\n\
         [[slave]]\nname = 'loop'\nid = 1\nmaster = 'far'\ncouple = 'off'\n\
         limits = {{ velocity = 1000, acceleration = 5000, jerk = 100000 }}\n\
         [[slave]]\nname = 'other'\nid = 2\nmaster = 'shaft'\n\
         limits = {{ velocity = 1000, acceleration = 5000, jerk = 100000 }}\n"
    )
}

fn start(folder: &Path, node: &str, other: &str, ports: [u16; 2]) -> Process {
    let file = folder.join(format!("{node}.toml"));
    std::fs::write(&file, config(node, other, ports)).expect("the folder can be written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-receiver"));
    command
        .arg(&file)
        .arg("--trace")
        .arg(folder.join(format!("{node}.csv")));
    Process::start(node, &mut command, &folder.join(format!("{node}.log")))
}

/// The largest velocity of the slave `loop` in a trace, in both directions, u/s.
fn fastest(trace: &Path) -> f64 {
    let mut reader = csv::Reader::from_path(trace).expect("a trace");
    let head = reader.headers().expect("a head line");
    let place = head
        .iter()
        .position(|name| name == "loop.velocity")
        .expect("the column");
    let velocities = reader
        .records()
        .map(|row| row.expect("a row")[place].parse::<f64>());
    velocities
        // Cells without a value are empty.
        .map(|velocity| velocity.unwrap_or(0.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn orders_at_both_ends_are_refused_and_the_circle_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b] = [(); 2].map(|()| ClaimedPort::find().expect("a free port").keep());
    let nodes = [
        start(folder.path(), "a", "b", [a, b]),
        start(folder.path(), "b", "a", [b, a]),
    ];
    let text = format!("connect = ['tcp/127.0.0.1:{a}', 'tcp/127.0.0.1:{b}']");
    let transport: TransportConfig = parse("test", &text).expect("a transport");
    let names = ["a", "b"].map(|name| NodeName::new(name).expect("a name"));
    let watcher = Watcher::open(&transport, &names).expect("a session");
    let commander = Commander::open(&transport).expect("a session");
    let order = |node: &NodeName, command| {
        let order = SlaveOrder {
            addressee: SlaveName::new("loop").expect("a name"),
            command,
            dry_run: false,
        };
        commander.send(node, &order.into()).expect("an answer")
    };
    let until = |what: &str, is_so: &dyn Fn(&Value) -> bool| {
        let both = |seen: &[SeenNode]| {
            let status = |node: &SeenNode| {
                node.status
                    .as_ref()
                    .map(|(_, status)| Value::Object(status.clone()))
            };
            seen.len() == 2
                && seen
                    .iter()
                    .all(|node| status(node).as_ref().is_some_and(is_so))
        };
        let seen = watcher.wait_for(Span::from_secs(WAIT_TIMEOUT.as_secs() as i64), both);
        coaxle_test_process::assert_alive(what);
        assert!(both(&seen), "{what}: {seen:#?}");
    };
    until("the circle is found", &|status| {
        status["circles"]["found"]
            .as_array()
            .is_some_and(|found| found.len() == 1)
    });
    for name in &names {
        assert!(order(name, coaxle_slave::Command::Power(true)).is_accepted());
    }
    until("each far axis is followed", &|status| {
        status["slaves"]["loop"]["state"] == "standstill" && status["axes"]["far"]["synced"] == true
    });
    // A gear that would amplify in a closed circle: by 30 % each time.
    let moving = coaxle_slave::Command::MoveVelocity {
        velocity: 10.0,
        dynamics: coaxle_slave::Dynamics::default(),
    };
    assert!(order(&names[0], moving).is_accepted());
    for (name, circle) in names.iter().zip([
        "a/slaves/1 follows b/slaves/1 follows a/slaves/1",
        "b/slaves/1 follows a/slaves/1 follows b/slaves/1",
    ]) {
        let answer = order(name, coaxle_slave::Command::GearIn(GearIn::of(1.3)));
        let CommandVerdict::Refused { code, text, .. } = &answer.verdict else {
            panic!("{answer:?}");
        };
        assert_eq!(code, "0x816f");
        assert!(text.contains(circle), "{text}");
    }
    until("it is said", &|status| {
        status["health"] == "circle" && status["slaves"]["loop"]["refusal"]["code"] == "0x816f"
    });
    for node in nodes {
        assert!(node.logged("0x816f: a circle: "), "{}", node.log());
        node.signal("TERM");
        assert!(node.wait().success());
    }
    // The commanded motion only, without any from the circle.
    assert!(fastest(&folder.path().join("a.csv")) <= 10.0 + 1e-9);
    assert_eq!(fastest(&folder.path().join("b.csv")), 0.0);
}
