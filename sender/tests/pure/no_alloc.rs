//! Absence of allocations in the cycle of a sender, for every source of axes.

use std::fmt::Write as _;

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{Instant, Local, Span};
use coaxle_node::config::parse;
use coaxle_node::{Message, Node, TimeRequest};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;

#[test]
fn cycles_of_every_kind_of_axis_do_not_allocate() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("taught.csv");
    std::fs::write(&recording, "time_s,position\n0,0\n0.5,1\n1,0\n").unwrap();

    let limits = "limits = { velocity = 100, acceleration = 1000, jerk = 10000 }";
    let mut text = format!(
        "name = 'test'\ncycle-time-us = 1000\n\
         [[axis]]\nid = 1\nname = 'taught'\nreplay = {{ file = {recording:?}, repeat = true }}\n\
         [[axis]]\nid = 2\nname = 'measured'\n[axis.encoder]\nresolution = 0.01\n\
         velocity-window-cycles = 50\n[axis.encoder.program]\n{limits}\nstart-velocity = 5.0\n"
    );
    // Seven axes with every kind of step, all changing within the test's three seconds.
    for id in 3..10 {
        write!(
            text,
            "[[axis]]\nid = {id}\nname = 'x'\nlead-ms = 50\n[axis.program]\n{limits}\nrepeat = true\n\
             steps = [{{ enable = true }}, {{ move-absolute = {{ position = {id} }} }}, \
             {{ loop = {{ count = 2, steps = [{{ move-relative = {{ distance = 1 }} }}] }} }}, \
             {{ velocity = {{ value = -50.0, for-s = 0.01 }} }}, {{ halt = {{}} }}, \
             {{ dwell = {{ for-s = 0.01 }} }}, {{ enable = false }}]\n"
        )
        .unwrap();
    }
    let config: SenderConfig = parse("s.toml", &text).unwrap();
    let start: Instant<Local> = Instant::EPOCH;
    let mut sender = Sender::new(&config, start, 1).unwrap();

    let mut sent = 0;
    assert_no_alloc(|| {
        for k in 0..3_000 {
            // Before the cycle that takes it, as a message on its way.
            let requested = start + Span::from_millis(k) - Span::from_micros(300);
            sender.receive(requested, 0, &Message::TimeRequest(TimeRequest::default()));
            // Sometimes cycles are skipped.
            let _ = sender.cycle(start + Span::from_millis(k + k / 100));
            while let Some(outgoing) = sender.transmit() {
                sent += outgoing.body.len();
            }
            // Reading the snapshot must not allocate, and the optimiser must not drop the read.
            sent += usize::from(sender.snapshot().signals.node.overruns > 1_000_000);
        }
    });
    // With debug assertions an allocation has aborted the test by now; without, it was counted.
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    // Nine axes of some fifty bytes each.
    assert!(sent > 3_000 * 9 * 50);
    assert_eq!(sender.snapshot().signals.node.requests_answered, 3_000);
    assert!(sender.snapshot().signals.node.plans_published > 7 * 30);
}
