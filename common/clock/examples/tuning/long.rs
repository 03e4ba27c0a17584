//! Longer cases, for what is remembered for minutes, and cases that few constants have a part in.

use crate::cases::{NamedCase, PLAIN, STAMPED, case, far};
use crate::far::{FarCase, step, swing};
use crate::link::Correlated;
use crate::world::Case;

/// All of them.
pub(crate) fn all() -> Vec<NamedCase> {
    let all = arrivals().into_iter().chain(polled());
    all.chain(paths()).chain(drifts()).collect()
}

fn arrivals() -> Vec<NamedCase> {
    let half_normal = |width: f64, time: f64, case: Case| Case {
        correlated: Some(Correlated::HalfNormal { width, time }),
        ..case
    };
    let servo = Case {
        servo: Some((1e-6, 10.0)),
        ..PLAIN
    };
    let grid = Case {
        arrival_grid: Some(50e-6),
        drift_step: Some((15.0, 60e-6)),
        ..PLAIN
    };
    let slow = Case {
        cycle: 1e-2,
        drift_step: Some((30.0, 60e-6)),
        ..PLAIN
    };
    let longer = Case {
        delay_step: Some((30.0, 60e-6)),
        ..half_normal(15e-6, 0.3, PLAIN)
    };
    let with_cycle_of_10_ms = Case {
        cycle: 1e-2,
        ..PLAIN
    };
    vec![
        case("servo 10 s, long", 320.0, servo),
        case(
            "AR(1) 40 µs/5 s, long",
            320.0,
            half_normal(40e-6, 5.0, STAMPED),
        ),
        case("AR(1), delay +60 µs", 60.0, longer),
        case("arrivals on 50 µs, drift +60 ppm", 30.0, grid),
        case("T = 10 ms, drift +60 ppm", 90.0, slow),
        // Just above what counts as no scatter at all.
        case("0.1/0.1", 20.0, Case::new(0.1, 0.1, false)),
        case("AR(1) 100 µs/10 s", 40.0, half_normal(100e-6, 10.0, PLAIN)),
        case("AR(1) 400 µs/20 s", 40.0, half_normal(400e-6, 20.0, PLAIN)),
        case(
            "T = 10 ms, AR(1) 100 µs/2 s",
            60.0,
            half_normal(100e-6, 2.0, with_cycle_of_10_ms),
        ),
        // A network whose jitter is five cycles and that keeps the order: nearly every message is held up.
        case("5/5000", 40.0, Case::new(5.0, 5_000.0, false)),
    ]
}

fn polled() -> Vec<NamedCase> {
    let polled = |every: f64, stamps: bool| FarCase {
        drift: |_| 300.0,
        polled: Some(every),
        stamps,
        ..FarCase::QUIET
    };
    vec![
        far("polled every 1 ms", polled(1e-3, true)),
        far("polled every 1 ms, no stamps", polled(1e-3, false)),
        far("polled every 0.5 ms", polled(0.5e-3, true)),
        // A fifth of a cycle, the finest grid whose teeth are looked for, and the next one.
        far("polled every 0.2 ms", polled(0.2e-3, true)),
        far(
            "polled every 1/6 ms, no responses",
            FarCase {
                mute: (0.0, 1e9),
                ..polled(1e-3 / 6.0, false)
            },
        ),
    ]
}

fn paths() -> Vec<NamedCase> {
    const QUIET: FarCase = FarCase::QUIET;
    /// Three steps of a cycle, as teeth would be, but at other intervals.
    fn climb(time: f64) -> f64 {
        step(time, 10.0, 1e-3) + step(time, 13.0, 1e-3) + step(time, 20.0, 1e-3)
    }
    let seconds = |seconds: f64| FarCase { seconds, ..QUIET };
    vec![
        far(
            "no drift, messages +1 ms at 10, 13, 20 s",
            FarCase {
                drift: |_| 0.0,
                back: climb,
                mute: (0.0, 1e9),
                stamps: false,
                ..QUIET
            },
        ),
        far(
            "path ±15 µs, 30 s",
            seconds(100.0).both_ways(|t| swing(t, 10.0, 15e-6, 30.0)),
        ),
        far(
            "path ±80 µs, 25 s",
            seconds(60.0).both_ways(|t| swing(t, 0.0, 80e-6, 25.0)),
        ),
        far(
            "path ±50 µs up to 62 s, 2.3 s mute",
            FarCase {
                mute: (45.0, 47.3),
                ..seconds(120.0)
            }
            .both_ways(|t| swing(t.min(62.5), 10.0, 50e-6, 30.0)),
        ),
        far(
            "path ±50 µs, 15 s, +2 ms",
            seconds(80.0).both_ways(|t| step(t, 38.0, 2e-3) + swing(t, 10.0, 50e-6, 15.0)),
        ),
    ]
}

fn drifts() -> Vec<NamedCase> {
    const QUIET: FarCase = FarCase::QUIET;
    vec![
        far(
            "5/400, drift +100 ppm",
            FarCase {
                seconds: 50.0,
                network: 400e-6,
                drift: |t| if t < 10.0 { 50.0 } else { 150.0 },
                ..QUIET
            },
        ),
        far(
            "drift +20 ppm/s for 10 s",
            FarCase {
                seconds: 50.0,
                drift: |t| 50.0 + 20.0 * (t - 10.0).clamp(0.0, 10.0),
                ..QUIET
            },
        ),
        far(
            "drift +100 ppm/s for 3 s",
            FarCase {
                drift: |t| 50.0 + 100.0 * (t - 10.0).clamp(0.0, 3.0),
                ..QUIET
            },
        ),
    ]
}
