//! Motion of a virtual axis by its program.

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::{AtLeastZero, AxisLimit, Coordinate, parse};
use coaxle_source::config::{ProgramConfig, Repeat, StepConfig};
use coaxle_source::{Activity, AxisSource, MotionProgram, SourceSample};
use proptest::prelude::*;

const LIMITS: &str = "limits = { velocity = 100, acceleration = 1000, jerk = 10000 }\n";

fn program(rest: &str) -> MotionProgram {
    let config: ProgramConfig = parse("p.toml", &format!("{LIMITS}{rest}")).expect("valid");
    MotionProgram::new(&config)
}

fn at(program: &mut MotionProgram, seconds: f64) -> SourceSample {
    program.sample(Span::from_secs_f64(seconds))
}

/// Returns samples of every millisecond up to `seconds`.
fn samples(program: &mut MotionProgram, seconds: f64) -> Vec<SourceSample> {
    (0..=(seconds * 1e3) as i64)
        .map(|k| program.sample(Span::from_millis(k)))
        .collect()
}

fn assert_close(received: f64, expected: f64) {
    assert!(
        (received - expected).abs() <= 1e-6 * (1.0 + expected.abs()),
        "received {received}, expected {expected}"
    );
}

#[test]
fn it_stands_still_and_is_not_operational_until_it_is_enabled() {
    let mut axis = program(
        "start-position = 7\nsteps = [{ dwell = { for-s = 0.5 } }, { enable = true }, \
         { velocity = { value = 50.0 } }]",
    );
    let before = at(&mut axis, 0.499);
    assert_eq!(before.motion, Kinematics::at_rest(7.0));
    assert!(!before.enabled);
    assert_eq!(before.activity, Activity::Idle);
    let after = at(&mut axis, 0.501);
    assert!(after.enabled);
    assert!(after.motion.velocity > 0.0);
}

#[test]
fn it_can_be_under_way_from_the_first_cycle() {
    let mut axis = program("start-position = 3\nstart-velocity = 50.0");
    for sample in samples(&mut axis, 2.0) {
        assert!(sample.enabled);
        assert_eq!(sample.activity, Activity::Continuous);
        assert_eq!(sample.motion.velocity, 50.0);
        assert_eq!(sample.motion.acceleration, 0.0);
    }
    assert_close(
        at(&mut axis, 86_400.0).motion.position,
        3.0 + 50.0 * 86_400.0,
    );
}

#[test]
fn absolute_moves_end_where_they_should() {
    let mut axis = program(
        "steps = [{ enable = true }, { move-absolute = { position = 20.0 } }, \
         { move-absolute = { position = -5.0, velocity = 10.0 } }]",
    );
    let samples = samples(&mut axis, 5.0);
    assert!(
        samples
            .iter()
            .any(|s| (s.motion.position - 20.0).abs() < 1e-3)
    );
    assert!(samples.iter().all(|s| s.motion.velocity >= -10.0));
    assert!(samples.iter().any(|s| s.motion.velocity > 50.0));
    let last = samples.last().unwrap();
    assert_eq!(last.motion, Kinematics::at_rest(-5.0));
    assert_eq!(last.activity, Activity::InTarget);
    assert_eq!(last.command_number, 2);
    let moving = &samples[100];
    assert_eq!(moving.activity, Activity::Positioning);
    assert_eq!((moving.target_position, moving.command_number), (20.0, 1));
}

#[test]
fn relative_moves_add_up_over_loops_and_repeats() {
    let mut axis = program(
        "repeat = 2\nsteps = [{ enable = true }, { loop = { count = 3, steps = [\
         { move-relative = { distance = 1.0 } }, \
         { loop = { count = 2, steps = [{ move-relative = { distance = 0.25 } }] } }] } }]",
    );
    let last = *samples(&mut axis, 20.0).last().unwrap();
    // Two runs of three passes of 1 + 2·0.25.
    assert_close(last.motion.position, 2.0 * 3.0 * 1.5);
    assert_eq!(last.command_number, 2 * 3 * 3);
    assert_eq!(last.activity, Activity::InTarget);
}

#[test]
fn a_velocity_is_reached_kept_and_left() {
    let mut axis = program(
        "steps = [{ enable = true }, { velocity = { value = 50.0, for-s = 1.0 } }, \
         { velocity = { value = -20.0, for-s = 0.5 } }, { halt = {} }]",
    );
    let samples = samples(&mut axis, 4.0);
    let at_50 = samples.iter().filter(|s| s.motion.velocity == 50.0).count();
    let at_20 = samples
        .iter()
        .filter(|s| s.motion.velocity == -20.0)
        .count();
    // A second in samples of a millisecond, with either end in between.
    assert!((999..=1_001).contains(&at_50), "{at_50}");
    assert!((499..=501).contains(&at_20), "{at_20}");
    assert_eq!(samples[500].activity, Activity::Continuous);
    let last = samples.last().unwrap();
    assert_eq!((last.motion.velocity, last.motion.acceleration), (0.0, 0.0));
    assert_eq!(last.activity, Activity::Halted);
}

#[test]
fn the_last_velocity_goes_on() {
    let mut axis = program("steps = [{ enable = true }, { velocity = { value = 50.0 } }]");
    assert_eq!(at(&mut axis, 1_000.0).motion.velocity, 50.0);
    assert_eq!(at(&mut axis, 1_000.0).activity, Activity::Continuous);
}

#[test]
fn a_dwell_waits_standing_or_moving() {
    let mut standing = program(
        "steps = [{ enable = true }, { dwell = { for-s = 1.0 } }, \
         { move-relative = { distance = 1.0 } }]",
    );
    assert_eq!(at(&mut standing, 0.999).motion.position, 0.0);
    assert_eq!(at(&mut standing, 5.0).motion.position, 1.0);

    let mut moving =
        program("start-velocity = 50.0\nsteps = [{ dwell = { for-s = 1.0 } }, { halt = {} }]");
    let samples = samples(&mut moving, 2.0);
    assert_eq!(samples[999].motion.velocity, 50.0);
    assert!(samples[1_010].motion.velocity < 50.0);
    assert_eq!(samples[2_000].motion.velocity, 0.0);
}

#[test]
fn disabling_a_moving_axis_halts_it_first() {
    let mut axis =
        program("start-velocity = 50.0\nsteps = [{ dwell = { for-s = 0.1 } }, { enable = false }]");
    let samples = samples(&mut axis, 1.0);
    for sample in &samples {
        assert!(
            sample.enabled || sample.motion.velocity == 0.0,
            "{sample:?}"
        );
    }
    assert!(!samples[1_000].enabled);
}

#[test]
fn repeated_for_ever_it_keeps_its_rhythm() {
    let mut axis = program(
        "start-velocity = 10.0\nrepeat = true\nsteps = [\
         { dwell = { for-s = 0.4 } }, { velocity = { value = 20.0 } }, \
         { dwell = { for-s = 0.3 } }, { velocity = { value = 10.0 } }]",
    );
    // Both changes take the same time, v/a + a/j at most.
    let samples = samples(&mut axis, 100.0);
    let first_rise = |from: usize| {
        from + samples[from..]
            .windows(2)
            .position(|pair| pair[0].motion.velocity == 10.0 && pair[1].motion.velocity > 10.0)
            .unwrap()
    };
    let first = first_rise(0);
    let second = first_rise(first + 1);
    let third = first_rise(second + 1);
    assert!((second - first).abs_diff(third - second) <= 1);
}

#[test]
fn sampling_rarely_or_often_gives_the_same_motion() {
    let text = "repeat = true\nsteps = [{ enable = true }, \
                { move-absolute = { position = 10.0 } }, { dwell = { for-s = 0.05 } }, \
                { move-absolute = { position = 0.0 } }, { velocity = { value = 30.0 } }, \
                { halt = {} }]";
    let mut often = program(text);
    let mut rarely = program(text);
    for k in 0..20_000 {
        let sample = often.sample(Span::from_millis(k));
        // Several moves lie between two such samples.
        if k % 700 == 0 {
            assert_eq!(sample, rarely.sample(Span::from_millis(k)));
        }
    }
}

#[test]
fn passes_that_take_no_time_never_hold_up_the_cycle() {
    // The axis is at its target: each pass is over at once, for ever.
    let mut axis = program(
        "repeat = true\nsteps = [{ enable = true }, \
         { loop = { count = 4000000000, steps = [{ move-absolute = { position = 0.0 } }] } }]",
    );
    for sample in samples(&mut axis, 1.0) {
        assert_eq!(sample.motion, Kinematics::at_rest(0.0));
    }
}

/// Random step that moves the axis or waits, within the limits above.
fn step() -> impl Strategy<Value = StepConfig> {
    let coordinate =
        |range: std::ops::Range<f64>| range.prop_map(|x| Coordinate::new(x).expect("in range"));
    let time = (0.0..0.3).prop_map(|t| AtLeastZero::new(t).expect("in range"));
    let speed = prop::option::of((0.1..=100.0).prop_map(|v| AxisLimit::new(v).expect("in range")));
    prop_oneof![
        (coordinate(-50.0..50.0), speed.clone())
            .prop_map(|(position, velocity)| StepConfig::MoveAbsolute { position, velocity }),
        (coordinate(-5.0..5.0), speed)
            .prop_map(|(distance, velocity)| StepConfig::MoveRelative { distance, velocity }),
        (coordinate(-100.0..100.0), time.clone())
            .prop_map(|(value, for_s)| StepConfig::Velocity { value, for_s }),
        time.prop_map(|for_s| StepConfig::Dwell { for_s }),
        Just(StepConfig::Halt {}),
    ]
}

proptest! {
    #[test]
    fn whatever_the_steps_the_motion_is_smooth(steps in prop::collection::vec(step(), 1..12)) {
        let mut config: ProgramConfig = parse("p.toml", LIMITS).unwrap();
        config.steps = steps;
        config.repeat = Repeat::Forever;
        let samples = samples(&mut MotionProgram::new(&config), 10.0);
        for pair in samples.windows(2) {
            let (a, b) = (pair[0].motion, pair[1].motion);
            prop_assert!(b.velocity.abs() <= 100.0 * (1.0 + 1e-9), "{b:?}");
            prop_assert!(b.acceleration.abs() <= 1_000.0 * (1.0 + 1e-9), "{b:?}");
            prop_assert!((b.acceleration - a.acceleration).abs() <= 10_000.0 * 1e-3 * (1.0 + 1e-6));
            // Error of the trapezoidal rule for a motion of bounded jerk in one millisecond.
            let mean = (a.velocity + b.velocity) / 2.0;
            let left = (b.position - a.position - mean * 1e-3).abs();
            prop_assert!(left <= 10_000.0 * 1e-9, "{a:?} {b:?}");
        }
    }
}
