//! The cases: those of the tables, shortened, and some for what those do not reach.

use crate::far::FarCase;
use crate::gate;
use crate::link::{Correlated, HoldUps, PowerSaving};
use crate::outcome::RunOutcome;
use crate::peers::Observer;
use crate::scores::{Scope, score};
use crate::world::{Case, Run};

/// A case under its name.
pub(crate) struct NamedCase {
    pub(crate) name: &'static str,
    kind: CaseKind,
}

enum CaseKind {
    /// Messages alone, and the observer.
    Arrivals(Box<Case>, Run),
    /// A far clock with exchanges.
    Far(Box<FarCase>),
    /// The age gate.
    Gate,
}

impl NamedCase {
    /// True if the constants of a block can have a part in it: those of exchanges have none where there are only messages.
    pub(crate) fn is_of(&self, block: &str) -> bool {
        match self.kind {
            CaseKind::Arrivals(..) => block != GATE && !OF_EXCHANGES.contains(&block),
            CaseKind::Far(_) => block != GATE,
            CaseKind::Gate => block == GATE,
        }
    }

    /// Runs the case once, with the constants as this thread has them.
    pub(crate) fn outcome(&self) -> RunOutcome {
        match &self.kind {
            CaseKind::Arrivals(case, run) => arrivals(case, run),
            CaseKind::Far(case) => case.outcome(),
            CaseKind::Gate => gate::outcome(),
        }
    }
}

fn arrivals(case: &Case, run: &Run) -> RunOutcome {
    let mut outcome = RunOutcome::default();
    let score = score(&mut Observer::new(case.cycle), run, &Scope::of_case(case));
    let claims = score.claims.unwrap();
    // The last number is the least change of interest: a twentieth of a µs beside nothing is no change by half.
    outcome.add("rms, µs", score.mean_square.sqrt() * 1e6, 0.05);
    outcome.add("largest, µs", score.max * 1e6, 0.2);
    outcome.add("settled, s", score.settled.unwrap_or(0.0), 0.2);
    outcome.add("jumps", f64::from(claims.shifts), 1.0);
    outcome.add("sigma, µs", claims.sigma * 1e6, 0.05);
    outcome.add("beyond 3σ, %", 100.0 * (1.0 - claims.within), 0.5);
    outcome.add("synchronised after, s", claims.synced_after, 0.1);
    outcome.add("largest synchronised, µs", claims.max_synced * 1e6, 0.2);
    outcome.add("drift, ppm", claims.worst_drift_ppm, 0.1);
    outcome.add("lead, µs", claims.lead * 1e6, 0.5);
    outcome
}

/// Blocks that only exchanges reach, …
const OF_EXCHANGES: [&str; 11] = [
    "BoundsTuning",
    "DriftCauseTuning",
    "EstimateTuning",
    "ExchangeTuning",
    "ExchangeWindowTuning",
    "StepTuning",
    "TimingLineTuning",
    "TimingNoiseTuning",
    "TimingTuning",
    "TrendTuning",
    "TwoWayTuning",
];
/// … and the one of the age gate.
const GATE: &str = "AgeGateTuning";

const SEED: u64 = 8_000_000;

pub(crate) const STAMPED: Case = Case::new(5.0, 20.0, true);
pub(crate) const PLAIN: Case = Case::new(5.0, 20.0, false);
const ROUGH: Case = Case::new(20.0, 100.0, false);

pub(crate) fn case(name: &'static str, seconds: f64, case: Case) -> NamedCase {
    let case = Case { seconds, ..case };
    let run = Run::new(&case, SEED);
    NamedCase {
        name,
        kind: CaseKind::Arrivals(Box::new(case), run),
    }
}

pub(crate) fn far(name: &'static str, case: FarCase) -> NamedCase {
    NamedCase {
        name,
        kind: CaseKind::Far(Box::new(case)),
    }
}

/// All cases.
pub(crate) fn all() -> Vec<NamedCase> {
    let gate = NamedCase {
        name: "age gate",
        kind: CaseKind::Gate,
    };
    let all = independent().into_iter().chain(correlated());
    let all = all.chain(events()).chain(grids());
    all.chain(far_clocks()).chain([gate]).collect()
}

fn independent() -> Vec<NamedCase> {
    let walk = Case {
        walk: 1e-6,
        ..PLAIN
    };
    let sine = Case {
        sine_drift: Some((5e-6, 20.0)),
        ..PLAIN
    };
    let servo = Case {
        servo: Some((1e-6, 4.0)),
        ..PLAIN
    };
    let slow = Case {
        cycle: 1e-2,
        ..PLAIN
    };
    vec![
        case("5/20 stamped", 20.0, STAMPED),
        case("5/20", 40.0, PLAIN),
        case("20/100", 40.0, ROUGH),
        case("20/1", 20.0, Case::new(20.0, 1.0, false)),
        // A nanosecond: below everything that is a least width.
        case("no jitter", 20.0, Case::new(1e-3, 1e-3, false)),
        case("walk 1 ppm/√s", 40.0, walk),
        case("sine 5 ppm/20 s", 40.0, sine),
        case("servo 4 s", 40.0, servo),
        // A window of the edge then has its least number of messages.
        case("T = 10 ms", 100.0, slow),
    ]
}

fn correlated() -> Vec<NamedCase> {
    let with = |correlated: Correlated, case: Case| Case {
        correlated: Some(correlated),
        ..case
    };
    let half_normal = |width: f64, time: f64| Correlated::HalfNormal { width, time };
    let telegraph = Correlated::Telegraph {
        height: 13e-6,
        up: 4.5,
        down: 6.0,
    };
    let levels = Correlated::Levels {
        height: 60e-6,
        held: 4.0,
    };
    let held_up = Case {
        hold_ups: Some(HoldUps {
            per_second: 2.0,
            length: 2e-3,
        }),
        ..PLAIN
    };
    vec![
        case(
            "AR(1) 15 µs/0.3 s",
            40.0,
            with(half_normal(15e-6, 0.3), PLAIN),
        ),
        case(
            "AR(1) 40 µs/5 s",
            60.0,
            with(half_normal(40e-6, 5.0), STAMPED),
        ),
        case("telegraph 13 µs", 50.0, with(telegraph, PLAIN)),
        case("levels 60 µs/4 s", 40.0, with(levels, PLAIN)),
        case("hold-ups 2 ms", 30.0, held_up),
        case("busy, 75 µs", 30.0, Case::busy(75.0)),
        case("busy, correlated", 40.0, Case::correlated_delay()),
    ]
}

fn events() -> Vec<NamedCase> {
    let delay = |by: f64, case: Case| Case {
        delay_step: Some((15.0, by)),
        ..case
    };
    let drift = |by: f64, case: Case| Case {
        drift_step: Some((15.0, by)),
        ..case
    };
    let load = |times: f64, case: Case| Case {
        load: Some((15.0, 30.0, times)),
        ..case
    };
    let ar = Case {
        correlated: Some(Correlated::HalfNormal {
            width: 15e-6,
            time: 0.3,
        }),
        ..PLAIN
    };
    vec![
        case("delay +30 µs", 30.0, delay(30e-6, PLAIN)),
        case("delay −200 µs", 30.0, delay(-200e-6, PLAIN)),
        case("delay +2 ms", 42.0, delay(2e-3, STAMPED)),
        case("AR(1), delay +200 µs", 30.0, delay(200e-6, ar)),
        case("drift +5 ppm", 30.0, drift(5e-6, PLAIN)),
        case("drift +60 ppm", 30.0, drift(60e-6, PLAIN)),
        case("20/100, drift −30 ppm", 40.0, drift(-30e-6, ROUGH)),
        case("AR(1), drift +60 ppm", 40.0, drift(60e-6, ar)),
        case("load × 20", 45.0, load(20.0, STAMPED)),
        case("load × 0.2", 45.0, load(0.2, PLAIN)),
        // Small enough a change that only the slow test of the widths notices it.
        case("load × 0.6", 45.0, load(0.6, PLAIN)),
    ]
}

fn grids() -> Vec<NamedCase> {
    let grid = |arrival_grid: f64, case: Case| Case {
        arrival_grid: Some(arrival_grid),
        ..case
    };
    let power_saving = Case {
        power_saving: Some(PowerSaving {
            beacons: 0.1024,
            airtime: 50e-6,
        }),
        ..STAMPED
    };
    vec![
        case("arrivals on 50 µs", 30.0, grid(50e-6, PLAIN)),
        case("arrivals on 6 µs", 20.0, grid(6e-6, PLAIN)),
        case("polled every 1 ms", 40.0, grid(1e-3, STAMPED)),
        case("polled every 1 ms, no stamps", 40.0, grid(1e-3, PLAIN)),
        case("polled every 0.25 ms", 40.0, grid(250e-6, STAMPED)),
        case("power saving", 40.0, power_saving),
    ]
}

fn far_clocks() -> Vec<NamedCase> {
    const QUIET: FarCase = FarCase::QUIET;
    fn step(time: f64, size: f64) -> f64 {
        crate::far::step(time, 10.0, size)
    }
    fn swing(time: f64, size: f64, period: f64) -> f64 {
        crate::far::swing(time, 10.0, size, period)
    }
    let rough = FarCase {
        sender: 20e-6,
        network: 100e-6,
        ..QUIET
    };
    vec![
        far("exchanges", QUIET),
        far(
            "drift +200 ppm",
            FarCase {
                drift: |t| 50.0 + step(t, 200.0),
                ..QUIET
            },
        ),
        far(
            "20/100, drift −200 ppm",
            FarCase {
                drift: |t| 50.0 + step(t, -200.0),
                ..rough
            },
        ),
        far(
            "drift −500 ppm",
            FarCase {
                drift: |t| 50.0 + step(t, -500.0),
                ..QUIET
            },
        ),
        far(
            "path +1 ms in 2 s",
            QUIET.both_ways(|t| 500e-6 * (t - 10.0).clamp(0.0, 2.0)),
        ),
        far(
            "path ±200 µs, 3 s",
            QUIET.both_ways(|t| swing(t, 200e-6, 3.0)),
        ),
        far(
            "path ±50 µs, 30 s",
            FarCase {
                seconds: 70.0,
                ..QUIET
            }
            .both_ways(|t| swing(t, 50e-6, 30.0)),
        ),
        far(
            "20/100, path ±200 µs, 3 s",
            rough.both_ways(|t| swing(t, 200e-6, 3.0)),
        ),
        far(
            "messages +400 µs",
            FarCase {
                back: |t| step(t, 400e-6),
                ..QUIET
            },
        ),
        far(
            "20/100, messages +400 µs",
            FarCase {
                back: |t| step(t, 400e-6),
                ..rough
            },
        ),
        far("both ways +5 ms", QUIET.both_ways(|t| step(t, 5e-3))),
        far(
            "stops of 2, 30 and 60 ms",
            FarCase {
                // Below and above what is mapped to whole cycles.
                stops: &[(10.0, 2e-3), (15.0, 30e-3), (20.0, 60e-3)],
                ..QUIET
            },
        ),
        far(
            "no responses, stops of 7 and 60 ms",
            FarCase {
                stops: &[(10.0, 7e-3), (20.0, 60e-3)],
                // Without a response steps are attributed by the messages alone.
                mute: (0.0, 1e9),
                stamps: false,
                ..QUIET
            },
        ),
        far(
            "silence",
            FarCase {
                silent: (10.0, 13.0),
                mute: (16.0, 21.0),
                loss: 0.3,
                ..QUIET
            },
        ),
        far(
            "ways of 2 ms, one swings",
            FarCase {
                seconds: 40.0,
                back: |t| 2e-3 + swing(t, 300e-6, 9.0),
                there: |_| 0.0,
                // True within the swing of the way, so exchanges deny it now and then.
                stated: Some((2e-3, 400e-6)),
                ..QUIET
            },
        ),
        far(
            "timing channel",
            FarCase {
                timing: Some((2e-6, 20.0)),
                ..QUIET
            },
        ),
        far(
            "timing channel, stop of 3 ms",
            FarCase {
                timing: Some((2e-6, 1e9)),
                stops: &[(15.0, 3e-3)],
                ..QUIET
            },
        ),
        far(
            "bad start",
            FarCase {
                network: 300e-6,
                back: |t| if t < 3.0 { 20e-3 - 5e-3 * t } else { 0.0 },
                loss: 0.4,
                ..QUIET
            },
        ),
    ]
}
