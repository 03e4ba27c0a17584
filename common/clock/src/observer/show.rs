//! Output of the observer once per receiver cycle: its state, the far time and what is known of it.

use super::events::within_cell;
use super::far_line::within_largest;
use super::output::Shown;
use super::report::{ObserverLine, ObserverOutput, ObserverState};
use super::stream::BLOCK;
use super::{Followed, PhaseObserver};
use crate::instant::{Instant, Local, Seconds};
use crate::numbers::together;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of what is not seen at first.
    UnseenTuning {
        /// Widths of the jitter by which the delay may be longer than usual at first …
        widths: f64 = 3.0,
        /// … and at least this, s.
        // A core that wakes up from sleep.
        least: f64 = 1e-5,
        /// Time constant with which it is forgotten, s.
        // For some seconds messages with less delay may still come.
        memory: f64 = 2.5,
    }
}

/// Time constants after which what is left changes no digit: exp(−40) is 4·10⁻¹⁸.
const FORGOTTEN_AFTER: f64 = 40.0;

impl PhaseObserver {
    /// Runs one receiver cycle, which ideally starts at `ideal_start` (the real wake-up would only add jitter).
    pub fn cycle(&mut self, ideal_start: Instant<Local>) -> ObserverOutput {
        let state = self.state(ideal_start);
        let followed = self.followed();
        self.show(ideal_start, state, followed.as_ref());
        let output = self.output(ideal_start, state, followed.as_ref());
        self.events.rebased = false;
        output
    }

    fn state(&mut self, now: Instant<Local>) -> ObserverState {
        let Some(stream) = &self.stream else {
            return ObserverState::Startup;
        };
        let silence = now - stream.newest_arrival;
        // Remembered, so that the message that ends the silence begins a new lock.
        if silence > self.lost_after {
            self.progress.lost = true;
        }
        if self.shown.is_none() && stream.line.is_none() {
            ObserverState::Startup
        } else if self.progress.lost {
            ObserverState::Lost
        } else if silence > self.holdover_after {
            ObserverState::Holdover
        } else if !self.progress.is_synced() {
            ObserverState::Locking
        } else if self.progress.is_unsure() || self.is_far_off() {
            ObserverState::Unsure
        } else {
            ObserverState::Synced
        }
    }

    /// True if the far time shown is so far from where it should be that it takes too long to make that up.
    fn is_far_off(&self) -> bool {
        let pace = self.parameters.pace(false);
        (self.shown.as_ref()).is_some_and(|shown| pace.is_too_slow_for(shown.remaining))
    }

    fn show(&mut self, now: Instant<Local>, state: ObserverState, followed: Option<&Followed>) {
        let line = followed.and_then(|line| self.heading(&line.estimate, line.at));
        let Some(shown) = &mut self.shown else {
            // The first far time begins where it should be: there is nothing to be smooth to.
            self.delay.jump();
            let delay = self.delay.shown();
            self.shown = line.map(|line| Shown::new(now, line.at(now).plus(delay)));
            return;
        };
        let locking = state == ObserverState::Locking;
        let passed = (now - shown.at).as_nanos() as f64;
        let gained = if locking {
            self.delay.jump();
            0.0
        } else {
            self.delay.advance(passed)
        };
        let rate = self
            .known_rate
            .or(line.map(|line| line.rate))
            .unwrap_or(1.0);
        let coasting = shown.far.plus(passed * rate + gained);
        let delay = self.delay.shown();
        let target = line.map_or(coasting, |line| line.at(now).plus(delay));
        shown.advance(now, coasting, target, self.parameters.pace(locking));
    }

    fn output(
        &self,
        now: Instant<Local>,
        state: ObserverState,
        followed: Option<&Followed>,
    ) -> ObserverOutput {
        let events = &self.events;
        let mut output = ObserverOutput {
            state,
            far_time: self.shown.map(|shown| shown.far),
            slew_remaining: self.shown.map_or(Seconds::ZERO, |shown| {
                shown.remaining + Seconds(self.delay.missing() * 1e-9)
            }),
            block_length: BLOCK as u16,
            shifts: events.shifts,
            last_shift: events.last_shift,
            drift_steps: self.drift_change.steps,
            relocks: events.relocks,
            last_relock: events.last_relock,
            rebases: events.rebases,
            rebased: events.rebased,
            ..ObserverOutput::default()
        };
        if let (Some(stream), Some(followed)) = (&self.stream, followed)
            && let Some(line) = &stream.line
        {
            let due = stream.first_arrival + self.data_cycle_time * followed.at;
            let dt = (now - due).as_secs_f64().max(0.0);
            let walk = followed.drift_walk;
            let estimate = followed.estimate;
            let drift_variance = estimate.drift_variance + dt * walk;
            // Reported as the rate of the far clock, while the estimate has the growth of phases.
            output.drift_ppm = (1.0 / (1.0 + within_largest(estimate.drift)) - 1.0) * 1e6;
            let mut variance = estimate.offset_variance_after(dt, walk);
            let polled = stream.resolution.polled();
            if polled > 0.0 {
                variance = within_cell(&estimate, dt, walk, polled);
            } else if stream.choice.is_edge() {
                output.line = ObserverLine::LowerEdge;
                variance += stream.edge.bias_variance();
            } else {
                variance += line.bank.bias_variance();
            }
            let sigma = stream.calibration.of(stream.choice.sigma(variance));
            output.within_three_sigma = stream.calibration.share();
            // Uncertainty of the offset beyond the filter's holds for the drift, too.
            let doubt = sigma / libm::sqrt(variance);
            output.drift_sigma_ppm = doubt * libm::sqrt(drift_variance) * 1e6;
            let doubt = together(self.unseen(now), self.drift_doubt());
            output.offset_sigma = Seconds(together(sigma, doubt));
            output.random_walk_ppm = line.bank.random_walk_ppm();
            output.lead = Seconds(self.jitter.moved());
            output.normal_jitter = Seconds(self.jitter.normal());
            output.exponential_jitter = Seconds(self.jitter.exponential());
        }
        output
    }

    /// Uncertainty that is not seen at first: whether messages will be earlier, once the delay is another, s.
    fn unseen(&self, now: Instant<Local>) -> f64 {
        let age = (now - self.progress.since).as_secs_f64().max(0.0);
        // Saves the exponential in nearly all cycles of a run.
        if age > FORGOTTEN_AFTER * TUNING.memory {
            return 0.0;
        }
        let most = (TUNING.widths * self.jitter.width()).max(TUNING.least);
        most * libm::exp(-age / TUNING.memory)
    }
}
