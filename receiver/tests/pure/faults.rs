//! Behaviour of a receiver in faults, and its recovery.

use std::slice::from_mut;

use crate::bench::{Far, LATENCY, MILLISECOND, Near, SECOND, Shown, VELOCITY, run, run_pair};
use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::time_sync::SyncError;
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_node::Rejection;
use coaxle_node::config::{Wrong, parse};
use coaxle_node::frame::{FrameHeader, KeySeal, body_capacity, decode, encode_body, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_receiver::{DriveState, FilterState, Health, HealthName, Receiver, ReceiverConfig};

/// The names of the healths passed through, each change once.
fn healths(snapshots: &[Shown]) -> Vec<HealthName> {
    let mut names: Vec<_> = snapshots.iter().map(|s| s.health.name()).collect();
    names.dedup();
    names
}

#[test]
fn health_goes_from_waiting_over_starting_up_to_ok() {
    let mut near = Near::new(1000, 0, "mode = 'sync'");
    run(None, from_mut(&mut near), 100 * MILLISECOND);
    assert_eq!(healths(&near.snapshots), [HealthName::WaitingForMaster]);
    let mut far = Far::new(1000, 1000, 100 * MILLISECOND, 1);
    run_pair(&mut far, &mut near, 5 * SECOND);
    assert_eq!(
        healths(&near.snapshots),
        [
            HealthName::WaitingForMaster,
            HealthName::StartingUp,
            HealthName::Ok
        ]
    );
}

#[test]
fn a_master_that_stops_is_an_error_that_stays() {
    let mut far = Far::new(1000, 1000, 0, 1);
    let mut near = Near::new(1000, 0, "mode = 'sync'");
    run_pair(&mut far, &mut near, 5 * SECOND);
    assert_eq!(near.last().health, Health::Ok);
    let before = near.snapshots.len();
    run(None, from_mut(&mut near), 6 * SECOND);
    let error = Health::Error(SyncError::MaxDataAgeExceeded);
    assert_eq!(near.last().health, error);
    let ok_for = near.snapshots[before..]
        .iter()
        .filter(|s| s.health == Health::Ok)
        .count();
    assert!(
        (6..=8).contains(&ok_for),
        "the age limit is 7 cycles: {ok_for}"
    );
    // The node returns, but the receiver is not permitted to resume by itself.
    let mut again = Far::new(1000, 1000, 6 * SECOND, 2);
    run_pair(&mut again, &mut near, 12 * SECOND);
    assert_eq!(near.last().health, error);
    assert_eq!(near.last().counters.restarts, 1);
    let master = near.last().master.unwrap();
    assert!(!master.synced);
    assert_eq!(master.state, FilterState::Pt1, "the fallback");
}

#[test]
fn a_master_that_stops_is_never_healthy_even_where_nothing_watches_its_age() {
    for mode in ["bypass", "pt1", "time", "sync"] {
        let mut far = Far::new(1000, 1000, 0, 1);
        let rest = format!(
            "mode = '{mode}'\nsync.time-sync = {{ age-of-data-limit = 0, max-cycle-index-difference = 0 }}"
        );
        let mut near = Near::new(1000, 0, &rest);
        run_pair(&mut far, &mut near, 5 * SECOND);
        assert_eq!(near.last().health, Health::Ok, "{mode}");
        run(None, from_mut(&mut near), 6 * SECOND + 100 * MILLISECOND);
        assert_eq!(near.last().health, Health::MasterSilent, "{mode}");
        assert!(near.last().master.unwrap().age_cycles > 1000);
    }
}

#[test]
fn a_backlog_after_a_stop_never_reaches_the_slave() {
    let mut far = Far::new(1000, 200, 0, 1);
    let mut near = Near::new(
        1000,
        0,
        "mode = 'sync'\nsync.time-sync.automatic-re-init = true",
    );
    run_pair(&mut far, &mut near, 2 * SECOND);
    let before = near.last().master.unwrap().count;
    let woken = near.snapshots.len();
    // Frames sent meanwhile are stamped when the receiver wakes.
    near.sleep_until(5 * SECOND);
    run_pair(&mut far, &mut near, 6 * SECOND);
    for (truth, snapshot) in near.truths.iter().zip(&near.snapshots).skip(woken) {
        let master = snapshot.master.unwrap();
        let sent = master.count as i64 * MILLISECOND * 1_000_000 / 1_000_200;
        let age = truth - sent - LATENCY.as_nanos();
        assert!(
            // Age limit of 7 cycles, and the cycle that reads.
            master.count == before || age <= 8 * MILLISECOND,
            "count {} is {age} ns old",
            master.count
        );
        let position = master.received.position;
        assert!((position - VELOCITY * master.count as f64 * 1e-3).abs() < 1e-6);
    }
    let counters = near.last().counters;
    let dropped = counters.stale + counters.overflow;
    // 3 s at 1 kHz, less what is fresh on waking.
    assert!((2_900..3_010).contains(&dropped), "{counters:?}");
    // Cycles of the 3 s of sleep.
    assert!(near.last().overruns >= 2_998);
    assert!(near.last().master.unwrap().age_cycles <= 1, "fresh again");
}

#[test]
fn a_sender_that_starts_anew_is_followed_and_synchronised_again() {
    let mut far = Far::new(1000, 1000, 0, 11);
    let mut near = Near::new(
        1000,
        0,
        "mode = 'sync'\nsync.time-sync.automatic-re-init = true",
    );
    run_pair(&mut far, &mut near, 4 * SECOND);
    assert_eq!(near.last().health, Health::Ok);
    assert_eq!(near.last().counters.restarts, 0);
    let mut again = Far::new(1000, -800, 4 * SECOND + 500 * MILLISECOND, 12);
    run_pair(&mut again, &mut near, 10 * SECOND);
    let last = near.last();
    assert_eq!(last.counters.restarts, 1);
    assert_eq!(last.health, Health::Ok);
    let master = last.master.unwrap();
    assert_eq!(master.epoch, 12);
    assert!(
        (master.drift_ppm / -800.0 - 1.0).abs() < 0.01,
        "{}",
        master.drift_ppm
    );
    let errors = near
        .snapshots
        .iter()
        .filter(|s| matches!(s.health, Health::Error(_)));
    assert!(errors.count() >= 1, "the gap did not pass unseen");
}

#[test]
fn every_reason_for_refusal_is_counted_and_the_receiver_goes_on() {
    let mut far = Far::new(1000, 1000, 0, 1);
    let mut near = Near::new(1000, 0, "mode = 'sync'");
    run_pair(&mut far, &mut near, 4 * SECOND);
    let bad = refused_frames();
    for (k, (_, frame)) in bad.iter().enumerate() {
        near.post(4 * SECOND + k as i64, frame);
    }
    near.post(4 * SECOND + 100, &[]);
    run_pair(&mut far, &mut near, 5 * SECOND);
    let last = near.last();
    let counters = &last.counters;
    assert_eq!(counters.rejected, bad.len() as u64 + 1);
    assert_eq!(bad.len(), Rejection::ALL.len());
    // Half a frame, and an empty one.
    assert_eq!(counters.rejected_truncated, 2);
    for once in [
        counters.rejected_wrong_version,
        counters.rejected_wrong_checksum,
        counters.rejected_malformed,
        counters.rejected_trailing_bytes,
        counters.rejected_cycle_time_out_of_range,
        counters.rejected_present_after_out_of_range,
        counters.rejected_foreign_sender,
        counters.rejected_axis_missing,
        counters.rejected_implausible,
    ] {
        assert_eq!(once, 1);
    }
    assert_eq!(last.health, Health::Ok);
    assert_eq!(last.counters.lost, 0);
    assert!(near.newest(1_000).iter().all(|s| s.health == Health::Ok));
}

/// A frame for each reason to reject it.
fn refused_frames() -> Vec<(Rejection, Vec<u8>)> {
    let key = "coaxle/conveyor/axes";
    let seal = KeySeal::new(key);
    let sealed = |body: &[u8]| {
        let mut frame = Vec::new();
        seal.seal(body, None, &mut frame);
        frame
    };
    let axis = |id| NcToPlcAxis {
        axis_id: id,
        ..NcToPlcAxis::default()
    };
    let good = body("conveyor", axis(1));
    // A frame of one axis: the nominal cycle time of 1 ms before the number of axes.
    let cycle_time = [0xC0, 0x84, 0x3D, 1];
    let at = good
        .windows(4)
        .position(|four| four == cycle_time)
        .expect("valid");
    let with = |replaced: &[u8]| [&good[..at], replaced, &good[at + 4..]].concat();

    let mut flipped = sealed(&good);
    // A CRC finds each single bit.
    flipped[20] ^= 4;
    let mut version = sealed(&good);
    version[0] = 3;
    // 4 000 000 001 ns, in a frame of version 2.
    let delay = [0x81, 0xD0, 0xAC, 0xF3, 0x0E];
    let mut presented = [&good[..at + 3], &delay, &good[at + 3..]].concat();
    presented[0] = 2;
    let whole = sealed(&good);
    let nan = NcToPlcAxis {
        set_velocity: f64::NAN,
        ..axis(1)
    };
    vec![
        (Rejection::WrongVersion, version),
        (Rejection::Truncated, whole[..whole.len() / 2].to_vec()),
        (Rejection::WrongChecksum, flipped),
        // 200 axes.
        (
            Rejection::Malformed,
            sealed(&with(&[0xC0, 0x84, 0x3D, 0xC8, 1])),
        ),
        (
            Rejection::TrailingBytes,
            sealed(&[&good[..], &[0]].concat()),
        ),
        // 99 999 ns.
        (
            Rejection::CycleTimeOutOfRange,
            sealed(&with(&[0x9F, 0x8D, 0x06, 1])),
        ),
        (Rejection::PresentAfterOutOfRange, sealed(&presented)),
        (Rejection::ForeignSender, sealed(&body("other", axis(1)))),
        (Rejection::AxisMissing, sealed(&body("conveyor", axis(9)))),
        (Rejection::Implausible, sealed(&body("conveyor", nan))),
    ]
}

fn body(sender: &str, axis: NcToPlcAxis) -> Vec<u8> {
    let header = FrameHeader {
        sender: sender_id(&NodeName::new(sender).expect("valid")),
        epoch: 1,
        index: CycleIndex(7),
        count: 7,
        cycle_time: CycleTime::new(Span::from_millis(1)).expect("valid"),
        present_after: None,
        send_stamp: None,
    };
    let mut body = vec![0; body_capacity(1)];
    let length = encode_body(&header, &[axis], &mut body).expect("valid");
    body.truncate(length);
    body
}

#[test]
fn a_jump_of_the_master_trips_the_drive_and_the_slave_says_so() {
    let mut far = Far::new(1000, 0, 0, 1);
    let rest = "mode = 'bypass'\nslave = [{ id = 4, limits = { velocity = 1e6, acceleration = 1e9, \
                jerk = 1e12, on-master-loss = 'follow', distance.window = 0 }, drive = { max-velocity = 1000.0, \
                following-error-window = 2.0, following-error-time-s = 0.02 } }]";
    let mut near = Near::new(1000, 0, rest);
    near.tweak = Some(Box::new(|sent, sample| {
        if sent > SECOND {
            // Far beyond the following-error window of 2.
            sample.set.position += 1000.0;
        }
    }));
    run_pair(&mut far, &mut near, SECOND);
    assert_eq!(near.last().health, Health::Ok);
    assert_eq!(slave_axis(&near).error_code, 0);
    run_pair(&mut far, &mut near, 2 * SECOND);
    assert_eq!(near.last().health, Health::DriveTripped);
    assert_eq!(near.last().drive().state, DriveState::Tripped);
    assert!(near.last().drive().velocity.abs() < 1e-6, "at rest");
    let axis = slave_axis(&near);
    assert_eq!(axis.error_code, 0x4550);
    assert!(axis.state_word.contains(StateWord::ERROR));
    assert!(!axis.state_word.contains(StateWord::OPERATIONAL));
    let first = near
        .snapshots
        .iter()
        .position(|s| s.health == Health::DriveTripped)
        .unwrap();
    // 1 000 cycles before the jump, then 20 ms of following error.
    assert!((1_015..1_030).contains(&first), "after 20 ms: {first}");
}

fn slave_axis(near: &Near) -> NcToPlcAxis {
    let mut found = None;
    let frame = near.slave_frame.as_ref().expect("a frame");
    decode("coaxle/saw/slaves", frame, |axis| found = Some(*axis)).expect("a good frame");
    found.expect("an axis")
}

#[test]
fn parameters_out_of_range_are_refused_by_name_before_anything_runs() {
    let refusal = |rest: &str| -> (Wrong, String) {
        let head = "name = 'saw'\nmaster.node = 'conveyor'\ncycle-time-us = 1000\n";
        let config: ReceiverConfig = parse("r.toml", &format!("{head}{rest}")).unwrap();
        let error = Receiver::new(&config, coaxle_clock::Instant::EPOCH, 1).unwrap_err();
        let text = error.to_string();
        (error, text)
    };
    for (rest, name) in [
        (
            "sync.time-sync.threshold-for-sync = 0.0",
            "threshold-for-sync",
        ),
        (
            "sync.time-sync.max-cycle-index-difference = -1.0",
            "max-cycle-index-difference",
        ),
        (
            "sync.time-sync.no-of-periods-for-mean-drift = 65",
            "no-of-periods-for-mean-drift",
        ),
        ("sync.time-sync.slope1-numerator = 1.5", "slope1-numerator"),
        (
            "sync.time-sync.slope1-denominator = 1.0",
            "slope1-denominator",
        ),
        (
            "sync.time-sync.end-of-transition-limit = 0",
            "end-of-transition-limit",
        ),
        (
            "sync.time-sync.delay-time-offset-s = inf",
            "delay-time-offset-s",
        ),
        (
            "sync.time-sync.data-cycle-time-s = 0.0015",
            "data-cycle-time-s",
        ),
        (
            "sync.extrapolate.max-position-diff = -1.0",
            "max-position-diff",
        ),
    ] {
        let (error, text) = refusal(rest);
        assert_eq!(error.field(), "sync", "{text}");
        assert!(text.contains(&format!("0x4b56: {name} is ")), "{text}");
    }
    for (slave, expected) in [
        ("gear.ratio = 0.0", "slave[0].gear: 0x421b: "),
        (
            "drive.position-gain = -3.0",
            "slave[0].drive: position-gain is -3",
        ),
    ] {
        let (error, text) = refusal(&format!("slave = [{{ {slave} }}]"));
        assert!(error.field().starts_with("slave[0]."), "{text}");
        assert!(text.starts_with(expected), "{text}");
    }
}
