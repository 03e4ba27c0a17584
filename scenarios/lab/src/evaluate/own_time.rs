//! A receiver's own time, by its cycles.

use coaxle_clock::CycleTime;

use crate::record::ReceiverCycle;

/// Time of a receiver's clock in each of its cycles, s: the one that another clock's drift is measured against.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OwnTime {
    /// Newest cycle, and the change of the period behind it, ppm.
    newest: Option<(u64, f64)>,
    /// Time by which a lock has moved the cycles.
    moved: f64,
}

impl OwnTime {
    /// Takes the next cycle, and returns its time.
    pub(super) fn take(&mut self, record: &ReceiverCycle, cycle_time: CycleTime) -> f64 {
        let (cycle, length) = (record.node.cycle, cycle_time.as_secs_f64());
        let ppm = record.node.cycle_period_ppm.unwrap_or_default();
        if let Some((before, moved)) = self.newest.replace((cycle, ppm)) {
            let passed = cycle.saturating_sub(before) as f64;
            self.moved += passed * length * moved * 1e-6;
        }
        length * cycle as f64 + self.moved
    }
}
