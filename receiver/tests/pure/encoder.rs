//! A far axis that is only measured, conditioned: judged by the differences of the set positions,
//! for any fault of its node and its clock.

use crate::bench;
use crate::bench::{Far, MILLISECOND, Nanos, Near, SECOND, Shown, run_pair};
use coaxle_axis::AxisStatus;
use coaxle_node::{CommandOrder, CommandOutcome, Node};
use coaxle_receiver::ContinuityState::{Braking, Following};
use coaxle_receiver::{HealthName, TravelDirection};
use coaxle_slave::CouplingPhase;

const CYCLE: f64 = 1e-3;
/// Drift of the sender's clock, ppm.
const PPM: i64 = 400;
const MODES: [&str; 5] = ["bypass", "pt1", "sync", "time", "observer"];
/// Limits of the conditioning, u/s³ and u/s²: its defaults, plus the rounding of differences.
const JERK: f64 = 1.001e5;
const ACCELERATION: f64 = 5_005.0;

/// True position of the axis by the sender's time in seconds.
type Motion = fn(f64) -> f64;

fn seconds(sent: Nanos) -> f64 {
    sent as f64 * 1e-9 * (1.0 + PPM as f64 * 1e-6)
}

/// A sender, and a receiver that gets the motion in whole increments.
struct Pair {
    far: Far,
    near: Near,
    now: Nanos,
}

impl Pair {
    fn new(increment: f64, motion: Motion, rest: &str) -> Self {
        Self::with_cycle(1_000, increment, motion, rest)
    }

    fn with_cycle(sender_us: u32, increment: f64, motion: Motion, rest: &str) -> Self {
        let mut pair = Self {
            far: Far::new(sender_us, PPM, 0, 1),
            near: Near::new(
                1_000,
                0,
                &format!("master.encoder = {{ increment = {increment:?} }}\n{rest}"),
            ),
            now: 0,
        };
        pair.measure(increment, motion);
        pair
    }

    fn measure(&mut self, increment: f64, motion: Motion) {
        self.near.tweak = Some(Box::new(move |sent, axis| {
            // An encoder counts whole increments only.
            let counted = (motion(seconds(sent)) / increment).floor() * increment;
            // As an encoder's controller differentiates it.
            let before = (motion(seconds(sent) - CYCLE) / increment).floor() * increment;
            axis.set.position = counted;
            axis.set.velocity = (counted - before) / CYCLE;
            axis.set.acceleration = 0.0;
        }));
    }

    fn run_for(&mut self, millis: i64) {
        self.now += millis * MILLISECOND;
        run_pair(&mut self.far, &mut self.near, self.now);
    }

    /// Runs the receiver alone: its sender is silent.
    fn run_silent_for(&mut self, millis: i64) {
        self.now += millis * MILLISECOND;
        bench::run(None, std::slice::from_mut(&mut self.near), self.now);
    }

    fn order(&mut self, command: &str) {
        let json = format!(r#"{{ "version": 1, "far": "conveyor", "command": {command} }}"#);
        let order = CommandOrder::from_json(json.as_bytes()).expect("an order");
        let outcome = self.near.node.execute(&order);
        assert!(
            matches!(outcome, CommandOutcome::FarAccepted { .. }),
            "{command}: {outcome:?}"
        );
    }

    /// Snapshots from this moment on.
    fn since(&self, from: Nanos) -> &[Shown] {
        let first = self.near.truths.partition_point(|at| *at < from);
        &self.near.snapshots[first..]
    }
}

/// Largest velocity, acceleration and jerk by differences of positions.
#[derive(Debug)]
struct Differences {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

fn differences(positions: &[f64]) -> Differences {
    let rate = |values: &[f64]| -> Vec<f64> {
        values
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / CYCLE)
            .collect()
    };
    let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let velocities = rate(positions);
    let accelerations = rate(&velocities);
    Differences {
        velocity: most(&velocities),
        acceleration: most(&accelerations),
        jerk: most(&rate(&accelerations)),
    }
}

/// The set positions that slaves get of it, from their first one on.
fn followed(shown: &[Shown]) -> Vec<f64> {
    let from = (shown.iter()).position(|shown| shown.axis.acquired == Some(true));
    let set = shown[from.unwrap_or(shown.len())..].iter();
    set.filter_map(|shown| shown.axis.corrected_position)
        .collect()
}

fn assert_limits(what: &str, positions: &[f64]) {
    let found = differences(positions);
    assert!(
        found.jerk <= JERK && found.acceleration <= ACCELERATION,
        "{what}: {found:?}"
    );
}

fn belt(t: f64) -> f64 {
    500.0 * t
}

/// 1 % of ripple at 1 Hz.
fn rippling(t: f64) -> f64 {
    500.0 * t - 5.0 / core::f64::consts::TAU * (core::f64::consts::TAU * t).cos()
}

fn slow(t: f64) -> f64 {
    20.0 * t
}

#[test]
fn increments_become_a_smooth_master_in_every_mode() {
    for mode in MODES {
        let mut pair = Pair::new(0.05, rippling, &format!("mode = '{mode}'"));
        pair.run_for(30_000);
        let shown = pair.since(2 * SECOND);
        assert_limits(mode, &followed(shown));
        let last = pair.near.last();
        assert_eq!(last.health.name(), HealthName::Ok, "{mode}");
        assert_eq!(last.axis.travel, Some(TravelDirection::Forward), "{mode}");
        assert_eq!(last.axis.acquired, Some(true), "{mode}");
        assert_eq!(last.axis.refused_jumps, Some(0), "{mode}");
        assert!(
            last.axis
                .encoder_bandwidth
                .is_some_and(|w| (w - 125.0).abs() < 1.0)
        );
        assert!(
            last.axis
                .velocity_sigma
                .is_some_and(|v| v > 0.1 && v < 10.0)
        );
        // Position errors: two increments in ripple, and the distance of a beat in the modes that
        // show it.
        let late = last.axis.far_time_ns;
        for shown in shown
            .iter()
            .filter(|shown| shown.axis.far_time_ns.is_some())
        {
            let far_time = shown.axis.far_time_ns.unwrap_or_default() as f64 * 1e-9;
            let error = shown.axis.corrected_position.unwrap_or_default() - rippling(far_time);
            // Two increments are 0.1 u, and a beat of 1 ms at 500 u/s another 0.5 u.
            let most = if mode == "observer" { 0.1 } else { 0.7 };
            assert!(error.abs() <= most, "{mode}: {error} at {far_time}");
        }
        // A filtered position belongs to no single instant.
        assert_eq!(late.is_some(), mode != "pt1", "{mode}");
    }
}

#[test]
fn a_sender_of_another_cycle_time_is_smoothed_for_that() {
    // 125 rad/s at 1 ms, times the ratio of cycle times to the power −1/7.
    for (sender_us, bandwidth) in [(2_000, 113.2), (500, 138.0)] {
        let mut pair = Pair::with_cycle(sender_us, 0.05, rippling, "");
        pair.run_for(5_000);
        assert_limits("cycle", &followed(pair.since(2 * SECOND)));
        let shown = pair.near.last().axis.encoder_bandwidth.unwrap_or_default();
        assert!((shown - bandwidth).abs() < 1.0, "{sender_us}: {shown}");
    }
}

#[test]
fn nobody_is_coupled_before_the_increments_have_settled() {
    for mode in MODES {
        let mut pair = Pair::new(0.05, belt, &format!("mode = '{mode}'"));
        pair.run_for(1_000);
        let settled = pair.near.snapshots.iter();
        let settled = settled
            .clone()
            .position(|shown| shown.axis.acquired == Some(true));
        let settled = settled.expect("it settles");
        // 12 / (125 rad/s) are 96 ms.
        assert!((90..110).contains(&settled), "{mode}: {settled} ms");
        let coupled = pair
            .near
            .snapshots
            .iter()
            .position(|shown| shown.slave().is_some());
        assert_eq!(coupled, Some(settled), "{mode}");
        let found = differences(&followed(&pair.near.snapshots));
        assert!((found.velocity - 500.0).abs() < 25.0, "{mode}: {found:?}");
        assert_limits(mode, &followed(&pair.near.snapshots));
    }
}

/// Changes of mode in any order, interrupted by the next one.
#[test]
fn no_order_breaks_the_limits() {
    let orders = [
        r#"{ "filter-mode": "bypass" }"#,
        r#"{ "filter-mode": "observer" }"#,
        r#"{ "filter-mode": "time" }"#,
        r#"{ "filter-mode": "sync" }"#,
        r#"{ "filter-mode": "pt1" }"#,
        r#"{ "filter-mode": "observer" }"#,
        r#"{ "disable": {} }"#,
        r#"{ "enable": {} }"#,
        r#"{ "re-initialise": {} }"#,
        r#"{ "set-delay": { "fixed-us": 3000.0 } }"#,
        r#"{ "set-parameters": { "extrapolate": { "max-position-diff": 0.5 } } }"#,
        r#"{ "set-parameters": { "extrapolate": { "max-position-diff": 0.0 } } }"#,
    ];
    // 37 ms interrupt a blending of 60 cycles.
    for every in [1_000, 37] {
        let mut pair = Pair::new(0.05, rippling, "delay = { fixed-us = 400 }");
        pair.run_for(3_000);
        for command in orders {
            pair.order(command);
            pair.run_for(every);
        }
        pair.run_for(2_000);
        let shown = pair.since(SECOND);
        assert_limits("orders", &followed(shown));
        assert!(shown.iter().all(|shown| shown.axis.continuity == Following));
        let found = differences(&followed(shown));
        assert!(found.velocity < 600.0, "{found:?}");
    }
}

/// Silence and the return, a new run at another position, and a silence during the return.
#[test]
fn silence_and_a_new_run_are_no_steps() {
    for mode in MODES {
        let rest = format!("mode = '{mode}'\nsync.time-sync.automatic-re-init = true");
        for silent in [20, 300, 3_000] {
            let mut pair = Pair::new(0.05, belt, &rest);
            pair.run_for(3_000);
            pair.run_silent_for(silent);
            pair.run_for(150);
            pair.run_silent_for(silent);
            pair.run_for(30_000);
            check_return(&pair, &format!("{mode}, silent for {silent} ms"));
        }
        let mut pair = Pair::new(0.05, belt, &rest);
        pair.run_for(3_000);
        pair.far = Far::new(1_000, PPM, pair.now + 50 * MILLISECOND, 2);
        pair.measure(0.05, |t| 500.0 * t - 300.0);
        pair.run_for(150);
        pair.run_silent_for(100);
        pair.run_for(30_000);
        check_return(&pair, &format!("{mode}, new run"));
    }
}

/// The dynamics of the return are those of [`coaxle_remote::Continuity`].
fn check_return(pair: &Pair, what: &str) {
    let found = differences(&followed(pair.since(2 * SECOND)));
    assert!(found.velocity < 1.9 * 500.0, "{what}: {found:?}");
    assert!(found.acceleration < 25_000.0, "{what}: {found:?}");
    let last = pair.near.last();
    assert_eq!(last.health.name(), HealthName::Ok, "{what}");
    assert_eq!(last.axis.continuity, Following, "{what}");
    assert_eq!(last.axis.acquired, Some(true), "{what}");
}

#[test]
fn an_outage_brakes_the_axis_and_says_nothing_of_its_direction() {
    let mut pair = Pair::new(0.05, belt, "");
    pair.run_for(3_000);
    pair.run_silent_for(2_000);
    let last = pair.near.last();
    assert_eq!(last.axis.continuity, Braking);
    assert!(!last.axis.synced);
    assert_eq!(last.axis.corrected_velocity, Some(0.0));
}

#[test]
fn a_count_that_no_motion_explains_moves_nothing() {
    let mut pair = Pair::new(0.05, belt, "");
    pair.near.tweak = Some(Box::new(|sent, axis| {
        let counted = (belt(seconds(sent)) / 0.05).floor() * 0.05;
        let is_wrong = sent / MILLISECOND % 1_000 == 700;
        axis.set.position = if is_wrong { counted + 900.0 } else { counted };
    }));
    pair.run_for(5_500);
    assert_limits("jumps", &followed(pair.since(2 * SECOND)));
    let axis = &pair.near.last().axis;
    // Once a second, from 0.7 to 4.7 s: five times in 5.5 s.
    assert_eq!(
        (axis.refused_jumps, axis.counter_resets),
        (Some(5), Some(0))
    );
}

/// A saw that a rollback would stop; it is coupled once every mode has synchronised.
const SAW: &str = "[[slave]]\nname = 'saw'\n\
    limits = { velocity = 1500, acceleration = 10000, jerk = 200000 }\n\
    [[slave.step]]\nwhen = { master-ready = true }\ndo = { power = true }\n\
    [[slave.step]]\nwhen = { master-above = 260 }\n\
    [slave.step.do.gear-in-pos]\nratio = { numerator = 1 }\nmaster-sync-position = 270\n\
    slave-sync-position = 4\nsync-mode.mask = ['rollback-lock']\n";

/// 0.1 mm increments at 20 mm/s: 5 ms without an edge are no rollback, nor is a stop and a start.
#[test]
fn a_slow_coarse_master_that_stops_is_no_rollback() {
    let motions: [Motion; 2] = [slow, |t| {
        // Motion that stops for a second every three seconds.
        let whole = (t / 3.0).floor();
        40.0 * whole + 20.0 * (t - 3.0 * whole).min(2.0)
    }];
    for motion in motions {
        for mode in MODES {
            let mut pair = Pair::new(0.1, motion, &format!("mode = '{mode}'\n{SAW}"));
            pair.run_for(40_000);
            let last = pair.near.last();
            assert_eq!(last.slaves[0].error, None, "{mode}");
            assert_eq!(
                last.slaves[0].status,
                AxisStatus::SynchronizedMotion,
                "{mode}"
            );
            assert_eq!(last.slaves[0].phase, Some(CouplingPhase::InSync), "{mode}");
            let backwards = pair.since(2 * SECOND).windows(2).filter(|pair| {
                pair[1].axis.trimming == Some(false)
                    && pair[1].axis.corrected_position < pair[0].axis.corrected_position
            });
            assert_eq!(backwards.count(), 0, "{mode}");
        }
    }
}

#[test]
fn a_master_that_truly_runs_back_is_one() {
    // Back from 14 s on, at 280 u: the saw is in sync from 270 u.
    let mut pair = Pair::new(0.1, |t| 20.0 * t.min(28.0 - t), SAW);
    pair.run_for(20_000);
    let last = pair.near.last();
    assert_eq!(last.axis.travel, Some(TravelDirection::Backward));
    let saw = &last.slaves[0];
    assert_eq!((saw.error, saw.phase), (None, None), "it was aborted");
    assert_eq!(saw.status, AxisStatus::Standstill);
}
