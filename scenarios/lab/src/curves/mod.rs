//! Curves of a run for its pictures, of bounded size for runs of any length.

mod drawn;
mod series;
mod windows;

use coaxle_node::config::Unit;
use coaxle_receiver::FilterState;

use crate::record::ReceiverCycle;
use crate::row::Row;
pub(crate) use drawn::Drawn;
pub use series::joined;
pub use series::{Series, Stretch};
use windows::EventWatch;
pub use windows::{CurveWindow, WindowEvent};

/// The curves of one receiver.
#[derive(Clone, Debug)]
pub struct Curves {
    /// The receiver's name.
    pub name: String,
    /// The receiver's mode.
    pub mode: &'static str,
    /// Unit of its master.
    pub unit: Unit,
    /// Difference quotient of the set position given to the drive, slave units/s.
    pub set_velocity: Series,
    /// Actual velocity of the drive, slave units/s.
    pub drive_velocity: Series,
    /// Correction time, µs.
    pub correction_us: Series,
    /// Corrected far time minus true far time, µs.
    pub time_error_us: Series,
    /// Estimated drift, ppm.
    pub drift_ppm: Series,
    /// Every slave.
    pub slaves: Vec<SlaveCurve>,
    /// The changes of state: time, s, and new state.
    pub states: Vec<(f64, Option<FilterState>)>,
    /// Every cycle around one beat.
    pub around_beat: Vec<Row>,
    /// Events that every receiver's cycles are kept around.
    pub windows: Vec<CurveWindow>,
    /// Own cycle time, s.
    cycle_s: f64,
    watch: EventWatch,
    recent: std::collections::VecDeque<Row>,
    beats: u32,
    capturing: bool,
}

/// A slave's curve.
#[derive(Clone, Debug)]
pub struct SlaveCurve {
    /// The slave's name.
    pub name: String,
    /// Unit of its position.
    pub unit: Unit,
    /// Set position, u.
    pub position: Series,
}

/// Cycles shown before a beat is detected, and after.
// TS5066 detects a beat a plateau of 90 cycles after it (`end_of_transition_limit`).
const BEFORE: usize = 200;
const AFTER: usize = 100;
/// Changes of state kept; a receiver that changes more often is a blur anyhow.
const MOST_STATES: usize = 20_000;

impl Curves {
    /// No curves yet of a receiver of this cycle time (s), with slaves of these names and units.
    #[must_use]
    pub fn new<'a>(
        name: &str,
        mode: &'static str,
        unit: Unit,
        cycle_s: f64,
        slaves: impl IntoIterator<Item = (&'a str, Unit)>,
    ) -> Self {
        let slave = |(name, unit): (&str, Unit)| SlaveCurve {
            name: name.to_owned(),
            unit,
            position: Series::default(),
        };
        Self {
            name: name.to_owned(),
            mode,
            unit,
            set_velocity: Series::default(),
            drive_velocity: Series::default(),
            correction_us: Series::default(),
            time_error_us: Series::default(),
            drift_ppm: Series::default(),
            slaves: slaves.into_iter().map(slave).collect(),
            states: Vec::new(),
            around_beat: Vec::new(),
            windows: Vec::new(),
            cycle_s,
            watch: EventWatch::default(),
            recent: std::collections::VecDeque::with_capacity(BEFORE),
            beats: 0,
            capturing: false,
        }
    }

    /// Unit of the drive: that of the first slave, or of the master without slaves.
    #[must_use]
    pub fn drive_unit(&self) -> &Unit {
        self.slaves.first().map_or(&self.unit, |slave| &slave.unit)
    }

    /// Takes the next cycle. The first beat that counts for the figures is shown in full. Returns a window around an event,
    /// to [`keep`](Self::keep) every cycle of it, of all receivers.
    #[must_use]
    pub fn push(&mut self, row: &Row) -> Option<CurveWindow> {
        let t = row.t_s;
        let record = &row.record;
        self.set_velocity.push(t, row.set_velocity);
        self.drive_velocity
            .push(t, record.slave().map(|slave| slave.drive_velocity));
        self.correction_us.push(t, record.axis.correction_us);
        self.time_error_us.push(t, row.time_error_us);
        self.drift_ppm
            // Zero stands for an estimate that is not there yet.
            .push(t, record.far.drift_ppm.filter(|ppm| *ppm != 0.0));
        for (curve, slave) in self.slaves.iter_mut().zip(&record.slaves) {
            curve.position.push(t, slave.position);
        }
        self.push_state(t, record);
        self.capture(row);
        let window = self.watch.look(t, self.cycle_s, record);
        self.windows.extend(window.clone());
        window
    }

    /// Keeps every cycle from one time to another, s.
    pub fn keep(&mut self, from_s: f64, to_s: f64) {
        let own = [
            &mut self.set_velocity,
            &mut self.drive_velocity,
            &mut self.correction_us,
            &mut self.time_error_us,
            &mut self.drift_ppm,
        ];
        let slaves = self.slaves.iter_mut().map(|slave| &mut slave.position);
        for series in own.into_iter().chain(slaves) {
            series.keep(from_s, to_s);
        }
    }

    fn push_state(&mut self, t: f64, record: &ReceiverCycle) {
        let changed = self
            .states
            .last()
            .is_none_or(|last| last.1 != record.axis.state);
        if changed && self.states.len() < MOST_STATES {
            self.states.push((t, record.axis.state));
        }
    }

    fn capture(&mut self, row: &Row) {
        let beat = row.record.far.beats > self.beats;
        self.beats = row.record.far.beats;
        if self.capturing {
            if self.around_beat.len() < BEFORE + AFTER {
                self.around_beat.push(row.clone());
            }
            return;
        }
        let is_full = self.recent.len() == BEFORE;
        match is_full.then(|| self.recent.pop_front()).flatten() {
            Some(mut oldest) => {
                // The oldest row's buffers are used again: nothing is allocated in the cycles of a long run.
                oldest.clone_from(row);
                self.recent.push_back(oldest);
            }
            None => self.recent.push_back(row.clone()),
        }
        // Beats of the lock-in are no example of what a correction makes of them.
        if beat && row.evaluated {
            self.capturing = true;
            self.around_beat.extend(self.recent.drain(..));
        }
    }
}
