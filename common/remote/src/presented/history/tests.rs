//! The motion between frames, and what a delay needs of them.

use super::*;

const CYCLE: Span = Span::from_millis(1);
const DELAY: Span = Span::from_millis(20);

/// A master that goes to and fro with a jerk of up to 100 000 u/s³.
fn master(t: f64) -> Kinematics {
    const W: f64 = 30.0;
    const A: f64 = 100_000.0 / (W * W * W);
    Kinematics {
        position: 500.0 * t + A * libm::sin(W * t),
        velocity: 500.0 + A * W * libm::cos(W * t),
        acceleration: -A * W * W * libm::sin(W * t),
    }
}

/// A history of the counts from 1 000 to 1 099 that `keep` keeps.
fn history(delay: Span, keep: impl Fn(u64) -> bool) -> FrameHistory {
    let mut history = FrameHistory::new(CYCLE);
    history.prepare(delay, CYCLE);
    for count in (1_000..1_100).filter(|count| keep(*count) || *count == 1_099) {
        history.take(count, &master(count as f64 * 1e-3), DELAY);
    }
    history
}

/// The largest deviations of position, velocity and acceleration over the last `behind` ms.
fn deviations(history: &FrameHistory, behind: f64, by_acceleration: bool) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for step in 0..1_000 {
        let behind = behind * 1e-3 * f64::from(step) / 1_000.0;
        let set = history.at(behind, by_acceleration).unwrap();
        let truth = master(1.099 - behind);
        let found = [
            set.position - truth.position,
            set.velocity - truth.velocity,
            set.acceleration - truth.acceleration,
        ];
        for (most, found) in most.iter_mut().zip(found) {
            *most = most.max(found.abs());
        }
    }
    most
}

#[test]
fn between_two_frames_it_is_the_master() {
    let all = history(Span::from_millis(50), |_| true);
    let [position, velocity, acceleration] = deviations(&all, 60.0, true);
    assert!(position < 1e-9 && velocity < 1e-6 && acceleration < 2e-3);
    // Every frame is met exactly: C2 where two pieces meet.
    for back in 0..60_u64 {
        let set = all.at(back as f64 * 1e-3, true).unwrap();
        let truth = master((1_099 - back) as f64 * 1e-3);
        assert!((set.position - truth.position).abs() < 1e-9, "{back}");
        assert!(
            (set.acceleration - truth.acceleration).abs() < 1e-3,
            "{back}"
        );
    }
}

#[test]
fn a_delay_that_is_slewed_leaves_no_gap() {
    let mut history = FrameHistory::new(CYCLE);
    // Over 60, 120 and 240 cycles, and back.
    let delays = (50..260).chain((50..260).rev());
    for (count, delay) in (1_000..).zip(delays) {
        history.prepare(Span::from_millis(delay), CYCLE);
        history.take(count, &master(count as f64 * 1e-3), DELAY);
        let known = (count - 1_000).min(delay.unsigned_abs());
        for behind in [known, known / 2, 1] {
            let Some(set) = history.at(behind as f64 * 1e-3, true) else {
                // Shorter than the delay: from before the first frame that is kept.
                assert!(count < 1_300, "{count}: {behind} behind, of {delay}");
                continue;
            };
            let truth = master((count - behind) as f64 * 1e-3);
            assert!(
                (set.position - truth.position).abs() < 1e-4,
                "{count} {behind}"
            );
        }
    }
}

/// The bound that the invariant of the lab has.
#[test]
fn a_change_of_the_jerk_within_a_gap_is_off_by_a_768th() {
    const JERK: f64 = 100_000.0;
    let ramp = |t: f64| {
        let t = t.max(0.0);
        Kinematics {
            position: JERK * t * t * t / 6.0,
            velocity: JERK * t * t / 2.0,
            acceleration: JERK * t,
        }
    };
    // Four cycles, with the change at different places of them.
    let worst = |change: f64| {
        let mut history = FrameHistory::new(CYCLE);
        for count in [1_000, 1_004] {
            history.take(
                count,
                &ramp((count as f64 - 1_000.0 - change) * 1e-3),
                DELAY,
            );
        }
        let off = (0..=1_000).map(|step| {
            let at = 4e-3 * f64::from(step) / 1_000.0;
            let set = history.at(4e-3 - at, true).unwrap();
            (set.position - ramp(at - change * 1e-3).position).abs()
        });
        off.fold(0.0, f64::max)
    };
    let bound = JERK * 4e-3_f64.powi(3) / 768.0;
    assert!(
        (worst(2.0) / bound - 1.0).abs() < 1e-6,
        "{} {bound}",
        worst(2.0)
    );
    for change in [0.3, 1.0, 1.7, 2.4, 3.3] {
        assert!(worst(change) < bound, "{change}");
    }
}

#[test]
fn lost_frames_are_spanned() {
    // Two of three are lost.
    let some = history(Span::from_millis(50), |count| count.is_multiple_of(3));
    let [position, velocity, _] = deviations(&some, 55.0, true);
    assert!(position < 1e-6 && velocity < 1e-3, "{position} {velocity}");
    // Ten in a row.
    let gap = history(Span::from_millis(50), |count| {
        !(1_060..1_070).contains(&count)
    });
    let [position, ..] = deviations(&gap, 55.0, true);
    assert!(position < 1e-4, "{position}");
}

#[test]
fn without_accelerations_it_is_a_cubic() {
    let all = history(Span::from_millis(50), |_| true);
    let [position, velocity, acceleration] = deviations(&all, 60.0, false);
    // A cubic is off by x⁗·T⁴/384, and 3·10⁶ u/s⁴ are 8e-9 u.
    assert!(position < 2e-8 && velocity < 5e-5 && acceleration < 0.5);
    // It does not see the accelerations at all.
    let mut noisy = FrameHistory::new(CYCLE);
    for count in 1_000..1_100_u64 {
        let set = Kinematics {
            acceleration: 1e9,
            ..master(count as f64 * 1e-3)
        };
        noisy.take(count, &set, DELAY);
    }
    let [with_noise, ..] = deviations(&noisy, 60.0, false);
    assert!(with_noise < 2e-8, "{with_noise}");
}

#[test]
fn before_all_frames_and_after_the_newest_there_is_nothing() {
    assert_eq!(FrameHistory::new(CYCLE).at(0.0, true), None);
    let all = history(Span::from_millis(50), |_| true);
    for behind in [-1e-9, 0.070, 70.0, 1e12, f64::NAN, f64::INFINITY] {
        assert_eq!(all.at(behind, true), None, "{behind}");
    }
    let mut cleared = all.clone();
    cleared.clear();
    assert_eq!(cleared.at(0.0, true), None);
    // A run that begins with cycle 0 has nothing before it.
    let mut first = FrameHistory::new(CYCLE);
    first.take(0, &master(0.0), DELAY);
    assert_eq!(first.at(0.0, true), Some(master(0.0)));
    assert_eq!(first.at(1e-3, true), None);
    first.take(u64::MAX, &master(0.0), DELAY);
    assert_eq!(first.at(1e-3, true), None);
}

#[test]
fn frames_come_in_any_order_and_the_last_ones_are_kept() {
    let mut shuffled = FrameHistory::new(CYCLE);
    for n in 0..100_u64 {
        // Pairs change places.
        let count = 1_000 + (n ^ 1);
        shuffled.take(count, &master(count as f64 * 1e-3), DELAY);
        // A frame again.
        shuffled.take(count, &master(count as f64 * 1e-3), DELAY);
    }
    // One that is older than all of them.
    shuffled.take(7, &master(0.0), DELAY);
    let ordered = history(Span::from_millis(50), |_| true);
    for step in 0..1_000 {
        let behind = 0.063 * f64::from(step) / 1_000.0;
        assert_eq!(shuffled.at(behind, true), ordered.at(behind, true));
    }
}

#[test]
fn a_lost_frame_is_missing_and_one_that_is_left_out_is_not() {
    let some = history(Span::from_millis(50), |count| count != 1_090);
    for (behind, is_missing) in [
        (-1e-6, true),
        (0.0, false),
        (7.5e-3, false),
        (8.5e-3, true),
        (9.5e-3, true),
        (10.5e-3, false),
        (1.0, true),
    ] {
        assert_eq!(some.is_missing(behind), is_missing, "{behind}");
    }
    // Every second one is kept.
    let long = history(Span::from_millis(100), |_| true);
    assert!(!long.is_missing(50.5e-3) && !long.is_missing(0.5e-3));
}

/// A silence of 40 ms is spanned as long as it is shown, when 45 frames have come since.
#[test]
fn a_silence_is_spanned_to_its_end() {
    let mut history = FrameHistory::new(CYCLE);
    history.prepare(Span::from_millis(50), CYCLE);
    for count in (1_000..1_200_u64).filter(|count| !(1_100..1_140).contains(count)) {
        history.take(count, &master(count as f64 * 1e-3), DELAY);
        for step in 0..50_u32 {
            // A little after a frame, whose count no rounding can miss.
            let behind = (1e-3 * f64::from(step) - 1e-9).max(0.0);
            let is_there = count - 1_000 >= u64::from(step);
            assert_eq!(
                history.at(behind, true).is_some(),
                is_there,
                "{count} {step}"
            );
        }
    }
}

#[test]
fn for_a_long_delay_every_second_frame_or_fewer_are_kept() {
    let delay = Span::from_millis(1_000);
    let mut long = FrameHistory::new(CYCLE);
    long.prepare(delay, CYCLE);
    for count in 0..5_000_u64 {
        long.take(count, &master(count as f64 * 1e-3), DELAY);
    }
    for step in 0..1_000 {
        let behind = 1e-3 * f64::from(step);
        let set = long.at(behind, true).unwrap();
        // One of 17 frames: Δj·T³/768 with 3·10⁶ u/s⁴ over 17 ms is some 10⁻⁴ u at most.
        let off = (set.position - master(4.999 - behind).position).abs();
        assert!(off < 1e-4, "{step}: {off}");
    }
}
/// A delay that is slewed belongs to the frames that state it, and not to the instant at which they arrive.
#[test]
fn the_delay_at_an_instant_is_that_of_its_frames() {
    let mut history = FrameHistory::new(CYCLE);
    for count in 0..50_u64 {
        // By 800 ns a cycle.
        let delay = Span::from_nanos(20_000_000 + 800 * count as i64);
        history.take(count, &master(count as f64 * 1e-3), delay);
    }
    for (behind, expected) in [
        (0.0, 20.0392e-3),
        (10e-3, 20.0312e-3),
        (10.5e-3, 20.0308e-3),
    ] {
        let Seconds(found) = history.delay_at(behind).unwrap();
        assert!((found - expected).abs() < 1e-12, "{behind} {found}");
    }
    assert_eq!(history.delay_at(-1e-3), None);
    assert_eq!(history.delay_at(50e-3), None);
}
