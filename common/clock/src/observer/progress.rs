//! How far locking has come, and what happened on the way.

use super::parameters::ObserverParameters;
use crate::instant::{Instant, Local};

#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    pub(super) synced: bool,
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

/// So many times the messages that are enough are plenty.
const PLENTY: u32 = 4;

impl Progress {
    pub(super) const fn starting_at(since: Instant<Local>) -> Self {
        Self {
            synced: false,
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

    pub(super) fn judge(
        &mut self,
        now: Instant<Local>,
        sigma: f64,
        jitter: f64,
        parameters: &ObserverParameters,
    ) {
        let enough = parameters.synced_messages;
        // Wide jitter may be alike for long, and hide a drift.
        let plenty = self.messages / PLENTY >= enough;
        let sure = sigma * 1e6 < parameters.synced_sigma_us
            || plenty && sigma < parameters.synced_sigma_part * jitter
            || (now - self.since).as_secs_f64() > parameters.longest_locking_s;
        self.synced |= sure && self.messages >= enough;
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
