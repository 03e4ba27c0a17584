//! Rows that break an invariant, and rows that do not.

use super::*;
use crate::invariants::Invariant;
use coaxle_axis::AxisStatus;
use coaxle_node::config::parse;
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals};
use coaxle_receiver::{ContinuityState, FilterMode, FilterState, GuardState};
use coaxle_slave::CouplingPhase;

const CONFIG: &str = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'belt' }\n[[slave]]\nname = 'x'\n\
                      limits = { velocity = 500, acceleration = 1000, jerk = 1e5 }\n";

/// The invariants that rows break, a cycle apart.
fn broken(rows: impl IntoIterator<Item = SignalRow>) -> Vec<Invariant> {
    broken_in(World::Virtual, rows)
}

fn broken_in(world: World, rows: impl IntoIterator<Item = SignalRow>) -> Vec<Invariant> {
    broken_with(&[], world, rows)
}

fn broken_with(
    events: &[Event],
    world: World,
    rows: impl IntoIterator<Item = SignalRow>,
) -> Vec<Invariant> {
    let config: ReceiverConfig = parse("saw.toml", CONFIG).expect("a config");
    let mut watch = ReceiverWatch::new(&config, events, world);
    for (cycle, mut row) in (1..).zip(rows) {
        row.node.cycle += cycle;
        watch.push(cycle as f64 * 1e-3, &row);
    }
    watch.violations().map(|found| found.invariant).collect()
}

/// The invariants that rows of a far node break.
fn broken_of_far(rows: impl IntoIterator<Item = FarNodeSignals>) -> Vec<Invariant> {
    broken(
        rows.into_iter()
            .map(|far| row(SlaveSignals::default(), far)),
    )
}

fn row(slave: SlaveSignals, far: FarNodeSignals) -> SignalRow {
    SignalRow {
        node: NodeSignals::default(),
        far: [far].into(),
        axes: [FarAxisSignals::default()].into(),
        virtual_axes: [].into(),
        slaves: [slave].into(),
    }
}

fn in_state(state: AxisStatus, position: f64, velocity: f64) -> SignalRow {
    let slave = SlaveSignals {
        state,
        position: Some(position),
        velocity: Some(velocity),
        acceleration: Some(0.0),
        ..SlaveSignals::default()
    };
    row(slave, FarNodeSignals::default())
}

#[test]
fn error_stop_is_left_for_rest_only() {
    use AxisStatus::{DiscreteMotion, ErrorStop, Standstill};
    let states =
        |states: &[AxisStatus]| broken(states.iter().map(|state| in_state(*state, 0.0, 0.0)));
    assert_eq!(
        states(&[DiscreteMotion, ErrorStop, ErrorStop, Standstill]),
        []
    );
    assert_eq!(
        states(&[ErrorStop, DiscreteMotion]),
        [Invariant::ErrorLatch]
    );
}

#[test]
fn an_order_that_comes_with_a_reset_moves_it_in_the_same_cycle() {
    use AxisStatus::{DiscreteMotion, ErrorStop};
    let reset_at = |at: f64| -> Vec<Event> {
        let text = format!("at-s = {at}\nnode = 'saw'\nslave = 'x'\ncommand = {{ reset = {{}} }}");
        vec![toml::from_str(&text).expect("an event")]
    };
    let broken_with_reset = |at: f64, velocity: f64| {
        let rows = [
            in_state(ErrorStop, 0.0, velocity),
            in_state(DiscreteMotion, 0.0, velocity),
        ];
        broken_with(&reset_at(at), World::Virtual, rows)
    };
    // A reset and its order leave error stop for a motion within a cycle: allowed at rest, and never in motion.
    assert_eq!(broken_with_reset(0.0005, 0.0), []);
    assert_eq!(broken_with_reset(0.0005, 1.0), [Invariant::ErrorLatch]);
    // The node woke up 20 µs after the planned time of the cycle, and had the order then.
    assert_eq!(broken_with_reset(0.00102, 0.0), []);
}

#[test]
fn error_stop_comes_to_rest() {
    // 300 u/s with 1000 u/s² take 45 u to rest, and a little for the jerk. The slave here has gone 60.
    let on = (0..200).map(|k| in_state(AxisStatus::ErrorStop, 0.3 * f64::from(k), 300.0));
    assert_eq!(broken(on), [Invariant::StoppingWay]);
}

/// A far node whose followed run is the n-th after the first.
fn used(epoch: u64, count: u64, restarts: u64) -> FarNodeSignals {
    FarNodeSignals {
        followed: true,
        epoch: Some(epoch),
        count: Some(count),
        restarts,
        ..FarNodeSignals::default()
    }
}

#[test]
fn a_count_goes_back_with_another_run_only() {
    let used = |rows: &[(u64, u64, u64)]| {
        let rows = rows.iter();
        broken_of_far(rows.map(|(epoch, count, restarts)| used(*epoch, *count, *restarts)))
    };
    let runs = [(1, 5, 0), (1, 5, 0), (1, 7, 0), (2, 0, 1), (2, 1, 1)];
    assert_eq!(used(&runs), []);
    assert_eq!(used(&[(1, 5, 0), (1, 4, 0)]), [Invariant::Count]);
    // The first frame followed may have no axes: then the count shows it, and the image later.
    assert_eq!(used(&[(1, 5, 0), (1, 5, 1), (2, 0, 1)]), []);
}

#[test]
fn another_run_is_followed_if_it_is_counted() {
    let runs = |runs: &[(u64, u64)]| {
        broken_of_far(
            runs.iter()
                .map(|(epoch, restarts)| used(*epoch, 0, *restarts)),
        )
    };
    assert_eq!(runs(&[(1, 0), (1, 0), (7, 1), (1, 2)]), []);
    assert_eq!(runs(&[(1, 0), (7, 0)]), [Invariant::Owner]);
    assert_eq!(runs(&[(1, 0), (7, 1), (1, 1)]), [Invariant::Owner]);
}

#[test]
fn a_receiver_that_was_started_anew_follows_whom_it_hears() {
    let mut rows = [used(1, 90, 0), FarNodeSignals::default(), used(7, 0, 0)]
        .map(|far| row(SlaveSignals::default(), far));
    rows[1].node.run = 1;
    rows[2].node.run = 1;
    assert_eq!(broken(rows), []);
}

#[test]
fn another_node_is_followed_if_it_is_counted() {
    let config = "name = 'saw'\ncycle-time-us = 1000\n[[far]]\nnode = 'a'\nstandby = ['b']";
    let config: ReceiverConfig = parse("saw.toml", config).expect("a config");
    let owners = |owners: &[(usize, u64)]| {
        let mut watch = ReceiverWatch::new(&config, &[], World::Virtual);
        for (cycle, (followed, take_overs)) in (1..).zip(owners) {
            let mut row = SignalRow::new(&config);
            row.node.cycle = cycle;
            row.far[*followed].followed = true;
            row.far
                .iter_mut()
                .for_each(|far| far.take_overs = *take_overs);
            watch.push(0.0, &row);
        }
        let found = watch.violations().map(|found| found.invariant);
        found.collect::<Vec<_>>()
    };
    assert_eq!(owners(&[(0, 0), (1, 1), (1, 1), (0, 2)]), []);
    assert_eq!(owners(&[(0, 0), (1, 0)]), [Invariant::Owner]);
}

#[test]
fn every_message_is_accounted_for() {
    let far = FarNodeSignals {
        // 10 in order + 1 + 5 + 4 + 5 + 3: stale messages are among the late ones. Due: 10 + 5 + 6 = 20 + 1.
        received: 28,
        in_order: 10,
        duplicates: 1,
        late: 5,
        stale: 3,
        waiting: 4,
        overflow: 5,
        foreign_frames: 3,
        expected: 20,
        lost: 6,
        outdated: 1,
        ..FarNodeSignals::default()
    };
    assert_eq!(broken_of_far([far]), []);
    let mut one_more = [far; 3];
    one_more[0].received += 1;
    one_more[1].lost += 1;
    one_more[2].waiting -= 1;
    for far in one_more {
        assert_eq!(broken_of_far([far]), [Invariant::Messages]);
    }
}

#[test]
fn a_lock_changes_the_period_within_its_bounds() {
    let period = |ppm| {
        let mut row = row(SlaveSignals::default(), FarNodeSignals::default());
        row.node.cycle_period_ppm = Some(ppm);
        broken([row])
    };
    assert_eq!(period(-500.0), []);
    for ppm in [500.1, -501.0, f64::NAN] {
        assert_eq!(period(ppm), [Invariant::CyclePeriod], "{ppm}");
    }
}

#[test]
fn cycles_that_are_not_there_were_skipped() {
    // Successive cycles, and others with this many between them.
    let after = |world, between: u64, skipped: u64| {
        let mut rows = [(); 2].map(|()| in_state(AxisStatus::Standstill, 0.0, 0.0));
        rows[1].node.cycle = between;
        rows[1].node.overruns = skipped;
        broken_in(world, rows)
    };
    assert_eq!(after(World::Virtual, 0, 0), []);
    assert_eq!(after(World::Virtual, 3, 3), []);
    assert_eq!(after(World::Virtual, 3, 2), [Invariant::Cycles]);
    assert_eq!(after(World::Virtual, 0, 1), [Invariant::Cycles]);
    // A process may have shown fewer cycles than it ran.
    assert_eq!(after(World::Processes, 3, 2), []);
    assert_eq!(after(World::Processes, 3, 4), [Invariant::Cycles]);
}

#[test]
fn cycles_begin_anew_with_another_run_only() {
    let again = |run: u64| {
        let mut rows = [(); 3].map(|()| in_state(AxisStatus::Standstill, 0.0, 0.0));
        rows[0].node.cycle = 70;
        rows[0].node.run = 1;
        (rows[1].node.run, rows[2].node.run) = (run, run);
        broken(rows)
    };
    assert_eq!(again(2), []);
    assert_eq!(again(1), [Invariant::Cycles]);
}

#[test]
fn a_slave_that_has_set_values_keeps_them() {
    let without = || row(SlaveSignals::default(), FarNodeSignals::default());
    let with = || in_state(AxisStatus::Standstill, 0.0, 0.0);
    assert_eq!(broken([without(), without(), with(), with()]), []);
    assert_eq!(broken([with(), without()]), [Invariant::SetValues]);
    let mut some = with();
    some.slaves[0].velocity = None;
    assert_eq!(broken([some]), [Invariant::SetValues]);
}

/// Schedules found 16 slaves whose position was set while in motion, from `stopping` to `disabled`, before anything watched it.
#[test]
fn a_slave_is_set_anew_at_rest_only() {
    let then_set_anew = |velocity: f64, acceleration: f64| {
        let mut moving = in_state(AxisStatus::Stopping, 7.0, velocity);
        moving.slaves[0].acceleration = Some(acceleration);
        let mut set_anew = in_state(AxisStatus::Disabled, 9.0, 0.0);
        set_anew.slaves[0].set_anew = 1;
        broken([moving, set_anew])
    };
    assert_eq!(then_set_anew(0.0, 0.0), []);
    assert_eq!(then_set_anew(30.0, -900.0), [Invariant::SetAnew]);
    assert_eq!(then_set_anew(0.0, -900.0), [Invariant::SetAnew]);
}

/// A slave at this distance from the position that its coupling requires.
fn at_distance(phase: Option<CouplingPhase>, distance: f64) -> SignalRow {
    let mut row = in_state(AxisStatus::SynchronizedMotion, 0.0, 0.0);
    row.slaves[0].phase = phase;
    row.slaves[0].distance = distance;
    row
}

#[test]
fn in_sync_is_where_the_coupling_has_it() {
    let (in_sync, led) = (
        Some(CouplingPhase::InSync),
        Some(CouplingPhase::Synchronizing),
    );
    // The default window: j·T³ + v · 1 µs = 0.0001 + 0.0005.
    assert_eq!(broken([at_distance(in_sync, 0.0005)]), []);
    assert_eq!(broken([at_distance(led, 30.6)]), []);
    assert_eq!(broken([at_distance(in_sync, -30.6)]), [Invariant::InSync]);
}

#[test]
fn one_that_runs_away_from_its_target_does_not_approach_it() {
    let on = (0..200).map(|cycle| {
        let t = f64::from(cycle) * 1e-3;
        // All of its acceleration away from a target at -1 that stands: 2·a/j is 20 cycles, and 200 are more than enough.
        let (position, velocity) = (0.5 * 1_000.0 * t * t, 1_000.0 * t);
        let mut row = in_state(AxisStatus::DiscreteMotion, position, velocity);
        row.slaves[0].acceleration = Some(1_000.0);
        row.slaves[0].guard = GuardState::CatchingUp;
        row.slaves[0].distance = position + 1.0;
        row
    });
    assert_eq!(broken(on), [Invariant::Approach]);
}

#[test]
fn a_slave_that_stands_is_not_told_that_it_moves() {
    // Three equal positions while 500 u/s are published.
    let told = [(); 3].map(|()| in_state(AxisStatus::SynchronizedMotion, 7.0, 500.0));
    assert_eq!(broken(told), [Invariant::ToldVelocity]);
    let told = [(); 6].map(|()| {
        let mut row = in_state(AxisStatus::SynchronizedMotion, 7.0, 0.0);
        row.slaves[0].acceleration = Some(900.0);
        row
    });
    assert_eq!(broken(told), [Invariant::ToldAcceleration]);
}

/// Violations at the end of a run.
fn ended(rows: impl IntoIterator<Item = SignalRow>) -> Vec<Invariant> {
    ended_in(World::Virtual, rows)
}

fn ended_in(world: World, rows: impl IntoIterator<Item = SignalRow>) -> Vec<Invariant> {
    let config: ReceiverConfig = parse("saw.toml", CONFIG).expect("a config");
    let mut watch = ReceiverWatch::new(&config, &[], world);
    for (cycle, mut row) in (1..).zip(rows) {
        row.node.cycle += cycle;
        watch.push(cycle as f64 * 1e-3, &row);
    }
    watch.end();
    watch.violations().map(|found| found.invariant).collect()
}

#[test]
fn a_run_ends_well_or_not() {
    use ContinuityState::{Braking, Following, Rejoining};
    let stopped = || in_state(AxisStatus::ErrorStop, 0.0, 0.0);
    let well = || in_state(AxisStatus::Standstill, 0.0, 0.0);
    assert_eq!(ended([stopped(), well()]), []);
    assert_eq!(ended([well(), stopped()]), [Invariant::EndsWell]);
    // The default window of the guard: 0.1 s at 500 u/s.
    assert_eq!(ended([at_distance(None, 49.0)]), []);
    assert_eq!(ended([at_distance(None, 51.0)]), [Invariant::EndsWell]);
    let far = |error, synced, continuity| {
        let mut row = well();
        row.axes[0].error = error;
        row.axes[0].synced = synced;
        row.axes[0].continuity = continuity;
        row.far[0].enabled = true;
        row.far[0].mode = FilterMode::Observer;
        row
    };
    let synced = || far(0, true, Following);
    assert_eq!(ended([synced(), synced()]), []);
    assert_eq!(ended([synced(), far(0, false, Rejoining)]), []);
    for last in [
        far(0x4b52, true, Following),
        far(0, false, Following),
        far(0, false, Braking),
    ] {
        assert_eq!(ended([synced(), last]), [Invariant::EndsWell]);
    }
    // An order has chosen another mode.
    let mut filtered = far(0, false, Following);
    filtered.far[0].mode = FilterMode::Pt1;
    assert_eq!(ended([synced(), filtered]), []);
    // An axis that was never in sync need not be by now.
    assert_eq!(ended([far(0, false, Following)]), []);
    // A busy machine may take sync away from processes; an axis without a master has none on any.
    let ended = |last| ended_in(World::Processes, [synced(), last]);
    assert_eq!(ended(far(0, false, Following)), []);
    assert_eq!(ended(far(0, false, Braking)), [Invariant::EndsWell]);
    assert_eq!(ended(far(0x4b52, true, Following)), [Invariant::EndsWell]);
}

#[test]
fn a_far_axis_that_steps_further_than_its_master_can_is_found() {
    let found = |step: f64| {
        let rows = (0..200).map(|cycle| {
            let far = FarNodeSignals {
                cycle_time_us: Some(1_000.0),
                epoch: Some(1),
                count: Some(cycle),
                ..FarNodeSignals::default()
            };
            let mut row = row(SlaveSignals::default(), far);
            // 500 u/s at cycles of 1 ms, and set values 2 ms ahead of it.
            let position = 0.5 * cycle as f64;
            row.axes[0] = FarAxisSignals {
                state: Some(FilterState::Observer),
                received_position: Some(position),
                received_velocity: Some(500.0),
                received_acceleration: Some(0.0),
                correction_us: Some(2_000.0),
                corrected_position: Some(position + if cycle == 100 { step } else { 1.0 }),
                corrected_velocity: Some(500.0),
                ..FarAxisSignals::default()
            };
            row
        });
        broken(rows)
    };
    assert_eq!(found(1.0), []);
    // A step of more than eight units, seventeen cycles' way, out of a motion that has none.
    assert_eq!(found(9.4), [Invariant::FarAxis]);
}
