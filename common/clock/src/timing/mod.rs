//! The timing channel: a far clock by exchanges that were stamped near to the wire.
//!
//! Messages of axes are stamped where the program gets them, some ten microseconds late, and later for seconds when a
//! machine is busy. Exchanges that the kernel or the network card stamps are a hundred times sharper, but they may come
//! to an end at any time, and they come by another way than the axes. So they do not replace the
//! [`PhaseObserver`](crate::PhaseObserver), which goes on to follow the messages: they measure the sender's lead over
//! its line in every cycle, as [`DelayExchange`](crate::DelayExchange) does. The line's own wander cancels in that, and
//! where the channel comes to an end the far time goes on along the line, without a step.
//!
//! ```text
//! sender's clock   S ·············· what exchanges of the timing channel show, to a fraction of a microsecond
//!                    ↕ S − F         taken for the delay, as long as the channel is in use
//! observer's line  F ∿∿∿∿∿∿∿∿∿∿∿∿∿ what messages show
//! ```
//!
//! The channel is believed no further than the time exchanges of the transport leave open: one that contradicts them
//! is not used.

mod doubt;
pub(crate) mod line;
mod noise;
mod own_rate;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the timing channel.
    TimingTuning {
        /// Time without an exchange after which the channel is not in use any more.
        // Twenty of its exchanges at the least.
        stale_after: Span = Span::from_secs(2),
        /// Longest exchange.
        // One beyond it is wrong.
        longest: Span = Span::from_secs(1),
        /// Part of what both leave open within which a contradicted channel is believed again.
        // What is left open changes with the newest ways by a tenth: a clock that runs away was named ten times a second in turn with being used.
        reconciled: f64 = 0.5,
    }
}

#[cfg(test)]
mod tests;

use crate::delay::{DelayOutput, DelayState, TimeResponse};
use crate::instant::{Instant, Local, Seconds, Span};
use crate::observer::FarLine;
use line::TimingLine;
use own_rate::OwnRate;

/// Exchanges after which a change of a clock's rate has shown: a measurement is made of a group of them, and the change begins
/// within a group, so that only the next one is wholly of the time after it.
pub const EXCHANGES_OF_A_CHANGE: u32 = 2 * line::GROUP as u32;

/// Exchanges that can wait for their cycle.
const WAITING: usize = 16;

/// State of the timing channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum TimingState {
    /// Without exchanges, or not used.
    #[default]
    Waiting,
    /// Acquiring: too few exchanges as yet, or they are no better than those of the transport.
    Acquiring,
    /// Followed by the far time.
    InUse,
    /// No longer in use: the far time goes on from it, by the messages alone.
    Held,
    /// Contradicted by the time exchanges of the transport.
    Contradicted,
}

/// State and quality of the timing channel.
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimingOutput {
    /// State of the channel.
    pub state: TimingState,
    /// Standard deviation of the sender's clock as its exchanges show it.
    pub sigma: Option<Seconds>,
    /// Least round trip of late, both ways together.
    pub round_trip: Option<Seconds>,
    /// Time since the newest exchange.
    pub age: Option<Span>,
    /// Exchanges used.
    pub exchanges: u64,
    /// Exchanges refused, as they could not be true.
    pub refused: u64,
    /// Restarts of its line, since the clocks were no longer where the line had them.
    pub restarts: u32,
    /// Distance of the sender's clock from where other exchanges have it; none while one of both is not known.
    pub apart: Option<Seconds>,
}

/// Steering of the far time in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Steering {
    /// By the timing channel: the sender's clock is `ahead` of the line.
    Channel {
        ahead: Seconds,
        uncertainty: Seconds,
        sigma: Seconds,
        /// Rate of the sender's clock, seconds per local second.
        rate: f64,
        /// True if the channel did not steer in the cycle before.
        begins: bool,
    },
    /// By the exchanges of the transport, and what the channel left behind.
    Exchanges { beside: Seconds },
}

impl Steering {
    /// Steering without a timing channel.
    pub(crate) const NONE: Self = Self::Exchanges {
        beside: Seconds::ZERO,
    };

    /// The delay by which another channel is judged: by this one while it is in use, or else by the transport's exchanges and what it left
    /// behind.
    pub(crate) fn watching(&self, known: Option<Known>) -> Option<Known> {
        match *self {
            Self::Channel {
                ahead, uncertainty, ..
            } => Some(Known {
                delay: ahead,
                uncertainty,
            }),
            Self::Exchanges { beside } => known.map(|known| Known {
                delay: Seconds(known.delay.0 + beside.0),
                uncertainty: Seconds(known.uncertainty.0 + libm::fabs(beside.0)),
            }),
        }
    }

    /// The steering where another channel steers, or has left the sender's lead `beside` behind.
    pub(crate) fn under(self, other: Self, other_ends: bool) -> Self {
        match (other, self) {
            (Self::Channel { .. }, _) => other,
            (Self::Exchanges { beside: left }, Self::Exchanges { beside }) => Self::Exchanges {
                beside: Seconds(beside.0 + left.0),
            },
            (
                Self::Exchanges { beside: left },
                Self::Channel {
                    ahead,
                    uncertainty,
                    sigma,
                    rate,
                    begins,
                },
            ) => Self::Channel {
                ahead: Seconds(ahead.0 + left.0),
                uncertainty: Seconds(uncertainty.0 + libm::fabs(left.0)),
                sigma,
                rate,
                begins: begins || other_ends,
            },
        }
    }

    /// Applies the steering to a delay.
    pub(crate) fn applied_to(&self, known: DelayOutput) -> DelayOutput {
        match *self {
            Self::Channel {
                ahead,
                uncertainty,
                sigma,
                ..
            } => DelayOutput {
                state: DelayState::Measured,
                delay: Some(ahead),
                uncertainty: Some(uncertainty),
                jitter: Some(sigma),
                sigma: Some(sigma),
                ..known
            },
            Self::Exchanges { beside } => DelayOutput {
                delay: known.delay.map(|delay| Seconds(delay.0 + beside.0)),
                uncertainty: (known.uncertainty)
                    .map(|uncertainty| Seconds(uncertainty.0 + libm::fabs(beside.0))),
                ..known
            },
        }
    }
}

/// Delay by the transport's own exchanges in the same cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// Sender's lead over the line.
    pub(crate) delay: Seconds,
    /// Greatest error of that.
    pub(crate) uncertainty: Seconds,
}

/// The timing channel of one far clock.
#[derive(Clone, Debug, Default)]
pub(crate) struct TimingChannel {
    waiting: [Option<(Instant<Local>, TimeResponse)>; WAITING],
    is_heard: bool,
    line: Option<TimingLine>,
    /// The rate to begin the next line with, as long as there is none.
    own_rate: OwnRate,
    newest: Option<Instant<Local>>,
    state: TimingState,
    /// Difference between what the channel showed last and the exchanges, s.
    beside: f64,
    /// Run of the sender, restarts of its locking, and new maps of its counts.
    of: Option<(u64, u32, u32)>,
    exchanges: u64,
    refused: u64,
    restarts: u32,
    /// Distance from the other exchanges in the newest cycle.
    apart: Option<Seconds>,
}

impl TimingChannel {
    /// Takes an exchange whose response arrived at `arrived`.
    pub(crate) fn exchange(&mut self, arrived: Instant<Local>, exchange: &TimeResponse) {
        self.is_heard = true;
        match self.waiting.iter_mut().find(|place| place.is_none()) {
            Some(place) => *place = Some((arrived, *exchange)),
            None => self.refused = self.refused.saturating_add(1),
        }
    }

    /// True if an exchange ever came: without, there is nothing to steer by.
    pub(crate) const fn is_heard(&self) -> bool {
        self.is_heard
    }

    /// True if it steered in the newest cycle.
    pub(crate) fn is_in_use(&self) -> bool {
        self.state == TimingState::InUse
    }

    /// Forgets the line and its state.
    pub(crate) fn forget(&mut self) {
        self.line = None;
        self.own_rate = OwnRate::default();
        self.newest = None;
        self.beside = 0.0;
        self.apart = None;
        self.state = TimingState::Waiting;
    }

    /// Runs one cycle, with the observer's line as it is now and the delay by the exchanges of the transport.
    pub(crate) fn steer(
        &mut self,
        now: Instant<Local>,
        line: Option<&FarLine>,
        known: Option<Known>,
    ) -> Steering {
        let Some(far) = line else {
            return self.exchanges();
        };
        let of = (far.epoch, far.relocks, far.rebases);
        // Another run, lock or map of counts: leads over the line of before are of no use.
        if self.of.replace(of) != Some(of) {
            self.forget();
        }
        self.take_waiting(now, far);
        self.judge(now, far, known)
    }

    /// Reports the channel at `now`.
    pub(crate) fn output(&self, now: Instant<Local>) -> TimingOutput {
        let line = self.line.as_ref().filter(|line| line.is_acquired());
        TimingOutput {
            state: self.state,
            sigma: line.map(|line| Seconds(line.sigma(now))),
            round_trip: line.map(|line| Seconds(line.round_trip())),
            age: self.newest.map(|newest| now - newest),
            exchanges: self.exchanges,
            refused: self.refused,
            restarts: self.restarts,
            apart: self.apart,
        }
    }

    const fn exchanges(&self) -> Steering {
        Steering::Exchanges {
            beside: Seconds(self.beside),
        }
    }

    fn take_waiting(&mut self, now: Instant<Local>, far: &FarLine) {
        for n in 0..WAITING {
            let Some((arrived, exchange)) = self.waiting[n].take_if(|(at, _)| *at <= now) else {
                continue;
            };
            let took = arrived - exchange.requested;
            let is_plausible = exchange.epoch == far.epoch
                && (Span::ZERO..=TUNING.longest).contains(&took)
                && (Span::ZERO..=TUNING.longest)
                    .contains(&(exchange.responded - exchange.received));
            if !is_plausible {
                self.refused = self.refused.saturating_add(1);
                continue;
            }
            self.exchanges = self.exchanges.saturating_add(1);
            self.newest = Some(self.newest.map_or(arrived, |newest| newest.max(arrived)));
            let line = match &mut self.line {
                Some(line) => line,
                // The rate to begin beside is not known yet.
                None if !far.synced => continue,
                none => {
                    let Some(rate) = self.own_rate.take(arrived, &exchange, far.rate) else {
                        continue;
                    };
                    none.insert(TimingLine::new(&exchange, rate, noise::KEPT))
                }
            };
            if line.take(arrived, &exchange) {
                self.line = None;
                self.own_rate = OwnRate::default();
                self.restarts = self.restarts.saturating_add(1);
            }
        }
    }

    fn judge(&mut self, now: Instant<Local>, far: &FarLine, known: Option<Known>) -> Steering {
        let was_in_use = self.state == TimingState::InUse;
        let was_contradicted = self.state == TimingState::Contradicted;
        self.apart = None;
        let is_fresh = self
            .newest
            .is_some_and(|newest| now - newest <= TUNING.stale_after);
        let line = self.line.as_ref().filter(|line| line.is_acquired());
        let (Some(line), Some(known), true) = (line, known, is_fresh && far.synced) else {
            self.leave(now, far, known, is_fresh);
            return self.exchanges();
        };
        let ahead = far.offset_at(line.far_time(now), now).0;
        let sigma = line.sigma(now);
        let uncertainty = line.uncertainty(now);
        let apart = ahead - known.delay.0;
        self.apart = Some(Seconds(apart));
        // Both say how wrong they may be. Beyond the sum one of them is, and the transport's exchanges travel as the axes do.
        let most = known.uncertainty.0 + uncertainty;
        let most = match was_contradicted {
            true => TUNING.reconciled * most,
            false => most,
        };
        if libm::fabs(apart) > most {
            self.state = TimingState::Contradicted;
            return self.exchanges();
        }
        if uncertainty >= known.uncertainty.0 {
            self.leave(now, far, Some(known), is_fresh);
            return self.exchanges();
        }
        self.state = TimingState::InUse;
        // Should it end now, the far time goes on from here.
        self.beside = apart;
        Steering::Channel {
            ahead: Seconds(ahead),
            uncertainty: Seconds(uncertainty),
            sigma: Seconds(sigma),
            rate: line.rate(),
            begins: !was_in_use,
        }
    }

    /// Leaves the channel unused in this cycle.
    fn leave(&mut self, now: Instant<Local>, far: &FarLine, known: Option<Known>, is_fresh: bool) {
        if self.state == TimingState::InUse {
            // Taken in this cycle, whatever happened to the line and to the exchanges since the one before.
            if let (Some(line), Some(known)) = (&self.line, known) {
                let apart = far.offset_at(line.far_time(now), now).0 - known.delay.0;
                if libm::fabs(apart) <= known.uncertainty.0 {
                    self.beside = apart;
                }
            }
        }
        if !is_fresh {
            // An old line would predict the clock of seconds ago.
            self.line = None;
        }
        self.state = match self.state {
            TimingState::InUse | TimingState::Held => TimingState::Held,
            _ if is_fresh => TimingState::Acquiring,
            _ => TimingState::Waiting,
        };
    }
}

#[cfg(feature = "perturb")]
pub(crate) const ALL_TUNED: &[crate::tuning::TunedBlock] = &[
    TUNED,
    doubt::TUNED,
    line::TUNED,
    noise::TUNED,
    own_rate::TUNED,
];
