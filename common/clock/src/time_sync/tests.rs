mod beats;
mod faults;
mod parameters;

use super::*;

const CYCLE: Span = Span::from_millis(1);

/// A far sender as the receiver's cycles see it: no jitter, so that every figure is exact.
struct Far {
    /// Data cycles per receiver cycle.
    rate: f64,
    /// Data cycles at receiver cycle 0.
    phase: f64,
    first_index: u16,
}

impl Far {
    fn drifting(ppm: f64) -> Self {
        Self {
            rate: 1.0 + ppm * 1e-6,
            phase: 100.5,
            first_index: 0,
        }
    }

    fn true_count(&self, cycle: i64) -> f64 {
        self.phase + cycle as f64 * self.rate
    }

    fn count(&self, cycle: i64) -> i64 {
        self.true_count(cycle).floor() as i64
    }

    fn index(&self, cycle: i64) -> CycleIndex {
        CycleIndex((self.count(cycle) as u16).wrapping_add(self.first_index))
    }
}

fn started(parameters: TimeSyncParameters) -> TimeSync {
    TimeSync::start(CYCLE, parameters).unwrap()
}

fn defaults() -> TimeSyncParameters {
    TimeSyncParameters::default()
}

/// Corrected data count minus the true one, in data cycles.
fn error_of(far: &Far, cycle: i64, output: &TimeSyncOutput, data_cycle: f64) -> f64 {
    let correction = output.correction_time.unwrap().0 / data_cycle;
    far.count(cycle) as f64 + correction - far.true_count(cycle)
}

/// Runs until synchronised and returns the cycle, or none within `cycles`.
fn cycle_of_sync(sync: &mut TimeSync, far: &Far, cycles: i64) -> Option<(i64, TimeSyncOutput)> {
    (0..cycles)
        .map(|cycle| (cycle, sync.update(far.index(cycle), 1)))
        .find(|(_, output)| output.state == TimeSyncState::Synced)
}
