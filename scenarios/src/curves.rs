//! What is kept of a run for its pictures, however long it lasts.

use coaxle_node::config::Unit;
use coaxle_receiver::StateName;

use crate::record::Record;
use crate::row::Row;

/// The curves of one receiver.
#[derive(Clone, Debug)]
pub struct Curves {
    /// The receiver's name.
    pub name: String,
    /// Its mode.
    pub mode: &'static str,
    /// What its master is in.
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
    /// The changes of state: from when (s), and which.
    pub states: Vec<(f64, Option<StateName>)>,
    /// Every cycle around one beat.
    pub around_beat: Vec<Row>,
    recent: std::collections::VecDeque<Row>,
    beats: u32,
    capturing: bool,
}

/// A slave's curve.
#[derive(Clone, Debug)]
pub struct SlaveCurve {
    /// The slave's name.
    pub name: String,
    /// What its position is in.
    pub unit: Unit,
    /// Set position, u.
    pub position: Series,
}

/// Cycles shown before a beat is detected, and after.
const BEFORE: usize = 200;
const AFTER: usize = 100;
/// Changes of state kept; a receiver that changes more often is a blur anyhow.
const MOST_STATES: usize = 20_000;

impl Curves {
    /// No curves yet of a receiver with slaves of these names and units.
    #[must_use]
    pub fn new<'a>(
        name: &str,
        mode: &'static str,
        unit: Unit,
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
            recent: std::collections::VecDeque::with_capacity(BEFORE),
            beats: 0,
            capturing: false,
        }
    }

    /// What the drive is in: the unit of the first slave, or of the master where there is none.
    #[must_use]
    pub fn drive_unit(&self) -> &Unit {
        self.slaves.first().map_or(&self.unit, |slave| &slave.unit)
    }

    /// The next cycle. `evaluated` tells whether it counts for the figures: the beat that is shown
    /// in full is the first one that does.
    pub fn push(&mut self, row: &Row, evaluated: bool) {
        let t = row.t_s;
        let record = &row.record;
        self.set_velocity.push(t, row.set_velocity);
        self.drive_velocity
            .push(t, record.slave().map(|slave| slave.drive_velocity));
        self.correction_us.push(t, record.axis.correction_us);
        self.time_error_us.push(t, row.time_error_us);
        self.drift_ppm
            .push(t, record.far.drift_ppm.filter(|ppm| *ppm != 0.0));
        for (curve, slave) in self.slaves.iter_mut().zip(&record.slaves) {
            curve.position.push(t, slave.position);
        }
        self.push_state(t, record);
        self.capture(row, evaluated);
    }

    fn push_state(&mut self, t: f64, record: &Record) {
        let changed = self
            .states
            .last()
            .is_none_or(|last| last.1 != record.axis.state);
        if changed && self.states.len() < MOST_STATES {
            self.states.push((t, record.axis.state));
        }
    }

    fn capture(&mut self, row: &Row, evaluated: bool) {
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
                oldest.clone_from(row);
                self.recent.push_back(oldest);
            }
            None => self.recent.push_back(row.clone()),
        }
        if beat && evaluated {
            self.capturing = true;
            self.around_beat.extend(self.recent.drain(..));
        }
    }
}

/// A curve of bounded size: the smallest and the largest value of each stretch of time, so that no
/// spike is ever lost.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// The stretches, in order.
    pub stretches: Vec<Stretch>,
    /// Values per stretch.
    per_stretch: u32,
    filled: u32,
}

/// The values of a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// When it begins, s.
    pub t_s: f64,
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

/// Stretches kept at most.
const MOST_STRETCHES: usize = 4_000;

impl Series {
    /// The next value; none is a gap.
    pub fn push(&mut self, t_s: f64, value: Option<f64>) {
        let Some(value) = value.filter(|value| value.is_finite()) else {
            return;
        };
        match self.stretches.last_mut() {
            Some(last) if self.filled < self.per_stretch => {
                last.low = last.low.min(value);
                last.high = last.high.max(value);
                self.filled += 1;
            }
            _ => {
                self.make_room();
                self.stretches.push(Stretch {
                    t_s,
                    low: value,
                    high: value,
                });
                self.filled = 1;
            }
        }
    }

    fn make_room(&mut self) {
        self.per_stretch = self.per_stretch.max(1);
        if self.stretches.len() < MOST_STRETCHES {
            return;
        }
        let merged = self.stretches.chunks(2).map(|pair| Stretch {
            t_s: pair[0].t_s,
            low: pair.iter().fold(f64::INFINITY, |low, s| low.min(s.low)),
            high: pair
                .iter()
                .fold(f64::NEG_INFINITY, |high, s| high.max(s.high)),
        });
        self.stretches = merged.collect();
        self.per_stretch *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_stays_small_and_keeps_its_spikes() {
        let mut series = Series::default();
        for k in 0..1_000_000 {
            let value = if k == 777_777 { 5.0 } else { 1.0 };
            series.push(f64::from(k), Some(value));
        }
        assert!(series.stretches.len() <= MOST_STRETCHES);
        let spikes = series.stretches.iter().filter(|s| s.high == 5.0).count();
        assert_eq!(spikes, 1);
        assert!(series.stretches.is_sorted_by_key(|s| s.t_s));
    }
}
