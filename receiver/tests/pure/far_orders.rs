//! Orders on a far node, as received from the network: their effect, and the continuity of the set
//! values.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use crate::bench;
use crate::bench::{Far, MILLISECOND, Nanos, Near, SECOND, Shown, VELOCITY, run_pair};
use assert_no_alloc::assert_no_alloc;
use coaxle_axis::AxisStatus;
use coaxle_clock::time_sync::SyncError;
use coaxle_node::command::{FarRefusal, FarView};
use coaxle_node::{CommandOrder, CommandOutcome, Node};
use coaxle_receiver::FilterMode;
use coaxle_receiver::{FilterState, Health};

/// Distance moved per cycle, u.
const STEP: f64 = VELOCITY * 1e-3;

fn order(command: &str, dry_run: bool) -> CommandOrder {
    let json = format!(
        r#"{{ "version": 1, "far": "conveyor", "command": {command}, "dry-run": {dry_run} }}"#
    );
    CommandOrder::from_json(json.as_bytes()).unwrap()
}

fn outcome(near: &mut Near, command: &str, dry_run: bool) -> CommandOutcome {
    let order = order(command, dry_run);
    assert_no_alloc(|| near.node.execute(&order))
}

fn accepted(near: &mut Near, command: &str) -> FarView {
    match outcome(near, command, false) {
        CommandOutcome::FarAccepted { far } => far,
        other => panic!("{command}: {other:?}"),
    }
}

fn refused(near: &mut Near, command: &str) -> FarRefusal {
    match outcome(near, command, false) {
        CommandOutcome::FarRefused { refusal, .. } => refusal,
        other => panic!("{command}: {other:?}"),
    }
}

/// A sender and a receiver whose slave follows it.
struct Pair {
    far: Far,
    near: Near,
    now: Nanos,
}

impl Pair {
    /// Without a beat in the first seconds: set values in bypass move evenly.
    fn observing() -> Self {
        Self::of(
            20,
            "mode = 'observer'\ndelay = { fixed-us = 400 }\n[[slave]]\nname = 'saw'\n\
             limits = { velocity = 2000, acceleration = 2e5, jerk = 1e9 }",
        )
    }

    fn of(ppm: i64, rest: &str) -> Self {
        Self {
            far: Far::new(1000, ppm, 0, 1),
            near: Near::new(1000, 0, rest),
            now: 0,
        }
    }

    fn run_for(&mut self, millis: i64) {
        self.now += millis * MILLISECOND;
        run_pair(&mut self.far, &mut self.near, self.now);
    }

    fn last(&self) -> &Shown {
        self.near.last()
    }

    /// Executes the orders, each this number of milliseconds after the one before, and runs on.
    /// Returns the greatest deviation of the master's step per cycle from even motion, u.
    fn unevenness(&mut self, orders: &[(i64, &str)], then: i64) -> f64 {
        let from = self.near.snapshots.len() - 1;
        for (after, command) in orders {
            self.run_for(*after);
            let _ = accepted(&mut self.near, command);
        }
        self.run_for(then);
        let shown = &self.near.snapshots[from..];
        let position = |shown: &Shown| shown.master.unwrap().corrected.position;
        let step = |pair: &[Shown]| position(&pair[1]) - position(&pair[0]);
        let steps = shown.windows(2).map(step);
        steps.map(|step| (step - STEP).abs()).fold(0.0, f64::max)
    }
}

const ENABLE: &str = r#"{ "enable": {} }"#;
const DISABLE: &str = r#"{ "disable": {} }"#;
const RE_INITIALISE: &str = r#"{ "re-initialise": {} }"#;

#[test]
fn no_order_makes_a_step_whether_it_is_entered_left_or_interrupted() {
    const BYPASS: &str = r#"{ "filter-mode": "bypass" }"#;
    const OBSERVER: &str = r#"{ "filter-mode": "observer" }"#;
    const PT1: &str = r#"{ "filter-mode": "pt1" }"#;
    const SYNC: &str = r#"{ "filter-mode": "sync" }"#;
    const AHEAD: &str =
        r#"{ "set-parameters": { "time-sync": { "delay-time-offset-s": 0.001 } } }"#;
    const STRICT: &str =
        r#"{ "set-parameters": { "extrapolate": { "max-position-diff": 0.01 } } }"#;
    const LATER: &str = r#"{ "set-delay": { "fixed-us": 1400 } }"#;
    const OFF: &str = r#"{ "set-delay": "off" }"#;
    for (orders, allowed) in [
        // The observer is at most 0.4 u ahead of the received position, PT1 about 1.3 u behind it.
        (&[(0, BYPASS), (200, OBSERVER)][..], 0.4 / 60.0),
        (&[(0, BYPASS), (20, OBSERVER), (20, BYPASS)], 0.4 / 60.0),
        (&[(0, PT1), (200, OBSERVER)], 1.8 / 60.0),
        (&[(0, PT1), (30, BYPASS), (1, OBSERVER)], 2.0 / 60.0),
        (&[(0, SYNC), (300, OBSERVER)], 0.4 / 60.0),
        (&[(0, DISABLE), (200, ENABLE)], 0.4 / 60.0),
        (&[(0, DISABLE), (20, ENABLE), (3, DISABLE)], 0.4 / 60.0),
        (&[(0, RE_INITIALISE), (0, RE_INITIALISE)], 0.4 / 60.0),
        (&[(0, RE_INITIALISE), (30, RE_INITIALISE)], 0.4 / 60.0),
        (&[(0, AHEAD), (20, AHEAD)], 0.5 / 60.0),
        (&[(0, RE_INITIALISE), (300, AHEAD)], 0.9 / 60.0),
        (&[(0, STRICT), (300, BYPASS)], 2.0 / 60.0),
        // A delay is slewed by at most a thousandth: 0.5 u/s.
        (&[(0, LATER), (500, OFF)], 0.51e-3),
        (&[(0, LATER), (20, BYPASS), (20, OBSERVER)], 0.4 / 60.0),
    ] {
        let mut pair = Pair::observing();
        pair.run_for(3_000);
        assert_eq!(pair.last().master.unwrap().state, FilterState::Observer);
        let uneven = pair.unevenness(orders, 2_500);
        assert!(uneven < 1.1 * allowed, "{orders:?}: {uneven} of {allowed}");
        assert!(uneven > 1e-5, "{orders:?}: nothing happened");
        let slave = &pair.last().slaves[0];
        // A position error of the master stops its slaves, as always.
        if orders[0].1 != STRICT {
            assert_eq!(slave.status, AxisStatus::SynchronizedMotion, "{orders:?}");
        }
    }
}

#[test]
fn a_configured_offset_is_shown_while_it_is_a_part_of_the_correction() {
    const AHEAD: &str = r#"{ "set-parameters": { "time-sync": { "delay-time-offset-s": 0.03 } } }"#;
    const BYPASS: &str = r#"{ "filter-mode": "bypass" }"#;
    let mut pair = Pair::observing();
    pair.run_for(3_000);
    let shown = |pair: &Pair| pair.last().counters.time_offset_us;
    assert_eq!(shown(&pair), Some(0.0));
    let before = pair.last().counters.correction_us.unwrap();
    let _ = accepted(&mut pair.near, AHEAD);
    pair.run_for(500);
    assert_eq!(shown(&pair), Some(30_000.0));
    // The phase of both clocks changes by 20 ppm of half a second meanwhile, 10 µs.
    let ahead = pair.last().counters.correction_us.unwrap() - before;
    assert!((ahead - 30_000.0).abs() < 1_000.0, "{ahead}");
    let _ = accepted(&mut pair.near, BYPASS);
    pair.run_for(10);
    assert_eq!(shown(&pair), None);
}

#[test]
fn in_sync_mode_neither() {
    const MORE: &str = r#"{ "set-parameters": { "time-sync": {
        "no-of-periods-for-mean-drift": 2, "end-of-transition-limit": 50 } } }"#;
    const FORCED: &str = r#"{ "set-parameters": { "time-sync": { "force-time-mode": true } } }"#;
    for orders in [
        &[(0, RE_INITIALISE), (50, RE_INITIALISE)][..],
        // While it synchronises.
        &[(0, RE_INITIALISE), (600, MORE), (1_000, MORE)],
        &[(0, FORCED)],
        &[(0, DISABLE), (0, ENABLE)],
    ] {
        let mut pair = Pair::of(1000, "mode = 'sync'");
        pair.run_for(5_000);
        assert_eq!(pair.last().master.unwrap().state, FilterState::Sync);
        // The correction of a cycle is blended, or a beat of time mode concealed, over 60 cycles at
        // least.
        let uneven = pair.unevenness(orders, 5_000);
        assert!(uneven < 2.5 * STEP / 60.0, "{orders:?}: {uneven}");
        let forced = orders[0].1 == FORCED;
        assert_ne!(pair.last().master.unwrap().synced, forced, "{orders:?}");
    }
}

#[test]
fn disabled_the_axis_passes_through_unmodified_and_enabled_it_starts_anew() {
    let mut pair = Pair::observing();
    pair.run_for(2_000);
    let view = accepted(&mut pair.near, DISABLE);
    assert!(!view.enabled && view.synced, "the cycle is still to come");
    pair.run_for(200);
    for shown in pair.near.newest(100) {
        let signals = &shown.counters;
        assert_eq!((signals.enabled, signals.synced), (false, false));
        assert_eq!(signals.mode, FilterMode::Observer);
        assert_eq!(signals.observer_state, None);
        assert_eq!(shown.health, Health::Disabled);
        let master = shown.master.unwrap();
        assert_eq!(master.corrected, master.received);
        assert_eq!(master.state, FilterState::Bypass);
    }
    let position = pair.last().slave().unwrap().position;
    let master = pair.last().master.unwrap().corrected.position;
    assert!((position - master).abs() < 1e-9, "the slave still follows");

    // An enabled node is not restarted by another enable, and a disabled one refuses.
    let _ = accepted(&mut pair.near, DISABLE);
    assert_eq!(refused(&mut pair.near, RE_INITIALISE), FarRefusal::Disabled);
    let _ = accepted(&mut pair.near, ENABLE);
    let _ = accepted(&mut pair.near, ENABLE);
    pair.run_for(50);
    assert_eq!(pair.last().counters.re_initialisations, 1);
    assert_eq!(pair.last().health, Health::StartingUp);
    pair.run_for(2_000);
    assert_eq!(pair.last().health, Health::Ok);
    assert_eq!(pair.last().master.unwrap().state, FilterState::Observer);
}

#[test]
fn the_mode_does_not_touch_the_synchronisation() {
    let mut pair = Pair::of(1000, "mode = 'sync'");
    pair.run_for(5_000);
    for (mode, state) in [
        (FilterMode::Pt1, FilterState::Pt1),
        (FilterMode::Bypass, FilterState::Bypass),
        (FilterMode::Time, FilterState::Time),
        (FilterMode::Auto, FilterState::Sync),
    ] {
        let command = format!(r#"{{ "filter-mode": "{}" }}"#, state.name());
        assert_eq!(accepted(&mut pair.near, &command).mode, mode);
        // Beyond the blending of 60 cycles.
        pair.run_for(100);
        let shown = pair.last();
        assert_eq!(shown.counters.mode, mode);
        let master = shown.master.unwrap();
        assert_eq!((master.state, master.synced), (state, true));
    }
    // The observer starts on request, and keeps running afterwards.
    let _ = accepted(&mut pair.near, r#"{ "filter-mode": "observer" }"#);
    pair.run_for(50);
    assert_eq!(pair.last().health, Health::StartingUp);
    pair.run_for(2_000);
    let _ = accepted(&mut pair.near, r#"{ "filter-mode": "sync" }"#);
    pair.run_for(500);
    assert_eq!(pair.last().master.unwrap().state, FilterState::Sync);
    let _ = accepted(&mut pair.near, r#"{ "filter-mode": "observer" }"#);
    // At once, as the observer kept running.
    pair.run_for(2);
    assert_eq!(pair.last().master.unwrap().state, FilterState::Observer);
}

#[test]
fn parameters_hold_from_the_next_cycle_on_and_what_is_left_out_stays() {
    let mut pair = Pair::of(1000, "mode = 'sync'\nsync.extrapolate.t1-factor-pos = 5");
    pair.run_for(5_000);
    let command = r#"{ "set-parameters": { "fall-back-mode": "bypass",
        "time-sync": { "age-of-data-limit": 3, "automatic-re-init": true } } }"#;
    let _ = accepted(&mut pair.near, command);
    pair.run_for(10);
    assert_eq!(pair.last().counters.parameter_changes, 1);
    assert_eq!(pair.last().health, Health::Ok, "nothing was lost by it");
    // The master falls silent.
    // 5 cycles exceed the limit of 3 set above.
    pair.now += 5 * MILLISECOND;
    bench::run(None, std::slice::from_mut(&mut pair.near), pair.now);
    assert_eq!(
        pair.last().health,
        Health::Error(SyncError::MaxDataAgeExceeded)
    );
    assert_eq!(pair.last().master.unwrap().state, FilterState::Bypass);
}

#[test]
fn a_latched_error_is_gone_after_re_initialising() {
    let mut pair = Pair::of(1000, "mode = 'sync'");
    pair.run_for(5_000);
    // 20 cycles exceed the limit of 7.
    pair.now += 20 * MILLISECOND;
    bench::run(None, std::slice::from_mut(&mut pair.near), pair.now);
    pair.run_for(100);
    assert_eq!(
        pair.last().health,
        Health::Error(SyncError::MaxDataAgeExceeded)
    );
    let _ = accepted(&mut pair.near, RE_INITIALISE);
    pair.run_for(5);
    assert_eq!(pair.last().health, Health::StartingUp);
    pair.now = 15 * SECOND;
    pair.run_for(0);
    assert_eq!(pair.last().health, Health::Ok);
}

#[test]
fn wrong_values_are_named_and_change_nothing() {
    let mut pair = Pair::observing();
    pair.run_for(2_000);
    for (command, expected) in [
        (
            r#"{ "set-parameters": { "extrapolate": { "blending-time-s": -1 } } }"#,
            "0x4b56: extrapolate.blending-time-s: received -1, expected a finite number of at least 0",
        ),
        (
            r#"{ "set-parameters": { "time-sync": { "slope1-denominator": 2 } } }"#,
            "0x4b56: time-sync.slope1-denominator: received 2, expected above 0 and below 1",
        ),
        (
            r#"{ "set-parameters": { "time-sync": { "data-cycle-time-s": 0.002 } } }"#,
            "0x4b56: time-sync.data-cycle-time-s: received 0.002, expected 0, or the cycle time that the node's frames say",
        ),
        (
            r#"{ "set-parameters": {} }"#,
            "0x4b56: set-parameters: received no parameter, expected at least one to change",
        ),
        (
            r#"{ "set-delay": { "fixed-us": 2e6 } }"#,
            "0x4b56: fixed-us: received 2000000, expected a number from -1000000 to 1000000",
        ),
    ] {
        assert_eq!(refused(&mut pair.near, command).to_string(), expected);
    }
    let before = pair.last().counters;
    pair.run_for(1);
    let after = pair.last().counters;
    assert_eq!(after.parameter_changes, before.parameter_changes);
    assert_eq!(pair.last().health, Health::Ok);
}

#[test]
fn a_dry_run_changes_nothing() {
    let mut tried = Pair::observing();
    let mut left = Pair::observing();
    tried.run_for(2_000);
    left.run_for(2_000);
    for command in [
        DISABLE,
        RE_INITIALISE,
        r#"{ "filter-mode": "bypass" }"#,
        r#"{ "set-delay": "measured" }"#,
        r#"{ "set-parameters": { "start-up-mode": "pt1", "extrapolate": { "t1-factor-pos": 9 } } }"#,
    ] {
        let CommandOutcome::FarAccepted { far } = outcome(&mut tried.near, command, true) else {
            panic!("{command}");
        };
        assert!(far.enabled && far.mode == FilterMode::Observer);
    }
    tried.run_for(200);
    left.run_for(200);
    // Computed clocks make both runs equal to the last bit.
    assert_eq!(tried.last().master, left.last().master);
    assert_eq!(tried.last().counters, left.last().counters);
}

#[test]
fn who_asks_for_a_node_that_is_not_followed_hears_which_are() {
    let mut pair = Pair::observing();
    let json = r#"{ "version": 1, "far": "conveyer", "command": { "disable": {} } }"#;
    let order = CommandOrder::from_json(json.as_bytes()).unwrap();
    let CommandOutcome::NotTaken(reason) = pair.near.node.execute(&order) else {
        panic!("taken");
    };
    let expected = "far: received \"conveyer\", expected conveyor";
    assert_eq!(reason.to_string(), expected);
}
