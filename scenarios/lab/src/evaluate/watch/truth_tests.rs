//! Far time and far position, each just within its bound and just beyond it.

use coaxle_clock::delay::DelayState;
use coaxle_node::config::parse;
use coaxle_receiver::{FilterMode, ReceiverConfig};

use super::{FarErrorWatch, FarPositionWatch};
use crate::invariants::{Invariant, InvariantViolation};
use crate::record::ReceiverCycle;
use crate::row::Row;
use crate::topology::{ReceiverAxis, Root, View};

const CYCLE: f64 = 1e-3;

fn config() -> ReceiverConfig {
    let text = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'belt' }\n";
    parse("saw.toml", text).expect("a config")
}

fn view() -> View {
    View {
        name: "saw".to_owned(),
        receiver: 0,
        of: ReceiverAxis::Far { far: 0, axis: 0 },
        slaves: Vec::new(),
        root: Root {
            source: 0,
            node: 0,
            axis: 1,
            gear: None,
        },
        standbys: Vec::new(),
        nodes: vec![0],
    }
}

/// A cycle in sync by the observer.
fn row(cycle: u32) -> Row {
    let mut record = Box::<ReceiverCycle>::default();
    record.node.cycle = cycle.into();
    record.far.mode = FilterMode::Observer;
    record.axis.synced = true;
    Row {
        t_s: CYCLE * f64::from(cycle),
        record,
        truth: None,
        set_velocity: None,
        time_error_us: None,
        evaluated: true,
    }
}

/// Returns a cycle in sync by the observer, with a measured delay and its stated uncertainty, µs.
fn measured(cycle: u32, uncertainty: f64) -> Row {
    let mut row = row(cycle);
    row.record.far.delay_state = Some(DelayState::Measured);
    row.record.far.delay_uncertainty_us = Some(uncertainty);
    row
}

fn is_found(violations: impl Iterator<Item = InvariantViolation>, invariant: Invariant) -> bool {
    let found: Vec<_> = violations.map(|one| one.invariant).collect();
    assert!(found.iter().all(|one| *one == invariant));
    !found.is_empty()
}

/// Reports whether an error of the far time is found.
fn is_error_found(rows: impl IntoIterator<Item = Row>) -> bool {
    let mut watch = FarErrorWatch::new(&config(), &view(), &[], Some(0.0)).expect("a far axis");
    rows.into_iter().for_each(|row| watch.push(&row, 0.0));
    is_found(watch.violations(), Invariant::FarError)
}

#[test]
fn a_time_is_wrong_by_its_uncertainty_and_what_is_to_be_made_up_and_no_more() {
    let is_found = |error: f64, slew: f64| {
        let mut row = measured(1, 100.0);
        row.time_error_us = Some(error);
        row.record.far.slew_remaining_us = Some(slew);
        is_error_found([row])
    };
    // The uncertainty of 100 µs, and with it the 50 µs that are still to be slewed.
    assert!(!is_found(-99.0, 0.0) && is_found(-101.0, 0.0));
    assert!(!is_found(149.0, -50.0) && is_found(151.0, -50.0));
}

#[test]
fn a_time_is_wrong_by_what_a_clock_has_just_changed_too_and_no_more() {
    let is_found = |error: f64| {
        let mut watch = FarErrorWatch::new(&config(), &view(), &[], None).expect("a far axis");
        let mut row = measured(1, 2.0);
        row.time_error_us = Some(error);
        watch.push(&row, 3.0);
        is_found(watch.violations(), Invariant::FarError)
    };
    assert!(!is_found(4.9) && is_found(5.1));
}

/// Seed 519 of the swarm schedules compared a position within the turn with a master that was in another one.
#[test]
fn a_position_within_the_turn_is_in_any_turn_of_its_master() {
    let is_found = |position: &str, off: f64| {
        let text = format!(
            "name = 'saw'\ncycle-time-us = 1000\n[[far]]\nnode = 'belt'\naxes = [{{ id = 1, modulo = 360{position} }}]\n"
        );
        let config: ReceiverConfig = parse("saw.toml", &text).expect("a config");
        let mut watch = FarPositionWatch::new(&config, &view(), &[], None).expect("a far axis");
        for cycle in 0..1_000 {
            let mut row = measured(cycle, 100.0);
            let [position, velocity] = steady(row.t_s);
            row.truth = Some((position, velocity));
            row.record.axis.corrected_position = Some(position + off);
            watch.push(&row, 1.0, 0.0, true);
        }
        is_found(watch.violations(), Invariant::FarPosition)
    };
    let within = ", position = 'within-turn'";
    assert!(!is_found(within, 360.0) && !is_found(within, -720.049));
    assert!(is_found(within, 360.051) && is_found(within, 180.0));
    // One that counts through is in its master's turn.
    assert!(is_found("", 360.0) && !is_found("", 0.049));
}

#[test]
fn a_time_is_as_far_ahead_as_configured_and_wrong_by_no_more_than_its_uncertainty_beside_it() {
    let is_found = |error: f64| {
        let mut row = measured(1, 100.0);
        row.time_error_us = Some(error);
        row.record.far.time_offset_us = Some(30_000.0);
        is_error_found([row])
    };
    assert!(!is_found(30_099.0) && !is_found(29_901.0));
    // The offset has not been added, or twice.
    assert!(is_found(0.0) && is_found(60_000.0) && is_found(30_101.0));
}

#[test]
fn a_time_without_a_measured_delay_stays_where_it_was_but_for_what_is_to_be_made_up() {
    // Wrong by 700 µs from the start, as the delay is not measured; from 3 s on by this, µs.
    let is_found = |later: f64, slew: f64| {
        is_error_found((0..4_000).map(|cycle| {
            let mut row = row(cycle);
            let (error, slew) = if cycle < 3_000 {
                (0.0, 0.0)
            } else {
                (later, slew)
            };
            row.time_error_us = Some(700.0 + error);
            row.record.far.slew_remaining_us = Some(slew);
            row
        }))
    };
    // 2 ms either side of the 700 µs that it settled at.
    assert!(!is_found(1_990.0, 0.0) && is_found(2_010.0, 0.0));
    // An order has changed the path delay by 9 ms, which is slewed; and it is not.
    assert!(!is_found(9_000.0, -9_000.0) && is_found(9_000.0, 0.0));
    // A clock that goes wrong by 1000 ppm.
    let wrong = (0..8_000).map(|cycle| {
        let mut row = row(cycle);
        // 1 µs a cycle of 1 ms.
        row.time_error_us = Some(f64::from(cycle));
        row
    });
    assert!(is_error_found(wrong));
}

/// In swarm schedule 50718 a clock was unsure by 38 ms, and came back; before a cure it was 6 ms off while it stated 0.3.
#[test]
fn a_time_may_move_by_what_it_is_unsure_of_and_no_more() {
    let is_found = |sigma: fn(f64) -> f64, error: fn(f64) -> f64| {
        is_error_found((0..20_000).map(|cycle| {
            let mut row = row(cycle);
            let t = 1e-3 * f64::from(cycle);
            row.time_error_us = Some(error(t));
            row.record.far.offset_sigma_us = Some(sigma(t));
            row
        }))
    };
    let surer = |t: f64| 30_000.0 * (-t).exp() + 300.0;
    assert!(!is_found(surer, |t| 30_000.0 * (-t).exp()));
    assert!(!is_found(surer, |t| 30_000.0 * (-t).exp() + 150.0 * t));
    assert!(is_found(surer, |t| 30_000.0 * (-t).exp() + 500.0 * t));
    assert!(is_found(|_| 1.0, |t| 300.0 * t));
}

/// A master in a cycle: position, velocity.
type Motion = fn(f64) -> [f64; 2];

/// Reports whether a wrong position of an axis is found: off its master by `off`, as a function of the time, s, with set values
/// of this age, s, and a time that may be wrong by `uncertainty`, µs.
fn is_position_found(master: Motion, age: f64, uncertainty: f64, off: impl Fn(f64) -> f64) -> bool {
    let config = config();
    let mut watch = FarPositionWatch::new(&config, &view(), &[], None).expect("a far axis");
    for cycle in 0..1_000 {
        let mut row = measured(cycle, uncertainty);
        let [position, velocity] = master(row.t_s);
        row.truth = Some((position, velocity));
        row.record.axis.correction_us = Some(age * 1e6);
        row.record.axis.corrected_position = Some(position + off(row.t_s));
        watch.push(&row, 1.0, 0.0, true);
    }
    is_found(watch.violations(), Invariant::FarPosition)
}

fn steady(t: f64) -> [f64; 2] {
    [500.0 * t, 500.0]
}

/// From 0.5 s on it is accelerated by 5 000 u/s², for 0.1 s.
fn ramp(t: f64) -> [f64; 2] {
    let on = (t - 0.5).clamp(0.0, 0.1);
    let after = (t - 0.6).max(0.0);
    let way = 2_500.0 * on * on + 500.0 * after;
    [500.0 * t + way, 500.0 + 5_000.0 * on]
}

#[test]
fn an_axis_is_off_a_steady_master_by_the_time_times_the_velocity_and_no_more() {
    // 100 µs at 500 u/s.
    assert!(!is_position_found(steady, 5e-3, 100.0, |_| 0.0499));
    assert!(is_position_found(steady, 5e-3, 100.0, |_| -0.0501));
}

/// Swarm schedule 141: beside a time that was still to be slewed by 15 ms the axis was 14 nm farther than the velocity by reference time explains.
#[test]
fn a_time_of_the_far_clock_is_multiplied_by_the_velocity_in_that_clock() {
    let is_found = |pace: f64| {
        let config = config();
        let mut watch = FarPositionWatch::new(&config, &view(), &[], None).expect("a far axis");
        for cycle in 0..1_000 {
            let mut row = measured(cycle, 15_000.0);
            let [position, own_velocity] = steady(row.t_s);
            row.truth = Some((position, own_velocity * pace));
            row.record.axis.corrected_position = Some(position + own_velocity * 0.014_999);
            watch.push(&row, pace, 0.0, true);
        }
        is_found(watch.violations(), Invariant::FarPosition)
    };
    for pace in [1.0, 1.0 - 8e-4, 1.0 + 8e-4] {
        assert!(!is_found(pace), "{pace}");
    }
}

#[test]
fn what_set_values_under_way_do_not_know_of_a_motion_is_half_of_its_change_times_their_age_squared()
{
    // Of a motion that began since it was sent: ½ · 5 000 u/s² · (5 ms)², and what a time that is off by 100 µs adds.
    let unknown = |t: f64, age: f64| {
        let since = (t - 0.5).clamp(0.0, age);
        let is_new = t < 0.5 + age;
        if is_new {
            -2_500.0 * since * since
        } else {
            0.0
        }
    };
    assert!(!is_position_found(ramp, 5e-3, 100.0, |t| unknown(t, 5e-3)));
    // One that does not know of it for three times as long as it says.
    assert!(is_position_found(ramp, 5e-3, 100.0, |t| unknown(t, 15e-3)));
    // As far off once the motion is steady.
    // The bound of the ramp, ½ · 5 000 · (5 ms)², without a change to allow it.
    assert!(is_position_found(steady, 5e-3, 100.0, |_| 0.0625));
}

#[test]
fn what_changes_within_a_cycle_is_a_mean_over_it() {
    // Set values a tenth of a cycle old do not say when in the cycle the motion began: ½ · 5 000 u/s² · (1 ms)².
    let at_once = |off: f64| {
        move |t: f64| {
            if (0.5005..0.5025).contains(&t) {
                off
            } else {
                0.0
            }
        }
    };
    assert!(!is_position_found(ramp, 1e-4, 1.0, at_once(-0.0025)));
    assert!(is_position_found(ramp, 1e-4, 1.0, at_once(-0.0050)));
}

#[test]
fn a_jump_of_the_master_is_its_own_for_as_long_as_it_is_under_way() {
    let jumps = |t: f64| [500.0 * t + if t < 0.5 { 0.0 } else { 7.0 }, 500.0];
    let behind = |cycles: f64| {
        move |t: f64| {
            let is_behind = (0.5..0.5 + cycles * CYCLE).contains(&t);
            if is_behind { -7.0 } else { 0.0 }
        }
    };
    assert!(!is_position_found(jumps, 2e-3, 10.0, behind(2.0)));
    assert!(is_position_found(jumps, 2e-3, 10.0, behind(20.0)));
}

/// Wide schedule 701866: during a freeze its master turned round, and an axis goes on from a frame of that time.
#[test]
fn a_master_that_was_not_seen_is_bounded_by_its_velocity() {
    // At ±20 u/s, for 0.1 s each.
    let master = |t: f64| {
        let x = (t / 0.2).fract();
        let velocity = if x < 0.5 { 20.0 } else { -20.0 };
        [4.0 * if x < 0.5 { x } else { 1.0 - x }, velocity]
    };
    let found = |skipped: std::ops::Range<u32>, off: f64| {
        let mut watch = FarPositionWatch::new(&config(), &view(), &[], None).expect("a far axis");
        for cycle in (0..900).filter(|cycle| !skipped.contains(cycle)) {
            let mut row = measured(cycle, 1.0);
            let [position, velocity] = master(row.t_s);
            row.truth = Some((position, velocity));
            let is_off = cycle == 850;
            row.record.axis.correction_us = Some(if is_off { 0.3e6 } else { 1e3 });
            row.record.axis.corrected_velocity = Some(20.0);
            row.record.axis.corrected_position = Some(position + if is_off { off } else { 0.0 });
            watch.push(&row, 1.0, 0.0, true);
        }
        is_found(watch.violations(), Invariant::FarPosition)
    };
    // (20 + 20) u/s · 0.3 s.
    assert!(!found(452..850, 11.9));
    assert!(found(452..850, 12.2));
}
