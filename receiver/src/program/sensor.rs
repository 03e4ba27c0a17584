//! The simulated sensor of a slave's registration marks.

use crate::marks::MarksConfig;

/// Sees each mark once, when the master has moved it to the sensor, and remembers it until it is
/// used or past the slave's position 0.
///
/// As a touch probe does, it takes the master's position at the very moment, between two cycles:
/// that is the mark's own position less the distance of the sensor, so nothing but the number of
/// the mark is kept. It looks at the master as the slave has it, not at what is truly there.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    marks: MarksConfig,
    /// None as long as there is no master.
    seen: Option<Seen>,
    /// The mark used last.
    used: Option<u64>,
}

/// Numbers of marks.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// The oldest that is neither used nor past.
    oldest: u64,
    /// The next to come to the sensor.
    next: u64,
}

/// A mark to be used, and how far it is from the one that was used before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mark {
    /// Where the master is when it is at the slave's position 0, u of the master.
    pub(super) position: f64,
    /// From the mark used before, u of the master; the first spacing if none was.
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

    /// One cycle. The master's position, none as long as it is not ready: then what was seen of it
    /// is worth nothing any more.
    pub(super) fn look(&mut self, master: Option<f64>) {
        let Some(master) = master else {
            self.seen = None;
            return;
        };
        let at_sensor = master + self.marks.sensor_distance.get();
        let Some(seen) = &mut self.seen else {
            // What lies between sensor and slave already was not seen.
            let next = self.marks.first_beyond(at_sensor);
            self.seen = Some(Seen { oldest: next, next });
            return;
        };
        if self.marks.position(seen.next) <= at_sensor {
            seen.next = self.marks.first_beyond(at_sensor);
        }
        if seen.oldest < seen.next && self.marks.position(seen.oldest) <= master {
            seen.oldest = self.marks.first_beyond(master).min(seen.next);
        }
    }

    /// The oldest mark that is to be used.
    pub(super) fn mark(&self) -> Option<Mark> {
        let seen = self.seen.filter(|seen| seen.oldest < seen.next)?;
        let position = self.marks.position(seen.oldest);
        let before = self.used.map(|used| self.marks.position(used));
        Some(Mark {
            position,
            distance: before.map_or(self.marks.spacing.get(), |before| position - before),
        })
    }

    /// It was used.
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

    /// Marks at 100, 700, 1300 …, seen 500 before.
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
        // Nobody uses the next one, which passes.
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
        // What has passed the sensor meanwhile was not seen.
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
