//! Consequences of a jump of the phase.

use super::PhaseObserver;
use super::events::{Evidence, skipped_cycles};
use super::stream::Line;
use crate::instant::{Instant, Local};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of following a jump of the phase.
    FollowShiftTuning {
        /// Time after the start, s, from which the drift is trusted, whatever the offset does.
        drift_known_after: f64 = 3.0,
        /// Smaller shifts may be correlated delays, and the edge finds them itself, s.
        small_shift: f64 = 1e-4,
    }
}

/// A jump of the phase, and the part of it in whole cycles of a sender that stood still, s.
#[derive(Clone, Copy)]
struct Jump {
    shift: f64,
    cycles: i64,
    by_cycles: f64,
}

impl PhaseObserver {
    /// Follows a jump of the phase. Whole cycles of a sender that stood still go into the index map.
    pub(super) fn follow_shift(&mut self, arrived: Instant<Local>, newest: i64) {
        let Some(shift) = self.shift_line(arrived, newest) else {
            return;
        };
        // Before it is a jump of the path: with polled arrivals every tooth would be one.
        if self.is_tooth(newest, shift) {
            return;
        }
        let evidence = self.evidence();
        let cycles = skipped_cycles(shift, self.seconds_per_count, evidence, &self.parameters);
        let jump = Jump {
            shift,
            cycles,
            by_cycles: cycles as f64 * self.seconds_per_count,
        };
        let time = newest as f64 * self.seconds_per_count;
        if self.shift_choice(jump, time) {
            self.note_jump(jump, time, arrived);
        }
    }

    /// Evidence that distinguishes a longer path from a sender that stood still.
    const fn evidence(&self) -> Evidence {
        if self.exchanges_tell {
            Evidence::Exchanges
        } else if self.is_stamped {
            Evidence::SendStamps
        } else {
            Evidence::Nothing
        }
    }

    /// Shifts the line of all messages to where the last ones are. Returns the shift, s.
    fn shift_line(&mut self, arrived: Instant<Local>, newest: i64) -> Option<f64> {
        let stream = self.stream.as_mut()?;
        let line = stream.line.as_mut()?;
        let age = (arrived - self.progress.since).as_secs_f64();
        let moved = self.jitter.moved();
        let polled = stream.resolution.polled();
        let (shift, variance) = if polled > 0.0 {
            // Anywhere in a cell.
            let middle = median(*self.detector.recent());
            // Variance of a uniform distribution over the cell.
            (middle - 0.5 * polled, polled * polled / 12.0)
        } else {
            let located = self.jitter.locate(self.detector.recent(), 1e20).most_likely;
            (located - moved, self.jitter.variance())
        };
        let is_small = libm::fabs(shift) * 1e3 < self.parameters.smallest_skip_ms;
        let shift = if polled == 0.0 && age < TUNING.drift_known_after && is_small {
            // Soon after the start: the line was wrong in more than its offset. By no more than that, though.
            let drift = self.parameters.expected_drift_ppm * 1e-6;
            let before = line.bank.combined().offset;
            let mut recent = *self.detector.recent();
            for value in &mut recent {
                *value += before;
            }
            *line = Line::first(newest, &recent, &mut self.jitter, drift);
            line.bank.combined().offset - before
        } else {
            line.bank.shift(shift, variance);
            line.bounds = Line::bounds(&line.bank, &self.jitter);
            shift
        };
        stream.filled = 0;
        self.detector.clear();
        Some(shift)
    }

    /// Shifts the lower edge, and the choice between the lines. Returns whether the jump is one: the edge, where it is
    /// followed, knows small ones better.
    fn shift_choice(&mut self, jump: Jump, time: f64) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        let Jump {
            shift,
            cycles,
            by_cycles,
        } = jump;
        let size = libm::fabs(shift);
        let skip = cycles != 0 || size * 1e3 >= self.parameters.smallest_skip_ms;
        if size < TUNING.small_shift && self.jitter.cell() == 0.0 {
            // Stamps on a grid jump by cells, which is no level of the path.
            stream.choice.suspect_small_shift(time, shift);
        }
        if !stream.choice.is_edge() {
            stream.calibration.shift(shift);
        }
        if skip {
            // Points of both sides of a long jump are on no line.
            stream.drift_steps.forget_points();
            // Whole cycles of the sender's clock are exact; the edge finds the rest.
            let drift = stream.edge.line().map_or(0.0, |edge| edge.estimate.drift);
            let by = if cycles != 0 {
                by_cycles * (1.0 + drift)
            } else {
                shift
            };
            stream.edge.shift(by);
            stream.choice.shift_edge(by);
            stream.choice.shift_all(shift);
            if stream.choice.is_edge() {
                stream.calibration.shift(by);
            }
        } else if stream.choice.is_edge() {
            return false;
        } else if size >= TUNING.small_shift {
            stream.edge.shift(shift);
            stream.choice.shift_edge(shift);
            stream.choice.shift_all(shift);
        }
        true
    }

    /// Notes the jump, and maps counts to far time again where whole cycles are missing.
    fn note_jump(&mut self, jump: Jump, time: f64, arrived: Instant<Local>) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Jump {
            shift,
            cycles,
            by_cycles,
        } = jump;
        if libm::fabs(shift) >= TUNING.small_shift || !stream.choice.is_correlated() {
            self.events.shift(arrived);
        }
        let jumped = match (stream.choice.is_edge(), cycles) {
            // Whole cycles of a sender that stood still are in the map, and the path got no longer by them.
            (false, _) => shift - by_cycles,
            (true, 0) => shift,
            // The edge was moved by exactly those cycles, and finds the rest itself.
            (true, _) => 0.0,
        };
        self.jumped.0 += jumped;
        self.drift_change.attributed.note(time, jumped);
        if cycles != 0 {
            stream.origin += self.data_cycle_time * cycles;
            self.events.rebase();
        }
    }
}

fn median<const N: usize>(mut values: [f64; N]) -> f64 {
    *values.select_nth_unstable_by(N / 2, f64::total_cmp).1
}
