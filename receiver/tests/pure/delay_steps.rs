//! Paths that become longer or shorter and senders that stall, judged by the differences of the
//! axes' values: far time increases strictly, at a bounded rate, and no set position steps.

use crate::paths::{CYCLE, MS, Seen, VELOCITY, World};

/// Rate limit of far time: relative to the far clock 100 ppm for the line and 1000 for the delay.
/// The rest is the drift of the clocks, and the error of the drift …
const RATE: f64 = 2e-3;
/// … and more of that for a step in the first seconds, when the line is restarted.
const RATE_AFTER_START: f64 = 3e-3;
/// Greatest relative speed difference of an axis that returns to its master.
const BRINGING_BACK: f64 = 0.6;
/// Hardest change of the velocity by which an axis is braked or returned, u/s².
const HARDEST: f64 = 25_000.0;
/// Time over which one mode is blended into another, in a straight line, ms.
const BLENDING: f64 = 60.0;

const STEPS_MS: [i64; 10] = [1, -1, 3, -3, 5, -5, 10, -10, 50, -50];
/// Sizes for a step and its reversal.
const SIZES_MS: [i64; 5] = [1, 3, 5, 10, 50];

/// Old data are used for half a second.
const PATIENT: &str =
    "sync.time-sync = { age-of-data-limit = 500, max-cycle-index-difference = 500 }\n";

fn world(delay: &str, seed: u64) -> World {
    // Fast, slow and almost equal clocks.
    let ppm = [60.0, -35.0, 5.0][seed as usize % 3];
    World::new(&format!("delay = {delay}\n{PATIENT}"), ppm, seed)
}

const MEASURED: &str = "'measured'";
const OFF: &str = "'off'";
const FIXED: &str = "{ fixed-us = 1000 }";

fn rate_of_positions(pair: &[Seen]) -> f64 {
    (pair[1].position - pair[0].position) / (VELOCITY * CYCLE as f64 * 1e-9)
}

/// Failures, case by case.
struct Findings {
    wrong: Vec<String>,
    /// Time that may be blended away when it synchronises again, ms.
    blended: f64,
    rate: f64,
}

impl Findings {
    /// Starts without failures, with this limit for the relative rate of far time.
    const fn within(rate: f64) -> Self {
        Self {
            wrong: Vec::new(),
            blended: 0.0,
            rate,
        }
    }

    fn expect(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.wrong.push(what());
        }
    }

    /// Checks the axis from `from_s` on. Returns the number of cycles in which it was not its master.
    fn check(&mut self, world: &World, from_s: f64, what: &str) -> usize {
        let first = world
            .seen
            .partition_point(|seen| (seen.at as f64) < from_s * 1e9);
        let seen = &world.seen[first..];
        self.expect(!seen.is_empty(), || format!("{what}: no cycle"));
        let blended = self.blended / BLENDING;
        let bounds = (self.rate, blended);
        let wrong = |at: &Seen, what_is: String| {
            format!("{what}: {what_is} at {:.4} s", at.at as f64 * 1e-9)
        };
        let pairs = seen
            .windows(2)
            .filter_map(|pair| Some(wrong(&pair[1], wrong_rate(pair, bounds)?)));
        let triples = seen
            .windows(3)
            .filter_map(|three| Some(wrong(&three[1], too_hard(three, blended)?)));
        self.wrong.extend(pairs.take(1));
        self.wrong.extend(triples.take(1));
        seen.iter().filter(|seen| !seen.synced).count()
    }
}

impl Drop for Findings {
    fn drop(&mut self) {
        assert!(
            self.wrong.is_empty() || std::thread::panicking(),
            "{:#?}",
            self.wrong
        );
    }
}

/// Checks the rate of far time and position from one cycle to the next.
fn wrong_rate(pair: &[Seen], (most_off, blended): (f64, f64)) -> Option<String> {
    let rate = rate_of_positions(pair);
    let is_followed = pair.iter().all(|seen| seen.is_followed);
    let (least, most) = match is_followed {
        true => (1.0 - most_off, 1.0 + most_off),
        // The axis may have been braked to a standstill.
        false => (-1e-9, 1.0 + BRINGING_BACK + blended),
    };
    if !(least..=most).contains(&rate) {
        return Some(format!("positions go {rate:.4} times as fast"));
    }
    if !is_followed {
        return None;
    }
    let (Some(before), Some(after)) = (pair[0].far_time, pair[1].far_time) else {
        return Some("no far time".into());
    };
    let rate = (after - before) as f64 / (pair[1].at - pair[0].at) as f64;
    (after <= before || (rate - 1.0).abs() > most_off)
        .then(|| format!("far time goes at {rate:.4}"))
}

/// Checks the acceleration of positions over three cycles.
fn too_hard(three: &[Seen], blended: f64) -> Option<String> {
    let change = rate_of_positions(&three[1..]) - rate_of_positions(&three[..2]);
    let cycle = CYCLE as f64 * 1e-9;
    let acceleration = change * VELOCITY / cycle;
    (acceleration.abs() > HARDEST + blended * VELOCITY / cycle)
        .then(|| format!("{acceleration:.0} u/s²"))
}

/// Greatest distance of the axis from its master since `from_s`, as a time, µs.
fn lag_us(world: &World, from_s: f64) -> f64 {
    let from = (from_s * 1e9) as i64;
    let errors = world.seen.iter().filter(|seen| seen.at >= from);
    errors
        .map(|seen| (seen.position - seen.true_position).abs() / VELOCITY * 1e6)
        .fold(0.0, f64::max)
}

/// A world after five seconds, with paths that can become shorter by `step`.
fn settled(delay: &str, seed: u64, step: i64) -> World {
    let mut world = world(delay, seed);
    world.run(2.0);
    if step < 0 {
        world.step_all_paths(-step * MS);
    }
    world.run(3.0);
    world
}

#[test]
fn a_longer_or_shorter_way_is_no_step_of_far_time() {
    let mut findings = Findings::within(RATE);
    for (n, step) in (0..).zip(SIZES_MS) {
        for delay in [MEASURED, OFF, FIXED] {
            for has_stamps in [true, false] {
                let mut world = world(delay, n);
                world.has_stamps = has_stamps;
                world.run(2.0);
                world.step_all_paths(step * MS);
                world.run(4.0);
                world.step_all_paths(-step * MS);
                world.run(4.0);
                let what = format!("{step} ms, delay {delay}, stamps {has_stamps}");
                let off = findings.check(&world, 1.0, &what);
                let told = delay == MEASURED || has_stamps && step < 50;
                if told || step < 5 {
                    findings.expect(off == 0, || format!("{what}: {off} cycles off"));
                }
                if delay == MEASURED {
                    let lag = lag_us(&world, 1.5);
                    findings.expect(lag < 60.0, || format!("{what}: off by {lag:.1} µs"));
                }
            }
        }
    }
}

#[test]
fn a_way_of_messages_alone_or_of_one_direction_is_no_step_either() {
    let mut findings = Findings::within(RATE);
    for (n, step) in (0..).zip(STEPS_MS) {
        for responses_too in [false, true] {
            let mut world = settled(MEASURED, n, step);
            for by in [step, -step] {
                world.paths.message += by * MS;
                if responses_too {
                    world.paths.response += by * MS;
                }
                world.run(12.0);
            }
            let what = format!("{step} ms, responses {responses_too}");
            let off = findings.check(&world, 1.0, &what);
            findings.expect(off == 0, || format!("{what}: {off} cycles off"));
            let lag = lag_us(&world, 1.5);
            findings.expect(lag < 60.0, || format!("{what}: off by {lag:.1} µs"));
        }
    }
}

#[test]
fn a_sender_whose_clock_stood_still_is_told_from_a_longer_way() {
    let mut findings = Findings::within(RATE);
    for (n, stop) in (0..).zip([6, -6, 10, -10, 50, -50, 300]) {
        for rest in [0, 400_000] {
            let mut world = settled(MEASURED, n, stop);
            world.stop_clock(stop * MS + rest);
            world.run(7.0);
            let what = format!("{stop} ms and {rest} ns");
            let off = findings.check(&world, 1.0, &what);
            findings.expect(off > 10, || format!("{what}: not brought back"));
            // Fractions of a cycle are slewed with 1 ms/s.
            let lag = lag_us(&world, 11.0);
            findings.expect(lag < 60.0, || format!("{what}: off by {lag:.1} µs"));
        }
    }
    for stop in [1, -1, 3, -3] {
        let mut world = settled(MEASURED, 3, stop);
        world.stop_clock(stop * MS + 200_000);
        world.run(7.0);
        let what = format!("{stop} ms");
        let off = findings.check(&world, 1.0, &what);
        findings.expect(off == 0, || {
            format!("{what}: {off} cycles off, it is slewed")
        });
        let lag = lag_us(&world, 11.0);
        findings.expect(lag < 60.0, || format!("{what}: off by {lag:.1} µs"));
    }
}

#[test]
fn a_phase_of_the_sender_that_steps_is_slewed() {
    let mut findings = Findings::within(RATE);
    // Up to half a cycle of 1 ms: beyond that, the next one is nearer.
    for (n, phase) in (0..).zip([100_000, -300_000, 499_000]) {
        for delay in [MEASURED, OFF] {
            for has_stamps in [true, false] {
                let mut world = world(delay, n);
                world.has_stamps = has_stamps;
                world.run(5.0);
                world.stop_clock(phase);
                world.run(6.0);
                let what = format!("{phase} ns, delay {delay}, stamps {has_stamps}");
                let off = findings.check(&world, 1.0, &what);
                findings.expect(off == 0, || format!("{what}: {off} cycles off"));
            }
        }
    }
}

#[test]
fn a_frozen_sender_skips_and_is_followed_on() {
    let mut findings = Findings::within(RATE);
    // Up to the limit of the age of data, 500 cycles.
    for (n, frozen) in (0..).zip([3, 7, 20, 100, 300, 500]) {
        for delay in [MEASURED, OFF] {
            for has_stamps in [true, false] {
                let mut world = world(delay, n);
                world.has_stamps = has_stamps;
                world.run(5.0);
                world.freeze(frozen * MS);
                world.run(4.0);
                let what = format!("frozen for {frozen} ms, delay {delay}, stamps {has_stamps}");
                let _ = findings.check(&world, 1.0, &what);
                if delay == MEASURED {
                    let lag = lag_us(&world, 8.0);
                    findings.expect(lag < 60.0, || format!("{what}: off by {lag:.1} µs"));
                }
            }
        }
    }
}

#[test]
fn steps_come_with_jitter_and_loss() {
    let mut findings = Findings::within(RATE);
    for (n, step) in (0..).zip(SIZES_MS) {
        for (jitter, loss) in [(5e3, 0.0), (100e3, 0.01), (20e3, 0.2)] {
            let mut world = world(MEASURED, n);
            (world.jitter, world.loss) = (jitter, loss);
            world.run(6.0);
            world.step_all_paths(step * MS);
            world.run(4.0);
            world.step_all_paths(-step * MS);
            world.run(4.0);
            let what = format!("{step} ms, jitter {jitter} ns, loss {loss}");
            let off = findings.check(&world, 4.0, &what);
            findings.expect(off == 0, || format!("{what}: {off} cycles off"));
        }
    }
}

#[test]
fn steps_come_at_any_time_of_the_start_up() {
    let mut findings = Findings::within(RATE_AFTER_START);
    for (n, step) in (0..).zip(STEPS_MS) {
        for at in [0.005, 0.05, 0.2, 0.28, 0.35, 0.6, 1.5, 2.9, 3.1] {
            for delay in [MEASURED, OFF] {
                let mut world = world(delay, n);
                world.step_all_paths((-step).max(0) * MS);
                world.run(at);
                world.step_all_paths(step * MS);
                world.run(6.0);
                let what = format!("{step} ms after {at} s, delay {delay}");
                // A step during synchronisation may take long; the axis is not followed until then.
                let Some(followed) = world.seen.iter().find(|seen| seen.is_followed) else {
                    continue;
                };
                let from = followed.at as f64 * 1e-9;
                let _ = findings.check(&world, from, &what);
            }
        }
    }
}

#[test]
fn steps_come_while_another_one_is_told_or_slewed() {
    let mut findings = Findings::within(RATE);
    for (n, step) in (0..).zip(STEPS_MS) {
        for pause in [0.01, 0.06, 0.15, 0.5, 2.0] {
            for (delay, second) in [(MEASURED, 7), (MEASURED, -5), (OFF, 7), (OFF, -2)] {
                let mut world = settled(delay, n, step.min(0) - 5);
                world.step_all_paths(step * MS);
                world.run(pause);
                world.step_all_paths(second * MS);
                world.run(3.0);
                let what = format!("{step} ms, after {pause} s {second} ms, delay {delay}");
                let _ = findings.check(&world, 1.0, &what);
                if delay == MEASURED {
                    // The exchanges of the first step are just being replaced here.
                    let lag = lag_us(&world, 1.5);
                    findings.expect(lag < 500.0, || format!("{what}: off by {lag:.1} µs"));
                }
            }
        }
    }
}

#[test]
fn steps_come_with_a_fallback() {
    // Data older than seven cycles are not used: the axis is braked, and returned.
    let mut findings = Findings::within(RATE);
    for (n, step) in (0..).zip(SIZES_MS) {
        for delay in [MEASURED, OFF] {
            let mut world = World::new(&format!("delay = {delay}\n"), 30.0, n);
            let what = format!("{step} ms, delay {delay}, no patience");
            world.run(5.0);
            for by in [step, -step] {
                world.step_all_paths(by * MS);
                world.run(8.0);
                // And while it is silent.
                world.freeze(100 * MS);
                world.run(0.05);
                world.step_all_paths(by * MS);
                world.run(8.0);
            }
            findings.blended = 2.0 * step as f64 + 1.0;
            let _ = findings.check(&world, 1.0, &what);
            world.run(30.0);
            findings.expect(world.is_synced(), || format!("{what}: not synced"));
        }
    }
}

#[test]
fn where_nobody_responds_the_axes_are_brought_to_where_the_sender_seems_to_be() {
    let mut findings = Findings::within(RATE);
    for (n, step) in (0..).zip(SIZES_MS) {
        for has_stamps in [true, false] {
            let mut world = world(MEASURED, n);
            world.has_stamps = has_stamps;
            world.responds = false;
            world.run(5.0);
            world.paths.message += step * MS;
            world.run(3.0);
            world.paths.message -= step * MS;
            world.run(3.0);
            let what = format!("{step} ms, stamps {has_stamps}");
            let _ = findings.check(&world, 1.0, &what);
        }
    }
}
