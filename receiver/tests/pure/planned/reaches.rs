//! A step that waits until the master is about to come to a position, as it is promised.

use coaxle_node::config::ConfigError;
use coaxle_receiver::{Receiver, ReceiverConfig};

use super::*;

/// A slave that goes through these conditions, each with a command that is done at once.
fn slave(conditions: &[&str]) -> String {
    let step =
        |when: &&str| format!("[[slave.step]]\nwhen = {{ {when} }}\ndo = {{ reset = {{}} }}\n");
    let steps: String = conditions.iter().map(step).collect();
    format!("[[slave]]\nname = 'gate'\ncouple = 'off'\n{steps}")
}

/// Instants of the master that are shown in the cycles in which each condition holds, s.
fn taken(bench: &mut Bench, until_s: f64) -> Vec<f64> {
    let mut taken = Vec::new();
    let mut before = Some(1);
    while bench.receiver.next_cycle().as_nanos() < (until_s * 1e9) as i64 {
        let now = bench.receiver.next_cycle().as_nanos() as f64 * 1e-9;
        bench.run(now + 1e-9, |_, _| {});
        let signals = &bench.receiver.snapshot().signals;
        let step = signals.slaves[0].program_step;
        if step != before {
            let shown = signals.axes[0].far_time_ns.expect("it follows");
            taken.push(shown as f64 * 1e-9);
        }
        before = step;
    }
    taken
}

/// Instant at which the master is at a position, s: it moves forward only.
fn arrival(position: f64) -> f64 {
    let mut master = program(Span::ZERO);
    let mut millis = 1;
    let at = |master: &mut MotionProgram, nanos: i64| {
        let now = master.sample(Span::from_nanos(nanos)).motion;
        now.position
    };
    while at(&mut master, millis * MILLISECOND) < position {
        millis += 1;
    }
    // Programs do not run backwards.
    let mut master = program(Span::ZERO);
    let mut nanos = (millis - 1) * MILLISECOND;
    while at(&mut master, nanos) < position {
        nanos += 100;
    }
    nanos as f64 * 1e-9
}

#[test]
fn it_is_taken_the_time_ahead_of_the_arrival_and_a_cycle_later_at_most() {
    for (delay, lead) in [(60, 500), (0, 500)] {
        for within in [0.0, 0.3, 20.0, 150.0] {
            let conditions = [
                format!("master-reaches = {{ position = 2500, within-ms = {within} }}"),
                format!(
                    "master-reaches = {{ position = 2650, within-ms = {within}, direction = 'forward' }}"
                ),
                format!(
                    "master-reaches = {{ position = 2700, within-ms = {within}, direction = 'backward' }}"
                ),
            ];
            let conditions: Vec<_> = conditions.iter().map(String::as_str).collect();
            let mut bench = Bench::new(&slave(&conditions), delay, lead);
            bench.is_lost = |count| count % 50 % 7 == 3 || (10..13).contains(&(count % 100));
            let taken = taken(&mut bench, 8.0);
            assert_eq!(taken.len(), 2, "{taken:?}");
            for (shown, position) in taken.into_iter().zip([2_500.0, 2_650.0]) {
                let ahead = (arrival(position) - shown) * 1e3;
                // The far clock is known to a microsecond.
                let is_due = ahead > within - 1.0 - 2e-3 && ahead <= within + 2e-3;
                assert!(is_due, "{delay}: {ahead} ms ahead for {within}");
            }
        }
    }
}

/// Time of the middle of [`OUTAGE`], ms.
const MIDDLE_OF_OUTAGE: i64 = 5_170;

#[test]
fn an_arrival_in_an_outage_within_the_promise_is_not_missed() {
    for (delay, lead) in [(60, 400), (0, 500)] {
        let in_the_middle = program(Span::ZERO).sample(Span::from_millis(MIDDLE_OF_OUTAGE));
        let position = in_the_middle.motion.position;
        let condition = format!("master-reaches = {{ position = {position}, within-ms = 20 }}");
        let mut bench = Bench::new(&slave(&[&condition, "time-s = 1000"]), delay, lead);
        bench.is_lost = OUTAGE;
        let taken = taken(&mut bench, 8.0);
        assert_eq!(taken.len(), 1, "{delay}: {taken:?}");
        let ahead = (arrival(position) - taken[0]) * 1e3;
        assert!(ahead > 18.998 && ahead <= 20.002, "{delay}: {ahead}");
    }
}

#[test]
fn a_modulo_master_comes_to_a_position_in_each_turn() {
    let turn =
        "master-reaches = { position = { in-turn = 90 }, within-ms = 20, direction = 'forward' }";
    // Past it before the next turn is waited for.
    let past = "after-s = 0.1";
    // The last step is never taken: a program that ends shows no other step.
    let text = slave(&["time-s = 1", turn, past, turn, past, turn, "time-s = 1000"]);
    let mut bench = Bench::with_master("node = 'a', modulo = 360", &text, 60, 500);
    let shown = taken(&mut bench, 6.0);
    assert_eq!(shown.len(), 6, "{shown:?}");
    let turns = [shown[1], shown[3], shown[5]];
    let first = (0..).find(|turn| arrival(90.0 + 360.0 * f64::from(*turn)) > turns[0]);
    for (turn, shown) in (first.expect("a turn")..).zip(turns) {
        let ahead = (arrival(90.0 + 360.0 * f64::from(turn)) - shown) * 1e3;
        assert!(ahead > 18.998 && ahead <= 20.002, "{turn}: {ahead}");
    }
}

fn refused(master: &str, condition: &str) -> String {
    let text = format!(
        "name = 'line'\ncycle-time-us = 1000\n{master}{}",
        slave(&[condition])
    );
    let config: Result<ReceiverConfig, ConfigError> = parse("r.toml", &text);
    let config = match config {
        Err(error) => return error.to_string(),
        Ok(config) => config,
    };
    let receiver = Receiver::new(&config, Instant::from_nanos(0), 7);
    receiver.map(drop).expect_err("refused").to_string()
}

#[test]
fn what_cannot_be_promised_or_reached_is_refused() {
    let far = "mode = 'observer'\nmaster = { node = 'a' }\n";
    let own = "[[virtual-axis]]\nid = 1\nname = 'shaft'\n[virtual-axis.program]\n\
               limits = { velocity = 1, acceleration = 1, jerk = 1 }\n";
    for (master, condition, expected) in [
        (
            own,
            "position = 1",
            "when.master-reaches: received a virtual axis as master, expected an axis of a sender",
        ),
        (
            far,
            "position = { in-turn = 90 }",
            "when.master-reaches.position: received in-turn 90 of a master without a modulo turn",
        ),
        (far, "position = 'there'", "a position, or { in-turn = 90 }"),
        (
            far,
            "position = 1, within-ms = -1",
            "a number from 0 to 4000",
        ),
        (far, "position = 1, direction = 'up'", "forward"),
    ] {
        let error = refused(master, &format!("master-reaches = {{ {condition} }}"));
        assert!(error.contains(expected), "{error}, not {expected}");
    }
}
