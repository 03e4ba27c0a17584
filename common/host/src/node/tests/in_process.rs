//! Whole nodes, with all their threads, within this process.

use coaxle_node::config::TransportConfig;
use coaxle_os::EndReason;
use serde_json::{Map, Value};

use super::{AXIS, Memory, following, setup};
use crate::network::transport::InProcess;
use crate::node::toy::ToySnapshot;
use crate::node::{Record, Recorder, run_over};

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
