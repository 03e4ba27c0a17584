//! A curve of bounded size.

use std::collections::VecDeque;

/// The smallest and the largest value of each stretch of time, so that no spike is ever lost; and every cycle within some
/// [windows](super::CurveWindow).
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// The stretches, in order.
    pub stretches: Vec<Stretch>,
    /// Every cycle of some windows, in order: time, s, and value.
    pub windows: Vec<Vec<(f64, f64)>>,
    /// Values per stretch.
    per_stretch: u32,
    filled: u32,
    /// Recent values, with which a window may begin.
    recent: VecDeque<(f64, f64)>,
    /// Beginning and end of the last window, s.
    open: Option<(f64, f64)>,
}

/// The values of a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Beginning, s.
    pub t_s: f64,
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

/// Stretches kept at most.
// More than the pixels of a wide screen, so that joined neighbours are not seen.
const MOST_STRETCHES: usize = 4_000;
/// Cycles that a window may begin in the past by, and another receiver be ahead by.
// 500 cycles of the longest window before its event, and 1000 rows that another receiver waits for its master.
const RECENT: usize = 2_000;

impl Series {
    /// Takes the next value; none is a gap.
    pub fn push(&mut self, t_s: f64, value: Option<f64>) {
        // NaN would stay in no extreme, and infinity would flatten all.
        let Some(value) = value.filter(|value| value.is_finite()) else {
            return;
        };
        self.push_cycle(t_s, value);
        match self.stretches.last_mut() {
            Some(last) if self.filled < self.per_stretch => {
                last.low = last.low.min(value);
                last.high = last.high.max(value);
                self.filled += 1;
            }
            _ => {
                self.make_room();
                self.stretches.push(Stretch {
                    t_s,
                    low: value,
                    high: value,
                });
                self.filled = 1;
            }
        }
    }

    /// Keeps every cycle from one time to another, s, past and future. A window that meets the last one extends it.
    pub fn keep(&mut self, from_s: f64, to_s: f64) {
        let kept_until = match self.open {
            Some((from, to)) if from_s <= to => {
                self.open = Some((from, to.max(to_s)));
                to
            }
            _ => {
                self.windows.push(Vec::new());
                self.open = Some((from_s, to_s));
                f64::NEG_INFINITY
            }
        };
        if let Some(window) = self.windows.last_mut() {
            // Cycles up to `kept_until` are there already, as they came while the window was open.
            let in_it = |(t, _): &&(f64, f64)| *t >= from_s && *t <= to_s && *t > kept_until;
            window.extend(self.recent.iter().filter(in_it));
        }
    }

    fn push_cycle(&mut self, t_s: f64, value: f64) {
        if self.recent.len() == RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back((t_s, value));
        let is_open = self.open.is_some_and(|(from, to)| t_s >= from && t_s <= to);
        if let (true, Some(window)) = (is_open, self.windows.last_mut()) {
            window.push((t_s, value));
        }
    }

    fn make_room(&mut self) {
        self.per_stretch = self.per_stretch.max(1);
        if self.stretches.len() < MOST_STRETCHES {
            return;
        }
        // Twice as long stretches, and half as many: each value is joined a few times at most, by the logarithm of the length.
        self.stretches = self.stretches.chunks(2).filter_map(joined).collect();
        self.per_stretch *= 2;
    }
}

/// Neighbours as one stretch; none if there are none.
pub fn joined(stretches: &[Stretch]) -> Option<Stretch> {
    let (first, others) = stretches.split_first()?;
    Some(others.iter().fold(*first, |all, one| Stretch {
        low: all.low.min(one.low),
        high: all.high.max(one.high),
        ..all
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_stays_small_and_keeps_its_spikes() {
        let mut series = Series::default();
        for k in 0..1_000_000 {
            let value = if k == 777_777 { 5.0 } else { 1.0 };
            series.push(f64::from(k), Some(value));
        }
        assert!(series.stretches.len() <= MOST_STRETCHES);
        let spikes = series.stretches.iter().filter(|s| s.high == 5.0).count();
        // A value belongs to one stretch, however often stretches are joined.
        assert_eq!(spikes, 1);
        assert!(series.stretches.is_sorted_by_key(|s| s.t_s));
    }

    #[test]
    fn a_window_has_every_cycle_of_what_was_and_of_what_comes() {
        let mut series = Series::default();
        let ask = |k: i32| match k {
            5_000 => Some((4_900.0, 5_050.0)),
            // Meets it.
            5_040 => Some((4_950.0, 5_100.0)),
            // Apart, and not even begun.
            9_000 => Some((9_010.0, 9_020.0)),
            _ => None,
        };
        for k in 0..10_000 {
            let t = f64::from(k);
            series.push(t, (k != 4_901).then_some(2.0 * t));
            if let Some((from, to)) = ask(k) {
                series.keep(from, to);
            }
        }
        let cycles = |from: i32, to: i32| {
            let all = (from..=to).filter(|k| *k != 4_901);
            all.map(|k| (f64::from(k), 2.0 * f64::from(k))).collect()
        };
        let expected: Vec<Vec<_>> = vec![cycles(4_900, 5_100), cycles(9_010, 9_020)];
        assert_eq!(series.windows, expected);
    }
}
