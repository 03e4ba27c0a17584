//! The simulated sensor of a slave's registration marks.

use crate::marks::MarksConfig;

/// Detects each mark once, when the master has moved it to the sensor, and keeps it until it is
/// used or past the slave's position 0.
///
/// Like a touch probe, it captures the master's position at the exact moment between two cycles:
/// the mark's own position less the distance of the sensor, so only the number of the mark is kept.
/// It uses the master as the slave sees it, not its true position.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    marks: MarksConfig,
    /// Detected marks; none while there is no master.
    seen: Option<MarkNumbers>,
    /// The mark used last.
    used: Option<u64>,
}

/// Numbers of the detected marks.
#[derive(Clone, Copy, Debug)]
struct MarkNumbers {
    /// The oldest mark that is neither used nor past.
    oldest: u64,
    /// The next mark to reach the sensor.
    next: u64,
}

/// A mark to be used, and its distance from the one used before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SensorMark {
    /// Position of the master when the mark is at the slave's position 0, u of the master.
    pub(super) position: f64,
    /// Distance from the mark used before, u of the master; the first spacing if none was.
    pub(super) distance: f64,
}

impl Sensor {
    pub(super) const fn new(marks: MarksConfig) -> Self {
        Self {
            marks,
            seen: None,
            used: None,
        }
    }

    /// Runs one cycle with the master's position; none while it is not ready, which discards the
    /// detected marks.
    pub(super) fn look(&mut self, master: Option<f64>) {
        let Some(master) = master else {
            self.seen = None;
            return;
        };
        let at_sensor = master + self.marks.sensor_distance.get();
        let Some(seen) = &mut self.seen else {
            // Marks already between sensor and slave were not detected.
            let next = self.marks.first_beyond(at_sensor);
            self.seen = Some(MarkNumbers { oldest: next, next });
            return;
        };
        if self.marks.position(seen.next) <= at_sensor {
            seen.next = self.marks.first_beyond(at_sensor);
        }
        if seen.oldest < seen.next && self.marks.position(seen.oldest) <= master {
            seen.oldest = self.marks.first_beyond(master).min(seen.next);
        }
    }

    /// The oldest mark to be used.
    pub(super) fn mark(&self) -> Option<SensorMark> {
        let seen = self.seen.filter(|seen| seen.oldest < seen.next)?;
        let position = self.marks.position(seen.oldest);
        let before = self.used.map(|used| self.marks.position(used));
        Some(SensorMark {
            position,
            distance: before.map_or(self.marks.spacing.get(), |before| position - before),
        })
    }

    /// Marks the oldest mark as used.
    pub(super) fn use_up(&mut self) {
        if let Some(seen) = &mut self.seen
            && seen.oldest < seen.next
        {
            self.used = Some(seen.oldest);
            seen.oldest += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marks at 100, 700, 1300 …, detected 500 before.
    fn sensor() -> Sensor {
        let text = "first = 100\nspacing = 600\nsensor-distance = 500";
        Sensor::new(coaxle_node::config::parse("marks", text).expect("marks"))
    }

    fn position(sensor: &Sensor) -> Option<f64> {
        sensor.mark().map(|mark| mark.position)
    }

    #[test]
    fn a_mark_is_seen_when_it_is_at_the_sensor_and_not_before() {
        let mut sensor = sensor();
        sensor.look(Some(-450.0));
        assert_eq!(position(&sensor), None);
        sensor.look(Some(-400.001));
        assert_eq!(position(&sensor), None);
        sensor.look(Some(-399.9));
        assert_eq!(position(&sensor), Some(100.0));
    }

    #[test]
    fn a_mark_is_used_once_and_knows_the_one_before() {
        let mut sensor = sensor();
        sensor.look(Some(-450.0));
        sensor.look(Some(-400.0));
        let first = sensor.mark().unwrap();
        assert_eq!((first.position, first.distance), (100.0, 600.0));
        sensor.use_up();
        assert_eq!(sensor.mark(), None);
        // Back and forth over the same place.
        sensor.look(Some(-500.0));
        sensor.look(Some(-300.0));
        assert_eq!(sensor.mark(), None);
        // The next mark passes unused.
        sensor.look(Some(750.0));
        sensor.look(Some(800.0));
        let third = sensor.mark().unwrap();
        assert_eq!((third.position, third.distance), (1300.0, 1200.0));
    }

    #[test]
    fn what_passes_the_slave_unused_is_forgotten() {
        let mut sensor = sensor();
        sensor.look(Some(-450.0));
        sensor.look(Some(-350.0));
        sensor.look(Some(99.0));
        assert_eq!(position(&sensor), Some(100.0));
        sensor.look(Some(100.0));
        assert_eq!(position(&sensor), None);
        sensor.look(Some(1e9));
        assert!(position(&sensor).is_some_and(|mark| mark > 1e9));
    }

    #[test]
    fn a_new_master_is_looked_at_anew() {
        let mut sensor = sensor();
        sensor.look(Some(-450.0));
        sensor.look(Some(-350.0));
        sensor.look(None);
        assert_eq!(position(&sensor), None);
        // Marks that passed the sensor meanwhile were not detected.
        sensor.look(Some(250.0));
        assert_eq!(position(&sensor), None);
        sensor.look(Some(900.0));
        assert_eq!(position(&sensor), Some(1300.0));
    }

    #[test]
    fn nothing_seen_nothing_used() {
        let mut sensor = sensor();
        sensor.use_up();
        sensor.look(Some(0.0));
        sensor.use_up();
        assert_eq!(sensor.mark(), None);
    }
}
