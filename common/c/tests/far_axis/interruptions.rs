//! Interruptions of an axis: none leaves a step, and each ends at the truth.
#![expect(clippy::print_stdout, reason = "how far an axis steps is a figure")]

use coaxle_c::*;

use super::{CYCLE_NS, RATE, axis_of_mode, cycle, sized, take};

/// Something that happens to an axis at 1 s, and is over at 2 s.
struct Interruption {
    name: &'static str,
    /// Presentation delay before and after, and during it, ms.
    delay_ms: [i64; 2],
    /// Samples are lost but for every n-th.
    every: u64,
    is_clock_known: bool,
    /// True if the node begins another run at the end of it.
    restarts: bool,
    /// Largest way that `FB_AxisSync` blends, mm; none where it jumps.
    way: Option<f64>,
}

/// Speed of the master, mm/s, which stands for a moment every four seconds.
const MOST_SPEED: f64 = 200.0;

fn running(t: f64) -> coaxle_far_sample {
    let omega = core::f64::consts::FRAC_PI_2;
    let (sin, cos) = (omega * (t + 1.0)).sin_cos();
    coaxle_far_sample {
        position: 100.0 * (t - sin / omega),
        velocity: 100.0 * (1.0 - cos),
        acceleration: 100.0 * omega * sin,
        ..sized()
    }
}

#[test]
fn no_interruption_leaves_a_step_and_each_ends_at_the_truth() {
    let calm = Interruption {
        name: "nothing",
        delay_ms: [0, 0],
        every: 1,
        is_clock_known: true,
        restarts: false,
        way: Some(0.0),
    };
    for case in [
        Interruption { ..calm },
        Interruption {
            name: "it is shown later",
            delay_ms: [0, 20],
            way: Some(4.0),
            ..calm
        },
        Interruption {
            name: "by another delay",
            delay_ms: [20, 35],
            way: Some(3.0),
            ..calm
        },
        Interruption {
            name: "by a slewed delay",
            delay_ms: [20, 21],
            way: Some(0.2),
            ..calm
        },
        Interruption {
            name: "it is shown now",
            delay_ms: [20, 0],
            way: Some(4.0),
            ..calm
        },
        // A beat is a cycle's way.
        Interruption {
            name: "the clock is unknown",
            is_clock_known: false,
            way: Some(0.4),
            ..calm
        },
        Interruption {
            name: "unknown, shown later",
            delay_ms: [20, 20],
            is_clock_known: false,
            way: Some(0.4),
            ..calm
        },
        Interruption {
            name: "frames are lost",
            every: 7,
            way: Some(0.1),
            ..calm
        },
        Interruption {
            name: "lost, shown later",
            delay_ms: [20, 20],
            every: 7,
            ..calm
        },
        // It goes back to where it was received last, and then to where its master is by now.
        Interruption {
            name: "it is silent",
            every: u64::MAX,
            way: None,
            ..calm
        },
        Interruption {
            name: "silent, shown later",
            delay_ms: [20, 20],
            every: u64::MAX,
            way: None,
            ..calm
        },
        Interruption {
            name: "its node restarts",
            restarts: true,
            way: Some(0.4),
            ..calm
        },
        Interruption {
            name: "restarts, shown later",
            delay_ms: [20, 20],
            restarts: true,
            way: Some(4.5),
            ..calm
        },
        Interruption {
            name: "restarts after a silence",
            every: u64::MAX,
            restarts: true,
            way: None,
            ..calm
        },
    ] {
        // On its way back it is faster than its master by half at the most.
        interrupt(&case, true, 1.5 * MOST_SPEED * 1e-3 * RATE);
        if let Some(way) = case.way {
            // Over 60 ms, beside the way of the master.
            interrupt(&case, false, MOST_SPEED * 1e-3 * RATE + way / 60.0);
        }
    }
}

/// Judges each step, with this bound in mm, and where the axis is before and long after an interruption.
fn interrupt(case: &Interruption, is_continuous: bool, most: f64) {
    let axis = axis_of_mode(COAXLE_MODE_OBSERVER, is_continuous);
    let (mut newest, mut begin) = (0, 0);
    let mut before: Option<f64> = None;
    let mut largest = 0.0_f64;
    for own in 1_u64..7_000 {
        let is_on = (1_000..2_000).contains(&own);
        let delay_ms = case.delay_ms[usize::from(is_on)];
        let far = own as f64 * RATE;
        if case.restarts && own == 2_000 {
            // SAFETY: the rules of the header.
            assert_eq!(unsafe { coaxle_far_axis_restart(axis) }, COAXLE_OK);
            begin = far as u64;
            newest = 0;
        }
        let count = far as u64 - begin;
        if !is_on || count.is_multiple_of(case.every) {
            newest = count;
            let sample = coaxle_far_sample {
                count,
                present_after_ns: delay_ms * CYCLE_NS,
                ..running((begin + count) as f64 * 1e-3)
            };
            take(axis, &sample);
        }
        let age = (far - (begin + newest) as f64) * 1e-3;
        let state = cycle(axis, (!is_on || case.is_clock_known).then_some(age));
        let position = state.position;
        if let Some(before) = before.replace(position) {
            largest = largest.max((position - before).abs());
        }
        // Settled: long before it, and long after it.
        if (500..1_000).contains(&own) || own > 6_000 {
            assert_eq!(
                (state.mode, state.error),
                (COAXLE_MODE_OBSERVER, 0),
                "{}",
                case.name
            );
            let truth = running(far * 1e-3 - delay_ms as f64 * 1e-3).position;
            // A slewed delay takes a second and more.
            let off = (position - truth).abs();
            assert!(off < 1e-4, "{}, {own}: {off} mm", case.name);
        }
    }
    println!("{}: steps up to {largest:.4} mm of {most:.4}", case.name);
    assert!(
        largest < most + 1e-3,
        "{}: {largest} mm, at most {most}",
        case.name
    );
    // SAFETY: the rules of the header.
    unsafe { coaxle_far_axis_free(axis) };
}
