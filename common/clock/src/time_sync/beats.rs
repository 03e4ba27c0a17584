//! Plateaus, beats, and the drift they show.

/// Most periods a mean can be taken over.
pub(super) const MOST_PERIODS: usize = 64;

/// Finds plateaus in the offset between the two cycle counts, and measures the time between the
/// steps from one to the next.
#[derive(Clone, Debug)]
pub(super) struct Beats {
    /// Cycles of constant offset that make a plateau.
    limit: i64,
    run: Option<Run>,
    plateau: Option<i64>,
    last: Option<i64>,
    count: u32,
    periods: Periods,
}

/// An offset that has not changed since a cycle.
#[derive(Clone, Copy, Debug)]
struct Run {
    offset: i64,
    since: i64,
}

/// A change of the plateau.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beat {
    /// The first plateau of all: no beat yet.
    First,
    /// A step by this number of ticks.
    Counted { ticks: i64 },
}

impl Beat {
    /// The step without its sign, in ticks.
    pub(super) const fn size(self) -> i64 {
        match self {
            Self::First => 0,
            Self::Counted { ticks } => ticks.abs(),
        }
    }
}

impl Beats {
    pub(super) fn new(limit: i64, periods: u16) -> Self {
        Self {
            limit,
            run: None,
            plateau: None,
            last: None,
            count: 0,
            periods: Periods::new(usize::from(periods)),
        }
    }

    pub(super) fn restart(&mut self) {
        self.run = None;
        self.plateau = None;
        self.last = None;
        self.count = 0;
        self.periods.clear();
    }

    /// Changes what makes a plateau and a mean; what is known is kept.
    pub(super) fn set(&mut self, limit: i64, periods: u16) {
        self.limit = limit;
        self.periods.want(usize::from(periods));
    }

    /// Runs one cycle; `offset` is none when it brought no new data. Returns a change of the plateau.
    pub(super) fn observe(&mut self, offset: Option<i64>, cycle: i64) -> Option<Beat> {
        // Silence confirms nothing: one late message before a pause would make a plateau.
        let run = self.continue_run(offset?, cycle);
        // Around a beat the offset flickers with the jitter of both sides for many cycles.
        if cycle - run.since < self.limit || self.plateau == Some(run.offset) {
            return None;
        }
        let Some(plateau) = self.plateau.replace(run.offset) else {
            return Some(Beat::First);
        };
        let ticks = run.offset - plateau;
        if let Some(last) = self.last {
            self.periods.push(ticks, run.since - last);
        }
        // The beat was when the new offset first stayed, not when it had stayed long enough.
        self.last = Some(run.since);
        self.count = self
            .count
            .saturating_add(u32::try_from(ticks.unsigned_abs()).unwrap_or(u32::MAX));
        Some(Beat::Counted { ticks })
    }

    fn continue_run(&mut self, offset: i64, cycle: i64) -> Run {
        let begun = Run {
            offset,
            since: cycle,
        };
        let run = self.run.filter(|run| run.offset == offset);
        *self.run.insert(run.unwrap_or(begun))
    }

    /// The offset of the plateau in force.
    pub(super) const fn plateau(&self) -> Option<i64> {
        self.plateau
    }

    /// The cycle of the last beat.
    pub(super) const fn last(&self) -> Option<i64> {
        self.last
    }

    /// Beats so far; one of several ticks counts as several.
    pub(super) const fn count(&self) -> u32 {
        self.count
    }

    /// True if there are enough periods for the mean wanted.
    pub(super) const fn mean_is_known(&self) -> bool {
        self.periods.len == self.periods.wanted
    }

    /// The mean drift in ticks per own cycle, signed; 0 until a period is known.
    pub(super) fn ticks_per_cycle(&self) -> f64 {
        self.periods.mean()
    }
}

/// The last few periods between beats.
#[derive(Clone, Debug)]
struct Periods {
    wanted: usize,
    len: usize,
    next: usize,
    /// Direction of the step that ended the period, and its length in cycles.
    ring: [(f64, f64); MOST_PERIODS],
}

impl Periods {
    const fn new(wanted: usize) -> Self {
        Self {
            wanted,
            len: 0,
            next: 0,
            ring: [(0.0, 0.0); MOST_PERIODS],
        }
    }

    fn clear(&mut self) {
        self.len = 0;
        self.next = 0;
    }

    /// Changes the number of periods; the newest are kept.
    fn want(&mut self, wanted: usize) {
        let kept = self.len.min(wanted);
        let oldest = self.next + self.wanted - kept;
        let old = self.ring;
        for n in 0..kept {
            self.ring[n] = old[(oldest + n) % self.wanted];
        }
        self.len = kept;
        self.next = kept % wanted;
        self.wanted = wanted;
    }

    /// A step of several ticks is that many periods of equal length.
    fn push(&mut self, ticks: i64, cycles: i64) {
        let steps = ticks.unsigned_abs().max(1);
        let period = cycles as f64 / steps as f64;
        for _ in 0..steps.min(self.wanted as u64) {
            self.ring[self.next] = (ticks.signum() as f64, period);
            self.next = (self.next + 1) % self.wanted;
            self.len = (self.len + 1).min(self.wanted);
        }
    }

    /// Net ticks over the time they took; for periods of one direction that is one over their mean.
    fn mean(&self) -> f64 {
        let known = &self.ring[..self.len];
        // Net ticks, so that a beat and its way back, by jitter, cancel.
        let (ticks, cycles) = known
            .iter()
            .fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        if cycles > 0.0 { ticks / cycles } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_more_or_fewer_periods_wanted_the_newest_are_kept() {
        for wanted in 1..5 {
            for known in 0..7 {
                for then in 1..6 {
                    let mut periods = Periods::new(wanted);
                    (0..known).for_each(|n| periods.push(1, 100 + n));
                    periods.want(then);
                    (known..known + 2).for_each(|n| periods.push(1, 100 + n));
                    let kept = (known as usize).min(wanted).min(then);
                    assert_eq!(periods.len, (kept + 2).min(then));
                    let newest = (0..known + 2).rev().take(periods.len);
                    let sum: i64 = newest.map(|n| 100 + n).sum();
                    let mean = periods.len as f64 / sum as f64;
                    assert!((periods.mean() - mean).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn one_late_message_before_a_silence_makes_no_plateau() {
        let mut beats = Beats::new(90, 1);
        for cycle in 0..200 {
            let _ = beats.observe(Some(3), cycle);
        }
        assert_eq!(beats.observe(Some(-35), 200), None);
        for cycle in 201..400 {
            assert_eq!(beats.observe(None, cycle), None);
        }
        assert_eq!(beats.observe(Some(3), 400), None);
        assert_eq!((beats.plateau(), beats.count()), (Some(3), 0));
    }
}
