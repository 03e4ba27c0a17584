//! Arrivals on a grid that is coarser than the jitter.
//!
//! Where somebody polls for messages every millisecond, phases are level for as long as it takes the sender's clock to
//! gain or lose one, and then jump by one: teeth of a saw. A line through them is level, and jumps again and again; the
//! clock's own line goes through their lower corners, as no message is seen before it comes. So a tooth that returns is
//! no shift of the path. From then on only corners are measurements: between them nothing says where in a cell the line is.

use super::filter::Estimate;
use super::shift::Bounds;
use super::stream::{BLOCK, Residual};
use super::{LARGEST_DRIFT, PhaseObserver};
use crate::instant::{Instant, Local};
use crate::numbers::rounded;

/// So many jumps of one size and sign, …
const ALIKE: usize = 3;
/// … within this part of it, are teeth; what lies between them takes equally long to such a part.
const SIZE: f64 = 0.05;
const REGULAR: f64 = 0.5;
const LEFT: f64 = 0.25;
/// Between teeth phases climb by no more than such a part of one: a path that swings climbs by as much as it jumps.
const LEVEL: f64 = 0.1;
/// Phases are level between teeth only if a cycle is a whole number of cells: so many at most, each so many times as wide as the
/// jitter. On a finer grid cells are a jitter like any other (all is well up to a tenth of a cycle), and a path that grows steadily is followed
/// in steps as small and regular.
const MOST_CELLS: i64 = 5;
const COARSER: f64 = 4.0;
/// A level that differs from another one by a cell does so within this part of it.
const OF_CELL: f64 = 0.25;
/// By how much corners are off the line is learnt from them, over so many. Before, it is taken for the jitter, and for no less
/// than such a part of a cell, with the weight of so many; and one counts as so many times the usual at most.
const MEMORY: f64 = 32.0;
const FIRST: f64 = 0.02;
const PRIOR: f64 = 4.0;
const OUTLIER: f64 = 9.0;
/// Not even a grid without any jitter has sharper corners, s².
const LEAST: f64 = 1e-14;
/// What is so many standard deviations outside of a cell is no tooth.
const BEYOND: f64 = 5.0;
/// A drift that one tooth shows lies between none and twice the half of it, one that several show within this part.
const OF_ONE: f64 = 0.5;
const OF_SEVERAL: f64 = 0.2;

/// A jump of the phase: when, by how much, and where the phases are since, s.
#[derive(Clone, Copy, Debug, Default)]
struct Jump {
    time: f64,
    size: f64,
    level: f64,
}

/// The last jumps, and the level of the last block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Teeth {
    /// The oldest first.
    jumps: [Jump; ALIKE],
    known: usize,
    /// The phase of the newest block, s.
    level: f64,
    /// The variance of a corner, s², a mean over so many.
    corner: f64,
    corners: f64,
}

/// The drift that a tooth or several show beside the level line, and what that is wrong by, s/s.
#[derive(Clone, Copy, Debug)]
struct Shown {
    drift: f64,
    sigma: f64,
}

/// The variance of an estimate after so many seconds; it knows at least in which cell it is.
pub(super) fn within_cell(estimate: &Estimate, dt: f64, walk: f64, cell: f64) -> f64 {
    let variance = estimate.offset_variance_after(dt, walk);
    variance.min(cell * cell / 12.0)
}

/// Phases lie within a cell above the line.
const fn bounds(cell: f64, unsure: f64) -> Bounds {
    Bounds {
        early: -unsure,
        late: cell + unsure,
        above: cell + unsure,
        level: 0.0,
        patience: 1.0,
    }
}

impl Teeth {
    fn take(&mut self, jump: Jump) {
        // What is left of a tooth is no tooth.
        if self.known > 0 && jump.size.abs() < LEFT * self.jumps[ALIKE - 1].size.abs() {
            return;
        }
        self.jumps.copy_within(1.., 0);
        self.jumps[ALIKE - 1] = jump;
        self.known = (self.known + 1).min(ALIKE);
    }

    /// Whether the last jumps are alike and come at regular intervals, and phases were level in between.
    fn return_regularly(&self) -> bool {
        let [first, middle, last] = self.jumps;
        let is_alike = |jump: &Jump| (jump.size / last.size - 1.0).abs() < SIZE;
        let intervals = [middle.time - first.time, last.time - middle.time];
        let is_regular = (intervals[0] / intervals[1] - 1.0).abs() < REGULAR;
        let climbed = last.level - first.level - middle.size - last.size;
        let is_level = climbed.abs() < LEVEL * last.size.abs();
        self.known == ALIKE && [first, middle].iter().all(is_alike) && is_regular && is_level
    }

    /// Learns from a corner that was off by so much what they are worth, beside what is known of the line.
    fn learn(&mut self, off: f64, known: f64) {
        self.corners = (self.corners + 1.0).min(MEMORY);
        let sample = (off * off - known).clamp(0.0, OUTLIER * self.corner);
        self.corner += (sample - self.corner) / self.corners;
        self.corner = self.corner.max(LEAST);
    }

    /// What they show; the phases were level since the start, at 0, or since the jump before.
    fn shown(&self) -> Shown {
        let [_, before, last] = self.jumps;
        let one = last.size / (last.time - before.time);
        let (part, sigma) = match self.return_regularly() {
            true => (1.0, OF_SEVERAL),
            false => (0.5, OF_ONE),
        };
        Shown {
            drift: (part * one).clamp(-LARGEST_DRIFT, LARGEST_DRIFT),
            sigma: (sigma * one.abs()).min(LARGEST_DRIFT),
        }
    }
}

impl PhaseObserver {
    /// Whether a jump of the phase is a tooth. Then only corners count from now on.
    pub(super) fn is_tooth(&mut self, newest: i64, jump: f64) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        let cycle = self.seconds_per_count;
        let cells = rounded(cycle / jump.abs()).max(1);
        let cell = cycle / cells as f64;
        let is_cell = cells <= MOST_CELLS && (jump.abs() / cell - 1.0).abs() < SIZE;
        if stream.resolution.polled() > 0.0 || !is_cell || cell < COARSER * self.jitter.width() {
            return false;
        }
        let level = stream.expected(newest, cycle);
        stream.teeth.take(Jump {
            time: newest as f64 * cycle,
            size: jump,
            level,
        });
        let is_tooth = match stream.echo.is_missing() {
            Some(is_missing) => is_missing,
            None => stream.teeth.return_regularly(),
        };
        if !is_tooth {
            return false;
        }
        stream.resolution.set_polled(cell);
        self.begin_at_corner(newest, jump, -jump.max(0.0));
        true
    }

    /// The line begins anew at the corner where phases jumped: it lies so much beside where the line of all messages now is
    /// at the newest message, s.
    fn begin_at_corner(&mut self, newest: i64, jump: f64, beside: f64) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Some(line) = &stream.line else {
            return;
        };
        let Shown { drift, sigma } = stream.teeth.shown();
        let before = *line.bank.combined();
        let ahead = newest.saturating_sub(line.at) as f64 * self.seconds_per_count;
        let cell = stream.resolution.polled();
        let first = (FIRST * cell).max(self.jitter.width());
        stream.teeth.corner = first * first;
        stream.teeth.corners = PRIOR;
        let offset = before.offset + before.drift * ahead + beside;
        let estimate = Estimate {
            offset,
            drift,
            offset_variance: stream.teeth.corner,
            covariance: 0.0,
            drift_variance: sigma * sigma,
        };
        stream.teeth.level = offset + jump.max(0.0);
        let since = stream.teeth.jumps[0].time;
        self.begin_line_anew(newest, &estimate, drift - before.drift);
        if let Some(line) = self.stream.as_mut().and_then(|stream| stream.line.as_mut()) {
            line.bounds = bounds(cell, BEYOND * cell);
        }
        let change = &mut self.drift_change;
        change.taken_back.0 += change.attributed.since(since);
        change.attributed.forget();
    }

    /// Where arrivals are polled for, takes the block that is full: a corner is a measurement, and a level says nothing. Gives
    /// whether they are.
    pub(super) fn take_level(&mut self, arrived: Instant<Local>) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        stream.echo.judge();
        let polled = stream.resolution.polled();
        let is_unseen = stream.echo.is_missing() == Some(true) && polled == 0.0;
        let unseen = if is_unseen {
            self.seconds_per_count
        } else {
            0.0
        };
        stream.choice.cells_unseen(unseen);
        let newest = stream.block[stream.filled.saturating_sub(1)];
        let block: [Residual; BLOCK] = core::array::from_fn(|n| stream.block[n]);
        let middle = stream.middle();
        let Some(line) = &mut stream.line else {
            return false;
        };
        if polled == 0.0 {
            return false;
        }
        stream.filled = 0;
        if stream.teeth.known == 0 {
            // The grid shows by this block, the first that is not level.
            let values = block.iter().map(|residual| residual.value);
            let jump = values
                .max_by(|a, b| a.abs().total_cmp(&b.abs()))
                .unwrap_or(0.0);
            stream.teeth.take(Jump {
                time: newest.count as f64 * self.seconds_per_count,
                size: jump,
                level: 0.0,
            });
            self.begin_at_corner(newest.count, jump, jump.min(0.0));
            return true;
        }
        let dt = middle.saturating_sub(line.at).max(0) as f64 * self.seconds_per_count;
        let estimate = *line.bank.combined();
        let expected = estimate.offset + estimate.drift * dt;
        let lowest = block
            .iter()
            .map(|residual| residual.value)
            .fold(f64::INFINITY, f64::min);
        let is_low = |residual: &&Residual| residual.value < lowest + 0.5 * polled;
        let low = block.iter().filter(is_low);
        let (sum, count) = low.fold((0.0, 0.0), |(sum, count), low| {
            (sum + low.value, count + 1.0)
        });
        let level = expected + sum / count;
        let is_cell = |jump: f64| (jump.abs() / polled - 1.0).abs() < OF_CELL;
        let highest = block
            .iter()
            .map(|residual| residual.value)
            .fold(f64::NEG_INFINITY, f64::max);
        let jump = level - stream.teeth.level;
        stream.teeth.level = level;
        let corner = match () {
            () if is_cell(jump) => Some(level - jump.max(0.0)),
            () if is_cell(highest - lowest) => Some(level),
            () => None,
        };
        if let Some(corner) = corner {
            let walk = line.bank.drift_walk();
            let known = estimate.offset_variance_after(dt, walk);
            stream.teeth.learn(corner - expected, known);
            line.at = line.at.max(middle);
            line.bank.observe(dt, corner, stream.teeth.corner);
        }
        let ahead = middle.saturating_sub(line.at).max(0) as f64 * self.seconds_per_count;
        let (estimate, walk) = (line.bank.combined(), line.bank.drift_walk());
        let sigma = libm::sqrt(within_cell(estimate, ahead, walk, polled));
        let corner = libm::sqrt(stream.teeth.corner);
        line.bounds = bounds(polled, BEYOND * (corner + sigma));
        self.choose_line(arrived, middle);
        true
    }
}
