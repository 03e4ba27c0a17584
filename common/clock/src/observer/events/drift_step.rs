//! A drift that has changed for good: phases that lie on another straight line than the one that is followed.
//!
//! The line follows a drift that wanders. One that changes at once by tens of ppm, as where somebody disciplines the sender's
//! clock, carries the phases away before it has followed; then all messages are late, or early, and that looks like a longer
//! delay again and again. But a delay that jumps leaves the phases as steep as they were, while these have another slope. So the
//! low phases of short windows are kept, on several scales of time, and the slope through the last of them is compared with the
//! drift of the line. The usual difference of both on a scale shows what is out of the ordinary there: where delays are
//! correlated that is a lot in a second, and little in ten.

use crate::observer::line::Estimate;
use crate::straight_line::StraightLine;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the detection of another drift.
    DriftStepTuning {
        /// Length of a window of the finest scale, s …
        finest: f64 = 0.05,
        /// … and its least number of counts.
        fewest_counts: f64 = 16.0,
        /// A slope is another drift if it is this many times farther off than usual …
        // With six, and points four times nearer, a telegraph of 13 µs is 3.84 µs rms instead of 2.61.
        out_of_the_ordinary: f64 = 8.0,
        /// … and than its own standard deviation …
        significant: f64 = 10.0,
        /// … and the points are this many times nearer, in squares, to one line than to two that are as steep as before, with a jump
        /// of the delay between them.
        better: f64 = 6.0,
        /// Another drift as well is one that is as steep for as many points again, from this part …
        steady_least: f64 = 0.7,
        /// … to this multiple of it …
        steady_greatest: f64 = 1.4,
        /// … and this many times farther off than usual, if that is known.
        beyond_usual: f64 = 2.0,
        /// Slopes that the usual difference is a mean over …
        memory: f64 = 128.0,
        /// … the greatest multiple of it that one counts as …
        clipped: f64 = 2.5,
        /// … and the number after which it is known.
        // Three times the points of a slope.
        known_after: u32 = 24,
        /// Least difference that is a slope, in cells.
        // Arrivals that are stamped to cells may be off by one.
        cells: f64 = 3.0,
        /// Possible error of a point, as a part of the change in the first window.
        doubt: f64 = 0.5,
        /// Low phases that the mean of their height above the line is over.
        level_memory: u32 = 32,
        /// Smaller changes are left to the filters, s/s.
        // A step of 5 ppm settles within some 2 s at 5/20.
        smallest: f64 = 8e-6,
    }
}

/// Scales, each with windows twice as long as the one before.
const SCALES: usize = 7;
/// Points that make a slope.
const POINTS: usize = 8;

/// Watches the slope of the phases.
#[derive(Clone, Debug)]
pub(in crate::observer) struct DriftSteps {
    window: f64,
    scales: [Scale; SCALES],
    open: Open,
}

/// The open window of the finest scale.
#[derive(Clone, Copy, Debug)]
struct Open {
    since: f64,
    least: Option<Point>,
    second: Option<Point>,
}

/// A low phase: when its message was due, s, and by how much it was above the line, s.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    time: f64,
    phase: f64,
    above: f64,
}

#[derive(Clone, Copy, Debug)]
struct Scale {
    points: [Point; POINTS],
    len: usize,
    /// The first of two points that become one of the next scale.
    first: Option<Point>,
    /// Mean square of the differences of slopes from the drift, s²/s².
    usual: f64,
    known: u32,
    /// Slopes in a row that stood out as much as this one, s/s.
    steady: usize,
    stood_out: f64,
    /// Usual height of low phases above the line: a mean over those that have left `points`, s.
    above: f64,
    left: u32,
}

/// Line that the phases are on since the drift changed.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct DriftStep {
    /// Line that they are on at the time `at`, s: where the line that was followed would be.
    pub(in crate::observer) at: f64,
    pub(in crate::observer) estimate: Estimate,
    /// By how much the drift changed, s/s.
    pub(in crate::observer) change: f64,
    /// Due time of the message of the first point, s, and its phase.
    pub(in crate::observer) since: f64,
    pub(in crate::observer) phase_then: f64,
    /// Spacing of the points, s.
    pub(in crate::observer) window: f64,
}

impl DriftSteps {
    /// Makes a detector for messages with this period, s.
    pub(in crate::observer) fn new(seconds_per_count: f64) -> Self {
        Self {
            window: TUNING.finest.max(TUNING.fewest_counts * seconds_per_count),
            scales: [Scale::NEW; SCALES],
            open: Open::at(f64::NEG_INFINITY),
        }
    }

    /// Takes the phase of a message due at `time`, and the line that is followed there: its offset and its drift.
    /// Arrivals are stamped to a `cell`, s.
    pub(in crate::observer) fn observe(
        &mut self,
        time: f64,
        phase: f64,
        (offset, drift): (f64, f64),
        cell: f64,
    ) -> Option<DriftStep> {
        let mut found = None;
        if time >= self.open.since + self.window {
            let closed = self.open.second;
            // A window without messages: points on both sides of it are not evenly spaced, and the slope would hang on few of them.
            let gap = time >= self.open.since + 2.0 * self.window;
            self.open = Open::at(time);
            match closed {
                Some(point) if !gap => found = self.close(point, drift, cell),
                _ => self.forget_points(),
            }
        }
        self.open.take(Point {
            time,
            phase,
            above: phase - offset,
        });
        found
    }

    /// Forgets the points after a jump of the path, across which they are on no line, or on another line.
    pub(in crate::observer) fn forget_points(&mut self) {
        for scale in &mut self.scales {
            scale.forget_points();
        }
        self.open = Open::at(self.open.since);
    }

    /// Closes a window of the finest scale, and with it those of others that end there.
    fn close(&mut self, point: Point, drift: f64, cell: f64) -> Option<DriftStep> {
        let mut point = point;
        let mut found = None;
        let mut finer = None;
        for scale in &mut self.scales {
            // The finest scale that finds it wins, as its points are the youngest.
            found = found.or(scale.take(point, drift, finer, cell));
            // Coarser scales need minutes to know their own, and differ less than finer ones do.
            finer = scale.usual().or(finer);
            let Some(first) = scale.first.take() else {
                scale.first = Some(point);
                break;
            };
            // The lower of two, as on the edge: messages are late now and then, and seldom early.
            if first.above < point.above {
                point = first;
            }
        }
        found
    }
}

impl Open {
    const fn at(since: f64) -> Self {
        Self {
            since,
            least: None,
            second: None,
        }
    }

    /// The second lowest is kept: now and then a single message is too early.
    fn take(&mut self, point: Point) {
        let lower =
            |than: &Option<Point>| (than.as_ref()).is_none_or(|than| point.above < than.above);
        // Most are above both.
        if !lower(&self.second) {
            return;
        }
        self.second = if lower(&self.least) {
            self.least.replace(point)
        } else {
            Some(point)
        };
    }
}

impl Scale {
    const NEW: Self = Self {
        points: [Point {
            time: 0.0,
            phase: 0.0,
            above: 0.0,
        }; POINTS],
        len: 0,
        first: None,
        usual: 0.0,
        known: 0,
        steady: 0,
        stood_out: 0.0,
        above: 0.0,
        left: 0,
    };

    fn forget_points(&mut self) {
        self.len = 0;
        self.first = None;
        self.steady = 0;
    }

    /// Usual difference of slopes of this scale from the drift, once that is known.
    fn usual(&self) -> Option<f64> {
        (self.known >= TUNING.known_after).then(|| libm::sqrt(self.usual))
    }

    /// `finer`: usual difference on a finer scale, which is more than on this one.
    fn take(
        &mut self,
        point: Point,
        drift: f64,
        finer: Option<f64>,
        cell: f64,
    ) -> Option<DriftStep> {
        if self.len == POINTS {
            self.left = self.left.saturating_add(1);
            let part = 1.0 / f64::from(self.left.min(TUNING.level_memory));
            // Only points that left: those still in it may be on another line already.
            self.above += (self.points[0].above - self.above) * part;
            self.points.copy_within(1.., 0);
            self.len -= 1;
        }
        self.points[self.len] = point;
        self.len += 1;
        if self.len < POINTS {
            return None;
        }
        let points = self.points.iter();
        let line = StraightLine::through(points.map(|point| (point.time, point.phase)));
        let off = line.slope - drift;
        // Each bound alone passes something that is no drift: chance, a grid of stamps, and what the filters follow anyway.
        let least = (TUNING.significant * line.slope_sigma())
            .max(TUNING.cells * cell / (point.time - self.points[0].time))
            .max(TUNING.smallest);
        let stands_out =
            off.abs() > least && self.scatter_of_jump(drift) > TUNING.better * line.scatter;
        self.count_steady(off, stands_out);
        // As many slopes again share no point with the first: the drift lasted.
        let is_steady = self.steady > POINTS;
        let times_usual = if is_steady {
            TUNING.beyond_usual
        } else {
            TUNING.out_of_the_ordinary
        };
        let is_unusual =
            (self.usual().or(finer)).map_or(is_steady, |usual| off.abs() > times_usual * usual);
        if stands_out && is_unusual {
            return Some(self.step(&line, off));
        }
        // Once it is no other drift it is usual, and not before.
        if self.steady == 0 || is_steady {
            self.learn(off);
        }
        None
    }

    /// Counts slopes that stand out alike.
    fn count_steady(&mut self, off: f64, stands_out: bool) {
        let is_alike = stands_out
            && (TUNING.steady_least..TUNING.steady_greatest).contains(&(off / self.stood_out));
        if self.steady > 0 && is_alike {
            self.steady += 1;
            return;
        }
        if self.steady <= POINTS {
            // They stood out for a while and then did not: they were chance after all, and belong to what is usual.
            for _ in 0..self.steady {
                self.learn(self.stood_out);
            }
        }
        self.steady = usize::from(stands_out);
        self.stood_out = off;
    }

    /// The least sum of squares about two lines of the drift of before, one through the first points and one through the
    /// others.
    fn scatter_of_jump(&self, drift: f64) -> f64 {
        let scatter = |points: &[Point]| {
            let n = points.len() as f64;
            let above = |point: &Point| {
                point.phase - points[0].phase - drift * (point.time - points[0].time)
            };
            let mean = points.iter().map(above).sum::<f64>() / n;
            let square = |point: &Point| {
                let off = above(point) - mean;
                off * off
            };
            points.iter().map(square).sum::<f64>()
        };
        // At every place where the delay may have jumped.
        let splits = (1..POINTS).map(|at| self.points.split_at(at));
        let sums = splits.map(|(before, after)| scatter(before) + scatter(after));
        sums.fold(f64::INFINITY, f64::min)
    }

    fn learn(&mut self, off: f64) {
        self.known = self.known.saturating_add(1);
        let square = off * off;
        // Clipped, or one drift that was not found would hide all that come after it.
        let square = match self.known > TUNING.known_after {
            true => square.min(TUNING.clipped * TUNING.clipped * self.usual),
            false => square,
        };
        let part = 1.0 / f64::from(self.known).min(TUNING.memory);
        self.usual += (square - self.usual) * part;
    }

    /// Makes the new line, whose slope differs by `off`. The first of the points may be of before.
    fn step(&self, line: &StraightLine, off: f64) -> DriftStep {
        let last = self.points[POINTS - 1].time;
        let window = (last - self.points[0].time) / (POINTS as f64 - 1.0);
        // The change began somewhere in the first window, so its point may be off by a part of it.
        let doubt = TUNING.doubt * off * window;
        let scatter = line.variance() + doubt * doubt;
        let ahead = last - line.time;
        let drift_variance = scatter / line.squares;
        DriftStep {
            at: last,
            estimate: Estimate {
                // Points are the low phases, which usually lie above the line that is followed.
                offset: line.value + line.slope * ahead - self.above,
                drift: line.slope,
                offset_variance: scatter / POINTS as f64 + drift_variance * ahead * ahead,
                covariance: drift_variance * ahead,
                drift_variance,
            },
            change: off,
            since: self.points[0].time,
            phase_then: self.points[0].phase,
            window,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACING: f64 = 1e-3;

    /// Drift step found in ten seconds of phases that are late by up to 20 µs; the line is level.
    fn found(phase: impl Fn(f64) -> f64) -> Option<DriftStep> {
        found_beside_cells(0.0, phase)
    }

    /// Likewise, where arrivals are stamped to a `cell`, s.
    fn found_beside_cells(cell: f64, phase: impl Fn(f64) -> f64) -> Option<DriftStep> {
        let mut steps = DriftSteps::new(SPACING);
        (0..10_000).find_map(|k: u32| {
            let time = SPACING * f64::from(k);
            let late = 20e-6 * f64::from(k.wrapping_mul(2_654_435_761) >> 8 & 0xffff) / 65_536.0;
            steps.observe(time, phase(time) + late, (0.0, 0.0), cell)
        })
    }

    #[test]
    fn what_lies_on_another_line_is_another_drift() {
        for (change, within) in [(200e-6, 0.6), (-200e-6, 0.6), (20e-6, 1.5), (-20e-6, 1.5)] {
            let phase = match change {
                200e-6 => |time: f64| 200e-6 * (time - 6.0).max(0.0),
                -200e-6 => |time: f64| -200e-6 * (time - 6.0).max(0.0),
                20e-6 => |time: f64| 20e-6 * (time - 6.0).max(0.0),
                _ => |time: f64| -20e-6 * (time - 6.0).max(0.0),
            };
            let step = found(phase).expect("it is found");
            assert!(
                (6.0..6.0 + within).contains(&step.at),
                "{change}: at {}",
                step.at
            );
            assert!(
                (5.5..6.5).contains(&step.since),
                "{change}: since {}",
                step.since
            );
            let sigma = step.estimate.drift_variance.sqrt();
            let off = step.estimate.drift - change;
            assert!(
                off.abs() < 3.0 * sigma && sigma < change.abs(),
                "{change}: {off}, {sigma}"
            );
            let off = step.estimate.offset - phase(step.at);
            assert!(off.abs() < 6e-6, "{change}: {off}");
        }
    }

    #[test]
    fn a_line_that_was_wrong_from_the_start_is_found_though_nothing_is_usual() {
        for drift in [80e-6, -80e-6] {
            let phase = match drift {
                80e-6 => |time: f64| 80e-6 * time,
                _ => |time: f64| -80e-6 * time,
            };
            let step = found(phase).expect("it is found");
            assert!(step.at < 4.0, "{drift}: at {}", step.at);
            let off = step.estimate.drift - drift;
            assert!(off.abs() < 4e-6, "{drift}: {off}");
        }
    }

    #[test]
    fn a_delay_that_jumps_or_jitters_more_is_no_drift() {
        assert!(found(|_| 0.0).is_none());
        assert!(found(|time| if time < 6.0 { 0.0 } else { 30e-6 }).is_none());
        assert!(found(|time| if time < 6.01 { 0.0 } else { 1e-3 }).is_none());
        let wider = |time: f64| 1e-4 * (1e6 * time * time).sin().abs() * f64::from(time > 6.0);
        assert!(found(wider).is_none());
    }

    #[test]
    fn a_gap_makes_no_line() {
        let mut steps = DriftSteps::new(SPACING);
        for k in 0..20_000_u32 {
            // Half a second of messages, and half a second without; phases that are alike by the second alone.
            let time = SPACING * f64::from(k);
            if time.rem_euclid(1.0) < 0.3 {
                let phase = 1e-4 * time.floor().rem_euclid(2.0);
                assert!(
                    steps.observe(time, phase, (0.0, 0.0), 0.0).is_none(),
                    "{time}"
                );
            }
        }
    }

    #[test]
    fn two_cells_are_no_slope_and_four_are() {
        let window = |drift: f64| {
            let step = found_beside_cells(50e-6, |time| drift * (time - 6.0).max(0.0));
            step.expect("it is found").window
        };
        // In seven windows of 0.2 s phases climb by 3.4 cells and by 2.6 cells.
        assert!((window(121e-6) - 0.2).abs() < 0.05, "{}", window(121e-6));
        assert!((window(93e-6) - 0.4).abs() < 0.05, "{}", window(93e-6));
    }
}
