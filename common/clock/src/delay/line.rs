//! Events of the line, and their attribution: to the path, or to the sender's clock.

use super::estimate::Estimate;
use super::step::{Cause, Step, TELLING, Ways};
use super::window::Exchange;
use super::{DelayExchange, Sender, TUNING};
use crate::instant::{Instant, Local, Seconds, Span};
use crate::observer::FarLine;

impl DelayExchange {
    /// Follows what happened to the line. After a new run of the sender everything is forgotten. A jump is taken for
    /// the path's doing, so that the sender's time stays where it was, until the next exchanges say otherwise (see
    /// [`step_of_sender`](Self::step_of_sender)); it is returned, to be passed to
    /// [`PhaseObserver::attribute_step_to_path`].
    ///
    /// [`PhaseObserver::attribute_step_to_path`]: crate::PhaseObserver::attribute_step_to_path
    pub fn follow(&mut self, line: &FarLine) -> Option<Seconds> {
        let now = Sender {
            epoch: line.epoch,
            jumped: line.jumped,
            corrected: line.corrected,
            taken_back: line.taken_back,
            drift_steps: line.drift_steps,
            rebases: line.rebases,
            relocks: line.relocks,
            synced: line.synced,
        };
        let before = match self.sender.replace(now) {
            Some(before) if before.epoch == now.epoch => before,
            _ => {
                self.forget();
                return None;
            }
        };
        if now.drift_steps != before.drift_steps {
            return self.follow_drift_step(now.taken_back - before.taken_back, line);
        }
        let jump = now.jumped - before.jumped;
        let corrected = now.corrected - before.corrected;
        let is_rebased = now.rebases != before.rebases;
        if jump != Seconds::ZERO {
            let (usual, newest) = (self.window.usual(line), self.window.newest(line));
            let step = self
                .step_of(jump, usual.zip(newest))
                .filter(|_| !is_rebased);
            // What exchanges leave open goes along with the line, until newer ones say something.
            let (bounds, pulled) = (self.bounds, self.pulled);
            self.start_over();
            (self.bounds, self.pulled) = (bounds, pulled);
            self.step = step;
            let estimate = self.estimate.as_mut()?;
            if let Some(usual) = usual {
                estimate.forget_spanning(jump.0, usual.delay() + self.asymmetry);
            }
            estimate.follow_jump(jump.0);
            // In one cycle the line may jump and be replaced by a better one.
            estimate.delay += corrected.0;
            return Some(jump + corrected);
        }
        if corrected != Seconds::ZERO {
            // The exchanges are corrected with the line: the sender's time stays where it was.
            let estimate = self.estimate.as_mut()?;
            estimate.delay += corrected.0;
            return Some(corrected);
        }
        if is_rebased || now.relocks != before.relocks {
            // Measurements against a line that is gone are no help any more.
            self.start_over();
            self.asymmetry = 0.0;
            self.is_of_lost_line = now.relocks != before.relocks;
        } else if now.synced && !before.synced {
            self.measure_again(line);
            if let Some(estimate) = &self.estimate {
                self.estimate(estimate.newest, line);
            }
            self.ask_fast();
        }
        None
    }

    /// Reports whether exchanges will attribute a step of the line at `now` to the path or to the sender.
    #[must_use]
    pub fn can_attribute(&self, now: Instant<Local>) -> bool {
        let is_fresh = |estimate: &Estimate| now - estimate.newest <= TUNING.stale_after;
        let compares = self.step.is_some() || self.window.len() >= TELLING;
        compares && self.estimate.as_ref().is_some_and(is_fresh)
    }

    /// Takes a step of the line that was taken for the path's until exchanges showed that the sender's clock stood
    /// still, or leapt; each once. It is to be passed to [`PhaseObserver::attribute_step_to_sender`], whose result
    /// goes to [`map_step_of_sender`](Self::map_step_of_sender).
    ///
    /// [`PhaseObserver::attribute_step_to_sender`]: crate::PhaseObserver::attribute_step_to_sender
    pub const fn step_of_sender(&mut self) -> Option<Seconds> {
        self.step_of_sender.take()
    }

    /// Notes the part of a step of the sender that went into the map from counts to far time; the rest is slewed.
    pub fn map_step_of_sender(&mut self, mapped: Span) {
        let (Some(estimate), Some(sender)) = (&mut self.estimate, &mut self.sender) else {
            return;
        };
        if mapped != Span::ZERO {
            estimate.take_back(mapped.as_secs_f64());
            // The sender moved with the line, so what was measured against it holds.
            sender.rebases = sender.rebases.saturating_add(1);
        }
    }

    /// Makes a step of the line for exchanges to attribute, if enough came before it.
    fn step_of(&self, jump: Seconds, before: Option<(Ways, Ways)>) -> Option<Step> {
        match &self.step {
            // Exchanges of between two steps fit neither line of before nor of after.
            Some(step) => Some(step.again(jump.0)),
            None => before.map(|(usual, newest)| Step::new(jump.0, usual, newest)),
        }
    }

    /// Follows a line that is another one, and has not jumped but changed its drift. Against another line the delay that
    /// was known may be anything that exchanges leave open.
    fn follow_drift_step(&mut self, taken_back: Seconds, line: &FarLine) -> Option<Seconds> {
        self.start_over();
        let estimate = self.estimate.as_mut()?;
        estimate.take_back(taken_back.0);
        self.bound_by_history(line);
        Some(Seconds::ZERO - taken_back)
    }

    /// Attributes the last step by an exchange.
    pub(super) fn attribute(&mut self, exchange: &Exchange) {
        let ways = Ways {
            there: exchange.there,
            back: exchange.back,
        };
        let cause = self.step.as_mut().and_then(|step| step.take(ways));
        match cause {
            None => return,
            Some(Cause::Sender(step)) => self.step_of_sender = Some(Seconds(step)),
            Some(Cause::Path { asymmetry }) => self.asymmetry += asymmetry,
        }
        self.step = None;
    }
}
