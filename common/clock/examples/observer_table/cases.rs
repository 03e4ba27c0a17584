//! The cases of the table, by group.

use crate::link::{Correlated, HoldUps, PowerSaving};
use crate::world::Case;

/// The groups that can be selected, in the order of the table.
pub(crate) const GROUPS: [&str; 8] = [
    "independent",
    "correlated",
    "drift",
    "steps",
    "load",
    "busy",
    "cycles",
    RECORDED,
];

/// The group that is not generated.
pub(crate) const RECORDED: &str = "recorded";

/// A generated case under its name.
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) case: Case,
}

fn named(name: impl Into<String>, case: Case) -> Named {
    Named {
        name: name.into(),
        case,
    }
}

/// The generated cases of a group; none of an unknown one.
pub(crate) fn generated(group: &str) -> Vec<Named> {
    match group {
        "independent" => independent(),
        "correlated" => correlated(),
        "drift" => drift(),
        "steps" => steps(),
        "load" => load(),
        "busy" => busy(),
        "cycles" => cycles(),
        _ => Vec::new(),
    }
}

const STAMPED: Case = Case::new(5.0, 20.0, true);
const PLAIN: Case = Case::new(5.0, 20.0, false);
const SHARP: Case = Case::new(1.0, 5.0, false);
const ROUGH: Case = Case::new(20.0, 100.0, false);

fn usual() -> [(&'static str, Case); 3] {
    [
        ("5/20 stamped", STAMPED),
        ("5/20", PLAIN),
        ("20/100", ROUGH),
    ]
}

fn independent() -> Vec<Named> {
    let others = [(1.0, 20.0), (20.0, 20.0), (5.0, 100.0)].map(|(sender, network)| {
        named(
            format!("{sender}/{network}"),
            Case::new(sender, network, false),
        )
    });
    let usual = usual().map(|(name, case)| named(name, case));
    usual.into_iter().chain(others).collect()
}

/// Correlated delays and arrivals.
fn correlated() -> Vec<Named> {
    let half_normal = |width: f64, time: f64| Correlated::HalfNormal { width, time };
    let mut cases = Vec::new();
    for (text, kind) in [
        ("15 µs/0.3 s", half_normal(15e-6, 0.3)),
        ("40 µs/5 s", half_normal(40e-6, 5.0)),
    ] {
        for (name, case) in [("5/20", PLAIN), ("5/20 stamped", STAMPED)] {
            let correlated = Some(kind);
            let case = Case { correlated, ..case };
            cases.push(named(format!("{name}, half-normal AR(1) {text}"), case));
        }
    }
    // Recorded on a busy machine: the 10 % level of delays goes from 7.5 to 20.5 µs for 4.5 s and back.
    let telegraph = Correlated::Telegraph {
        height: 13e-6,
        up: 4.5,
        down: 6.0,
    };
    // Recorded between processes beside two busy ones: 76 to 198 hold-ups of 2 ms a minute.
    let hold_ups = HoldUps {
        per_second: 2.0,
        length: 2e-3,
    };
    let telegraph = Case {
        correlated: Some(telegraph),
        ..PLAIN
    };
    let held_up = Case {
        hold_ups: Some(hold_ups),
        ..PLAIN
    };
    let quantised = Case {
        arrival_grid: Some(50e-6),
        ..PLAIN
    };
    for (name, case) in [("5/20", PLAIN), ("5/20 stamped", STAMPED), ("1/5", SHARP)] {
        let levels = Correlated::Levels {
            height: 60e-6,
            held: 4.0,
        };
        let case = Case {
            correlated: Some(levels),
            ..case
        };
        cases.push(named(format!("{name}, levels 60 µs/4 s"), case));
    }
    for (name, cycle) in [("1 ms", 1e-3), ("10 ms", 1e-2)] {
        let power_saving = PowerSaving {
            // A beacon interval of 100 time units of 1.024 ms is what access points come with.
            beacons: 0.1024,
            airtime: 50e-6,
        };
        let case = Case {
            cycle,
            power_saving: Some(power_saving),
            ..STAMPED
        };
        cases.push(named(
            format!("5/20 stamped, power saving, T = {name}"),
            case,
        ));
    }
    cases.push(named("5/20, telegraph 13 µs", telegraph));
    cases.push(named("5/20, hold-ups 2 ms", held_up));
    cases.push(named("5/20, arrivals on 50 µs", quantised));
    cases
}

/// Drifts that do not keep to the usual random walk.
fn drift() -> Vec<Named> {
    let sine = Case {
        sine_drift: Some((5e-6, 20.0)),
        ..PLAIN
    };
    let walks = [0.1, 1.0].map(|ppm: f64| {
        let walk = ppm * 1e-6;
        named(format!("5/20, walk {ppm} ppm/√s"), Case { walk, ..PLAIN })
    });
    let mut cases = vec![named("5/20, drift sine 5 ppm/20 s", sine)];
    for period in [4.0, 10.0] {
        let case = Case {
            servo: Some((1e-6, period)),
            ..PLAIN
        };
        cases.push(named(format!("5/20, servo 1 µs/s, {period} s"), case));
    }
    cases.extend(walks);
    cases
}

fn steps() -> Vec<Named> {
    let mut cases = Vec::new();
    for (name, case) in usual() {
        for by in [5e-6, -5e-6] {
            let case = Case {
                seconds: 120.0,
                drift_step: Some((80.0, by)),
                ..case
            };
            cases.push(named(format!("{name}, drift {:+} ppm", by * 1e6), case));
        }
        // The smallest is below what is a shift at once: it must not kick the drift.
        for by in [3e-5, 2e-4, -2e-4, 2e-3, -2e-3] {
            let case = Case {
                seconds: 80.0,
                delay_step: Some((40.0, by)),
                ..case
            };
            cases.push(named(format!("{name}, delay {:+.0} µs", by * 1e6), case));
        }
    }
    cases
}

fn load() -> Vec<Named> {
    let mut cases = Vec::new();
    for (name, case) in usual() {
        // At 20 times 20/100 a message waits for two cycles in the mean, and hardly one meets a free link.
        for times in [5.0, 20.0, 0.2] {
            let load = Some((100.0, 160.0, times));
            cases.push(named(
                format!("{name}, load × {times}"),
                Case { load, ..case },
            ));
        }
    }
    cases
}

fn busy() -> Vec<Named> {
    let networks = [50.0, 75.0, 100.0];
    let networks =
        networks.map(|network| named(format!("busy, {network} µs"), Case::busy(network)));
    let mut cases: Vec<Named> = networks.into();
    cases.push(named("busy, correlated delay", Case::correlated_delay()));
    cases
}

/// Other cycle times and other relations of the jitters.
fn cycles() -> Vec<Named> {
    let cycles = [1e-4, 1e-2, 1e-1].map(|cycle: f64| {
        let seconds = if cycle < 1e-3 {
            60.0
        } else {
            // As many messages as at 1 ms, up to half an hour.
            240.0 * (cycle / 1e-3).min(8.0)
        };
        let case = Case {
            cycle,
            seconds,
            ..PLAIN
        };
        named(format!("5/20, T = {} ms", cycle * 1e3), case)
    });
    // Ratios beyond both ends of the table of information, and jitter as wide as a cycle.
    let jitters = [(0.05, 20.0), (20.0, 1.0), (1.0, 1.0), (100.0, 1000.0)];
    let jitters = jitters.map(|(sender, network)| {
        named(
            format!("{sender}/{network}"),
            Case::new(sender, network, false),
        )
    });
    cycles.into_iter().chain(jitters).collect()
}
