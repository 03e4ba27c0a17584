//! Behaviour of a far axis while its master accelerates, and its own estimates: judged by its
//! positions, in every mode.

use crate::bench;
use std::slice::from_mut;

use crate::bench::{Far, MILLISECOND, Nanos, Near, SECOND, VELOCITY, run, run_pair};
use coaxle_axis::AxisStatus;
use coaxle_receiver::ContinuityState::Following;
use coaxle_receiver::HealthName;

const CYCLE: f64 = 1e-3;
const MODES: [&str; 5] = ["bypass", "pt1", "sync", "time", "observer"];

/// Up and down between 100 and 800 u/s, again and again, from 2 s on.
const RAMPS: &str = "limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }, steps = [{ enable = true }, \
    { velocity = { value = 100, for-s = 2 } }, { loop = { count = 20, steps = [{ velocity = { value = 800, for-s = \
    0.6 } }, { velocity = { value = 100, for-s = 0.6 } }] } }]";

fn receiver(mode: &str) -> Near {
    let rest = format!(
        "mode = '{mode}'\nsync.time-sync = {{ automatic-re-init = true, age-of-data-limit = 500, \
         max-cycle-index-difference = 500 }}"
    );
    Near::new(1000, 0, &rest)
}

/// The far axis's own positions and velocities.
fn corrected(near: &Near, from: Nanos) -> Vec<(f64, f64)> {
    let from = near.truths.partition_point(|at| *at < from);
    let shown = near.snapshots[from..].iter();
    let pair = |shown: &bench::Shown| {
        let master = shown.master?;
        Some((master.corrected.position, master.corrected.velocity))
    };
    shown.filter_map(pair).collect()
}

fn largest_acceleration(corrected: &[(f64, f64)]) -> f64 {
    let accelerations = corrected
        .windows(3)
        .map(|w| (w[2].0 - 2.0 * w[1].0 + w[0].0).abs() / (CYCLE * CYCLE));
    accelerations.fold(0.0, f64::max)
}

/// Silences the sender for a while, during which it moves on.
fn outage(far: &mut Far, near: &mut Near, from: Nanos, silent: Nanos) {
    run_pair(far, near, from);
    run(None, from_mut(near), from + silent);
    let frame = far.tick(from + silent);
    near.post(from + silent, &frame);
}

#[test]
fn an_outage_in_a_ramp_is_no_step_of_the_far_axis() {
    for mode in MODES {
        for silent in [10, 30, 80, 100, 200] {
            let mut far = Far::with_program(1000, 50, 0, 1, RAMPS);
            let mut near = receiver(mode);
            // At different places of the ramps.
            for n in 0..8 {
                let from = 4 * SECOND + n * 1_230 * MILLISECOND;
                outage(&mut far, &mut near, from, silent * MILLISECOND);
            }
            run_pair(&mut far, &mut near, 20 * SECOND);
            let hardest = largest_acceleration(&corrected(&near, 3 * SECOND));
            // Beats, and short silences within the limit, are visible in the modes without a clock.
            let most = match mode {
                "bypass" => 20.0 * 800.0 / CYCLE,
                "pt1" => 8.0 * 800.0 / CYCLE,
                _ => 25_000.0,
            };
            assert!(hardest < most, "{mode}, {silent} ms: {hardest} u/s²");
            let last = near.last().master.expect("there is one");
            assert_eq!(last.continuity, Following, "{mode}, {silent} ms");
        }
    }
}

#[test]
fn what_stands_is_told_to_stand() {
    for mode in ["bypass", "pt1"] {
        let mut far = Far::new(1000, 100, 0, 1);
        let mut near = receiver(mode);
        // Within the age limit of 500 cycles: nothing brakes it.
        outage(&mut far, &mut near, 6 * SECOND, 450 * MILLISECOND);
        run_pair(&mut far, &mut near, 12 * SECOND);
        let silent = |ms: Nanos| 6 * SECOND + ms * MILLISECOND;
        let standing = corrected(&near, silent(5));
        // Silent for 450 cycles, of which 5 have passed.
        for pair in standing[..430].windows(2) {
            let velocity = (pair[1].0 - pair[0].0) / CYCLE;
            assert!((velocity - pair[1].1).abs() < 1e-6, "{mode}: {pair:?}");
        }
        assert!(standing[400].1.abs() < 1e-9, "{mode}");
        // And back: it does not make up for 450 in one cycle.
        let ways = standing.windows(2).map(|pair| pair[1].0 - pair[0].0);
        let longest = ways.fold(0.0, f64::max);
        assert!(longest < 4.0 * VELOCITY * CYCLE, "{mode}: {longest}");
        assert_eq!(near.last().master.expect("one").continuity, Following);
        let slave = near.last().slave().expect("coupled");
        let master = near.last().master.expect("one").corrected;
        assert!((slave.position - master.position).abs() < 1e-6, "{mode}");
    }
}

/// The shipped receiver's slave, and its age limit.
const SHIPPED: &str = "mode = 'observer'\nsync.time-sync = { age-of-data-limit = 100, \
    max-cycle-index-difference = 100 }\n[[slave]]\nname = 'saw'\nlimits = { velocity = 1000, acceleration = 5000, \
    jerk = 100000, on-master-loss = 'follow' }";

/// A receiver that is stopped for 2, 2, 1.5 and 3 s with 4 s between. Each time it finds a backlog,
/// in pieces as the network reads it, and stamped as it is read; messages beyond its buffers are
/// lost.
fn frozen(piece: usize, room: usize) -> Near {
    let mut far = Far::new(1000, 100, 0, 1);
    let mut near = Near::new(1000, 0, SHIPPED);
    (near.piece, near.room) = (Some(piece), room);
    let mut now = 6 * SECOND;
    for stopped in [2_000, 2_000, 1_500, 3_000] {
        run_pair(&mut far, &mut near, now);
        near.sleep_until(now + stopped * MILLISECOND);
        now += (stopped + 4_000) * MILLISECOND;
    }
    // It is four metres behind, eight if a backlog takes as long again, and makes them up at half of its velocity.
    let back = if piece > 5 { 41 } else { 91 };
    run_pair(&mut far, &mut near, now + back * SECOND);
    near
}

/// Velocities of the far axis by its own positions, in stretches of consecutive cycles.
fn velocities(near: &Near, from: Nanos) -> Vec<Vec<f64>> {
    let from = near.truths.partition_point(|at| *at < from);
    let position = |n: usize| near.snapshots[n].master.map(|it| it.corrected.position);
    let mut all = vec![Vec::new()];
    for n in from..near.truths.len() {
        let passed = (near.truths[n] - near.truths[n - 1]) as f64 * 1e-9;
        if passed > 1.5 * CYCLE {
            // Stopped: no frame left meanwhile.
            all.push(Vec::new());
            continue;
        }
        let (before, now) = (position(n - 1).expect("known"), position(n).expect("known"));
        all.last_mut().expect("one").push((now - before) / passed);
    }
    all
}

#[test]
fn a_receiver_that_stood_still_follows_the_same_run() {
    let all = usize::MAX;
    for (piece, room) in [
        (2_000, all),
        (400, all),
        (40, all),
        (5, all),
        (3, all),
        (2, all),
    ] {
        let near = frozen(piece, room);
        let last = near.last();
        let at = format!("{piece} per cycle of {room}");
        assert_eq!(last.counters.foreign_frames, 0, "{at}");
        assert_eq!(last.counters.restarts, 0, "{at}");
        let velocities = velocities(&near, 5 * SECOND);
        assert_eq!(velocities.len(), 5, "{at}");
        // At most half as fast again as its master, to catch up.
        let faster = 0.6 * VELOCITY;
        for stretch in &velocities {
            let (slowest, fastest) = (stretch.iter())
                .fold((0.0_f64, 0.0_f64), |(least, most), at| {
                    (least.min(*at), most.max(*at))
                });
            assert!(
                slowest > -1.0 && fastest < VELOCITY + faster,
                "{at}: {slowest} to {fastest} u/s"
            );
            // Braking takes 1500 u/s². Until the clock is known again time mode is active, and
            // takes a beat of one cycle back over 90 cycles.
            let most = VELOCITY / 90.0 + 1_500.0 * CYCLE;
            let step = stretch
                .windows(2)
                .position(|pair| (pair[1] - pair[0]).abs() > most);
            let around = step.map(|n| &stretch[n.saturating_sub(2)..(n + 6).min(stretch.len())]);
            assert_eq!(step, None, "{at}: {around:?}");
        }
        let master = last.master.expect("there is one");
        assert!(master.synced && master.continuity == Following, "{at}");
        assert_eq!(last.health.name(), HealthName::Ok, "{at}");
        let slave = &last.slaves[0];
        let expected = (None, AxisStatus::SynchronizedMotion);
        assert_eq!((slave.error, slave.status), expected, "{at}");
        let off = slave.set.expect("coupled").position - master.corrected.position;
        assert!(off.abs() < 1e-6, "{at}: {off} u");
    }
}

/// Wide schedules 100691, 101347, 102214 and 200175: the block falls back in the cycle after a stop, and blends from where it would have
/// been. A way back that was planned with the velocity of that blend went at up to 3.5 times the master's velocity, or stepped by that
/// velocity where the blend ended.
#[test]
fn a_block_that_falls_back_after_a_stop_leaves_no_blend_in_the_way_back() {
    for mode in ["time", "sync", "observer"] {
        for stopped in [60, 100, 205, 700] {
            let rest = format!(
                "mode = '{mode}'\nsync.time-sync = {{ automatic-re-init = true, age-of-data-limit = 63, \
                 max-cycle-index-difference = 5 }}"
            );
            let mut far = Far::new(1000, 500, 0, 1);
            let mut near = Near::new(1000, 0, &rest);
            run_pair(&mut far, &mut near, 3 * SECOND);
            // It wakes as a cycle of it begins.
            near.sleep_until((3_000 + stopped) * MILLISECOND + MILLISECOND / 2);
            run_pair(&mut far, &mut near, 10 * SECOND);
            for stretch in velocities(&near, 2 * SECOND) {
                let fastest = stretch.iter().fold(0.0_f64, |most, at| most.max(at.abs()));
                assert!(fastest < 1.7 * VELOCITY, "{mode}, {stopped} ms: {fastest}");
                let steps = stretch.windows(2).map(|pair| (pair[1] - pair[0]).abs());
                let step = steps.fold(0.0, f64::max);
                assert!(step < 0.06 * VELOCITY, "{mode}, {stopped} ms: {step}");
            }
        }
    }
}

/// A rotary master whose set position is within the modulo period of 360.
fn wrapping(rest: &str) -> (Far, Near) {
    let far = Far::new(1000, 50, 0, 1);
    let head = "sync.time-sync = { age-of-data-limit = 500, max-cycle-index-difference = 500 }";
    let mut near = Near::with_master(1000, 0, rest, head);
    near.tweak = Some(Box::new(|_, axis| {
        axis.set.position = axis.set.position.rem_euclid(360.0);
    }));
    (far, near)
}

#[test]
fn a_master_within_its_turn_is_followed_over_its_turns() {
    let (mut far, mut near) = wrapping("modulo = 360, position = 'within-turn'");
    outage(&mut far, &mut near, 4 * SECOND, 200 * MILLISECOND);
    run_pair(&mut far, &mut near, 10 * SECOND);
    let corrected = corrected(&near, 2 * SECOND);
    let ways = corrected.windows(2).map(|pair| pair[1].0 - pair[0].0);
    for way in ways {
        assert!((way - VELOCITY * CYCLE).abs() < 0.01, "{way}");
    }
    let axis = near.last().axis;
    // Only wraps that no modulo explains are counted.
    assert_eq!(axis.wraps, 0);
    // 5 u are 10 ms of motion.
    assert!((near.last().slave().expect("coupled").position - VELOCITY * 10.0).abs() < 5.0);
}

#[test]
fn a_wrap_that_is_not_configured_is_counted_with_its_length() {
    for rest in ["modulo = 360", "unit = 'mm'"] {
        let (mut far, mut near) = wrapping(rest);
        run_pair(&mut far, &mut near, 5 * SECOND);
        let axis = near.last().axis;
        // 2 500 u in 5 s are six whole turns of 360.
        assert!((5..=7).contains(&axis.wraps), "{rest}: {}", axis.wraps);
        assert!((axis.wrap_length.expect("one") - 360.0).abs() < 1e-6);
    }
}

#[test]
fn a_pace_out_of_range_is_named_and_refused() {
    for mode in MODES {
        let mut far = Far::new(1000, -3_000, 0, 1);
        let mut near = receiver(mode);
        run_pair(&mut far, &mut near, 20 * SECOND);
        let last = near.last();
        assert_eq!(last.health.name(), HealthName::PaceOutOfRange, "{mode}");
        let pace = last.counters.pace_ppm.expect("measured");
        assert!((pace + 3_000.0).abs() < 20.0, "{mode}: {pace}");
        assert_eq!(
            (last.counters.error, last.axis.error),
            (0x4b56, 0x4b56),
            "{mode}"
        );
        let stale = last.counters.stale;
        assert_eq!(stale, 0, "{mode}");
        let standing = corrected(&near, 19 * SECOND);
        assert!(standing.iter().all(|at| *at == standing[0]), "{mode}");
    }
}

#[test]
fn a_receiver_says_how_far_off_it_may_be_in_motion_and_is_not_further() {
    let mut far = Far::with_program(1000, 50, 0, 1, RAMPS);
    let mut near = receiver("observer");
    run_pair(&mut far, &mut near, 12 * SECOND);
    // Compared at the sender's own time, `correction` after the frame: the program's position at
    // that time.
    let mut program = std::collections::BTreeMap::new();
    for shown in &near.snapshots {
        let Some(master) = shown.master else { continue };
        program.insert(master.count, master.received.position);
    }
    let mut most = 0.0_f64;
    for shown in near.snapshots.iter().skip(4_000) {
        let far_time = shown.axis.far_time_ns.expect("it follows") as f64 * 1e-6;
        let (count, share) = (far_time.floor(), far_time.fract());
        let at = |count: f64| program.get(&(count as u64)).copied();
        let (Some(before), Some(after)) = (at(count), at(count + 1.0)) else {
            continue;
        };
        let truth = before + share * (after - before);
        let off = (shown.axis.corrected_position.expect("it is there") - truth).abs();
        let bound = shown.axis.prediction_sigma.expect("in observer mode");
        // A straight line between two cycles is off by an eighth of the acceleration's distance in
        // a cycle.
        assert!(off <= 4.0 * bound + 0.001, "{off} u, {bound} u");
        most = most.max(bound);
    }
    assert!(most > 1e-5 && most < 0.1, "{most}");
}
