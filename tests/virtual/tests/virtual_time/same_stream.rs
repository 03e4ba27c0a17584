//! Random schedules, run more than once: equal seeds give equal rows, and the slaves do not affect the
//! axes that they follow.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::hash::{DefaultHasher, Hasher};

use coaxle_lab::catalog::Source;
use coaxle_lab::row::{Row, RowSink};
use coaxle_lab::soak::schedule;
use coaxle_lab::virtual_time;
use toml::Table;

/// Seeds of every test run.
const SEEDS: std::ops::Range<u64> = 500..512;

/// The rows of a run, each as one number, by axis.
#[derive(Default)]
struct Rows {
    /// Rows of the far nodes and axes.
    far: BTreeMap<usize, Vec<u64>>,
    /// Rows of all signals.
    all: BTreeMap<usize, Vec<u64>>,
}

impl RowSink for Rows {
    fn row(&mut self, view: usize, row: &Row) {
        let record = &row.record;
        // Debug writes the shortest digits that give a number back, so equal texts are equal bits.
        let far = hash(format_args!("{:?} {:?}", record.far, record.axis));
        self.far.entry(view).or_default().push(far);
        let all = hash(format_args!("{row:?}"));
        self.all.entry(view).or_default().push(all);
    }
}

/// Text into a hash: every digit of every number counts.
struct Hashed(DefaultHasher);

impl fmt::Write for Hashed {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}

fn hash(text: fmt::Arguments<'_>) -> u64 {
    let mut hashed = Hashed(DefaultHasher::new());
    hashed.write_fmt(text).expect("a hash takes all");
    hashed.0.finish()
}

fn rows_of(text: String) -> Rows {
    let source = Source {
        name: "schedule".to_owned(),
        file: "schedule.toml".to_owned(),
        text,
    };
    let scenario = source.read(&[]).expect("a schedule");
    let mut rows = Rows::default();
    virtual_time::run(&scenario, &mut rows, &mut ()).expect("nodes keep the contract");
    rows
}

/// Checks that two runs are equal, and reports the first difference.
fn assert_same(seed: u64, one: &BTreeMap<usize, Vec<u64>>, other: &BTreeMap<usize, Vec<u64>>) {
    assert_eq!(one.len(), other.len(), "seed {seed}");
    for (view, rows) in one {
        // 40 s at the slowest cycle, 2 ms, are 20 000 rows, less the times in which a receiver is away.
        assert!(rows.len() > 10_000, "seed {seed}: {} rows", rows.len());
        assert_eq!(rows.len(), other[view].len(), "seed {seed}, axis {view}");
        let differs = rows
            .iter()
            .zip(&other[view])
            .position(|(one, other)| one != other);
        assert_eq!(
            differs, None,
            "seed {seed}, axis {view}: the first row that differs"
        );
    }
}

#[test]
fn the_same_schedule_gives_the_same_rows() {
    let first = rows_of(schedule::of(SEEDS.start));
    assert_same(
        SEEDS.start,
        &first.all,
        &rows_of(schedule::of(SEEDS.start)).all,
    );
    let other = rows_of(schedule::of(SEEDS.end));
    assert!(first.all[&0] != other.all[&0], "the seed has no effect");
}

#[test]
fn what_becomes_of_slaves_changes_nothing_of_their_masters() {
    let mut changed = 0;
    for seed in SEEDS {
        // A hold-back that changes at once while the slaves stand moves the axes that they follow.
        let schedule: Table = schedule::before_lags(&schedule::of(seed))
            .parse()
            .expect("TOML");
        let schedule = of_senders_alone(schedule);
        let with = rows_of(schedule.to_string());
        let without = rows_of(without_slaves(schedule).to_string());
        assert_same(seed, &with.far, &without.far);
        changed += u64::from(with.all != without.all);
    }
    // Otherwise slaves that never moved would prove nothing.
    assert_eq!(changed, SEEDS.end - SEEDS.start, "there were slaves");
}

/// Leaves out receivers that follow a receiver, as their master is a slave.
fn of_senders_alone(mut schedule: Table) -> Table {
    let mut gone = Vec::new();
    list(&mut schedule, "receiver").retain(|receiver| {
        let follows = receiver["master"]["node"].as_str().expect("a name");
        // A master that is a slave itself moves otherwise once its limits and commands are removed.
        let stays = !follows.starts_with("follower");
        if !stays {
            gone.push(receiver["name"].clone());
        }
        stays
    });
    list(&mut schedule, "event").retain(|event| !gone.contains(&event["node"]));
    schedule
}

/// Leaves each receiver only its default slave: a gear, without limits and commands.
fn without_slaves(mut schedule: Table) -> Table {
    for receiver in list(&mut schedule, "receiver") {
        let receiver = receiver.as_table_mut().expect("a receiver");
        receiver.remove("slave").expect("slaves");
    }
    list(&mut schedule, "event").retain(|event| event.get("slave").is_none());
    schedule
}

fn list<'a>(schedule: &'a mut Table, name: &str) -> &'a mut Vec<toml::Value> {
    let none = || toml::Value::Array(Vec::new());
    let list = schedule.entry(name).or_insert_with(none);
    list.as_array_mut().expect("a list")
}
