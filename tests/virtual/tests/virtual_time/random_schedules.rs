//! Random schedules in virtual time: under all faults, no slave leaves its limits, no far time goes back, and
//! when it is quiet again every receiver is in sync.
//!
//! Some run with every test run; `coaxle soak --hours 10` runs more. `SCHEDULES=1234 cargo test -p
//! coaxle-virtual-tests random_schedules::` runs one seed alone, `SCHEDULES=1000..2000` a range.

use std::ops::Range;

use coaxle_lab::soak::Soak;
use coaxle_lab::soak::schedule::{
    PLAIN, SWARM, ScheduleKind, WIDE, before_dead_times, before_followers, before_lags,
};
use coaxle_lab::stage::VirtualTime;
use coaxle_report::reported;

/// Schedules as they were before lags were drawn: most of those that once failed are older.
const PLAIN_BEFORE_LAGS: ScheduleKind = ScheduleKind {
    text: |seed| before_lags(&(PLAIN.text)(seed)),
    ..PLAIN
};
const WIDE_BEFORE_LAGS: ScheduleKind = ScheduleKind {
    text: |seed| before_lags(&(WIDE.text)(seed)),
    ..WIDE
};
const SWARM_BEFORE_LAGS: ScheduleKind = ScheduleKind {
    text: |seed| before_lags(&(SWARM.text)(seed)),
    ..SWARM
};

/// Schedules as they were with lags, before followers and promises were drawn.
const SWARM_BEFORE_FOLLOWERS: ScheduleKind = ScheduleKind {
    text: |seed| before_followers(&(SWARM.text)(seed)),
    ..SWARM
};

/// Schedules as they were with those, before dead times of drives were drawn.
const SWARM_BEFORE_DEAD_TIMES: ScheduleKind = ScheduleKind {
    text: |seed| before_dead_times(&(SWARM.text)(seed)),
    ..SWARM
};

/// Seeds that once failed, with the reasons.
const REGRESSIONS: &[(u64, &str)] = &[
    (
        15,
        "the first frame, repeated while no other came, was followed",
    ),
    (44, "likewise"),
    (
        1_080_801,
        "against a line that began anew, a delay that all exchanges denied was taken for sure",
    ),
    (1_160_823, "likewise"),
    (
        20_112_407,
        "one that another run of its master had begun 2 s before the end was to be in sync",
    ),
];

/// Seeds of wide schedules that once failed, with the reasons.
const WIDE_REGRESSIONS: &[(u64, &str)] = &[
    (
        200_456,
        "an axis received only once, 3.2 s ago, was shown there for a cycle",
    ),
    (
        300_217,
        "an observer that tolerates 1 ms of silence was to be in sync on a network whose messages are later again and again",
    ),
    (
        300_282,
        "a stop planned from 251 u/s was judged by its first cycle, at 94 u/s",
    ),
    (
        300_571,
        "a follower of a slave without power was to be in sync, while the slave's master was on a way of 5 m",
    ),
    (
        300_665,
        "brought back relative to positions that stood until the next frame, an axis ran away from its master",
    ),
    (300_893, "likewise"),
    (
        400_419,
        "over 90 ms without frames, a master between ±5 mm was taken to be accelerated to 600 mm/s",
    ),
    (
        500_360,
        "a velocity beside its positions by the pace of its master was to be compensated beyond the acceleration limit",
    ),
    (
        500_647,
        "an acceleration that a slave stated in a single frame was carried on to −245 m/s",
    ),
    (503_539, "as 500360"),
    (
        503_740,
        "the check forgot a forged position while the receiver still took it into account",
    ),
    (
        601_779,
        "a reset came after the planned time of a cycle, and before the node woke up in it",
    ),
    (
        605_685,
        "with power after 142 skipped cycles, a slave was at once where its gear had led it meanwhile",
    ),
    (
        606_458,
        "as 605685, after 70 cycles and by a superimposed motion",
    ),
    (
        606_543,
        "the first acceleration of an encoder, from a velocity that it did not know, threw its axis back at ten times its velocity",
    ),
    (
        608_381,
        "of 5892 skipped cycles a slave stood still for 892, at its velocity",
    ),
    (
        700_308,
        "a velocity beside its positions by the pace of its master was to be compensated with a tenth of the acceleration left",
    ),
    (
        701_866,
        "a master that turned round during a freeze of its receiver was judged by its mean acceleration",
    ),
    (702_652, "as 606543"),
    (
        703_128,
        "as 500647, by the coarse accelerations of an encoder over 50 ms without frames",
    ),
    (
        723_586,
        "what a master did while its sender stood still was to be known",
    ),
];

/// Seeds of swarm schedules that once failed, with the reasons.
const SWARM_REGRESSIONS: &[(u64, &str)] = &[
    (
        141,
        "a position beside a time that was still to be slewed was judged by the velocity in another clock",
    ),
    (
        143,
        "an axis with limits was never following a master that came in beats",
    ),
    (630, "as 143"),
    (
        484,
        "an acceleration that was stated in the first frame of a motion was not taken for a part of it",
    ),
    (
        1_075,
        "an axis with limits was led away from a master that its own guard led to and fro",
    ),
    (2_339, "as 1075"),
    (
        2_530,
        "a node whose clock was set back executed a reset seconds later",
    ),
    (
        2_656,
        "the allowance for a rate that has just changed was missing every few cycles",
    ),
    (
        2_726,
        "a slave went between the beats of its master, and was to be on them",
    ),
    (2_799, "as 2726"),
    (
        3_088,
        "a way back that was planned again was judged from its first plan on",
    ),
    (
        2_932,
        "by the rate of a line that had just begun, two ways took nothing together, and the error that was stated was too small",
    ),
    (
        4_937,
        "a way back began from its start whenever the clock was found again",
    ),
    (
        4_941,
        "an order made the blending longer than the check assumed",
    ),
    (
        4_957,
        "a velocity beside its positions after skipped cycles was to be compensated beyond the acceleration limit",
    ),
    (
        5_125,
        "in its last cycle, an axis that is shown later was judged by another pace than that of its master's clock",
    ),
    (
        410,
        "by a timing channel, the far time of clocks that wander was farther off than stated",
    ),
    (424, "as 410"),
    (472, "as 410"),
    (527, "as 410"),
    (661, "as 410"),
    (
        519,
        "as 410, and a position within the turn was compared with a master in another turn",
    ),
    (
        606,
        "by a timing channel, a rate that had changed at once was not in the stated error for a second",
    ),
];

/// Seeds of swarm schedules with lags that once failed, with the reasons.
const LAG_REGRESSIONS: &[(u64, &str)] = &[
    (
        20_033,
        "in its last cycle, the lag of an axis was taken at another pace than that of its master's clock",
    ),
    (20_067, "as 20300, of the first hold-back"),
    (
        20_300,
        "a hold-back that fell at once, while the slaves stood, was taken for a far time that ran back",
    ),
    (
        40_054,
        "a slave that waits for a master without power, and is not published, was to be followed in sync",
    ),
];

/// Seeds of swarm schedules with followers that once failed, with the reasons.
const FOLLOWER_REGRESSIONS: &[(u64, &str)] = &[
    (
        41_102,
        "an axis on its way back to a master that had never moved was stopped within a cycle",
    ),
    (
        50_274,
        "each beat of its master that was larger than usual began a way back from its start",
    ),
    (
        50_473,
        "a backlog in the first messages of a run left a clock with a wrong drift for minutes",
    ),
    (
        50_709,
        "behind a pause of its receiver, what a rate that had changed excuses was no number",
    ),
    (
        50_718,
        "a lower edge with a wrong drift was moved up again and again, and kept it",
    ),
    (
        50_771,
        "a filter went on towards 0 for ever, and its axis was brought back again in each cycle",
    ),
    (
        50_823,
        "the last set values of a motion that faded were shown later as no numbers",
    ),
    (
        60_591,
        "in the cycle in which its hold-back ended, a coupled slave was shown where it had stood before",
    ),
    (
        61_153,
        "a master at its newest sample had the pace of the true time",
    ),
    (
        61_166,
        "messages that were late by their sender were to show beats to a block of TS5066",
    ),
];

/// Seeds that once failed with locked cycles, or with delays that followers decide, with the reasons.
const LOCK_REGRESSIONS: &[(u64, &str)] = &[
    (
        80_255,
        "a cycle that was nearly a whole one late was moved into the past",
    ),
    (
        80_307,
        "set values that wait for a hold-back were judged by the delay of others",
    ),
    (
        80_380,
        "an axis beyond its newest frame was judged by a delay that no frame had stated",
    ),
    (
        80_813,
        "a delay that grew over 60 cycles left no frames between which to show an axis",
    ),
    (
        80_951,
        "other parameters began a blend that was taken for an error",
    ),
    (
        81_289,
        "frames that came fifty at a time brought a delay that is followed slowly",
    ),
    (
        81_060,
        "a rate that wanders was judged by changes that cancel",
    ),
    (
        81_098,
        "a block of TS5066 was to be in sync behind two links, of one of which alone the jitter was counted",
    ),
    (81_281, "as 81 667"),
    (
        81_667,
        "back from another mode, an axis was shown by the delay of before, and came to the one in force at 0.1 % of the time",
    ),
    (81_751, "as 81 098, of three links"),
    (
        90_111,
        "a delay that had gone on while no frame came was to be followed at once",
    ),
    (
        90_328,
        "frames that last two cycles of a receiver were judged by what changes from one to the next, and not within a cycle",
    ),
    (
        90_356,
        "a slave was to be beside a target that changes its velocity more quickly than it can",
    ),
    (91_876, "as 90 111, over a freeze of 145 ms"),
    (
        90_447,
        "a rate that changed within a group of exchanges made the stated least round trip shorter than any was",
    ),
];

/// Seeds of every test run.
// The soaks of `.ci/run` go on from the end of this range and of the next one, so that none runs twice.
const FEW: Range<u64> = 0..60;
/// Seeds of swarm schedules of every test run: a second each.
const FEW_OF_SWARM: Range<u64> = 0..4;

#[test]
fn some_random_schedules() {
    run_all(PLAIN, asked_for().unwrap_or(FEW), "random-schedules");
    // Each on its own: they lie far apart, and a range would run all between.
    for (seed, _) in REGRESSIONS {
        run_all(PLAIN_BEFORE_LAGS, *seed..*seed + 1, "random-schedules");
    }
}

#[test]
fn wide_schedules_that_once_failed() {
    for (seed, _) in WIDE_REGRESSIONS {
        run_all(WIDE_BEFORE_LAGS, *seed..*seed + 1, "wide-schedules");
    }
}

#[test]
fn some_swarm_schedules() {
    run_all(SWARM, FEW_OF_SWARM, "swarm-schedules");
    for (seed, _) in SWARM_REGRESSIONS {
        run_all(SWARM_BEFORE_LAGS, *seed..*seed + 1, "swarm-schedules");
    }
    for (seed, _) in LAG_REGRESSIONS {
        run_all(SWARM_BEFORE_FOLLOWERS, *seed..*seed + 1, "swarm-schedules");
    }
    for (seed, _) in FOLLOWER_REGRESSIONS {
        run_all(SWARM_BEFORE_DEAD_TIMES, *seed..*seed + 1, "swarm-schedules");
    }
    for (seed, _) in LOCK_REGRESSIONS {
        run_all(SWARM, *seed..*seed + 1, "swarm-schedules");
    }
}

/// A seed repeats a failure only if it gives the same schedule on every machine, and with every version that did not mean to change it.
#[test]
fn a_seed_gives_the_same_swarm_schedule() {
    for seed in [3, 17] {
        insta::assert_snapshot!(format!("swarm-schedule-{seed}"), (SWARM.text)(seed));
    }
}

/// `SCHEDULES`, a seed or a range of them.
fn asked_for() -> Option<Range<u64>> {
    let asked = std::env::var("SCHEDULES").ok()?;
    let number = |text: &str| {
        text.parse()
            .expect("SCHEDULES: expected a seed, or FROM..TO")
    };
    Some(match asked.split_once("..") {
        Some((from, to)) => number(from)..number(to),
        None => number(&asked)..number(&asked) + 1,
    })
}

fn run_all(schedule: ScheduleKind, seeds: Range<u64>, folder: &str) {
    // Kept for the files of failures; of each process its own, as two checkouts may be tested at a time.
    let out = std::env::temp_dir().join(format!("{folder}-{}", std::process::id()));
    let soak = Soak {
        stage: &VirtualTime,
        seeds,
        schedule,
        out,
        junit: None,
        leave: &reported::leave,
    };
    let soaked = soak.run(&|| true, &|_, _| {}).expect("a scratch folder");
    let lines = soaked.failures.iter().map(|failure| {
        let wrong = failure.wrong.join("\n  ");
        format!(
            "seed {}, as {}:\n  {wrong}",
            failure.seed,
            failure.file.display()
        )
    });
    let lines: Vec<_> = lines.collect();
    assert!(
        lines.is_empty(),
        "{} failed\n{}",
        lines.len(),
        lines.join("\n")
    );
    // Without a failure nothing in it is of use. A folder that cannot be removed is no fault of the schedules.
    let _ = std::fs::remove_dir_all(&soak.out);
}
