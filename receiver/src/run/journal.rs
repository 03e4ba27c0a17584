//! What of a receiver's life is worth a line in the log.

use coaxle_clock::delay::DelayState;
use coaxle_clock::{Instant, Seconds, Span};
use coaxle_host::Machine;
use coaxle_node::keys::NodeName;

use super::fault::Fault;
use crate::record::StateName;
use crate::snapshot::{Health, MasterSnapshot, ReceiverSnapshot};

/// Looks for changes from cycle to cycle.
#[derive(Debug, Default)]
pub(super) struct Journal {
    before: Option<ReceiverSnapshot>,
    window: Option<Window>,
}

/// A line for the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Note {
    pub(super) level: Level,
    pub(super) text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    Info,
    Warning,
    Error,
}

/// A receiver that falls out of sync and back hundreds of times a second must not flood the log.
const MOST_LINES: u32 = 10;
/// So many lines, and no more, in each stretch of this length.
const WINDOW: Span = Span::from_secs(1);

#[derive(Debug)]
struct Window {
    began: Instant<Machine>,
    lines: u32,
    left_out: u32,
}

impl Journal {
    /// What a cycle has changed.
    pub(super) fn take(&mut self, at: Instant<Machine>, now: &ReceiverSnapshot) -> Vec<Note> {
        let mut notes = match self.before.replace(*now) {
            Some(before) => changes(&before, now),
            None => Vec::new(),
        };
        self.keep_short(at, &mut notes);
        notes
    }

    fn keep_short(&mut self, at: Instant<Machine>, notes: &mut Vec<Note>) {
        let window = self.window.get_or_insert(Window::beginning(at));
        let mut left_out = 0;
        if at - window.began >= WINDOW {
            left_out = window.left_out;
            *window = Window::beginning(at);
        }
        let room = MOST_LINES.saturating_sub(window.lines) as usize;
        window.left_out += notes.len().saturating_sub(room) as u32;
        notes.truncate(room);
        window.lines += notes.len() as u32;
        if left_out > 0 {
            let text = format!("{left_out} more changes in the last second");
            notes.insert(0, Note::new(Level::Warning, text));
        }
    }
}

impl Window {
    const fn beginning(at: Instant<Machine>) -> Self {
        Self {
            began: at,
            lines: 0,
            left_out: 0,
        }
    }
}

impl Note {
    fn new(level: Level, text: impl Into<String>) -> Self {
        Self {
            level,
            text: text.into(),
        }
    }

    pub(super) fn log(&self, node: &NodeName) {
        let text = &self.text;
        match self.level {
            Level::Info => tracing::info!(%node, "{text}"),
            Level::Warning => tracing::warn!(%node, "{text}"),
            Level::Error => tracing::error!(%node, "{text}"),
        }
    }
}

fn changes(before: &ReceiverSnapshot, now: &ReceiverSnapshot) -> Vec<Note> {
    let mut notes = Vec::new();
    if now.counters.restarts > before.counters.restarts {
        notes.push(Note::new(Level::Warning, "the master's node has restarted"));
    }
    if now.health != before.health {
        notes.push(health(now));
    }
    notes.extend(delay(before, now));
    let warning = |snapshot: &ReceiverSnapshot| snapshot.master.and_then(|m| m.warning);
    if let Some(warning) = warning(now).filter(|_| warning(before).is_none()) {
        let fault = Fault::from(warning);
        notes.push(Note::new(Level::Warning, format!("warning {fault}")));
    }
    notes
}

/// That the delay was measured, and that its measurement grew old.
fn delay(before: &ReceiverSnapshot, now: &ReceiverSnapshot) -> Option<Note> {
    let delay = now.delay?;
    if before
        .delay
        .is_some_and(|before| before.state == delay.state)
    {
        return None;
    }
    let micros = |seconds: Option<Seconds>| seconds.map_or(f64::NAN, Seconds::as_micros);
    let value = micros(delay.delay);
    match delay.state {
        DelayState::Measured => Some(Note::new(
            Level::Info,
            format!(
                "delay measured: {value:.1} µs, at most {:.1} µs off",
                micros(delay.uncertainty)
            ),
        )),
        DelayState::Stale => Some(Note::new(
            Level::Warning,
            format!("the master answers no questions any more; the delay stays {value:.1} µs"),
        )),
        DelayState::Off | DelayState::Fixed | DelayState::Asking => None,
    }
}

fn health(now: &ReceiverSnapshot) -> Note {
    match (now.health, &now.master) {
        (Health::Ok, Some(master)) => Note::new(Level::Info, well(master)),
        (Health::StartingUp, Some(master)) => {
            let state = StateName::from(master.state).as_str();
            let text = format!("starting up in {state} mode until the far clock's drift is known");
            Note::new(Level::Info, text)
        }
        (Health::MasterSilent, Some(master)) => {
            let text = format!(
                "no new data from the master for {} cycles",
                master.age_cycles
            );
            Note::new(Level::Warning, text)
        }
        _ => match Fault::of(now) {
            Some(fault) => {
                let state = now.master.map(|m| StateName::from(m.state).as_str());
                let means = match state {
                    Some(state) => format!("set values in {state} mode"),
                    None => "no set values".to_owned(),
                };
                Note::new(Level::Error, format!("error {fault}; {means}"))
            }
            None => Note::new(Level::Info, now.health.name().as_str()),
        },
    }
}

fn well(master: &MasterSnapshot) -> String {
    match StateName::from(master.state) {
        StateName::Sync => format!(
            "synchronised after {} beats, drift {:+.2} ppm",
            master.beats, master.drift_ppm
        ),
        StateName::Observer => format!("synchronised, drift {:+.2} ppm", master.drift_ppm),
        state => format!("follows the master in {} mode", state.as_str()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ReceiverConfig;
    use crate::node::Receiver;
    use coaxle_clock::CycleIndex;
    use coaxle_clock::time_sync::{SyncError, SyncWarning};
    use coaxle_motion::profile::Kinematics;
    use coaxle_motion::remote::FilterState;
    use coaxle_motion::slave::SlaveError;
    use coaxle_node::Node;
    use coaxle_node::config::parse;

    fn waiting() -> ReceiverSnapshot {
        let text = "name = 'saw'\ncycle-time-us = 1000\nmaster.node = 'conveyor'";
        let config: ReceiverConfig = parse("r", text).unwrap();
        Receiver::new(&config, Instant::EPOCH, 1)
            .unwrap()
            .snapshot()
    }

    fn following(health: Health, state: FilterState) -> ReceiverSnapshot {
        ReceiverSnapshot {
            health,
            master: Some(MasterSnapshot {
                epoch: 1,
                index: CycleIndex(1),
                count: 1,
                age_cycles: 1_001,
                received: Kinematics::default(),
                corrected: Kinematics::default(),
                far_time: None,
                state,
                synced: state == FilterState::Sync,
                error: None,
                warning: None,
                beats: 2,
                correction_time: None,
                drift_ppm: -12.345,
            }),
            ..waiting()
        }
    }

    fn failed() -> ReceiverSnapshot {
        let error = SyncError::MaxDataAgeExceeded;
        let mut snapshot = following(Health::Error(error), FilterState::Pt1);
        if let Some(master) = &mut snapshot.master {
            master.error = Some(error);
        }
        snapshot
    }

    fn at(millis: i64) -> Instant<Machine> {
        Instant::EPOCH + Span::from_millis(millis)
    }

    #[test]
    fn each_change_is_told_once() {
        let mut warned = following(Health::Ok, FilterState::Sync);
        if let Some(master) = &mut warned.master {
            master.warning = Some(SyncWarning::DriftChangedSignificantly);
        }
        let mut restarted = warned;
        restarted.counters.restarts = 1;
        let mut tripped = following(Health::DriveTripped, FilterState::Time);
        if let Some(slave) = &mut tripped.slaves[0] {
            slave.error = Some(SlaveError::FollowingError {
                following_error: 3.0,
            });
        }
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
        let mut journal = Journal::default();
        let mut told = Vec::new();
        for (k, snapshot) in (0..).zip(&life) {
            told.extend(journal.take(at(1_000 * k), snapshot));
            assert_eq!(journal.take(at(1_000 * k + 1), snapshot), []);
        }
        let told: Vec<_> = told.iter().map(|n| (n.level, n.text.as_str())).collect();
        assert_eq!(
            told,
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
                (Level::Warning, "the master's node has restarted"),
                (
                    Level::Error,
                    "error 0x4b52: no new data for too long; set values in pt1 mode"
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
    fn a_receiver_that_flutters_does_not_flood_the_log() {
        let mut journal = Journal::default();
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
}
