//! Two receivers that follow each other, with all their threads, within this process: `far-axis/circle-a.toml` and `circle-b.toml`.
//!
//! The tests wait for reports of the nodes; their duration is not judged.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use coaxle_clock::Span;
use coaxle_gear::GearIn;
use coaxle_host::client::{Commander, SeenNode, Watcher};
use coaxle_host::files::Rows;
use coaxle_host::network::transport::{
    BytesHandler, Client, Declared, InProcess, PresenceHandler, Publisher, RequestHandler,
    Transport, Urgency,
};
use coaxle_node::command::{CommandAnswer, CommandVerdict, SlaveName, SlaveOrder};
use coaxle_node::config::parse;
use coaxle_node::keys::NodeName;
use coaxle_slave::Command;
use serde_json::Value;

use super::recorder::ReceiverRecorder;
use super::setup;
use crate::config::ReceiverConfig;
use crate::node::Receiver;

/// Longest wait for an expected report: a machine may be busy.
const PATIENCE: Span = Span::from_secs(60);

/// A network that withholds statuses from the nodes on request.
#[derive(Clone, Default)]
struct Network {
    transport: InProcess,
    holds_statuses: Arc<AtomicBool>,
}

impl Transport for Network {
    fn publisher(&self, key: &str, urgency: Urgency) -> anyhow::Result<Box<dyn Publisher>> {
        self.transport.publisher(key, urgency)
    }

    fn subscribe(&self, key: &str, mut on_bytes: BytesHandler) -> anyhow::Result<Declared> {
        let is_status = key.ends_with("/status");
        let holds = Arc::clone(&self.holds_statuses);
        let on_bytes = move |at, bytes: &[u8]| {
            if !(is_status && holds.load(Ordering::Relaxed)) {
                on_bytes(at, bytes);
            }
        };
        self.transport.subscribe(key, Box::new(on_bytes))
    }

    fn announce(&self, key: &str) -> anyhow::Result<Declared> {
        self.transport.announce(key)
    }

    fn watch(&self, key: &str, on_change: PresenceHandler) -> anyhow::Result<Declared> {
        self.transport.watch(key, on_change)
    }

    fn serve(&self, key: &str, on_request: RequestHandler) -> anyhow::Result<Declared> {
        self.transport.serve(key, on_request)
    }

    fn client(&self, key: &str, patience: Duration) -> anyhow::Result<Box<dyn Client>> {
        self.transport.client(key, patience)
    }

    fn whereabouts(&self) -> &str {
        self.transport.whereabouts()
    }

    fn close(&self) {}
}

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn config(node: &str, other: &str) -> ReceiverConfig {
    let text = format!(
        "name = '{node}'\ncycle-time-us = 2000\n\
         [[far]]\nnode = '{other}'\nchannel = 'slaves'\naxes = [{{ id = 1, name = 'far' }}]\n\
         sync.time-sync = {{ age-of-data-limit = 250, max-cycle-index-difference = 250 }}\n\
         [[virtual-axis]]\nid = 1\nname = 'shaft'\n[virtual-axis.program]\n\
         limits = {{ velocity = 100, acceleration = 100, jerk = 1000 }}\n\
         steps = [{{ enable = true }}, {{ velocity = {{ value = 10 }} }}]\n\
         [[slave]]\nname = 'loop'\nid = 1\nmaster = 'far'\ncouple = 'off'\n\
         limits = {{ velocity = 1000, acceleration = 5000, jerk = 100000 }}\n\
         [[slave]]\nname = 'other'\nid = 2\nmaster = 'shaft'\n\
         limits = {{ velocity = 1000, acceleration = 5000, jerk = 100000 }}\n"
    );
    parse(node, &text).unwrap()
}

/// Rows without a destination.
fn rows(config: &ReceiverConfig) -> Rows {
    #[derive(clap::Parser)]
    struct Cli {
        #[command(flatten)]
        node: coaxle_host::cli::NodeArgs,
    }
    let cli = <Cli as clap::Parser>::parse_from(["node", "r.toml"]);
    super::rows(&cli.node, config).unwrap()
}

/// Two nodes, which run until the test program ends.
struct Line {
    network: Network,
    watcher: Watcher,
    commander: Commander,
}

impl Line {
    fn start(holds_statuses: bool) -> Self {
        let network = Network::default();
        network
            .holds_statuses
            .store(holds_statuses, Ordering::Relaxed);
        for (node, other) in [("a", "b"), ("b", "a")] {
            let (config, network) = (config(node, other), network.clone());
            let node = move || {
                let built = config.clone();
                let build = move |start, epoch| Ok(Receiver::new(&built, start, epoch)?);
                let rows = rows(&config);
                let recorder = ReceiverRecorder::new(&config, rows, None);
                let setup = setup(&config, Box::new(build), Box::new(recorder));
                coaxle_host::node::run_over(setup, network)
            };
            std::thread::spawn(node);
        }
        let transport = || Arc::new(network.transport.clone());
        let nodes = [name("a"), name("b")];
        Self {
            watcher: Watcher::over(transport(), &nodes).unwrap(),
            commander: Commander::over(transport(), None).unwrap(),
            network,
        }
    }

    /// Waits until the statuses of both nodes fulfil the predicate.
    fn until(&self, what: &str, is_so: impl Fn(&Value) -> bool) -> Vec<Value> {
        let status = |node: &SeenNode| {
            let status = node.status.as_ref().map(|(_, status)| status.clone());
            Value::Object(status.unwrap_or_default())
        };
        let both =
            |seen: &[SeenNode]| seen.len() == 2 && seen.iter().all(|node| is_so(&status(node)));
        let seen = self.watcher.wait_for(PATIENCE, both);
        assert!(both(&seen), "{what}: {seen:#?}");
        seen.iter().map(status).collect()
    }

    /// Sends an order to the slave `loop`.
    fn order(&self, node: &str, command: Command) -> CommandAnswer {
        let slave = SlaveName::new("loop").unwrap();
        let dry_run = false;
        let order = SlaveOrder {
            slave,
            command,
            dry_run,
        };
        self.commander.send(&name(node), &order.into()).unwrap()
    }

    fn switch_on(&self) {
        for node in ["a", "b"] {
            assert!(self.order(node, Command::Power(true)).is_accepted());
        }
        self.until("each slave stands, each far axis is followed", |status| {
            status["slaves"]["loop"]["state"] == "standstill"
                && status["axes"]["far"]["synced"] == true
        });
    }
}

#[test]
fn orders_that_would_close_a_circle_over_two_nodes_are_refused_and_name_it() {
    let line = Line::start(false);
    let statuses = line.until("the circle is found", |status| {
        status["circles"]["found"]
            .as_array()
            .is_some_and(|found| !found.is_empty())
    });
    let circle = "a/slaves/1 follows b/slaves/1 follows a/slaves/1";
    assert_eq!(statuses[0]["circles"]["found"][0], circle);
    line.switch_on();
    for (node, circle) in [
        ("a", circle),
        ("b", "b/slaves/1 follows a/slaves/1 follows b/slaves/1"),
    ] {
        let answer = line.order(node, Command::GearIn(GearIn::of(1.3)));
        let CommandVerdict::Refused { code, text, .. } = &answer.verdict else {
            panic!("{answer:?}");
        };
        assert_eq!(code, "0x816f");
        assert!(text.contains(circle), "{text}");
    }
    let statuses = line.until("it is said", |status| {
        status["health"] == "circle" && status["slaves"]["loop"]["refusal"].is_object()
    });
    for status in statuses {
        assert_eq!(status["error"]["code"], "0x816f", "{status}");
        assert_eq!(status["slaves"]["loop"]["refusal"]["code"], "0x816f");
        assert!(status["slaves"]["loop"]["circle"].is_string());
        assert_eq!(status["slaves"]["other"]["circle"], Value::Null);
        assert_eq!(status["slaves"]["loop"]["position"], 0.0);
    }
}

#[test]
fn slaves_that_are_coupled_when_the_circle_is_found_stop() {
    let line = Line::start(true);
    line.switch_on();
    for node in ["a", "b"] {
        let answer = line.order(node, Command::GearIn(GearIn::of(1.3)));
        assert!(answer.is_accepted(), "nothing is known yet: {answer:?}");
    }
    for status in line.until("both are coupled", |status| {
        status["slaves"]["loop"]["phase"] == "in-sync"
    }) {
        assert_eq!(status["circles"]["found"].as_array().map(Vec::len), Some(0));
        assert_eq!(
            status["circles"]["unknown"].as_array().map(Vec::len),
            Some(1)
        );
    }
    line.network.holds_statuses.store(false, Ordering::Relaxed);
    let stopped = line.until("both have stopped", |status| {
        let slave = &status["slaves"]["loop"];
        slave["state"] == "error-stop" && slave["circle"].is_string()
    });
    // The first node to find the circle stops, so that the other one loses its master.
    let codes: Vec<_> = (stopped.iter())
        .map(|status| status["slaves"]["loop"]["error"]["code"].as_str())
        .collect();
    assert!(codes.contains(&Some("0x816f")), "{codes:?}");
    for (status, code) in stopped.iter().zip(&codes) {
        assert!(matches!(code, Some("0x816f" | "0x42a0")), "{codes:?}");
        assert_eq!(status["health"], "slave-failed");
        assert_eq!(status["slaves"]["loop"]["velocity"], 0.0);
    }
}
