//! Regularity of frames: pace of the counts, missing counts, bursts.

use coaxle_clock::{Instant, Span};
use coaxle_node::FrameHeader;
use coaxle_os::Machine;

use super::runs::FramePlace;
use super::stamps::possible;
use crate::conform::rule::RuleOutcome;

/// Greatest deviation of a quartz …
const MOST_DRIFT: f64 = 1e-3;
/// … and accuracy of the least delay of a quarter of the time, s.
const JITTER: f64 = 0.01;
/// Length of a piece of time, whose least delay is kept, s.
const PIECE: f64 = 0.25;
/// Least number of pieces of a run with a pace.
const LEAST_PIECES: usize = 4;
/// Shares of counts that may be missing, and of frames that may leave late: machines and networks are busy now and then.
const MISSING: f64 = 0.1;
const LATE: f64 = 0.1;
/// Share of frames without stamps that may come right behind the one before.
const CROWDED: f64 = 0.5;

/// The pace of all runs.
#[derive(Debug, Default)]
pub(super) struct PaceChecks {
    current: Option<RunSegment>,
    /// The longest of those before.
    longest: Option<RunSegment>,
    came: u64,
    missing: u64,
    stamped: u64,
    late: u64,
    /// Frames with the next count: their number, and the number of those that came right behind the one before.
    next: u64,
    crowded: u64,
    before: Option<Instant<Machine>>,
}

/// Frames of one run.
#[derive(Clone, Debug)]
struct RunSegment {
    since: Instant<Machine>,
    count: u64,
    cycle: Span,
    /// Least delay of each piece of time, with the arrival of its frame, s since the first frame.
    least: Vec<Option<(f64, f64)>>,
}

impl PaceChecks {
    /// Takes a frame that has its place in a run.
    pub(super) fn take(&mut self, at: Instant<Machine>, header: &FrameHeader, step: FramePlace) {
        let cycle = header.cycle_time.span();
        self.came += 1;
        if let Some(stamp) = possible(header) {
            self.stamped += 1;
            self.late += u64::from(stamp >= cycle);
        }
        if let FramePlace::Goes { counts } = step {
            self.missing += counts - 1;
            if let (1, Some(before)) = (counts, self.before) {
                self.next += 1;
                self.crowded += u64::from(at - before < cycle / 5);
            }
        } else {
            self.begin(at, header);
        }
        self.before = Some(at);
        if let Some(segment) = &mut self.current {
            segment.take(at, header.count);
        }
    }

    fn begin(&mut self, at: Instant<Machine>, header: &FrameHeader) {
        let new = RunSegment {
            since: at,
            count: header.count,
            cycle: header.cycle_time.span(),
            least: Vec::new(),
        };
        if let Some(ended) = self.current.replace(new)
            && ended.least.len() > self.longest.as_ref().map_or(0, |run| run.least.len())
        {
            self.longest = Some(ended);
        }
    }

    pub(super) fn pace(&self) -> RuleOutcome {
        let all = self.longest.iter().chain(&self.current);
        let longest = all.max_by_key(|segment| segment.least.len());
        let known = longest.and_then(|segment| Some((segment.cycle, segment.rate()?)));
        let Some((cycle, (rate, known))) = known else {
            return RuleOutcome::not_seen("it takes a second of frames of one run");
        };
        let (rate_ppm, known_ppm, most) = (rate * 1e6, known * 1e6, MOST_DRIFT * 1e6);
        let words = format!("counts {rate_ppm:+.0} ppm off the cycle time of {cycle}");
        if rate.abs() <= MOST_DRIFT + known {
            return RuleOutcome::kept(format!("{words}, known to ± {known_ppm:.0} ppm"));
        }
        RuleOutcome::broken(
            words,
            format!("within {most:.0} ppm, and the ± {known_ppm:.0} ppm that arrivals leave open"),
        )
    }

    pub(super) fn every_cycle(&self) -> RuleOutcome {
        let all = self.came + self.missing;
        if all < 2 {
            return RuleOutcome::not_seen("it takes two good frames");
        }
        let is_kept = self.missing as f64 <= MISSING * all as f64;
        let words = format!("{} of {all} counts", self.came);
        RuleOutcome::of(is_kept, words, "a frame for each cycle")
    }

    pub(super) fn bursts(&self) -> RuleOutcome {
        let (part, all, most, words) = if self.stamped > 0 {
            let words = "left when their cycle was over already";
            (self.late, self.stamped, LATE, words)
        } else {
            let words = "came within a fifth of a cycle of the one before";
            (self.crowded, self.next, CROWDED, words)
        };
        if all < 2 {
            return RuleOutcome::not_seen("it takes two good frames");
        }
        RuleOutcome::of(
            part as f64 <= most * all as f64,
            format!("{part} of {all} frames that {words}"),
            "cycles that were missed to be skipped, not caught up",
        )
    }
}

impl RunSegment {
    fn take(&mut self, at: Instant<Machine>, count: u64) {
        let passed = (at - self.since).as_secs_f64();
        let counted = count.saturating_sub(self.count) as f64 * self.cycle.as_secs_f64();
        let (piece, delay) = ((passed.max(0.0) / PIECE) as usize, passed - counted);
        if self.least.len() <= piece {
            self.least.resize(piece + 1, None);
        }
        let least = &mut self.least[piece];
        if least.is_none_or(|(_, before)| delay < before) {
            *least = Some((passed, delay));
        }
    }

    /// Relative excess of the frame rate over that of the stated cycle time, and its accuracy.
    fn rate(&self) -> Option<(f64, f64)> {
        let pieces = self.least.len();
        if pieces < LEAST_PIECES {
            return None;
        }
        let quarter = pieces.div_ceil(4);
        let least = |pieces: &[Option<(f64, f64)>]| {
            let all = pieces.iter().flatten().copied();
            all.min_by(|(_, a), (_, b)| a.total_cmp(b))
        };
        let (begin, first) = least(&self.least[..quarter])?;
        let (end, last) = least(&self.least[pieces - quarter..])?;
        let between = end - begin;
        (between > 0.0).then(|| ((first - last) / between, JITTER / between))
    }
}
