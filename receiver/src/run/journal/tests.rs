use super::*;
use coaxle_axis::drive::DriveFault;
use coaxle_clock::time_sync::SyncError;
use coaxle_node::config::parse;
use coaxle_slave::SlaveError;

use crate::program::{BlockedProgram, Outcome, Trouble, WaitsFor};

fn config() -> ReceiverConfig {
    parse(
        "r",
        "name = 'saw'\ncycle-time-us = 1000\nmode = 'sync'\nmaster.node = 'conveyor'",
    )
    .unwrap()
}

/// Log lines of a sequence of snapshots, one a second; each line comes once.
fn told(life: &[ReceiverSnapshot]) -> Vec<Note> {
    let mut journal = Journal::new(&config());
    let mut told = Vec::new();
    for (k, snapshot) in (0..).zip(life) {
        told.extend(journal.take(at(1_000 * k), snapshot));
        assert_eq!(journal.take(at(1_000 * k + 1), snapshot), []);
    }
    told
}

fn as_texts(notes: &[Note]) -> Vec<(Level, &str)> {
    notes.iter().map(|n| (n.level, n.text.as_str())).collect()
}

fn waiting() -> ReceiverSnapshot {
    ReceiverSnapshot::new(&config(), Instant::EPOCH)
}

fn following(health: Health, state: FilterState) -> ReceiverSnapshot {
    let mut snapshot = waiting();
    snapshot.health = health;
    if !is_of_a_slave(health) {
        snapshot.far_health[0] = health;
    }
    let far = &mut snapshot.signals.far[0];
    far.age_cycles = 1_001;
    far.beats = 2;
    far.drift_ppm = Some(-12.345);
    snapshot.signals.axes[0].state = Some(state);
    snapshot
}

fn failed() -> ReceiverSnapshot {
    following(
        Health::Error(SyncError::MaxDataAgeExceeded),
        FilterState::Pt1,
    )
}

fn at(millis: i64) -> Instant<Machine> {
    Instant::EPOCH + Span::from_millis(millis)
}

#[test]
fn another_count_of_the_same_run_is_no_restart() {
    let mut before = following(Health::Ok, FilterState::Sync);
    before.signals.far[0].epoch = Some(7);
    let mut after = before.clone();
    after.signals.far[0].restarts = 1;
    let told = told(&[before, after]);
    let text = "the master's node goes on with another count of its run: epoch 7";
    assert!(
        as_texts(&told).contains(&(Level::Warning, text)),
        "{told:?}"
    );
}

#[test]
fn each_change_is_told_once() {
    let mut warned = following(Health::Ok, FilterState::Sync);
    warned.signals.far[0].warning = SyncWarning::DriftChangedSignificantly.code();
    warned.signals.far[0].epoch = Some(7);
    let mut restarted = warned.clone();
    restarted.signals.far[0].restarts = 1;
    restarted.signals.far[0].epoch = Some(8);
    let mut tripped = following(Health::DriveTripped, FilterState::Time);
    tripped.faults[0].error = Some(SlaveError::Drive(DriveFault::FollowingError {
        following_error: 3.0,
    }));
    let life = [
        waiting(),
        following(Health::StartingUp, FilterState::Time),
        following(Health::Ok, FilterState::Sync),
        warned,
        restarted,
        failed(),
        following(Health::MasterSilent, FilterState::Pt1),
        tripped,
    ];
    let told = told(&life);
    assert_eq!(
        as_texts(&told),
        [
            (
                Level::Info,
                "starting up in time mode until the far clock's drift is known"
            ),
            (Level::Info, "synchronised after 2 beats, drift -12.35 ppm"),
            (
                Level::Warning,
                "warning 0x0001: the drift changed by more than half"
            ),
            (
                Level::Warning,
                "the master's node has restarted: epoch 8 after 7"
            ),
            (
                Level::Error,
                "error 0x4b52: no new data for too long: 1001 own cycles, more than sync.time-sync.age-of-data-limit permits, \
                 in the config 7 (on a PC without real-time priority 100, or more); set values in pt1 mode"
            ),
            (
                Level::Warning,
                "no new data from the master for 1001 cycles"
            ),
            (
                Level::Error,
                "error 0x4550: the drive tripped: its following error was too large for too \
                 long; set values in time mode"
            ),
        ]
    );
}

#[test]
fn no_other_limit_is_advised_than_an_observer_has_by_default() {
    for (cycle_us, expected) in [(1_000, "in the config 100;"), (10_000, "in the config 10;")] {
        let text = format!("name = 'saw'\ncycle-time-us = {cycle_us}\nmaster.node = 'conveyor'");
        let config: ReceiverConfig = parse("r", &text).unwrap();
        let heard = heard(&config);
        let line = health_of_far(&failed(), 0, &heard[0]).text;
        assert!(line.contains(expected), "{line}");
    }
}

#[test]
fn what_a_program_waits_for_in_vain_or_of_somebody_is_told() {
    let with = |program, health, trouble: Option<Trouble>| {
        let mut snapshot = following(health, FilterState::Time);
        let slave = &mut snapshot.signals.slaves[0];
        slave.program = Some(program);
        slave.program_step = Some(3);
        slave.program_waits_for = Some(WaitsFor::InSync);
        snapshot.faults[0].blocked = trouble.map(|trouble| BlockedProgram {
            step: 3,
            waits_for: WaitsFor::InSync,
            trouble,
        });
        snapshot
    };
    let life = [
        with(ProgramState::Running, Health::Ok, None),
        with(ProgramState::WaitingForOrder, Health::Ok, None),
        with(
            ProgramState::Blocked,
            Health::ProgramBlocked { slave: 0 },
            Some(Trouble::Outcome(Outcome::RolledBack)),
        ),
    ];
    let told = told(&life);
    assert_eq!(
        as_texts(&told),
        [
            (
                Level::Info,
                "slave: step 3 of the program waits for in-sync, which only an order can bring"
            ),
            (
                Level::Error,
                "error 0x4b07: step 3 of the program waits for in-sync, which cannot come by \
                 itself: its flying saw was rolled back; set values in time mode"
            ),
        ]
    );
}

#[test]
fn a_receiver_that_flutters_does_not_flood_the_log() {
    let mut journal = Journal::new(&config());
    let mut lines = Vec::new();
    for k in 0..2_001 {
        let snapshot = match k % 2 {
            0 => following(Health::StartingUp, FilterState::Time),
            _ => failed(),
        };
        lines.extend(journal.take(at(k), &snapshot));
    }
    assert_eq!(lines.len(), 10 + 1 + 10 + 1 + 1);
    assert!(
        lines
            .iter()
            .any(|n| n.text == "989 more changes in the last second"),
        "{lines:?}"
    );
}

#[test]
fn a_slave_that_is_held_back_is_named_with_its_distance() {
    let mut behind = following(Health::SlaveBehind { slave: 0 }, FilterState::Observer);
    behind.signals.slaves[0].distance = 0.5;
    let told = told(&[following(Health::Ok, FilterState::Observer), behind]);
    let text = "slave: 0.500000 u off the position of its coupling, where its limits hold it";
    assert!(as_texts(&told).contains(&(Level::Info, text)), "{told:#?}");
}
