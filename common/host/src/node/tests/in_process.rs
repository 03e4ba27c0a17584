//! Whole nodes, with all their threads, within this process.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use coaxle_clock::Instant;
use coaxle_node::audit::{AuditDoor, AuditExcerpt, AuditRecord};
use coaxle_node::config::TransportConfig;
use coaxle_os::EndReason;
use coaxle_os::machine::Machine;
use coaxle_slave::Command;
use serde_json::{Map, Value};

use super::{AXIS, Memory, following, name, order, setup};
use crate::client::Commander;
use crate::network::transport::{InProcess, Transport};
use crate::node::toy::ToySnapshot;
use crate::node::{Record, Recorder, run_over};

/// Timeout of a response on a busy machine.
const LONG: Duration = Duration::from_secs(60);

/// Bounds in numbers are wide: the machine may be busy.
#[test]
fn a_node_follows_another() {
    let network = InProcess::default();
    let (sent_memory, memory) = (Memory::default(), Memory::default());
    let sender = {
        let (network, memory) = (network.clone(), sent_memory.clone());
        let setup = move || setup("belt", TransportConfig::default(), 2, &memory);
        std::thread::spawn(move || run_over(setup(), network).unwrap())
    };
    let mut saw = setup("saw", TransportConfig::default(), 1, &memory);
    saw.wiring.publications.clear();
    saw.wiring.subscriptions = following("belt", AXIS, "");
    let got = run_over(saw, network).unwrap();
    let sent = sender.join().unwrap();
    assert_eq!(
        (sent.ended, got.ended),
        (EndReason::TimeUp, EndReason::TimeUp)
    );
    // Both run for a second or two at 2 ms: hundreds of frames on an idle machine, ten on any.
    assert!(sent.published > 10 && sent.not_published == 0, "{sent:?}");
    assert!(got.received > 10 && got.refused == 0, "{got:?}");

    let remembered = memory.get();
    assert!(remembered.finished && remembered.in_order);
    // Each cycle leaves a record or is counted as dropped.
    assert_eq!(remembered.records + got.telemetry_dropped, got.cycles);
    let samples = remembered.last.unwrap().snapshot.samples;
    assert!(samples > 10 && samples <= got.received, "{samples}");
    assert_eq!(sent_memory.get().last.unwrap().snapshot.samples, 0);
}

#[test]
fn a_node_that_cannot_be_built_is_an_error_before_anything_opens() {
    let mut setup = setup("broken", TransportConfig::default(), 5, &Memory::default());
    setup.build = Box::new(|_, _| anyhow::bail!("no axis"));
    let message = format!("{:#}", run_over(setup, InProcess::default()).unwrap_err());
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
    let message = format!("{:#}", run_over(setup, InProcess::default()).unwrap_err());
    assert_eq!(
        message,
        "the recorder could not keep what it recorded: no space left"
    );
}

#[test]
fn a_thread_that_panics_ends_the_node_and_is_named() {
    struct Ill(u32);
    impl Recorder<ToySnapshot> for Ill {
        fn record(&mut self, _: &Record<ToySnapshot>) {
            self.0 += 1;
            assert!(self.0 < 5, "five is too many");
        }
        fn status(&self) -> Map<String, Value> {
            Map::new()
        }
        fn finish(&mut self) -> anyhow::Result<()> {
            Ok(())
        }
    }
    // An hour, if the panic went unnoticed.
    let mut setup = setup("ill", TransportConfig::default(), 3_600, &Memory::default());
    setup.recorder = Box::new(Ill(0));
    // The name of the thread and its own words.
    let message = format!("{:#}", run_over(setup, InProcess::default()).unwrap_err());
    assert_eq!(message, "the telemetry thread panicked: five is too many");
}

/// Records of the audit that a recorder got, and texts of those that were published.
#[derive(Clone, Default)]
struct Audited {
    recorded: Arc<Mutex<Vec<AuditRecord>>>,
    published: Arc<Mutex<Vec<AuditRecord>>>,
}

impl Recorder<ToySnapshot> for Audited {
    fn record(&mut self, _: &Record<ToySnapshot>) {}

    fn audited(&mut self, _: Instant<Machine>, record: &AuditRecord) {
        self.recorded.lock().unwrap().push(record.clone());
    }
}

#[test]
fn what_was_done_and_refused_is_published_recorded_and_answered() {
    let network = InProcess::default();
    let node = name("clerk");
    let audited = Audited::default();
    let published = Arc::clone(&audited.published);
    let take = move |_, bytes: &[u8]| {
        let record = AuditRecord::from_json(bytes).unwrap();
        published.lock().unwrap().push(record);
    };
    let _heard = network
        .subscribe(&node.audit_key(), Box::new(take))
        .unwrap();
    let running = {
        let (network, audited) = (network.clone(), audited.clone());
        std::thread::spawn(move || {
            let mut setup = setup("clerk", TransportConfig::default(), 3, &Memory::default());
            setup.recorder = Box::new(audited);
            run_over(setup, network).unwrap()
        })
    };
    let anna = Commander::named(Arc::new(network.clone()), name("anna"));
    anna.send(&node, &order("toy", Command::Home { position: 3.0 }))
        .unwrap();
    anna.send(&node, &order("other", Command::Power(true)))
        .unwrap();
    let client = network.client(&node.audit_key(), LONG).unwrap();
    let ask = |query: &str| client.request(query.to_owned()).unwrap().unwrap();
    let excerpt = AuditExcerpt::from_json(&ask("")).unwrap();
    let error = String::from_utf8(ask("{")).unwrap();
    assert!(error.contains("EOF while parsing"), "{error}");
    running.join().unwrap();

    let recorded = audited.recorded.lock().unwrap();
    let numbers: Vec<_> = recorded.iter().map(|record| record.number).collect();
    assert_eq!(numbers, (1..=numbers.len() as u64).collect::<Vec<_>>());
    assert_eq!(*audited.published.lock().unwrap(), *recorded);
    // Taken while the node ran: all but its end.
    assert_eq!(excerpt.records[..], recorded[..excerpt.records.len()]);
    // Other tests of this process may report connections.
    let own =
        |record: &&AuditRecord| matches!(record.entry.door, AuditDoor::Run | AuditDoor::Order);
    let texts: Vec<_> = recorded
        .iter()
        .filter(own)
        .map(|it| it.entry.to_string())
        .collect();
    let is_there = |part: &str| texts.iter().any(|text| text.contains(part));
    for part in [
        "run of \"clerk\": start: accepted, version ",
        "order of \"anna\": MC_Home to \"toy\": accepted",
        "order of \"anna\": MC_Power to \"other\": not taken, ",
    ] {
        assert!(is_there(part), "{part}: {texts:?}");
    }
    let last = texts.last().unwrap();
    assert!(
        last.ends_with("run of \"clerk\": run: ended, TimeUp"),
        "{last}"
    );
    assert_eq!(texts.len(), 4, "{texts:?}");
}
