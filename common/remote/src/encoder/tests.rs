use std::vec::Vec;

use coaxle_clock::Span;
use proptest::prelude::*;

use super::*;

const INCREMENT: f64 = 0.01;
const CYCLE: f64 = 1e-3;

fn parameters() -> EncoderParameters {
    EncoderParameters {
        increment: INCREMENT,
        max_speed: 2_000.0,
        ..EncoderParameters::default()
    }
}

fn master(parameters: EncoderParameters) -> EncoderMaster {
    EncoderMaster::new(&parameters.checked(Span::from_millis(1)).unwrap())
}

fn sample(position: f64) -> EncoderSample {
    EncoderSample::next(libm::floor(position / INCREMENT) as i64 as u64)
}

/// Feeds it a constant velocity from a position on, cycle by cycle; returns the last output.
fn drive(master: &mut EncoderMaster, from: f64, velocity: f64, cycles: u32) -> EncoderOutput {
    let mut output = EncoderOutput::default();
    for cycle in 1..=cycles {
        let position = from + velocity * f64::from(cycle) * CYCLE;
        output = master.update(Some(sample(position)), Seconds::ZERO, 1);
    }
    output
}

/// Accelerates to a speed within the limits; returns the axis's position.
fn run_up(master: &mut EncoderMaster, velocity: f64) -> f64 {
    let (mut position, mut reached) = (0.0, 0.0);
    let _ = drive(master, position, 0.0, 300);
    while reached < velocity {
        // 1000 mm/s², a fifth of what the master may use.
        reached += 1.0;
        position += reached * CYCLE;
        let _ = master.update(Some(sample(position)), Seconds::ZERO, 1);
    }
    let _ = drive(master, position, velocity, 700);
    position + 0.7 * velocity
}

#[test]
fn before_the_first_sample_there_is_nothing() {
    let output = master(parameters()).update(None, Seconds::ZERO, 1);
    assert_eq!(output.set, Kinematics::default());
    assert!(output.standstill && !output.acquired);
    assert_eq!(output.direction, None);
}

#[test]
fn whatever_the_horizon_all_values_are_finite() {
    for horizon in [f64::NAN, f64::INFINITY, -0.01, 0.0, 1e9] {
        let mut master = master(parameters());
        for cycle in 0..500 {
            let new = Some(sample(0.2 * f64::from(cycle)));
            let output = master.update(new, Seconds(horizon), 1);
            let set = output.set;
            assert!(set.position.is_finite() && set.velocity.is_finite());
            assert!(output.position_sigma.is_finite() && output.velocity_sigma.is_finite());
        }
    }
}

#[test]
fn an_axis_at_rest_is_in_the_middle_of_its_increment() {
    let output = drive(&mut master(parameters()), -4.003, 0.0, 400);
    // Count -401: from -4.01 to -4.00.
    assert!((output.set.position + 4.005).abs() < 1e-9);
    assert_eq!((output.set.velocity, output.direction), (0.0, None));
    assert!(output.standstill && output.acquired);
}

#[test]
fn a_belt_that_moves_already_is_acquired_at_once() {
    let mut master = master(parameters());
    let output = drive(&mut master, 1_000.0, -1_234.0, 100);
    assert!(output.acquired);
    assert_eq!(output.direction, Some(TravelDirection::Backward));
    let position = 1_000.0 - 1_234.0 * 0.1;
    assert!((output.set.position - position).abs() < 0.05, "{output:?}");
    assert!((output.set.velocity + 1_234.0).abs() < 5.0, "{output:?}");
}

#[test]
fn the_horizon_is_made_good() {
    for horizon in [0.0, 2e-3, 10e-3] {
        let mut master = master(parameters());
        let mut error = f64::NAN;
        for cycle in 0..2_000 {
            let position = 333.3 * f64::from(cycle) * CYCLE;
            let set = master
                .update(Some(sample(position)), Seconds(horizon), 1)
                .set;
            error = set.position - (position + 333.3 * horizon);
        }
        assert!(error.abs() < 0.01, "{horizon}: {error}");
    }
}

#[test]
fn a_slower_counter_is_as_good_as_one_of_the_own_cycle() {
    let slow = EncoderParameters {
        sampling_time: Seconds(4e-3),
        ..parameters()
    };
    let mut master = master(slow);
    for cycle in 0..3_000_u32 {
        let position = 100.0 * f64::from(cycle) * CYCLE;
        let age = cycle % 4;
        let new = (age == 0).then(|| sample(position));
        let set = master.update(new, Seconds(f64::from(age) * CYCLE), 1).set;
        let error = set.position - position;
        assert!(cycle < 1_000 || error.abs() < 0.01, "{cycle}: {error}");
    }
}

/// Occasionally a cycle has no sample, or two at once, of which the newer counts.
#[test]
fn beats_with_a_drifting_sender_leave_no_trace() {
    for drift in [-2e-4, 2e-4] {
        let mut master = master(parameters());
        let sampling = CYCLE * (1.0 + drift);
        let mut taken = -1;
        for cycle in 0..20_000 {
            let now = f64::from(cycle) * CYCLE + 0.3e-3;
            let index = libm::floor(now / sampling) as i32;
            let at = f64::from(index) * sampling;
            let cycles = (index - taken) as u32;
            taken = index;
            let new = (cycles > 0).then(|| sample(600.3 * at).after(cycles));
            let set = master.update(new, Seconds(now - at), 1).set;
            let error = set.position - 600.3 * now;
            assert!(
                cycle < 500 || error.abs() < 0.02,
                "{drift}, {cycle}: {error}"
            );
        }
    }
}

#[test]
fn cycles_that_were_skipped_are_made_at_once() {
    let mut master = master(parameters());
    let mut position = run_up(&mut master, 400.0);
    for elapsed in [1_u32, 2, 3, 7, 20, 1, 1] {
        position += 400.0 * f64::from(elapsed) * CYCLE;
        let new = Some(sample(position).after(elapsed));
        let set = master.update(new, Seconds::ZERO, elapsed).set;
        assert!((set.position - position).abs() < 0.03, "{elapsed}: {set:?}");
    }
}

#[test]
fn a_repeated_sample_is_ignored() {
    let (mut once, mut twice) = (master(parameters()), master(parameters()));
    for cycle in 0..500 {
        let new = Some(sample(0.07 * f64::from(cycle)));
        let expected = once.update(new, Seconds::ZERO, 1);
        let again = new.map(|sample| sample.after(0));
        twice.take(sample(0.07 * f64::from(cycle)));
        assert_eq!(twice.update(again, Seconds::ZERO, 1), expected);
    }
}

#[test]
fn without_samples_it_goes_on_for_a_while_and_then_stops_within_its_limits() {
    let mut master = master(parameters());
    let start = run_up(&mut master, 500.0);
    let mut sets = Vec::new();
    for cycle in 1..=1_500 {
        let age = Seconds(f64::from(cycle) * CYCLE);
        sets.push(master.update(None, age, 1).set);
    }
    let after_100_ms = sets[99].position - (start + 50.0);
    // Continued at the estimated velocity, whose error of some mm/s acts for 0.1 s.
    assert!(after_100_ms.abs() < 0.5, "{after_100_ms}");
    assert_eq!(sets[1_499].velocity, 0.0);
    for pair in sets.windows(2) {
        let jerk = (pair[1].acceleration - pair[0].acceleration) / CYCLE;
        assert!(jerk.abs() <= 1.000_001e5 && pair[1].acceleration.abs() <= 5_000.000_1);
        assert!(pair[1].velocity >= -1e-6, "{pair:?}");
    }
}

#[test]
fn after_a_long_silence_it_catches_up() {
    let mut master = master(parameters());
    let start = run_up(&mut master, 500.0);
    for cycle in 1..=400 {
        let _ = master.update(None, Seconds(f64::from(cycle) * CYCLE), 1);
    }
    let back = start + 0.4 * 500.0;
    let _ = master.update(Some(sample(back).after(400)), Seconds::ZERO, 1);
    let output = drive(&mut master, back, 500.0, 2_000);
    let error = output.set.position - (back + 2.0 * 500.0);
    assert!(error.abs() < 0.02, "{error}");
    assert_eq!(output.refused_jumps, 0);
}

#[test]
fn a_wild_count_is_refused_and_moves_nothing() {
    let (mut calm, mut disturbed) = (master(parameters()), master(parameters()));
    let _ = run_up(&mut calm, 500.0);
    let start = run_up(&mut disturbed, 500.0);
    let expected = calm.update(None, Seconds(CYCLE), 1);
    let output = disturbed.update(Some(sample(start + 70.0)), Seconds(CYCLE), 1);
    assert_eq!(output.set, expected.set);
    assert_eq!(output.refused_jumps, 1);
}

#[test]
fn a_counter_that_is_set_anew_moves_nothing() {
    let mut master = master(parameters());
    let before = run_up(&mut master, 500.0);
    let output = drive(&mut master, 77_777.0, 500.0, 500);
    let error = output.set.position - (before + 0.5 * 500.0);
    assert!(error.abs() < 0.05, "{error}");
    // The first and two that fit to it are refused, and the third that fits confirms.
    assert_eq!((output.refused_jumps, output.counter_resets), (3, 1));
}

#[test]
fn a_counter_of_16_bits_turns_over_unnoticed() {
    let narrow = EncoderParameters {
        counter_bits: 16,
        ..parameters()
    };
    let output = drive(&mut master(narrow), 0.0, 990.0, 5_000);
    // 65 536 increments are 655 mm, so the counter turns over seven times.
    assert!((output.set.position - 4_950.0).abs() < 0.02, "{output:?}");
    assert_eq!(output.refused_jumps, 0);
}

#[test]
fn far_from_zero_it_is_as_good() {
    let far = 1e9;
    let mut master = master(parameters());
    let mut error = f64::NAN;
    for cycle in 0..2_000 {
        let position = far + 123.4 * f64::from(cycle) * CYCLE;
        let counted = libm::floor(position / INCREMENT) * INCREMENT;
        let new = EncoderSample::next_position(counted, INCREMENT);
        error = master.update(new, Seconds::ZERO, 1).set.position - position;
    }
    assert!(error.abs() < 0.01, "{error}");
}

#[test]
fn a_reversal_is_announced_when_it_is_certain() {
    let mut master = master(parameters());
    let top = run_up(&mut master, 50.0);
    let _ = drive(&mut master, top, 0.0, 400);
    for cycle in 0..400 {
        // Backward with 100 mm/s².
        let t = f64::from(cycle) * CYCLE;
        let position = top - 50.0 * t * t;
        let output = master.update(Some(sample(position)), Seconds::ZERO, 1);
        let is_backward = output.direction == Some(TravelDirection::Backward);
        // Two counts of retreat: more than one increment, less than three.
        assert!(!is_backward || top - position > INCREMENT);
        assert!(is_backward || top - position < 3.0 * INCREMENT);
    }
    let output = master.update(None, Seconds(CYCLE), 1);
    assert!(output.set.velocity < -30.0, "{output:?}");
}

#[test]
fn vibration_that_was_announced_is_no_motion() {
    let trembling = EncoderParameters {
        vibration: 0.5 * INCREMENT,
        ..parameters()
    };
    let mut master = master(trembling);
    for cycle in 0..5_000 {
        // Two frequencies that do not repeat, up to 4 sigmas.
        let t = f64::from(cycle);
        let swing = libm::sin(0.7 * t) + libm::sin(1.618 * t);
        let position = 5.0 + swing * INCREMENT;
        let output = master.update(Some(sample(position)), Seconds::ZERO, 1);
        assert_eq!((output.direction, output.standstill), (None, true));
        assert_eq!(output.set.velocity, 0.0);
    }
}

#[test]
fn a_master_that_stopped_too_late_walks_back_slowly() {
    let mut master = master(parameters());
    let end = run_up(&mut master, 100.0);
    let mut walked = 0;
    let mut last = drive(&mut master, end, 0.0, 1).set;
    for _ in 0..1_500 {
        // The axis is blocked at once.
        let output = drive(&mut master, end, 0.0, 1);
        let velocity = (output.set.position - last.position) / CYCLE;
        assert!(velocity >= -5.000_1, "{velocity}");
        assert!(velocity >= -1e-6 || output.trimming, "{velocity}");
        walked += u32::from(output.trimming);
        last = output.set;
    }
    assert!(walked > 10, "{walked}");
    assert!((last.position - end).abs() < 1.5 * INCREMENT, "{last:?}");
    assert_eq!(last.velocity, 0.0);
}

#[test]
fn any_cycle_time_and_increment_will_do() {
    for cycle_us in [100, 250, 2_000, 10_000] {
        for increment in [0.0005, 0.02, 0.3] {
            let own = EncoderParameters {
                increment,
                ..parameters()
            };
            let checked = own.checked(Span::from_micros(cycle_us)).unwrap();
            let mut master = EncoderMaster::new(&checked);
            let (velocity, cycle) = (617.0, cycle_us as f64 * 1e-6);
            let mut error = f64::NAN;
            for k in 0..(3.0 / cycle) as u32 {
                let position = velocity * f64::from(k) * cycle;
                let counted = libm::floor(position / increment) * increment;
                let new = EncoderSample::next_position(counted, increment);
                error = master.update(new, Seconds::ZERO, 1).set.position - position;
            }
            // Near a resonance of counts and cycles up to half an increment is unseen.
            assert!(
                error.abs() < increment,
                "{cycle_us} µs, {increment}: {error}"
            );
        }
    }
}

#[test]
fn a_restart_forgets_where_it_was() {
    let mut master = master(parameters());
    let _ = run_up(&mut master, 500.0);
    master.restart();
    let output = drive(&mut master, -9_000.0, 0.0, 1);
    assert_eq!(output.set, Kinematics::at_rest(-9_000.0 + 0.5 * INCREMENT));
    assert!(!output.acquired && output.refused_jumps == 0);
}

proptest! {
    /// With any input the output is finite and keeps its limits.
    #[test]
    fn no_counts_break_the_limits(
        counts in prop::collection::vec((prop::option::of(-40_i64..40), 1_u32..4), 1..400),
    ) {
        let mut master = master(parameters());
        let _ = drive(&mut master, 0.0, 0.0, 200);
        let (mut count, mut missed) = (0, 0);
        let mut last = Kinematics::at_rest(0.5 * INCREMENT);
        for (step, elapsed) in counts {
            missed += elapsed;
            let new = step.map(|step| {
                count += step;
                EncoderSample::next(count as u64).after(missed)
            });
            if new.is_some() {
                missed = 0;
            }
            let set = master.update(new, Seconds(f64::from(missed) * CYCLE), elapsed).set;
            let time = f64::from(elapsed) * CYCLE;
            let jerk = (set.acceleration - last.acceleration) / time;
            prop_assert!(set.position.is_finite());
            prop_assert!(jerk.abs() <= 1.000_001e5, "{}", jerk);
            prop_assert!(set.acceleration.abs() <= 5_000.000_1);
            last = set;
        }
    }
}

#[cfg(feature = "serde")]
mod in_a_config {
    use super::*;

    #[test]
    fn smoothing_is_auto_or_a_time() {
        let parse = |text: &str| toml::from_str::<EncoderParameters>(text);
        let smoothing = |text: &str| parse(text).map(|parameters| parameters.smoothing);
        assert_eq!(smoothing("increment = 0.01"), Ok(Smoothing::Auto));
        assert_eq!(smoothing("smoothing = \"auto\""), Ok(Smoothing::Auto));
        assert_eq!(
            smoothing("smoothing = 0.02"),
            Ok(Smoothing::Time(Seconds(0.02)))
        );
        assert!(smoothing("smoothing = \"much\"").is_err());
        assert!(parse("incremnt = 0.01").is_err());
    }

    #[test]
    fn what_is_written_is_read_again() {
        let parameters = EncoderParameters {
            smoothing: Smoothing::Time(Seconds(0.013)),
            ..parameters()
        };
        let text = toml::to_string(&parameters).unwrap();
        assert_eq!(toml::from_str(&text), Ok(parameters));
    }
}
