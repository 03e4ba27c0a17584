//! Three simple methods that use the lowest phase of each window, where a message met the least delay. They show the
//! accuracy without a model of the jitter.

use std::collections::VecDeque;

use crate::peers::{Follower, far_by, phase};
use crate::world::Message;

/// A phase and when its message was due, s.
#[derive(Clone, Copy)]
struct Point {
    due: f64,
    phase: f64,
}

/// A straight line through phases.
#[derive(Clone, Copy)]
struct Line {
    at: f64,
    offset: f64,
    drift: f64,
}

impl Line {
    fn phase(&self, due: f64) -> f64 {
        self.offset + self.drift * (due - self.at)
    }

    fn far(&self, now: i64) -> f64 {
        far_by(now, self.at, self.offset, self.drift)
    }

    /// Fits a line by least squares. None for less than two points.
    fn fitted(points: impl ExactSizeIterator<Item = Point> + Clone) -> Option<Self> {
        let n = points.len() as f64;
        if n < 2.0 {
            return None;
        }
        let at = points.clone().map(|point| point.due).sum::<f64>() / n;
        let offset = points.clone().map(|point| point.phase).sum::<f64>() / n;
        let (mut products, mut squares) = (0.0, 0.0);
        for point in points {
            let away = point.due - at;
            products += away * (point.phase - offset);
            squares += away * away;
        }
        Some(Self {
            at,
            offset,
            drift: products / squares,
        })
    }
}

/// Finds the lowest phase of each window.
struct Minima {
    cycle: f64,
    window: f64,
    /// Number of the window that is being filled.
    number: i64,
    /// Height above the drift of the lowest point, and the point.
    lowest: Option<(f64, Point)>,
}

impl Minima {
    const fn new(cycle: f64, window: f64) -> Self {
        Self {
            cycle,
            window,
            number: i64::MIN,
            lowest: None,
        }
    }

    /// Takes a message. `drift` is taken away before phases are compared. Returns the lowest of the window that the
    /// message ended.
    fn take(&mut self, message: &Message, drift: f64) -> Option<Point> {
        let (due, phase) = phase(message, self.cycle);
        let number = (due / self.window).floor() as i64;
        let ended = if number > self.number {
            self.number = number;
            self.lowest.take()
        } else {
            None
        };
        // Otherwise the lowest of a second would be its first or its last message, at 100 ppm.
        let height = phase - drift * (due - number as f64 * self.window);
        if self.lowest.is_none_or(|(lowest, _)| height < lowest) {
            self.lowest = Some((height, Point { due, phase }));
        }
        ended.map(|(_, point)| point)
    }
}

/// A line through the lowest of each of the last eight seconds, extrapolated.
pub(crate) struct MinimaLine {
    minima: Minima,
    points: VecDeque<Point>,
    line: Option<Line>,
}

impl MinimaLine {
    const POINTS: usize = 8;

    pub(crate) fn new(cycle: f64) -> Self {
        Self {
            minima: Minima::new(cycle, 1.0),
            points: VecDeque::new(),
            line: None,
        }
    }
}

impl Follower for MinimaLine {
    fn observe(&mut self, message: &Message) {
        let drift = self.line.map_or(0.0, |line| line.drift);
        let Some(point) = self.minima.take(message, drift) else {
            return;
        };
        self.points.push_back(point);
        if self.points.len() > Self::POINTS {
            let _ = self.points.pop_front();
        }
        self.line = Line::fitted(self.points.iter().copied());
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        self.line.map(|line| line.far(now))
    }
}

/// The lowest of each second, followed by a proportional-integral servo of second order.
pub(crate) struct MinimaServo {
    minima: Minima,
    /// Natural frequency, rad/s.
    bandwidth: f64,
    first: Option<Point>,
    line: Option<Line>,
}

impl MinimaServo {
    const DAMPING: f64 = 0.7;

    pub(crate) const fn new(cycle: f64, bandwidth: f64) -> Self {
        Self {
            minima: Minima::new(cycle, 1.0),
            bandwidth,
            first: None,
            line: None,
        }
    }

    /// Takes the first drift from the first two points, as in common PTP servos.
    fn begin(&mut self, point: Point) {
        if let Some(first) = self.first {
            self.line = Some(Line {
                at: point.due,
                offset: point.phase,
                drift: (point.phase - first.phase) / (point.due - first.due),
            });
        }
        self.first = Some(point);
    }
}

impl Follower for MinimaServo {
    fn observe(&mut self, message: &Message) {
        let drift = self.line.map_or(0.0, |line| line.drift);
        let Some(point) = self.minima.take(message, drift) else {
            return;
        };
        let Some(line) = self.line else {
            self.begin(point);
            return;
        };
        let predicted = line.phase(point.due);
        let error = point.phase - predicted;
        let passed = point.due - line.at;
        self.line = Some(Line {
            at: point.due,
            offset: predicted + 2.0 * Self::DAMPING * self.bandwidth * passed * error,
            drift: line.drift + self.bandwidth * self.bandwidth * passed * error,
        });
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        self.line.map(|line| line.far(now))
    }
}

/// A regression over as many samples as lie on a straight line, as chrony's: when the signs of the
/// residuals change too rarely for independent noise, the oldest samples are dropped. A sample is
/// the lowest of an eighth of a second.
pub(crate) struct RunsRegression {
    minima: Minima,
    samples: VecDeque<Point>,
    line: Option<Line>,
    /// Greatest number of runs of equal signs that is too few, by the number of residuals.
    too_few_runs: Vec<usize>,
}

impl RunsRegression {
    const MOST: usize = 64;
    const LEAST: usize = 6;
    const SIGNIFICANCE: f64 = 0.1;

    pub(crate) fn new(cycle: f64) -> Self {
        Self {
            minima: Minima::new(cycle, 0.125),
            samples: VecDeque::new(),
            line: None,
            too_few_runs: (0..=Self::MOST).map(too_few_runs).collect(),
        }
    }

    /// True if the residuals of all samples change signs as independent noise would.
    fn is_straight(&self, line: &Line) -> bool {
        let above = |point: &Point| point.phase > line.phase(point.due);
        runs(self.samples.iter().map(above)) > self.too_few_runs[self.samples.len()]
    }
}

impl Follower for RunsRegression {
    fn observe(&mut self, message: &Message) {
        let drift = self.line.map_or(0.0, |line| line.drift);
        let Some(sample) = self.minima.take(message, drift) else {
            return;
        };
        self.samples.push_back(sample);
        if self.samples.len() > Self::MOST {
            let _ = self.samples.pop_front();
        }
        self.line = Line::fitted(self.samples.iter().copied());
        while let Some(line) = &self.line
            && self.samples.len() > Self::LEAST
            && !self.is_straight(line)
        {
            let _ = self.samples.pop_front();
            self.line = Line::fitted(self.samples.iter().copied());
        }
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        self.line.map(|line| line.far(now))
    }
}

/// Number of runs of equal signs.
fn runs(signs: impl Iterator<Item = bool>) -> usize {
    let (mut count, mut previous) = (0, None);
    for sign in signs {
        count += usize::from(previous != Some(sign));
        previous = Some(sign);
    }
    count
}

/// Returns the most runs among `n` independent signs that are still too few: this number or fewer come with at most
/// the probability of the significance. All runs but the first begin with a change of sign; the number of changes is
/// binomial among `n − 1`.
fn too_few_runs(n: usize) -> usize {
    if n < 2 {
        return 0;
    }
    let changes = n - 1;
    let mut probability = 0.5f64.powi(changes as i32);
    let (mut total, mut runs) = (probability, 0);
    while total <= RunsRegression::SIGNIFICANCE {
        runs += 1;
        probability *= (changes + 1 - runs) as f64 / runs as f64;
        total += probability;
    }
    runs
}
