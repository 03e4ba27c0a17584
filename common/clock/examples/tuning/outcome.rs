//! Outcome of a run: a few figures, and a digest of everything that was put out.

/// Outcome of one run.
#[derive(Clone, Default, PartialEq)]
pub(crate) struct RunOutcome {
    /// Digest of all outputs: another one is another run.
    pub(crate) digest: u64,
    pub(crate) figures: Vec<RunFigure>,
}

/// A figure of a run.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct RunFigure {
    pub(crate) name: &'static str,
    pub(crate) value: f64,
    /// A change by less than this is of no interest.
    pub(crate) least: f64,
}

impl RunOutcome {
    /// Takes a value into the digest.
    pub(crate) fn digest(&mut self, value: f64) {
        // FNV-1a, a word at a time.
        self.digest = (self.digest ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3);
    }

    pub(crate) fn add(&mut self, name: &'static str, value: f64, least: f64) {
        self.digest(value);
        self.figures.push(RunFigure { name, value, least });
    }

    /// The figure that differs most from that of another run, relative to it, and by how much.
    pub(crate) fn largest_change(&self, base: &Self) -> Option<(RunFigure, RunFigure, f64)> {
        let pairs = self.figures.iter().zip(&base.figures);
        let changes = pairs.map(|(new, old)| {
            let by = match (new.value.is_finite(), old.value.is_finite()) {
                (true, true) => (new.value - old.value).abs() / old.value.abs().max(old.least),
                // Both never came to it.
                (false, false) => 0.0,
                _ => f64::INFINITY,
            };
            (*new, *old, by)
        });
        changes.max_by(|a, b| a.2.total_cmp(&b.2))
    }
}
