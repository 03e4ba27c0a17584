//! Progress of locking, and events on the way.

use super::parameters::ObserverParameters;
use crate::instant::{Instant, Local};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the progress of locking.
    ProgressTuning {
        /// Growth of the standard deviation beyond the good one, as a factor, at which synchronised is left.
        // Less would leave it by chance.
        unsure: f64 = 2.0,
        /// Factor on the messages that are enough from which an accuracy beside the jitter counts.
        // Wide jitter may hide a drift.
        plenty_times: u32 = 4,
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    /// The standard deviation that was good enough when it synchronised, s; none before.
    granted: Option<f64>,
    /// True if it is not good enough any more.
    unsure: bool,
    pub(super) lost: bool,
    pub(super) messages: u32,
    pub(super) since: Instant<Local>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Events {
    pub(super) shifts: u32,
    pub(super) last_shift: Option<Instant<Local>>,
    pub(super) relocks: u32,
    pub(super) last_relock: Option<Instant<Local>>,
    pub(super) rebases: u32,
    pub(super) rebased: bool,
}

impl Progress {
    pub(super) const fn starting_at(since: Instant<Local>) -> Self {
        Self {
            granted: None,
            unsure: false,
            lost: false,
            messages: 0,
            since,
        }
    }

    pub(super) fn heard(&mut self, at: Instant<Local>, events: &mut Events) {
        if self.lost {
            *self = Self::starting_at(at);
            events.relock(at);
        }
        self.messages = self.messages.saturating_add(1);
    }

    /// Judges the progress after a block of messages. Locking does not end before it `may_end`.
    pub(super) fn judge(
        &mut self,
        now: Instant<Local>,
        may_end: bool,
        sigma: f64,
        jitter: f64,
        longest_locking: f64,
        parameters: &ObserverParameters,
    ) {
        match self.granted {
            Some(granted) => {
                // Hysteresis by a factor of two, or a deviation at the bound would make the state flicker.
                let bound = if self.unsure {
                    granted
                } else {
                    TUNING.unsure * granted
                };
                self.unsure = sigma > bound;
            }
            None if may_end => {
                self.granted = self.good_enough(now, sigma, jitter, longest_locking, parameters);
            }
            None => {}
        }
    }

    /// Returns the standard deviation that is good enough now, if this one is.
    fn good_enough(
        &self,
        now: Instant<Local>,
        sigma: f64,
        jitter: f64,
        longest_locking: f64,
        parameters: &ObserverParameters,
    ) -> Option<f64> {
        let enough = parameters.synced_messages;
        if self.messages < enough {
            return None;
        }
        // Wide jitter may be correlated for long, and hide a drift.
        let plenty = self.messages / TUNING.plenty_times >= enough;
        let part = if plenty {
            parameters.synced_sigma_part * jitter
        } else {
            0.0
        };
        let wanted = part.max(parameters.synced_sigma_us * 1e-6);
        let too_long = (now - self.since).as_secs_f64() > longest_locking;
        // Whatever was granted is the bound from now on: after a long wait that is what there was.
        (sigma < wanted || too_long).then_some(wanted.max(sigma))
    }

    /// True if it synchronised.
    pub(super) const fn is_synced(&self) -> bool {
        self.granted.is_some()
    }

    /// True if it synchronised, but is less sure by now.
    pub(super) const fn is_unsure(&self) -> bool {
        self.unsure
    }
}

impl Events {
    pub(super) fn shift(&mut self, at: Instant<Local>) {
        self.shifts = self.shifts.saturating_add(1);
        self.last_shift = Some(at);
    }

    pub(super) fn relock(&mut self, at: Instant<Local>) {
        self.relocks = self.relocks.saturating_add(1);
        self.last_relock = Some(at);
    }

    pub(super) fn rebase(&mut self) {
        self.rebases = self.rebases.saturating_add(1);
        self.rebased = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn synced_at(sigma: f64) -> Progress {
        let mut progress = Progress::starting_at(Instant::EPOCH);
        let mut events = Events::default();
        for _ in 0..300 {
            progress.heard(Instant::EPOCH, &mut events);
        }
        judge(&mut progress, sigma);
        progress
    }

    fn judge(progress: &mut Progress, sigma: f64) {
        let parameters = ObserverParameters::default();
        progress.judge(Instant::EPOCH, true, sigma, 20e-6, 30.0, &parameters);
    }

    #[test]
    fn locking_does_not_end_before_it_may() {
        let mut progress = Progress::starting_at(Instant::EPOCH);
        let parameters = ObserverParameters::default();
        for _ in 0..300 {
            progress.heard(Instant::EPOCH, &mut Events::default());
        }
        progress.judge(Instant::EPOCH, false, 0.0, 20e-6, 30.0, &parameters);
        assert!(!progress.is_synced());
        progress.judge(Instant::EPOCH, true, 0.0, 20e-6, 30.0, &parameters);
        assert!(progress.is_synced());
    }

    #[test]
    fn it_is_unsure_at_twice_and_sure_again_at_once_what_was_good_enough() {
        let mut progress = synced_at(0.5e-6);
        for (sigma, unsure) in [
            (1.0e-6, false),
            (1.9e-6, false),
            (2.1e-6, true),
            (1.9e-6, true),
            (1.1e-6, true),
            (0.9e-6, false),
            (1.9e-6, false),
            (1.0, true),
        ] {
            judge(&mut progress, sigma);
            assert_eq!(progress.is_unsure(), unsure, "{sigma}");
            assert!(progress.is_synced());
        }
    }

    #[test]
    fn before_it_synchronised_it_is_not_unsure() {
        let mut progress = synced_at(5e-6);
        assert!(!progress.is_synced() && !progress.is_unsure());
        judge(&mut progress, 0.9e-6);
        assert!(progress.is_synced() && !progress.is_unsure());
    }

    #[test]
    fn the_lost_begins_anew() {
        let mut progress = synced_at(0.5e-6);
        judge(&mut progress, 5e-6);
        progress.lost = true;
        let mut events = Events::default();
        let later = Instant::from_nanos(1_000);
        progress.heard(later, &mut events);
        assert!(!progress.is_synced() && !progress.is_unsure() && !progress.lost);
        assert_eq!((progress.since, progress.messages), (later, 1));
        assert_eq!((events.relocks, events.last_relock), (1, Some(later)));
    }
}
