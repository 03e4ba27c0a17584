//! Standbys: another node with the same axes takes over when the first falls silent, and no set value is a step.

use crate::nodes;
use crate::nodes::{Far, MILLISECOND, receiver};
use coaxle_node::{Channel, CommandOrder, CommandOutcome, Node};
use coaxle_receiver::{ContinuityState, HealthName, Receiver, SignalRow};

const VELOCITY: f64 = 300.0;
const MODES: [&str; 5] = ["bypass", "pt1", "sync", "time", "observer"];

fn follower(mode: &str, rest: &str) -> Receiver {
    receiver(&format!(
        "master = {{ node = 'line-a', axis = 1, standby = ['line-b'], take-over-after-ms = 20 {rest} }}\n\
         mode = '{mode}'\ndelay = 'off'\n\
         sync.time-sync = {{ automatic-re-init = true, age-of-data-limit = 100, max-cycle-index-difference = 500 }}\n\
         [[slave]]\nname = 'x'\n\
         limits = {{ velocity = 1000, acceleration = 5000, deceleration = 5000, jerk = 100000 }}\n"
    ))
}

/// Two lines whose clocks drift apart; the second one is ahead by `offset`.
fn lines(offset: f64) -> [Far; 2] {
    let mut lines = [
        Far::new(0, 1_000_100, &[VELOCITY]),
        Far::new(1, 999_900, &[VELOCITY]),
    ];
    lines[1].epoch = 77;
    lines[1].offsets = vec![offset];
    lines
}

/// Set positions from cycle to cycle, judged by differences.
#[derive(Default)]
struct Watch {
    positions: Vec<f64>,
}

impl Watch {
    fn keep(&mut self, row: &SignalRow) {
        let slave = &row.slaves[0];
        assert_eq!(slave.error, 0, "{slave:?}");
        self.positions.extend(slave.position);
    }

    /// Largest velocity, acceleration and jerk.
    fn largest(&self) -> [f64; 3] {
        let mut values = self.positions.clone();
        std::array::from_fn(|_| {
            values = values
                .windows(2)
                .map(|pair| (pair[1] - pair[0]) * 1e3)
                .collect();
            values
                .iter()
                .fold(0.0, |most: f64, value| most.max(value.abs()))
        })
    }
}

fn run(
    receiver: &mut Receiver,
    lines: &mut [Far],
    until_ms: i64,
    watch: &mut Watch,
    mut each: impl FnMut(&SignalRow, i64),
) {
    nodes::run(receiver, lines, until_ms * MILLISECOND, |row, at| {
        watch.keep(row);
        each(row, at / MILLISECOND);
    });
}

fn followed(row: &SignalRow) -> usize {
    let followed: Vec<_> = (0..row.far.len())
        .filter(|n| row.far[*n].followed)
        .collect();
    assert_eq!(followed.len(), 1);
    followed[0]
}

#[test]
fn a_standby_takes_over_and_keeps_on_until_it_is_silent_itself() {
    for (mode, offset) in MODES
        .into_iter()
        .flat_map(|mode| [(mode, 0.0), (mode, 2.5)])
    {
        let mut receiver = follower(mode, "");
        let mut lines = lines(offset);
        let mut watch = Watch::default();
        run(&mut receiver, &mut lines, 25_000, &mut watch, |row, _| {
            assert_eq!(followed(row), 0);
        });
        let row = &receiver.snapshot().signals;
        assert_eq!(row.far[0].health, HealthName::Ok, "{mode}");
        assert!(row.far[1].stands_by, "{mode}");
        // Its start within the first 5 s is not judged.
        watch.positions.drain(..5_000);
        let mut taken = None;
        for (silent, until, take_overs) in [(0, 35_000, 1), (2, 90_000, 1), (1, 95_000, 2)] {
            lines[0].silent = silent == 0;
            lines[1].silent = silent == 1;
            run(&mut receiver, &mut lines, until, &mut watch, |row, at| {
                if followed(row) == 1 {
                    taken = taken.or(Some(at));
                }
                assert!(row.far[0].take_overs <= take_overs, "{mode} {at}");
            });
            let row = &receiver.snapshot().signals;
            assert_eq!(row.far[0].take_overs, take_overs, "{mode}");
            assert!(row.far[followed(row)].age_cycles < 3);
            let health = match followed(row) {
                0 => HealthName::NoStandby,
                _ => HealthName::OnStandby,
            };
            assert_eq!(
                (row.node.health, row.far[0].health),
                (health, health),
                "{mode}"
            );
            assert_eq!(row.far[1 - followed(row)].stands_by, silent == 2, "{mode}");
        }
        let taken = taken.expect("it took over");
        // Silent from 25 s on, then 20 ms of patience.
        assert!((25_018..25_024).contains(&taken), "{mode}: {taken}");
        if matches!(mode, "observer" | "sync" | "time") {
            let [velocity, acceleration, jerk] = watch.largest();
            let most = [1_000.0, 5_000.0, 100_000.0];
            assert!(velocity <= most[0] * 1.001, "{mode} {offset}: {velocity}");
            assert!(
                acceleration <= most[1] * 1.01,
                "{mode} {offset}: {acceleration}"
            );
            assert!(jerk <= most[2] * 1.05, "{mode} {offset}: {jerk}");
        }
    }
}

#[test]
fn a_short_silence_changes_nothing() {
    let mut receiver = follower("observer", "");
    let mut lines = lines(0.0);
    let mut watch = Watch::default();
    run(&mut receiver, &mut lines, 3_000, &mut watch, |_, _| {});
    for n in 0..20 {
        lines[0].silent = true;
        run(
            &mut receiver,
            &mut lines,
            // 18 ms are shorter than the 20 ms after which a standby takes over.
            3_018 + n * 100,
            &mut watch,
            |_, _| {},
        );
        lines[0].silent = false;
        run(
            &mut receiver,
            &mut lines,
            3_100 + n * 100,
            &mut watch,
            |row, _| {
                assert_eq!(row.far[0].take_overs, 0);
            },
        );
    }
}

#[test]
fn one_that_is_never_heard_is_stood_in_for_after_a_second() {
    let mut receiver = follower("observer", "");
    let mut lines = lines(0.0);
    lines[0].silent = true;
    let mut taken = None;
    nodes::run(&mut receiver, &mut lines, 5_000 * MILLISECOND, |row, at| {
        if followed(row) == 1 {
            taken = taken.or(Some(at / MILLISECOND));
        }
    });
    let taken = taken.expect("it took over");
    assert!((1_000..3_000).contains(&taken), "{taken}");
    assert!(receiver.snapshot().signals.axes[0].synced);
}

#[test]
fn one_without_the_axes_does_not_take_over() {
    let mut receiver = follower("observer", "");
    let mut lines = lines(0.0);
    lines[1].axes = vec![None];
    nodes::run(&mut receiver, &mut lines, 5_000 * MILLISECOND, |_, _| {});
    lines[0].silent = true;
    nodes::run(&mut receiver, &mut lines, 6_000 * MILLISECOND, |_, _| {});
    assert_eq!(receiver.snapshot().signals.far[0].take_overs, 0);
}

#[test]
fn each_is_asked_for_its_own_time() {
    let text =
        "[[far]]\nnode = 'line-a'\nstandby = ['line-b', 'line-c']\n[[far]]\nnode = 'infeed'\n";
    let mut receiver = receiver(text);
    let mut lines = [0, 1, 2, 3].map(|n| Far::new(n, 1_000_000 + 50 * n as i64, &[VELOCITY]));
    let mut asked = [0; 4];
    while receiver.next_cycle().as_nanos() < 3_000 * MILLISECOND {
        let now = receiver.next_cycle();
        for line in &mut lines {
            line.send_until(now, &mut receiver);
        }
        let _ = receiver.cycle(now);
        while let Some(outgoing) = receiver.transmit() {
            if outgoing.channel == Channel::TimeRequests {
                asked[outgoing.far] += 1;
            }
        }
    }
    assert!(asked.iter().all(|count| *count > 5), "{asked:?}");
    let drifts: Vec<_> = receiver
        .snapshot()
        .signals
        .far
        .iter()
        .map(|far| far.drift_ppm)
        .collect();
    for (n, drift) in drifts.iter().enumerate() {
        // Each is 50 ppm slower than the one before.
        let expected = -50.0 * n as f64;
        assert!((drift.expect("known") - expected).abs() < 5.0, "{drifts:?}");
    }
}

/// The smoothing of a standby's increments is kept warm: its axis is never without a master, nor braked.
#[test]
fn an_axis_that_is_only_measured_is_taken_over_as_it_moves() {
    let mut receiver = follower("observer", ", encoder = { increment = 0.05 }");
    let mut lines = lines(7.0);
    let mut watch = Watch::default();
    run(&mut receiver, &mut lines, 5_000, &mut watch, |_, _| {});
    for (silent, until) in [(0, 10_000), (2, 15_000), (1, 20_000)] {
        lines[0].silent = silent == 0;
        lines[1].silent = silent == 1;
        run(&mut receiver, &mut lines, until, &mut watch, |row, at| {
            let axis = &row.axes[0];
            assert_eq!(axis.acquired, Some(true), "{at}");
            assert_ne!(axis.continuity, ContinuityState::Braking, "{at}");
        });
        let axis = &receiver.snapshot().signals.axes[0];
        assert_eq!(axis.continuity, ContinuityState::Following);
    }
    assert_eq!(receiver.snapshot().signals.far[0].take_overs, 2);
}

/// A small generator: the same numbers for the same seed.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % end
    }
}

#[test]
fn whoever_is_silent_restarts_or_comes_back_the_slave_keeps_its_limits() {
    for seed in 1..40 {
        let mode = ["observer", "time"][seed as usize % 2];
        play(seed, &mut follower(mode, ""), &[]);
    }
}

/// Far axes with limits of their own, and orders that restart their clock or change its mode, at
/// any moment of a take-over.
#[test]
fn orders_at_any_moment_and_limits_of_the_far_axis_change_nothing_of_that() {
    let orders = [
        r#"{ "re-initialise": {} }"#,
        r#"{ "filter-mode": "time" }"#,
        r#"{ "filter-mode": "observer" }"#,
        r#"{ "set-delay": { "fixed-us": 700 } }"#,
    ];
    for seed in 1..40 {
        let limits = [
            "",
            ", limits = { velocity = 600, acceleration = 3000, jerk = 60000 }",
        ][seed as usize % 2];
        play(seed, &mut follower("observer", limits), &orders);
    }
}

/// A random schedule of silences, restarts and orders on the far node; one of the lines is always
/// present.
fn play(seed: u64, receiver: &mut Receiver, orders: &[&str]) {
    // 2³² divided by the golden ratio, so that near seeds give far states.
    let mut random = Random(seed * 0x9e37_79b9);
    let mut lines = lines([0.0, 2.5, -40.0][seed as usize % 3]);
    let mut watch = Watch::default();
    run(receiver, &mut lines, 4_000, &mut watch, |_, _| {});
    watch.positions.drain(..2_000);
    let mut at = 4_000;
    let mut last = None;
    while at < 30_000 {
        let n = random.below(2) as usize;
        let is_alone = lines[1 - n].silent;
        match random.below(4) {
            // A node restarts, at once or after a silence.
            0 => {
                lines[n].epoch += 100;
                lines[n].silent = random.below(2) == 0 && !is_alone;
            }
            1 => lines[n].silent = !is_alone,
            _ => lines[n].silent = false,
        }
        let mut is_ordered = false;
        if !orders.is_empty() && random.below(3) == 0 {
            let order = orders[random.below(orders.len() as u64) as usize];
            tell(receiver, order);
            is_ordered = true;
        }
        at += [7, 30, 400, 2_000][random.below(4) as usize];
        if is_ordered {
            // Orders may restart the far clock: times before and after are not compared.
            last = None;
        }
        run(receiver, &mut lines, at, &mut watch, |row, at| {
            let axis = &row.axes[0];
            let of = (followed(row), row.far[followed(row)].epoch, axis.state);
            let shown = axis.far_time_ns.map(|time| (of, time));
            // Times of different runs, or of different modes, have no order.
            if let (Some((of_last, before)), Some((of, now))) = (last, shown)
                && of == of_last
            {
                assert!(now > before, "seed {seed} at {at}: {before} {now}");
            }
            last = shown;
        });
    }
    let [velocity, acceleration, jerk] = watch.largest();
    assert!(velocity <= 1_001.0, "seed {seed}: {velocity}");
    assert!(acceleration <= 5_050.0, "seed {seed}: {acceleration}");
    assert!(jerk <= 105_000.0, "seed {seed}: {jerk}");
    // With both present the axis is at its master's position.
    lines.iter_mut().for_each(|line| line.silent = false);
    run(receiver, &mut lines, at + 40_000, &mut watch, |_, _| {});
    let axis = &receiver.snapshot().signals.axes[0];
    assert_eq!(axis.continuity, ContinuityState::Following, "seed {seed}");
    assert!(axis.synced, "seed {seed}");
}

fn tell(receiver: &mut Receiver, command: &str) {
    let json =
        format!(r#"{{ "version": 1, "far": "line-a", "command": {command}, "dry-run": false }}"#);
    let order = CommandOrder::from_json(json.as_bytes()).expect("an order");
    let outcome = receiver.execute(&order);
    assert!(
        matches!(outcome, CommandOutcome::FarAccepted { .. }),
        "{command}: {outcome:?}"
    );
}
