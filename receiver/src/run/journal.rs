//! Log events of a receiver.

mod common_time;
mod delay;
mod late_frames;
mod plans;
mod standby;
mod wraps;

use coaxle_clock::time_sync::{SyncError, SyncWarning};
use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_os::Machine;

use super::fault::Fault;
use crate::config::ReceiverConfig;
use crate::health::Health;
use crate::program::ProgramState;
use crate::signals::FarNodeSignals;
use crate::snapshot::ReceiverSnapshot;
use coaxle_remote::{ContinuityState, FilterState};
use common_time::clocks_disagree;
use delay::{Asked, delay, denied};
use late_frames::LateFrames;
use plans::{of_contradictions, of_refusals};
use standby::{Heard, heard, standing_by, taken_over};
use wraps::of_wraps;

/// Detects changes from cycle to cycle.
#[derive(Debug)]
pub(super) struct Journal {
    /// The nodes received from.
    far: Vec<Heard>,
    /// The names of the far axes.
    far_axes: Vec<String>,
    /// The names of the virtual axes.
    virtual_axes: Vec<String>,
    /// The names of the slaves.
    slaves: Vec<String>,
    before: Option<ReceiverSnapshot>,
    /// State of the unanswered time requests to each node received from.
    asked: Vec<Asked>,
    /// Frames of each node received from that come too late to be shown.
    late: Vec<LateFrames>,
    window: Option<NoteWindow>,
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

impl From<Level> for coaxle_recording::Level {
    fn from(level: Level) -> Self {
        match level {
            Level::Info => Self::Info,
            Level::Warning => Self::Warning,
            Level::Error => Self::Error,
        }
    }
}

/// Greatest number of lines per window: a receiver that loses and regains sync hundreds of times a
/// second must not flood the log.
const MOST_LINES: u32 = 10;
/// Length of the window for this number of lines.
const WINDOW: Span = Span::from_secs(1);

#[derive(Debug)]
struct NoteWindow {
    began: Instant<Machine>,
    lines: u32,
    left_out: u32,
}

impl Journal {
    pub(super) fn new(config: &ReceiverConfig) -> Self {
        Self {
            far: heard(config),
            far_axes: config.far_axis_names(),
            virtual_axes: config.virtual_axis_names(),
            slaves: config
                .slaves
                .iter()
                .map(|slave| slave.name.to_string())
                .collect(),
            before: None,
            asked: Vec::new(),
            late: Vec::new(),
            window: None,
        }
    }

    /// Log lines on the changes of a cycle.
    pub(super) fn take(&mut self, at: Instant<Machine>, now: &ReceiverSnapshot) -> Vec<Note> {
        let mut notes = match &mut self.before {
            Some(before) => {
                let mut notes = changes(before, now, &self.far, &self.slaves);
                notes.extend(of_wraps(before, now, &self.far_axes));
                notes.extend(of_contradictions(before, now, &self.far_axes));
                notes.extend(of_virtual_axes(before, now, &self.virtual_axes));
                notes.extend(of_programs(before, now, &self.slaves));
                // Into the memory of the last one, in each cycle.
                before.clone_from(now);
                notes
            }
            None => {
                self.before = Some(now.clone());
                self.asked = self.far.iter().map(|_| Asked::default()).collect();
                self.late = self.far.iter().map(|_| LateFrames::default()).collect();
                Vec::new()
            }
        };
        for ((asked, heard), signals) in self.asked.iter_mut().zip(&self.far).zip(&now.signals.far)
        {
            let note = asked.in_vain(at, signals);
            notes.extend(note.map(|note| about(heard, self.far.len(), note)));
        }
        for ((late, heard), signals) in self.late.iter_mut().zip(&self.far).zip(&now.signals.far) {
            let note = late.too_late(at, signals);
            notes.extend(note.map(|note| about(heard, self.far.len(), note)));
        }
        self.keep_short(at, &mut notes);
        notes
    }

    fn keep_short(&mut self, at: Instant<Machine>, notes: &mut Vec<Note>) {
        let window = self.window.get_or_insert(NoteWindow::beginning(at));
        let mut left_out = 0;
        if at - window.began >= WINDOW {
            left_out = window.left_out;
            *window = NoteWindow::beginning(at);
        }
        let room = MOST_LINES.saturating_sub(window.lines) as usize;
        window.left_out += notes.len().saturating_sub(room) as u32;
        // The first ones stay: causes come before their effects.
        notes.truncate(room);
        window.lines += notes.len() as u32;
        // In the next window, when the number is final.
        if left_out > 0 {
            let text = format!("{left_out} more changes in the last second");
            notes.insert(0, Note::new(Level::Warning, text));
        }
    }
}

impl NoteWindow {
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

/// Adds the node's name to a line where there are several nodes.
fn about(node: &Heard, of: usize, mut note: Note) -> Note {
    if of > 1 {
        note.text = format!("{}: {}", node.name, note.text);
    }
    note
}

fn changes(
    before: &ReceiverSnapshot,
    now: &ReceiverSnapshot,
    heard: &[Heard],
    slaves: &[String],
) -> Vec<Note> {
    let mut notes = Vec::new();
    let pairs = before.signals.far.iter().zip(&now.signals.far);
    for (n, (signals, changed)) in pairs.enumerate() {
        let mut own = changes_of_far(signals, changed);
        own.extend(of_refusals(signals, changed));
        let health = now.far_health[n];
        let taken_over = taken_over(before, now, heard, n);
        let is_told = match health {
            Health::OnStandby => taken_over.is_some(),
            // A standby's own line reports that it stands by.
            _ if heard[n].is_standby => !matches!(
                health,
                Health::TwoSenders | Health::CycleTimesDoNotFit | Health::PaceOutOfRange
            ),
            _ => false,
        };
        own.extend(taken_over);
        if health != before.far_health[n] && !is_told && !is_of_a_slave(now.health) {
            // Behind the cause, a restart say, where there is one.
            own.insert(
                usize::from(!own.is_empty()),
                health_of_far(now, n, &heard[n]),
            );
        }
        own.extend(standing_by(signals, changed));
        let about = |note| about(&heard[n], heard.len(), note);
        notes.extend(own.into_iter().map(about));
    }
    if now.health != before.health && is_of_a_slave(now.health) {
        notes.push(match now.health {
            Health::SlaveBehind { slave } => behind(now, slave, &slaves[slave]),
            _ => failure(now, Fault::of(now)),
        });
    }
    notes
}

/// Log lines on virtual axes that went into error, or out of it.
fn of_virtual_axes(
    before: &ReceiverSnapshot,
    now: &ReceiverSnapshot,
    names: &[String],
) -> Vec<Note> {
    let of = |snapshot: &ReceiverSnapshot, n: usize| snapshot.signals.virtual_axes[n].error;
    let changed = names.iter().enumerate().filter_map(|(n, name)| {
        let error = of(now, n);
        // Changes only: an error that lasts has one line.
        (error != of(before, n)).then(|| match Fault::of_virtual_axis(error) {
            Some(fault) => Note::new(Level::Error, format!("{name}: error {fault}")),
            None => Note::new(Level::Info, format!("{name}: moves again")),
        })
    });
    changed.collect()
}

/// Log lines on programs that wait for an order.
fn of_programs(before: &ReceiverSnapshot, now: &ReceiverSnapshot, names: &[String]) -> Vec<Note> {
    let of = |snapshot: &ReceiverSnapshot, n: usize| {
        let slave = &snapshot.signals.slaves[n];
        let waits = slave.program == Some(ProgramState::WaitingForOrder);
        let waits_for = slave.program_waits_for.filter(|_| waits)?;
        Some((slave.program_step?, waits_for))
    };
    let begun = names.iter().enumerate().filter_map(|(n, name)| {
        let (step, waits_for) = of(now, n).filter(|waits| of(before, n) != Some(*waits))?;
        let text = format!(
            "{name}: step {step} of the program waits for {waits_for}, which only an order can bring"
        );
        Some(Note::new(Level::Info, text))
    });
    begun.collect()
}

const fn is_of_a_slave(health: Health) -> bool {
    matches!(
        health,
        Health::DriveTripped
            | Health::SlaveFailed { .. }
            | Health::Circle
            | Health::CommandRefused { .. }
            | Health::ProgramBlocked { .. }
            | Health::SlaveBehind { .. }
    )
}

fn changes_of_far(before: &FarNodeSignals, now: &FarNodeSignals) -> Vec<Note> {
    let mut notes = Vec::new();
    notes.extend(another_run(before, now));
    notes.extend(drift_step(before, now));
    notes.extend(delay(before, now));
    notes.extend(denied(before, now));
    notes.extend(orders(before, now));
    // Warnings come and go with the drift: each beginning has a line.
    if now.warning != 0 && before.warning == 0 {
        let fault = Fault::from(SyncWarning::DriftChangedSignificantly);
        notes.push(Note::new(Level::Warning, format!("warning {fault}")));
    }
    notes
}

/// Log line on another run that is followed: of the node itself, or of a duplicate sender.
fn another_run(before: &FarNodeSignals, now: &FarNodeSignals) -> Option<Note> {
    if now.restarts <= before.restarts {
        return None;
    }
    let text = match (before.epoch, now.epoch) {
        (Some(before), Some(now)) if before == now => {
            format!("the master's node goes on with another count of its run: epoch {now}")
        }
        (Some(before), Some(now)) => {
            format!("the master's node has restarted: epoch {now} after {before}")
        }
        _ => "the master's node has restarted".to_owned(),
    };
    Some(Note::new(Level::Warning, text))
}

/// Log line on a step of the drift, after which the line was searched again.
fn drift_step(before: &FarNodeSignals, now: &FarNodeSignals) -> Option<Note> {
    // A drift that is not known is no drift of 0.
    let [was, is] = [before, now].map(|signals| signals.drift_ppm.unwrap_or(f64::NAN));
    (now.drift_steps > before.drift_steps).then(|| {
        let text = format!("the drift has changed at once, from {was:+.1} to about {is:+.1} ppm");
        Note::new(Level::Warning, text)
    })
}

/// Log lines on changes by orders.
fn orders(before: &FarNodeSignals, now: &FarNodeSignals) -> impl Iterator<Item = Note> {
    let mode = now.mode.name();
    let notes = [
        // Before its first cycle a node is shown disabled.
        (before.enabled && before.mode != now.mode)
            .then(|| format!("by an order: {mode} mode from now on")),
        (now.re_initialisations > before.re_initialisations)
            .then(|| "by an order: its clock starts anew".to_owned()),
        (now.parameter_changes > before.parameter_changes)
            .then(|| "by an order: other parameters from now on".to_owned()),
    ];
    let note = |text: String| Note::new(Level::Info, text);
    notes.into_iter().flatten().map(note)
}

fn health_of_far(now: &ReceiverSnapshot, n: usize, heard: &Heard) -> Note {
    let signals = &now.signals.far[n];
    let state = now.state_of(n).map(FilterState::name);
    match (now.far_health[n], state) {
        (Health::Ok, Some(_)) => Note::new(Level::Info, well(signals, now.state_of(n))),
        (Health::StartingUp, Some(state)) => {
            let text = format!("starting up in {state} mode until the far clock's drift is known");
            Note::new(Level::Info, text)
        }
        (Health::Disabled, _) => Note::new(
            Level::Warning,
            "disabled by an order: the axes pass through as they come",
        ),
        (Health::MasterSilent, _) => {
            let text = format!(
                "no new data from the master for {} cycles",
                signals.age_cycles
            );
            Note::new(Level::Warning, text)
        }
        (Health::NoStandby, _) => Note::new(
            Level::Warning,
            "followed, but none of its standbys could take over",
        ),
        (Health::OnStandby, _) => Note::new(Level::Warning, "a standby is followed"),
        (Health::ClocksDisagree, _) => Note::new(Level::Warning, clocks_disagree(signals)),
        (Health::TwoSenders, _) => Note::new(
            Level::Error,
            "a second node of the same name publishes the same axes: the first one is followed, as long as it is heard",
        ),
        (health, _) => match Fault::of_far(now, n) {
            Some(fault) if health == Health::Error(SyncError::MaxDataAgeExceeded) => {
                let Heard {
                    age_limit,
                    ordinary_limit,
                    ..
                } = heard;
                let text = format!(
                    "error {fault}: {} own cycles, more than sync.time-sync.age-of-data-limit permits, in the config {age_limit}{}; {}",
                    signals.age_cycles,
                    advice(*age_limit, *ordinary_limit),
                    effect(now, n)
                );
                Note::new(Level::Error, text)
            }
            Some(fault) => means(fault, now, n),
            None => Note::new(Level::Info, health.name().name()),
        },
    }
}

/// Advice about a limit that is too low for an ordinary PC.
fn advice(age_limit: u32, ordinary: u32) -> String {
    match age_limit < ordinary {
        true => format!(" (on a PC without real-time priority {ordinary}, or more)"),
        false => String::new(),
    }
}

/// Log line on a slave's fault.
fn failure(now: &ReceiverSnapshot, fault: Option<Fault>) -> Note {
    match fault {
        // Without a far node there is no mode.
        Some(fault) if now.signals.far.is_empty() => {
            Note::new(Level::Error, format!("error {fault}"))
        }
        Some(fault) => means(fault, now, 0),
        None => Note::new(Level::Info, now.health.name().name()),
    }
}

/// Log line on a slave that is not where its coupling has it.
fn behind(now: &ReceiverSnapshot, slave: usize, name: &str) -> Note {
    let distance = now.signals.slaves[slave].distance;
    let text = format!(
        "{name}: {distance:.6} u off the position of its coupling, where its limits hold it"
    );
    Note::new(Level::Info, text)
}

/// Log line on a fault, with its effect on the axes of a far node.
fn means(fault: Fault, now: &ReceiverSnapshot, far: usize) -> Note {
    let effect = effect(now, far);
    Note::new(Level::Error, format!("error {fault}; {effect}"))
}

/// Effect of a fault on the axes of a far node.
fn effect(now: &ReceiverSnapshot, far: usize) -> String {
    match (now.continuity_of(far), now.state_of(far)) {
        (Some(ContinuityState::Braking), _) => "the axis is braked, or at rest".to_owned(),
        (Some(ContinuityState::Rejoining), _) => "the axis is brought back".to_owned(),
        (_, Some(state)) => format!("set values in {} mode", state.name()),
        (_, None) => "no set values".to_owned(),
    }
}

fn well(signals: &FarNodeSignals, state: Option<FilterState>) -> String {
    let drift = signals.drift_ppm.unwrap_or_default();
    match state {
        Some(FilterState::Sync) => format!(
            "synchronised after {} beats, drift {drift:+.2} ppm",
            signals.beats
        ),
        Some(FilterState::Observer) => format!("synchronised, drift {drift:+.2} ppm"),
        Some(state) => format!("follows the master in {} mode", state.name()),
        None => "ok".to_owned(),
    }
}

#[cfg(test)]
mod tests;
