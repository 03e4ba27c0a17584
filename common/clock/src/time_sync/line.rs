//! The line a correction follows, and the blend from one line to the next.

/// Two sections of a ramp: `part` of the way within the first `section` of its length, the rest in
/// what remains.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    pub(super) part: f64,
    pub(super) section: f64,
}

impl Slopes {
    /// Share of the way that is made after the fraction `f` of the time; all of it from 1 on.
    fn share(self, f: f64) -> f64 {
        if f <= self.section {
            self.part * f.max(0.0) / self.section
        // Beyond the expected beat the ramp waits at its end: the clock is a little faster or slower than it was.
        } else if f < 1.0 {
            self.part + (1.0 - self.part) * (f - self.section) / (1.0 - self.section)
        } else {
            1.0
        }
    }
}

/// The corrected offset over the own cycles, in ticks: a plateau, and a ramp of one tick from the
/// last beat to the next one expected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    base: f64,
    ramp: Option<Ramp>,
}

#[derive(Clone, Copy, Debug)]
struct Ramp {
    since: i64,
    ticks_per_cycle: f64,
    slopes: Slopes,
}

impl Line {
    pub(super) const fn level(base: i64) -> Self {
        Self {
            base: base as f64,
            ramp: None,
        }
    }

    /// A ramp that starts at the plateau's `base` at the beat at cycle `since`.
    pub(super) const fn ramp(base: i64, since: i64, ticks_per_cycle: f64, slopes: Slopes) -> Self {
        Self {
            base: base as f64,
            ramp: Some(Ramp {
                since,
                ticks_per_cycle,
                slopes,
            }),
        }
    }

    pub(super) fn at(&self, cycle: i64) -> f64 {
        let Some(ramp) = &self.ramp else {
            return self.base;
        };
        // One tick takes 1/|drift| cycles, so this is the part of a beat that has passed.
        let fraction = (cycle - ramp.since) as f64 * ramp.ticks_per_cycle.abs();
        self.base + ramp.slopes.share(fraction).copysign(ramp.ticks_per_cycle)
    }
}

/// Goes from one line to another in equal steps, so that no change of aim is a jump.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend {
    from: Line,
    to: Line,
    since: i64,
    cycles: i64,
}

impl Blend {
    pub(super) const fn new(line: Line) -> Self {
        Self {
            from: line,
            to: line,
            since: 0,
            cycles: 0,
        }
    }

    /// Aims at another line, to be reached in `cycles`. A blend that is under way is left where it
    /// stands.
    pub(super) fn aim(&mut self, line: Line, cycle: i64, cycles: u16) {
        // From where the blend stands, or a second beat within it would be a jump.
        self.from = if self.has_arrived(cycle) {
            self.to
        } else {
            Line {
                base: self.at(cycle),
                ramp: None,
            }
        };
        self.to = line;
        self.since = cycle;
        self.cycles = i64::from(cycles);
    }

    /// True if the line aimed at is reached.
    pub(super) const fn has_arrived(&self, cycle: i64) -> bool {
        cycle - self.since >= self.cycles
    }

    pub(super) fn at(&self, cycle: i64) -> f64 {
        let passed = cycle - self.since;
        if self.has_arrived(cycle) {
            return self.to.at(cycle);
        }
        let share = passed as f64 / self.cycles as f64;
        (1.0 - share) * self.from.at(cycle) + share * self.to.at(cycle)
    }
}
