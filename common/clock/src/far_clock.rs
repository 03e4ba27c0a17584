//! A far clock, whole: messages and responses in, requests out, far time at any local instant.
//!
//! [`FarClock`] is the one handle over the [`PhaseObserver`] and the [`DelayExchange`]: the first finds the
//! line that messages arrive on, the second how far the sender's clock is ahead of it. Nothing here
//! sends or receives, and every instant is an argument:
//!
//! ```
//! use coaxle_clock::far_clock::{DelaySource, FarClock};
//! use coaxle_clock::observer::ObserverParameters;
//! use coaxle_clock::{CycleTime, Instant, Span};
//!
//! let cycle_time = CycleTime::new(Span::from_millis(1))?;
//! let fixed = DelaySource::Fixed(Span::from_micros(200));
//! let mut clock = FarClock::new(cycle_time, ObserverParameters::default(), fixed, 1)?;
//!
//! // The sender's clock runs 100 ppm slow, and messages take 200 µs.
//! let arrival = |count: i64| Instant::from_nanos(count * 1_000_100 + 200_000);
//! for count in 0..3_000 {
//!     clock.message(7, count as u64, arrival(count), None);
//!     // The own cycle, half a millisecond later.
//!     let now = clock.cycle(arrival(count) + Span::from_micros(500), |_, _| {});
//!     if count > 2_000 {
//!         assert!(now.is_sure);
//!     }
//! }
//! // Between cycles too: the sender is in the middle of its cycle 3000.
//! let at = arrival(3_000) - Span::from_micros(200) + Span::from_nanos(500_050);
//! let far = clock.far_time_at(at).expect("it is followed");
//! assert!(far.time.since(Instant::from_nanos(3_000_500_000)).0.abs() < 1e-6);
//! assert!(far.uncertainty.0 < 10e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Where a [timing channel](crate::timing) runs beside the transport, [`FarClock::timing_exchange`] takes its
//! exchanges, and the far time is as good as its stamps.
//!
//! With [`DelaySource::Measured`] there is a request to send whenever [`FarClock::request`] returns a number; the
//! response comes back as a [`TimeResponse`] with its four stamps.

mod output;

use crate::common_time::{CommonReading, CommonTime, FarCommonReading};
use crate::cycle::CycleTime;
use crate::delay::{Asymmetry, DelayExchange, DelayOutput, DelayState, Refusal, TimeResponse};
use crate::instant::{Instant, Local, Seconds, Span};
use crate::observer::{FarLine, ObserverLine, ObserverParameters, ObserverState, PhaseObserver};
use crate::time_sync::WrongParameter;
use crate::timing::{Known, Steering, TimingChannel};
use crate::two_way::TwoWay;
pub use output::{CommonTimeOutput, FarClockOutput, FarReading};

/// Responses that can wait for their cycle.
pub const RESPONSES: usize = 16;

/// Standard deviations that the uncertainty covers.
const COVERED: f64 = 3.0;

/// Source of the constant part of the delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DelaySource {
    /// Measured by time requests to the far node: the set values are those of its axes at the same
    /// moment.
    Measured,
    /// Fixed value, µs.
    #[cfg_attr(feature = "serde", serde(rename = "fixed-us"))]
    Fixed(
        #[cfg_attr(feature = "serde", serde(with = "super::instant::micros"))]
        #[cfg_attr(feature = "schema", schemars(with = "f64", range(min = -1e6, max = 1e6)))]
        Span,
    ),
    /// No compensation, as in TS5066: far time lags by the delay.
    #[default]
    Off,
}

impl DelaySource {
    /// Greatest fixed delay, forwards and backwards.
    // A cycle lasts 0.1 s at most, and the age limits of messages are far below a second: more is a wrong unit.
    pub const MOST: Span = Span::from_secs(1);

    /// True if a fixed delay is within the range.
    #[must_use]
    pub fn is_in_range(self) -> bool {
        match self {
            Self::Fixed(delay) => (-Self::MOST..=Self::MOST).contains(&delay),
            Self::Measured | Self::Off => true,
        }
    }
}

/// Follows one far clock.
///
/// Per cycle of the own clock: [`message`](Self::message) and [`response`](Self::response) for what has
/// come, then [`cycle`](Self::cycle), then [`request`](Self::request). Nothing allocates.
#[derive(Clone, Debug)]
pub struct FarClock {
    observer: PhaseObserver,
    delay: DelaySource,
    /// Delay in force until one is measured.
    held: Span,
    exchange: DelayExchange,
    waiting: [Option<(Instant<Local>, TimeResponse)>; RESPONSES],
    /// Responses that found no room to wait.
    overflow: u64,
    /// Exchanges beside the transport, stamped nearer to the wire.
    timing: TimingChannel,
    /// Common time of both nodes, and its exchanges.
    common: CommonTime,
    by_common_time: TimingChannel,
    /// The exchanges of the transport as a line of their own.
    two_way: TwoWay,
    steering: Steering,
    /// The line that the delay is measured against.
    line: Option<FarLine>,
    is_sure: bool,
    /// The newest cycle, if there was one.
    cycled: Option<Instant<Local>>,
    newest: FarClockOutput,
}

impl FarClock {
    /// Makes the clock of a node whose nominal cycle time is `far_cycle_time`, which its messages say. `run`
    /// distinguishes the requests of this run of the own node from those of others.
    ///
    /// # Errors
    /// [`WrongParameter`] names the parameter that is out of its range.
    pub fn new(
        far_cycle_time: CycleTime,
        parameters: ObserverParameters,
        delay: DelaySource,
        run: u64,
    ) -> Result<Self, WrongParameter> {
        Ok(Self {
            observer: PhaseObserver::new(far_cycle_time, parameters)?,
            delay,
            held: Span::ZERO,
            exchange: DelayExchange::new(run),
            waiting: [None; RESPONSES],
            overflow: 0,
            timing: TimingChannel::default(),
            common: CommonTime::default(),
            by_common_time: TimingChannel::default(),
            two_way: TwoWay::default(),
            steering: Steering::NONE,
            line: None,
            is_sure: false,
            cycled: None,
            newest: FarClockOutput::default(),
        })
    }

    /// Takes a message that arrived at `at`: number `count` of the far node's run `epoch`, which left `send_stamp`
    /// after the ideal start of its cycle.
    pub fn message(
        &mut self,
        epoch: u64,
        count: u64,
        at: Instant<Local>,
        send_stamp: Option<Span>,
    ) {
        self.observer.observe(epoch, count, at, send_stamp);
    }

    /// Takes a response that arrived at `at`. It waits for the first cycle that ideally begins no earlier.
    pub fn response(&mut self, at: Instant<Local>, response: &TimeResponse) {
        if self.delay != DelaySource::Measured {
            return;
        }
        match self.waiting.iter_mut().find(|place| place.is_none()) {
            Some(place) => *place = Some((at, *response)),
            None => self.overflow = self.overflow.saturating_add(1),
        }
    }

    /// Takes an exchange of the timing channel, whose response arrived at `at`: its four stamps were taken near to the
    /// wire. It is of use while the delay is measured.
    pub fn timing_exchange(&mut self, at: Instant<Local>, exchange: &TimeResponse) {
        if self.delay == DelaySource::Measured {
            self.timing.exchange(at, exchange);
        }
    }

    /// Takes readings of the common time in one exchange: the own one, at `here`, and that of the far node. It is of use while the delay is
    /// measured.
    pub fn common_time(
        &mut self,
        here: Instant<Local>,
        own: Option<CommonReading>,
        far: Option<FarCommonReading>,
    ) {
        if self.delay != DelaySource::Measured {
            return;
        }
        if let Some((arrived, exchange)) = self.common.take(here, own, far) {
            self.by_common_time.exchange(arrived, &exchange);
        }
    }

    /// Returns the number of the request to send in the cycle that ideally began at `now`, if one is due.
    pub fn request(&mut self, now: Instant<Local>) -> Option<u32> {
        match self.delay {
            DelaySource::Measured => self.exchange.ask(now),
            DelaySource::Off | DelaySource::Fixed(_) => None,
        }
    }

    /// Runs the cycle that ideally begins at `now`, with all messages up to then.
    ///
    /// Every response to a request of this run is shown to `used`, with its arrival. The output stays here until the
    /// next cycle: [`newest`](Self::newest).
    pub fn cycle(
        &mut self,
        now: Instant<Local>,
        used: impl FnMut(Instant<Local>, &TimeResponse),
    ) -> &FarClockOutput {
        if self.delay == DelaySource::Measured {
            self.measure(now, used);
        }
        let measures = self.delay == DelaySource::Measured;
        // Decided in each cycle, as exchanges may end at any time and steps are then for the messages to attribute.
        (self.observer).leave_steps_to_exchanges(measures && self.exchange.can_attribute(now));
        self.steer(now);
        // After the delay is passed on, or far time would follow a new one a cycle late.
        let mut observer = self.observer.cycle(now);
        if let Steering::Channel { rate, .. } = self.steering {
            observer.drift_ppm = (rate - 1.0) * 1e6;
            if !self.has_channel() {
                observer.line = ObserverLine::TwoWay;
            }
        }
        self.is_sure = is_sure(observer.state, self.is_sure);
        let delay = self.delay_output(now);
        let timing = self.timing.output(now);
        let common_time = self.common.lack().map(|lack| CommonTimeOutput {
            lack,
            timing: self.by_common_time.output(now),
        });
        self.cycled = Some(now);
        self.newest = FarClockOutput {
            observer,
            delay,
            timing,
            common_time,
            is_sure: self.is_sure,
        };
        &self.newest
    }

    /// Output of the newest cycle.
    #[must_use]
    pub fn newest(&self) -> Option<&FarClockOutput> {
        self.cycled.map(|_| &self.newest)
    }

    /// Returns the shift in time that makes message number `count` what the far node would have sent at the newest
    /// cycle; none as long as that is not sure.
    #[must_use]
    pub fn correction(&self, count: u64) -> Option<Seconds> {
        let newest = self.newest().filter(|newest| newest.is_sure)?;
        let sent = self.observer.far_time_of(count)?;
        Some(newest.observer.far_time?.since(sent))
    }

    /// Returns the far time at the local instant `at`, extrapolated from the newest cycle; none before it is known at
    /// all.
    #[must_use]
    pub fn far_time_at(&self, at: Instant<Local>) -> Option<FarReading> {
        let now = self.cycled?;
        let FarClockOutput {
            observer, delay, ..
        } = &self.newest;
        let offset_sigma = match self.steering {
            Steering::Channel { sigma, .. } => sigma,
            Steering::Exchanges { .. } => observer.offset_sigma,
        };
        let passed = (at - now).as_nanos() as f64;
        let rate = 1.0 + observer.drift_ppm * 1e-6;
        let observed =
            // Added and not as squares: beyond the newest cycle both errors may point the same way.
            COVERED * (offset_sigma.0 + observer.drift_sigma_ppm * 1e-6 * (passed * 1e-9).abs());
        // What is measured of the delay covers the line it is measured against.
        let known = delay.uncertainty.map_or(0.0, |uncertainty| uncertainty.0);
        Some(FarReading {
            time: observer.far_time?.plus(passed * rate),
            uncertainty: Seconds(observed.max(known) + observer.slew_remaining.0.abs()),
        })
    }

    /// Changes the source of the delay. Once far time is sure the change is slewed. Until one is measured the one
    /// before stays in force.
    pub fn set_delay(&mut self, delay: DelaySource) {
        if delay == self.delay {
            return;
        }
        self.held = self.delay_in_force();
        self.delay = delay;
        self.waiting = [None; RESPONSES];
        self.timing.forget();
        self.common = CommonTime::default();
        self.by_common_time.forget();
        self.two_way.forget();
        self.steering = Steering::NONE;
        if delay == DelaySource::Measured {
            self.exchange.restart();
        }
    }

    /// States the asymmetry of the ways of the link, for a delay that is measured. Once far time is sure the change is slewed.
    pub const fn state_asymmetry(&mut self, stated: Option<Asymmetry>) {
        self.exchange.state_asymmetry(stated);
    }

    fn delay_in_force(&self) -> Span {
        match self.delay {
            DelaySource::Off => Span::ZERO,
            DelaySource::Fixed(delay) => delay,
            DelaySource::Measured => match (self.steering, self.exchange.delay()) {
                (Steering::Channel { ahead, .. }, _) => ahead.to_span(),
                (Steering::Exchanges { beside }, Some(delay)) => delay + beside.to_span(),
                (Steering::Exchanges { .. }, None) => self.held,
            },
        }
    }

    /// Passes the delay to the observer, be it measured by the timing channel or otherwise.
    fn steer(&mut self, now: Instant<Local>) {
        if self.delay == DelaySource::Measured && self.has_channel() {
            self.steering = self.by_channels(now);
        } else if self.delay == DelaySource::Measured && self.two_way.is_in_use()
            || self.is_steered()
        {
            let was = self.is_steered();
            let line = self.observer.line();
            let two_way = line.and_then(|line| self.two_way.steer(now, &line, &self.exchange, was));
            self.steering = two_way.unwrap_or(Steering::NONE);
        }
        let delay = self.delay_in_force();
        match self.steering {
            Steering::Channel {
                begins: false,
                rate,
                ..
            } => self.observer.follow_delay(delay, rate),
            Steering::Channel { begins: true, .. } | Steering::Exchanges { .. } => {
                self.observer.set_delay(delay);
            }
        }
    }

    /// True if there is a timing channel, or a common time.
    const fn has_channel(&self) -> bool {
        self.timing.is_heard() || self.by_common_time.is_heard()
    }

    /// Steers by the common time; without it, or where it is contradicted, by the timing channel.
    fn by_channels(&mut self, now: Instant<Local>) -> Steering {
        let line = self.observer.line();
        let known = line.as_ref().and_then(|line| self.known(now, line));
        let by_ways = match self.timing.is_heard() {
            true => self.timing.steer(now, line.as_ref(), known),
            false => Steering::NONE,
        };
        if !self.by_common_time.is_heard() {
            return by_ways;
        }
        // What ways leave open watches the common time, which shows no error of its own.
        let was_in_use = self.by_common_time.is_in_use();
        let watching = by_ways.watching(known);
        let by_common_time = self.by_common_time.steer(now, line.as_ref(), watching);
        let ends = was_in_use && !self.by_common_time.is_in_use();
        by_ways.under(by_common_time, ends)
    }

    /// True if far time follows exchanges and not messages.
    const fn is_steered(&self) -> bool {
        matches!(self.steering, Steering::Channel { .. })
    }

    /// Delay by the exchanges of the transport.
    fn known(&self, now: Instant<Local>, line: &FarLine) -> Option<Known> {
        let output = self.exchange.output(now, line);
        let is_measured = matches!(output.state, DelayState::Measured | DelayState::Stale);
        Some(Known {
            delay: output.delay.filter(|_| is_measured)?,
            uncertainty: output.uncertainty?,
        })
    }

    fn measure(
        &mut self,
        now: Instant<Local>,
        mut used: impl FnMut(Instant<Local>, &TimeResponse),
    ) {
        let Some(line) = self.follow_line() else {
            return;
        };
        for place in &mut self.waiting {
            if let Some((arrived, response)) = place.take_if(|(at, _)| *at <= now) {
                // It counts the responses that it refuses.
                match self.exchange.take(&response, arrived, &line) {
                    Err(Refusal::OtherRun | Refusal::OtherEpoch | Refusal::NotAsked) => {}
                    // Another estimator may think otherwise of one that is implausible.
                    Err(_) => used(arrived, &response),
                    Ok(()) => {
                        self.two_way.take(arrived, &response, &line, &self.exchange);
                        used(arrived, &response);
                    }
                }
            }
        }
        if self.settle_drift() {
            // The output of this cycle is about the line that its far time is on.
            self.follow_line();
        }
        if let Some(step) = self.exchange.step_of_sender() {
            let mapped = self.observer.attribute_step_to_sender(step);
            self.exchange.map_step_of_sender(mapped);
        }
    }

    /// Returns the line as it is now, after the exchange has followed it.
    fn follow_line(&mut self) -> Option<FarLine> {
        let line = self.observer.line()?;
        self.line = Some(line);
        if let Some(jump) = self.exchange.follow(&line) {
            self.observer.attribute_step_to_path(jump);
        }
        Some(line)
    }

    /// Attributes a drift that may have changed by exchanges. Returns whether the line may have begun again.
    fn settle_drift(&mut self) -> bool {
        let suspected = self.observer.suspected_drift();
        let to_sender = self.exchange.is_drift_of_sender(suspected);
        if let Some(to_sender) = to_sender {
            self.observer.attribute_drift(to_sender);
        }
        let proven = self.exchange.proven_gain();
        if let Some((gain, sigma)) = proven {
            self.observer.follow_drift(gain, sigma);
        }
        to_sender == Some(true) || proven.is_some()
    }

    fn delay_output(&self, now: Instant<Local>) -> DelayOutput {
        match self.delay {
            DelaySource::Off => DelayOutput::default(),
            DelaySource::Fixed(delay) => DelayOutput {
                state: DelayState::Fixed,
                delay: Some(delay.into()),
                ..DelayOutput::default()
            },
            DelaySource::Measured => {
                let output = match &self.line {
                    Some(line) => self.exchange.output(now, line),
                    None => DelayOutput {
                        state: DelayState::Asking,
                        ..DelayOutput::default()
                    },
                };
                let output = self.steering.applied_to(output);
                DelayOutput {
                    refused: output.refused.saturating_add(self.overflow),
                    ..output
                }
            }
        }
    }
}

/// True if far time is sure: holding over, or with more uncertainty, it goes on as it did before.
const fn is_sure(state: ObserverState, before: bool) -> bool {
    match state {
        ObserverState::Synced => true,
        ObserverState::Unsure | ObserverState::Holdover => before,
        ObserverState::Startup | ObserverState::Locking | ObserverState::Lost => false,
    }
}

#[cfg(test)]
mod tests;
