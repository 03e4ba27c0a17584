//! Programs that wait for their followers, stop with them, and keep their limits.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Limits;
use coaxle_node::config::parse;
use coaxle_source::config::{AxisConfig, FollowersConfig, OnFailure, ProgramConfig};
use coaxle_source::{AxisSource, Followers, MotionProgram, SourceSample};
use proptest::prelude::*;

const LIMITS: &str = "limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }\n";

/// A node without limits of its own, in sync.
const WELL: Followers = Followers {
    are_in_sync: true,
    ..Followers::UNKNOWN
};

const FAILED: Followers = Followers {
    have_failed: true,
    ..Followers::UNKNOWN
};

fn ms(millis: i64) -> Span {
    Span::from_millis(millis)
}

fn program(steps: &str, lead: i64, on_failure: OnFailure, keep_limits: bool) -> MotionProgram {
    let config: ProgramConfig =
        parse("p.toml", &format!("{LIMITS}steps = [{steps}]")).expect("valid");
    let followers: FollowersConfig = parse("f.toml", "nodes = ['saw']").expect("valid");
    MotionProgram::new(&config)
        .with_lead(ms(lead))
        .with_followers(&FollowersConfig {
            on_failure,
            keep_limits,
            ..followers
        })
}

fn limits(velocity: f64, deceleration: f64) -> Limits {
    Limits::new(velocity, deceleration, deceleration, 1e5).expect("valid")
}

/// Runs a program, a cycle of a millisecond each, with the followers of each.
fn run(
    program: &mut MotionProgram,
    cycles: std::ops::Range<i64>,
    followers: &Followers,
) -> Vec<SourceSample> {
    let cycle = |k| {
        program.take_followers(ms(k), followers);
        program.sample(ms(k))
    };
    cycles.map(cycle).collect()
}

/// Largest acceleration and jerk, by differences of the set values.
fn largest(samples: &[SourceSample]) -> (f64, f64) {
    let of = |of: fn(&SourceSample) -> f64| {
        let changes = samples
            .windows(2)
            .map(move |pair| 1e3 * (of(&pair[1]) - of(&pair[0])).abs());
        changes.fold(0.0, f64::max)
    };
    (of(|it| it.motion.velocity), of(|it| it.motion.acceleration))
}

const ROUND: &str = "{ enable = true }, { when = { followers = 'in-sync' } }, \
                     { velocity = { value = 800, for-s = 1 } }, { move-absolute = { position = 2000 } }, \
                     { dwell = { for-s = 0.5 } }, { move-absolute = { position = 0 } }";

#[test]
fn it_waits_until_all_are_in_sync() {
    let mut axis = program(ROUND, 0, OnFailure::Stop, false);
    let before = run(&mut axis, 0..500, &Followers::UNKNOWN);
    assert!(before.iter().all(|sample| sample.motion.velocity == 0.0));
    let after = run(&mut axis, 500..900, &WELL);
    // From the cycle on in which it is known.
    assert_eq!(after[0].motion.acceleration, 0.0);
    assert!(after[1].motion.acceleration > 0.0);
    assert_eq!(after[399].motion.velocity, 800.0);
    // A wait that is over is over, whatever they do afterwards.
    let lost = run(&mut axis, 900..1_000, &Followers::UNKNOWN);
    assert_eq!(lost[99].motion.velocity, 800.0);
}

#[test]
fn what_was_promised_stays_while_it_waits_and_when_it_reacts() {
    let mut axis = program(ROUND, 100, OnFailure::Stop, false);
    run(&mut axis, 0..500, &Followers::UNKNOWN);
    let started = run(&mut axis, 500..1_200, &WELL);
    // By the lead later.
    assert_eq!(started[100].motion.acceleration, 0.0);
    assert!(started[101].motion.acceleration > 0.0);
    let stopping = run(&mut axis, 1_200..2_000, &FAILED);
    assert_eq!(stopping[100].motion.velocity, 800.0);
    assert!(stopping[102].motion.velocity < 800.0);
    assert_eq!(stopping[799].motion.velocity, 0.0);
    assert!(axis.is_held());
}

#[test]
fn a_coupled_stop_is_as_slow_as_the_slowest_follower() {
    let mut axis = program(ROUND, 0, OnFailure::Stop, false);
    run(&mut axis, 0..1_000, &WELL);
    let slowest = Followers {
        limits: limits(900.0, 1_600.0),
        ..FAILED
    };
    let stop = run(&mut axis, 1_000..4_000, &slowest);
    let (acceleration, jerk) = largest(&stop);
    assert!(
        (acceleration / 1_600.0 - 1.0).abs() < 1e-6,
        "{acceleration}"
    );
    assert!(jerk <= 1e5 * (1.0 + 1e-6), "{jerk}");
    // v/a + a/j
    let standing = stop.iter().position(|sample| sample.motion.velocity == 0.0);
    assert_eq!(standing, Some(516));
    // For good: followers that are well again change nothing.
    let later = run(&mut axis, 4_000..6_000, &WELL);
    assert!(later.iter().all(|sample| sample.motion.velocity == 0.0));
}

#[test]
fn a_halted_program_goes_on_where_it_was() {
    // With the same program without an interruption; 300 ms after it.
    let mut undisturbed = program(ROUND, 0, OnFailure::Halt, false);
    let whole = run(&mut undisturbed, 0..8_000, &WELL);
    for failed_at in [400, 900, 1_290, 1_400, 2_600, 2_800, 3_400, 4_500] {
        let mut axis = program(ROUND, 0, OnFailure::Halt, false);
        run(&mut axis, 0..failed_at, &WELL);
        let halted = run(&mut axis, failed_at..failed_at + 1_000, &FAILED);
        assert_eq!(halted[999].motion.velocity, 0.0, "{failed_at}");
        let after = run(&mut axis, failed_at + 1_000..12_000, &WELL);
        let (end, expected) = (after.last().unwrap(), whole.last().unwrap());
        assert_eq!(end.motion, expected.motion, "{failed_at}");
        // Steps wait for the end of theirs, as before.
        let at_target = |samples: &[SourceSample]| {
            samples
                .iter()
                .filter(|sample| sample.motion.position == 2_000.0)
                .count()
        };
        let stayed = at_target(&halted) + at_target(&after);
        if failed_at < 2_600 {
            assert_eq!(stayed, at_target(&whole), "{failed_at}");
        }
        let (acceleration, jerk) = largest(&[halted, after].concat());
        assert!(acceleration <= 5e3 * (1.0 + 1e-6) && jerk <= 1e5 * (1.0 + 1e-6));
    }
}

#[test]
fn limits_of_followers_are_kept_while_they_hold() {
    let mut axis = program(ROUND, 0, OnFailure::Ignore, true);
    let slow = Followers {
        limits: limits(500.0, 2_000.0),
        ..WELL
    };
    let samples = run(&mut axis, 0..1_000, &slow);
    assert_eq!(samples[999].motion.velocity, 500.0);
    assert!(largest(&samples).0 <= 2_000.0 * (1.0 + 1e-6));
    // An uncoupled slave bounds nothing.
    let faster = run(&mut axis, 1_000..1_300, &WELL);
    assert_eq!(faster[299].motion.velocity, 800.0);
    let slower = run(&mut axis, 1_300..1_900, &slow);
    assert_eq!(slower[599].motion.velocity, 500.0);
    let end = run(&mut axis, 1_900..12_000, &slow);
    assert_eq!(end.last().unwrap().motion.position, 0.0);
    let fastest = end
        .iter()
        .map(|it| it.motion.velocity.abs())
        .fold(0.0, f64::max);
    assert!(fastest <= 500.0 * (1.0 + 1e-9), "{fastest}");
}

#[test]
fn a_config_is_refused_with_the_field_what_came_and_what_is_expected() {
    let axis = "id = 1\nname = 'x'\n";
    let program = format!("[program]\n{LIMITS}");
    for (rest, expected) in [
        (
            format!("followers = {{ nodes = [] }}\n{program}"),
            "followers.nodes: received 0 nodes, expected 1 to 64",
        ),
        (
            format!("followers = {{ nodes = ['a', 'b', 'a'] }}\n{program}"),
            "followers.nodes[2]: received \"a\" twice, expected each once",
        ),
        (
            format!("followers = {{ nodes = ['a'], age-limit-ms = 50 }}\n{program}"),
            "followers.age-limit-ms: received 50, expected a number from 100 to 60000",
        ),
        (
            format!("followers = {{ nodes = ['a'], on-failure = 'wait' }}\n{program}"),
            "followers.on-failure: ",
        ),
        (
            "followers = { nodes = ['a'] }\nreplay = { file = 'x.csv' }".to_owned(),
            "followers: received a table, expected none for a replay: only a program waits and stops",
        ),
        (
            format!(
                "{program}steps = [{{ loop = {{ count = 2, steps = [{{ when = {{ followers = 'in-sync' }} }}] }} }}]"
            ),
            "program.steps[0].loop.steps[0].when: received no followers to wait for, expected \
             `followers = { nodes = [...] }` of the axis",
        ),
    ] {
        let message = parse::<AxisConfig>("a.toml", &format!("{axis}{rest}"))
            .expect_err("wrong")
            .to_string();
        assert!(message.contains(expected), "{message}\n{expected}");
    }
}

proptest! {
    /// Whatever the followers do, a plan is what the axis does up to its promise, within its limits.
    #[test]
    fn promises_are_kept_whatever_followers_do(
        lead in 0_i64..150,
        halt in any::<bool>(),
        changes in prop::collection::vec((1_i64..400, any::<bool>(), any::<bool>(), 50_f64..2e3, 100_f64..1e4), 1..30),
    ) {
        let on_failure = if halt { OnFailure::Halt } else { OnFailure::Stop };
        let mut axis = program(ROUND, lead, on_failure, true);
        let (mut k, mut plans, mut samples) = (0, Vec::new(), Vec::new());
        for (cycles, are_in_sync, have_failed, velocity, acceleration) in changes {
            let followers = Followers {
                are_in_sync,
                // Rarely, or it would stand all the time.
                have_failed: have_failed && cycles < 100,
                limits: limits(velocity, acceleration),
            };
            for _ in 0..cycles {
                axis.take_followers(ms(k), &followers);
                samples.push(axis.sample(ms(k)));
                plans.push(axis.plan(ms(k), Span::ZERO));
                k += 1;
            }
        }
        for (made, plan) in plans.iter().enumerate() {
            let Some(plan) = plan else { continue };
            for at in (made..samples.len()).step_by(7) {
                let now = ms(at as i64);
                if now > plan.promised_until() {
                    break;
                }
                let Some(planned) = plan.at(now, Seconds::ZERO) else { continue };
                let truth = samples[at].motion;
                let off = (planned.position - truth.position).abs();
                prop_assert!(off < 1e-9 * (1.0 + truth.position.abs()), "{made} {at} {off}");
            }
        }
        // Its own limits hold throughout, as does the jerk.
        let (acceleration, jerk) = largest(&samples);
        prop_assert!(acceleration <= 5e3 * (1.0 + 1e-6), "{acceleration}");
        prop_assert!(jerk <= 1e5 * (1.0 + 1e-6), "{jerk}");
    }
}
