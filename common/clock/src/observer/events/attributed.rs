//! The last jumps of the line that were taken for the path's.

const KEPT: usize = 16;

/// Jumps of the line with their times, s.
#[derive(Clone, Debug, Default)]
pub(in crate::observer) struct Attributed {
    jumps: [(f64, f64); KEPT],
    next: usize,
}

impl Attributed {
    pub(in crate::observer) fn note(&mut self, time: f64, jump: f64) {
        self.jumps[self.next] = (time, jump);
        self.next = (self.next + 1) % KEPT;
    }

    /// Sum of the jumps since then, s.
    pub(in crate::observer) fn since(&self, time: f64) -> f64 {
        let jumps = self.jumps.iter().filter(|(at, _)| *at >= time);
        jumps.map(|(_, jump)| jump).sum()
    }

    pub(in crate::observer) fn forget(&mut self) {
        *self = Self::default();
    }
}
