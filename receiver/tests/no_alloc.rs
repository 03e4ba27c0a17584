//! Nothing that a receiver does between two cycles or in one allocates, whatever comes in.

mod bench;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use bench::{Clock, Far, LATENCY, MILLISECOND};
use coaxle_clock::{Instant, Local};
use coaxle_node::config::parse;
use coaxle_node::{Intake, Message, Node, Rejection};
use coaxle_receiver::{HealthName, Receiver, ReceiverConfig};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

/// Synchronises, pauses for 3 s with a backlog, loses its master, finds a new run of it.
#[test]
fn receiving_cycling_transmitting_and_showing_do_not_allocate() {
    for mode in ["sync", "observer"] {
        goes_through_its_life_without_allocating(mode);
    }
}

fn goes_through_its_life_without_allocating(mode: &str) {
    let config: ReceiverConfig = parse(
        "r.toml",
        &format!(
            "name = 'saw'\nmaster.node = 'conveyor'\ncycle-time-us = 1000\nmode = '{mode}'\n\
             sync.time-sync.automatic-re-init = true\n\
             drive = {{ following-error-window = 1.0 }}"
        ),
    )
    .expect("a config");
    let intake = Intake::new("coaxle/conveyor/axes", &config.master.node, 1);
    let messages = messages(&intake);
    let clock = Clock { ppm: 0 };
    let mut receiver = Receiver::new(&config, clock.read(MILLISECOND / 2), 7).expect("a receiver");

    let mut next = messages.iter().peekable();
    let mut seen = [false; 4];
    let mut bytes = 0;
    assert_no_alloc(|| {
        while receiver.next_cycle() < clock.read(12_000 * MILLISECOND) {
            let mut now = receiver.next_cycle();
            if now > clock.read(4_000 * MILLISECOND) && now < clock.read(7_000 * MILLISECOND) {
                now = clock.read(7_000 * MILLISECOND);
            }
            while let Some((at, message)) = next.next_if(|(at, _)| *at <= now) {
                receiver.receive(*at, message);
            }
            let _ = receiver.cycle(now);
            while let Some(outgoing) = receiver.transmit() {
                bytes += outgoing.body.len();
            }
            match receiver.snapshot().health.name() {
                HealthName::WaitingForMaster => seen[0] = true,
                HealthName::StartingUp => seen[1] = true,
                HealthName::Ok => seen[2] = true,
                HealthName::DriveTripped => seen[3] = true,
                _ => {}
            }
        }
    });
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    assert_eq!(seen, [true; 4], "all of its life was gone through");
    assert!(bytes > 5_000 * 50);
    let counters = receiver.snapshot().counters;
    assert!(counters.restarts == 1 && counters.rejected.total() > 10);
    assert!(counters.overflow > 0 && counters.stale > 0);
}

/// Two runs of the sender with a pause between them, and refused frames in between.
fn messages(intake: &Intake) -> Vec<(Instant<Local>, Message)> {
    let clock = Clock { ppm: 0 };
    let mut messages = Vec::new();
    for (start, end, epoch) in [(100, 8_000, 1), (9_000, 11_500, 2)] {
        let mut far = Far::new(1000, 1000, start * MILLISECOND, epoch);
        while far.next() < end * MILLISECOND {
            let sent = far.next();
            let message = intake.message(&far.turn(sent));
            let at = clock.read(sent + LATENCY.as_nanos());
            messages.push((at, message));
            if far.count().is_multiple_of(500) {
                messages.push((at, Message::Rejected(Rejection::WrongChecksum)));
            }
        }
    }
    messages
}
