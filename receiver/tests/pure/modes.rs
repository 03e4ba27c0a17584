//! The master as a receiver shows it, for each mode and ratio.

use crate::bench::{Far, MILLISECOND, Near, SECOND, VELOCITY, ripple, run_pair};
use coaxle_receiver::{DriveState, FilterState, Health, HealthName};

fn state_of(near: &Near) -> FilterState {
    near.last().master.expect("a master").state
}

#[test]
fn each_mode_shows_itself() {
    for (mode, state, health) in [
        ("bypass", FilterState::Bypass, HealthName::Ok),
        ("pt1", FilterState::Pt1, HealthName::Ok),
        ("time", FilterState::Time, HealthName::Ok),
        ("sync", FilterState::Time, HealthName::StartingUp),
        ("observer", FilterState::Time, HealthName::StartingUp),
    ] {
        let mut far = Far::new(1000, 1000, 0, 1);
        let mut near = Near::new(1000, 0, &format!("mode = '{mode}'"));
        run_pair(&mut far, &mut near, 100 * MILLISECOND);
        assert_eq!(
            (state_of(&near), near.last().health.name()),
            (state, health),
            "{mode}"
        );
        run_pair(&mut far, &mut near, 5 * SECOND);
        let later = match mode {
            "sync" => FilterState::Sync,
            "observer" => FilterState::Observer,
            _ => state,
        };
        assert_eq!(state_of(&near), later, "{mode}");
        assert_eq!(near.last().health, Health::Ok, "{mode}");
        assert!(
            near.last().master.unwrap().synced,
            "{mode}: the drift is learnt in every mode"
        );
    }
}

#[test]
fn forced_time_mode_is_time_mode_and_all_is_well() {
    let mut far = Far::new(1000, 1000, 0, 1);
    let forced = "mode = 'sync'\nsync.time-sync.force-time-mode = true";
    let mut near = Near::new(1000, 0, forced);
    run_pair(&mut far, &mut near, 5 * SECOND);
    assert_eq!(state_of(&near), FilterState::Time);
    assert_eq!(near.last().health, Health::Ok);
}

#[test]
fn start_up_modes_are_obeyed() {
    for (mode, state) in [("bypass", FilterState::Bypass), ("pt1", FilterState::Pt1)] {
        let mut far = Far::new(1000, 1000, 0, 1);
        let mut near = Near::new(
            1000,
            0,
            &format!("mode = 'sync'\nsync.start-up-mode = '{mode}'"),
        );
        run_pair(&mut far, &mut near, 200 * MILLISECOND);
        assert_eq!(state_of(&near), state);
    }
}

#[test]
fn without_correction_every_beat_is_a_spike_and_with_it_there_is_none() {
    let slopes = "sync.time-sync = { slope1-numerator = 0.5, slope1-denominator = 0.5 }";
    let mut ripples = [0.0; 2];
    for (ripple_of, mode) in ripples.iter_mut().zip(["bypass", "sync"]) {
        let mut far = Far::new(1000, 1000, 0, 1);
        let mut near = Near::new(1000, 0, &format!("mode = '{mode}'\n{slopes}"));
        run_pair(&mut far, &mut near, 8 * SECOND);
        // Three beats, at one per second for 1 000 ppm.
        *ripple_of = ripple(near.newest(3000), 1e-3, VELOCITY * 1.001);
    }
    let [bypass, sync] = ripples;
    // A beat skips or repeats the way of a whole cycle.
    assert!((0.98..1.02).contains(&bypass), "{bypass}");
    assert!(sync < 0.005, "{sync}");
}

#[test]
fn the_cycle_time_of_the_sender_is_taken_from_its_frames() {
    for (data_us, own_us) in [(2000, 1000), (1000, 4000), (1000, 1000)] {
        let mut far = Far::new(data_us, 400, 0, 1);
        let mut near = Near::new(own_us, 0, "mode = 'sync'");
        run_pair(&mut far, &mut near, 20 * SECOND);
        let last = near.last();
        let master = last.master.expect("a master");
        assert!(master.synced, "{data_us} to {own_us} µs: {last:?}");
        assert_eq!(master.state, FilterState::Sync);
        let drift = master.drift_ppm / 400.0;
        assert!(
            (drift - 1.0).abs() < 0.01,
            "{data_us} to {own_us} µs: {drift}"
        );
        let cycle_s = f64::from(own_us) * 1e-6;
        let seconds = (1.0 / cycle_s) as usize;
        let rippled = ripple(near.newest(seconds), cycle_s, VELOCITY * 1.0004);
        assert!(rippled < 0.02, "{data_us} to {own_us} µs: {rippled}");
        let learnt = last.data_cycle_time.expect("known").span().as_micros_f64();
        assert_eq!(learnt, f64::from(data_us));
    }
}

#[test]
fn a_cycle_time_that_does_not_fit_moves_nothing() {
    // 1.5 and 0.7 ms are neither a multiple nor a part of 1 ms.
    for (data_us, rest) in [
        (1500, ""),
        (700, ""),
        (1000, "sync.time-sync.data-cycle-time-s = 0.002"),
        (2000, "sync.time-sync.data-cycle-time-s = 0.001"),
    ] {
        let mut far = Far::new(data_us, 0, 0, 1);
        let mut near = Near::new(1000, 0, rest);
        run_pair(&mut far, &mut near, SECOND);
        let last = near.last();
        assert_eq!(last.health, Health::CycleTimesDoNotFit, "{data_us} {rest}");
        assert_eq!((last.master, last.slave()), (None, None));
        assert_eq!(last.drive().state, DriveState::Off);
        assert_eq!(near.slave_frame, None);
        // At 2 ms, 500 frames arrive in the second.
        assert!(last.counters.received > 400, "it goes on listening");
        let learnt = last.data_cycle_time.expect("known").span().as_micros_f64();
        assert_eq!(learnt, f64::from(data_us));
    }
}

#[test]
fn a_configured_cycle_time_that_fits_is_no_obstacle() {
    let mut far = Far::new(2000, 0, 0, 1);
    let mut near = Near::new(
        1000,
        0,
        "mode = 'sync'\nsync.time-sync.data-cycle-time-s = 0.002",
    );
    run_pair(&mut far, &mut near, SECOND);
    assert_eq!(near.last().health, Health::StartingUp);
}

#[test]
fn the_index_wraps_unnoticed() {
    let run = |first: u16| {
        let mut far = Far::new(1000, 1000, 0, 1);
        let mut near = Near::new(1000, 0, "mode = 'sync'");
        near.first_index = Some(first);
        run_pair(&mut far, &mut near, 8 * SECOND);
        near
    };
    // From 60 000, the index wraps after 5.5 s.
    let (wrapping, plain) = (run(60_000), run(0));
    let indices: Vec<u16> = wrapping
        .snapshots
        .iter()
        .filter_map(|s| s.master.map(|m| m.index))
        .collect();
    assert!(
        indices
            .windows(2)
            .any(|pair| pair[0] > 65_000 && pair[1] < 500),
        "it wraps"
    );
    assert!(wrapping.last().master.unwrap().synced);
    for (a, b) in wrapping.snapshots.iter().zip(&plain.snapshots) {
        assert_eq!(a.slave(), b.slave());
        assert_eq!(a.health, b.health);
    }
}
