//! Axes and slaves that are still on their way, and those that have had time enough.

use coaxle_axis::AxisStatus;
use coaxle_node::config::parse;
use coaxle_receiver::ContinuityState;
use coaxle_receiver::signals::{FarAxisSignals, SlaveSignals};

use super::*;
use crate::record::ReceiverCycle;

const CONFIG: &str = "name = 'r'\ncycle-time-us = 1000\nmaster = { node = 'a' }\n[[slave]]\nname = 'x'\n\
                      limits = { velocity = 500, acceleration = 1000, jerk = 1e5 }\n";

fn config() -> ReceiverConfig {
    parse("r.toml", CONFIG).expect("a config")
}

fn row(t_s: f64, axis: FarAxisSignals) -> Row {
    Row {
        t_s,
        record: Box::new(ReceiverCycle {
            axis,
            ..ReceiverCycle::default()
        }),
        truth: None,
        set_velocity: None,
        time_error_us: None,
        evaluated: true,
    }
}

fn beside(continuity: ContinuityState, distance: f64, velocity: f64) -> FarAxisSignals {
    FarAxisSignals {
        continuity,
        received_position: Some(0.0),
        received_velocity: Some(velocity),
        corrected_position: Some(distance),
        ..FarAxisSignals::default()
    }
}

/// The fault of an axis after these rows, at their times.
fn fault_of_axis(rows: impl IntoIterator<Item = (f64, FarAxisSignals)>) -> Option<String> {
    let mut watch = AxisLiveness::new(&config(), &View::of_first_axis(1)).expect("a far axis");
    for (t_s, axis) in rows {
        watch.push(&row(t_s, axis));
    }
    watch.broken()
}

#[test]
fn an_axis_on_its_way_back_has_the_time_that_its_way_takes() {
    use ContinuityState::{Following, Rejoining};
    // 100 u, and 50 u of delay, at 50 u/s of a master that once had 100 u/s: 1.875 · 150/50 + 0.6 = 6.225 s.
    let until = |end: f64| {
        fault_of_axis([
            (0.0, beside(Following, 0.0, 100.0)),
            (10.0, beside(Rejoining, 100.0, 10.0)),
            (end, beside(Rejoining, 1.0, 10.0)),
        ])
    };
    assert_eq!(until(16.2), None);
    let fault = until(16.3).expect("a fault");
    assert!(
        fault.contains("it takes 6.225 s at most, and had 6.300 s"),
        "{fault}"
    );
}

/// Swarm schedule 3088: a way back of 245 u that began behind a master which had moved by micrometres, and later moved at 12 u/s.
#[test]
fn a_way_back_is_planned_again_behind_a_master_that_has_become_faster() {
    use ContinuityState::Rejoining;
    let until = |end: f64| {
        fault_of_axis([
            (0.0, beside(Rejoining, 100.0, 10.0)),
            (10.0, beside(Rejoining, 100.0, 100.0)),
            (11.0, beside(Rejoining, 100.0, 150.0)),
            (end, beside(Rejoining, 1.0, 10.0)),
        ])
    };
    // From 10 s on, when it became more than twice as fast: 100 u, and 75 u of delay, at half of 100 u/s: 1.875 · 175/50 + 0.6 = 7.1625 s.
    assert_eq!(until(17.1), None);
    assert!(until(17.2).is_some());
}

/// Swarm schedule 1075: its master, another far axis that its guard leads to and fro, changed its acceleration at seven times its jerk limit.
#[test]
fn an_axis_whose_master_is_rougher_than_its_limits_is_beside_it_by_no_more_than_that_explains() {
    let limits = "limits = { velocity = 500, acceleration = 1000, jerk = 30000 }";
    let text = format!("name = 'r'\ncycle-time-us = 1000\nmaster = {{ node = 'a', {limits} }}\n");
    let config: ReceiverConfig = parse("r.toml", &text).expect("a config");
    // Accelerations of up to ±200 u/s² in turn, in each cycle of 1 ms or in every fourth one, and velocities of 1 to 2 u/s.
    let fault_of = |every: u32, most: f64, distance: f64| {
        let mut watch = AxisLiveness::new(&config, &View::of_first_axis(1)).expect("a far axis");
        for cycle in 0..20_000_u32 {
            let is_odd = cycle / every % 2 == 1;
            let axis = FarAxisSignals {
                received_acceleration: Some(if is_odd { most } else { -most }),
                ..beside(
                    ContinuityState::Rejoining,
                    distance,
                    if is_odd { 2.0 } else { 1.0 },
                )
            };
            let mut row = row(1e-3 * f64::from(cycle), axis);
            row.record.far.count = Some((cycle / every).into());
            watch.push(&row);
        }
        watch.broken()
    };
    let fault = |turns, distance| fault_of(1, if turns { 200.0 } else { 0.0 }, distance);
    // A stop from the difference of 1 u/s: 1 · √(1/15 000) = 8.2e-3 u, and the tolerance of 1e-3 u.
    assert_eq!(fault(true, 9e-3), None);
    assert!(fault(true, 9.5e-3).is_some());
    assert!(fault(false, 9e-3).is_some(), "a steady acceleration");
    // The jerk of the axis is 30 u/s² in a cycle, however long a frame has been the newest one.
    assert_eq!(fault_of(4, 16.0, 9e-3), None);
    assert!(fault_of(4, 14.0, 9e-3).is_some());
}

#[test]
fn an_axis_without_a_master_is_a_fault_unless_that_is_in_error() {
    let braking = beside(ContinuityState::Braking, 0.0, 0.0);
    assert!(fault_of_axis([(1.0, braking)]).is_some());
    let in_error = FarAxisSignals {
        received_error: 0x4655,
        ..braking
    };
    assert_eq!(fault_of_axis([(1.0, in_error)]), None);
}

#[test]
fn at_rest_an_axis_is_where_its_master_is() {
    let at_rest = |distance: f64| {
        let rows = [0.0, 5.1].map(|t_s| (t_s, beside(ContinuityState::Following, distance, 0.0)));
        fault_of_axis(rows)
    };
    assert_eq!(at_rest(0.0005), None);
    assert!(at_rest(-0.002).is_some());
}

fn coupled(position: f64, distance: f64) -> SlaveSignals {
    SlaveSignals {
        position: Some(position),
        distance,
        state: AxisStatus::SynchronizedMotion,
        ..SlaveSignals::default()
    }
}

/// The fault of a slave after these rows, at their times.
fn fault_of_slave(rows: impl IntoIterator<Item = (f64, SlaveSignals)>) -> Option<String> {
    let mut watch = SlaveLiveness::new(&config().slaves[0], None);
    for (t_s, slave) in rows {
        watch.push(t_s, 0, &slave);
    }
    watch.broken(TargetMotion::Beats)
}

#[test]
fn a_coupled_slave_is_where_its_coupling_has_it_or_on_the_way_there() {
    // (10 + 500 · 0.51)/250 + 2 · 0.51 = 2.08 s.
    let behind = |end: f64, distance: f64| {
        // Its target goes away from it at 100 u/s, and in no beat.
        let away = (0..=100_u32).map(|k| (1.0 + 1e-3 * f64::from(k), -0.1 * f64::from(k)));
        let rows = away.chain([(end, distance)]);
        fault_of_slave(rows.map(|(t_s, distance)| (t_s, coupled(0.0, distance))))
    };
    assert_eq!(behind(9.0, 0.0005), None);
    assert_eq!(behind(3.0, -10.0), None);
    let fault = behind(3.1, -10.0).expect("a fault");
    assert!(fault.contains("10.000000 u away at the end"), "{fault}");
    // Without power it may be anywhere.
    let off = SlaveSignals {
        state: AxisStatus::Disabled,
        ..coupled(0.0, -10.0)
    };
    assert_eq!(fault_of_slave([(0.0, off), (9.0, off)]), None);
}

#[test]
fn a_slave_begins_to_make_up_its_distance_when_its_target_is_slow_enough() {
    // The target goes at 300 u/s up to 8 s, more than half of the limit, and stands from then on.
    let target = |t_s: f64| 300.0 * t_s.min(8.0);
    let rows = |end: f64| {
        let times = (0_u32..).map(|k| 1e-3 * f64::from(k));
        let times = times.take_while(move |t_s| *t_s <= end);
        times.map(move |t_s| (t_s, coupled(target(t_s) - 10.0, -10.0)))
    };
    assert_eq!(fault_of_slave(rows(9.5)), None);
    assert!(fault_of_slave(rows(10.5)).is_some());
}

#[test]
fn a_target_that_jumps_is_a_fault_where_its_master_moves_evenly() {
    let mut watch = SlaveLiveness::new(&config().slaves[0], None);
    // A millimetre each second, 10 mm/s in ten cycles, would be followed; at once it is 1000 mm/s for a cycle of 1 ms.
    for k in 0..20_000_u32 {
        let t_s = 1e-3 * f64::from(k);
        watch.push(t_s, 0, &coupled(t_s.floor() - 0.01, -0.01));
    }
    assert_eq!(
        watch.broken(TargetMotion::Beats),
        None,
        "in beats, or on the way"
    );
    let fault = watch.broken(TargetMotion::Even).expect("a fault");
    assert!(fault.contains("moved at 1000.000 u/s"), "{fault}");
}

/// Swarm schedules 2726, 2799 and 3279: behind an axis in `bypass`, each frame of whose master lasts four cycles.
#[test]
fn a_slave_of_an_axis_in_beats_is_within_a_beat_of_it() {
    let fault = |distance: f64| {
        let mut watch = SlaveLiveness::new(&config().slaves[0], None);
        for k in 0..20_000_u32 {
            // Steps of 0.2 u, 200 u/s for a cycle: less than half of the velocity limit.
            let target = 0.2 * f64::from(k / 4);
            watch.push(
                1e-3 * f64::from(k),
                0,
                &coupled(target + distance, distance),
            );
        }
        [TargetMotion::Beats, TargetMotion::Even].map(|motion| watch.broken(motion).is_some())
    };
    assert_eq!(fault(0.19), [false, true]);
    assert_eq!(fault(0.21), [true, true]);
}

/// Swarm schedule 90356: behind two receivers of a chain that follow one in `bypass`.
#[test]
fn a_slave_whose_target_is_rougher_than_its_limits_is_beside_it_by_no_more_than_that_explains() {
    // Velocities of 1 u/s and `swing` more in turn, each for eight cycles of 1 ms.
    let fault = |swing: f64, distance: f64| {
        let mut watch = SlaveLiveness::new(&config().slaves[0], None);
        let mut target = 0.0;
        for k in 0..20_000_u32 {
            target += 1e-3 * (1.0 + swing * f64::from(k / 8 % 2));
            watch.push(
                1e-3 * f64::from(k),
                0,
                &coupled(target + distance, distance),
            );
        }
        [
            TargetMotion::Relayed,
            TargetMotion::Beats,
            TargetMotion::Even,
        ]
        .map(|motion| watch.broken(motion).is_some())
    };
    // 2000 u/s² for a cycle. A stop from the difference of 2 u/s: 2 · √(2/50 000) = 12.6e-3 u, and the tolerance of 1e-3 u.
    assert_eq!(fault(2.0, 13e-3), [false, true, true]);
    assert_eq!(fault(2.0, 14e-3), [true, true, true]);
    // ±40 u/s², which change by less than the jerk allows in a cycle.
    assert_eq!(fault(0.04, 13e-3), [true, true, true]);
}

#[test]
fn masters_that_move_for_ever_are_not_judged() {
    let scenario = |seed: u64, kind: crate::soak::ScheduleKind| {
        let scenario = crate::soak::source((kind.text)(seed)).read(&[]);
        scenario.unwrap_or_else(|error| panic!("{error:#}"))
    };
    assert!(is_steady_at_the_end(&scenario(
        1,
        crate::soak::schedule::SWARM
    )));
    assert!(!is_steady_at_the_end(&scenario(
        1,
        crate::soak::schedule::PLAIN
    )));
}
