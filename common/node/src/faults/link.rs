//! A link with delays, losses, duplicates and reordering.

use coaxle_clock::Span;

use super::random::Random;
use super::terms::Terms;
use crate::config::{BurstLossConfig, LinkConfig, Wrong};

/// A link's model. It holds no messages and only computes their arrivals.
#[derive(Clone, Debug)]
pub struct LinkModel {
    config: LinkConfig,
    random: Random,
    /// Arrival of the newest message that keeps its place, since the start.
    newest: Span,
    in_burst: bool,
    /// The correlated part of the newest delay, in standard deviations, and its time.
    correlated: Option<(Span, f64)>,
    terms: Terms,
}

/// The delays of a message's arrivals: none, one or two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deliveries {
    delays: [Span; 2],
    count: u8,
    next: u8,
}

impl Deliveries {
    /// A single arrival.
    #[must_use]
    pub fn once(delay: Span) -> Self {
        let mut deliveries = Self::default();
        deliveries.push(delay);
        deliveries
    }

    fn push(&mut self, delay: Span) {
        self.delays[usize::from(self.count)] = delay;
        self.count += 1;
    }
}

impl Iterator for Deliveries {
    type Item = Span;
    fn next(&mut self) -> Option<Span> {
        (self.next < self.count).then(|| {
            self.next += 1;
            self.delays[usize::from(self.next) - 1]
        })
    }
}

impl LinkModel {
    /// Creates a link with the configured behaviour, with random parts drawn from `seed`. Reads the
    /// files of terms.
    ///
    /// # Errors
    /// [`Wrong`] names the term whose file cannot be used.
    pub fn new(config: &LinkConfig, seed: u64) -> Result<Self, Wrong> {
        Ok(Self {
            config: config.clone(),
            random: Random::new(seed),
            // Before any message.
            newest: Span::from_nanos(i64::MIN),
            in_burst: false,
            correlated: None,
            terms: Terms::of_link(config, seed)?,
        })
    }

    /// Deliveries of a message sent `since_start`. Messages are offered in the order of sending;
    /// they arrive in that order except for those that `reorder` holds back.
    pub fn offer(&mut self, since_start: Span) -> Deliveries {
        let mut deliveries = Deliveries::default();
        // Drawn for every message, so that a greater share of one fault does not shift the numbers of another. A share of 0
        // draws none: switching a fault on does shift them.
        let lost = self.random.chance(self.config.loss.get());
        let twice = self.random.chance(self.config.duplication.get());
        let held = self.random.chance(self.config.reorder.get());
        let in_burst = self.is_in_burst();
        let delay = self.delay(since_start);
        let is_faulty = self.config.is_faulty(since_start);
        let [lost, twice, held] = [lost || in_burst, twice, held].map(|it| it && is_faulty);
        if lost || self.is_cut(since_start) {
            return deliveries;
        }
        if held {
            let most = self.config.reorder_us.get();
            // A held message has its delay as any other, and waits besides.
            let held = delay + Span::from_micros_f64(most * self.random.uniform());
            deliveries.push(self.seen(since_start, held));
        } else {
            // A link with one queue does not reorder: a faster message waits for a slower one before it.
            self.newest = self.newest.max(since_start + delay);
            deliveries.push(self.seen(since_start, self.newest - since_start));
        }
        if twice {
            // A second way through the network has a delay of its own.
            let second = self.delay(since_start);
            let second = self.seen(since_start, second);
            // A copy is a copy: it cannot arrive before the original is seen.
            deliveries.push(second.max(deliveries.delays[0]));
        }
        deliveries
    }

    fn delay(&mut self, since_start: Span) -> Span {
        let steps: f64 = self
            .config
            .delay_steps
            .iter()
            .filter(|step| since_start >= step.at_s.span())
            .map(|step| step.by_us.get())
            .sum();
        let jitter = match &self.config.jitter {
            Some(jitter) => self.random.jitter_us(jitter),
            None => 0.0,
        };
        let spike = match &self.config.spikes {
            Some(spikes) if self.random.chance(spikes.share.get()) => {
                let (from, to) = (spikes.from_us.get(), spikes.to_us.get());
                let spike = from + (to - from) * self.random.uniform();
                // Drawn before it is asked: the end of the faults must not shift other numbers.
                if self.config.is_faulty(since_start) {
                    spike
                } else {
                    0.0
                }
            }
            _ => 0.0,
        };
        let correlated = self.correlated_us(since_start);
        let terms = self.terms.at(since_start.as_secs_f64());
        let micros = self.config.latency_us.get() + steps + jitter + spike + correlated + terms;
        // Normal jitter may exceed the latency: nothing arrives before it was sent.
        Span::from_micros_f64(micros.max(0.0))
    }

    fn correlated_us(&mut self, since_start: Span) -> f64 {
        let Some(config) = self.config.correlated else {
            return 0.0;
        };
        let fresh = self.random.normal();
        let now = match self.correlated {
            None => fresh,
            Some((at, before)) => {
                // Messages are offered in order. Two at one instant share their delay.
                let passed = (since_start - at).as_secs_f64().max(0.0);
                let alike = libm::exp(-passed / config.time_s.get());
                // √(1 − ρ²) keeps the variance: AR(1).
                before * alike + fresh * (1.0 - alike * alike).sqrt()
            }
        };
        self.correlated = Some((since_start, now));
        now * config.sigma_us.get()
    }

    fn is_in_burst(&mut self) -> bool {
        if let Some(BurstLossConfig { begins, ends }) = self.config.burst_loss {
            self.in_burst = match self.in_burst {
                // The state changes before the message: the one that starts a burst is lost.
                true => !self.random.chance(ends.get()),
                false => self.random.chance(begins.get()),
            };
        }
        self.in_burst
    }

    /// The visible delay of a message: after the end of a stall, and on the grid.
    fn seen(&self, since_start: Span, delay: Span) -> Span {
        let mut arrival = since_start + delay;
        for stall in &self.config.stalls {
            let from = stall.at_s.span();
            let until = from + stall.for_s.span();
            if (from..until).contains(&arrival) {
                arrival = until;
            }
        }
        let grid = self.config.resolution_us.span().as_nanos();
        if grid > 0 {
            let nanos = arrival.as_nanos();
            // Euclidean, so that instants before zero round up as well.
            let past = nanos.rem_euclid(grid);
            if past > 0 {
                arrival = Span::from_nanos(nanos - past + grid);
            }
        }
        arrival - since_start
    }

    fn is_cut(&self, since_start: Span) -> bool {
        self.config.partitions.iter().any(|partition| {
            let from = partition.at_s.span();
            let until = from + partition.for_s.span();
            // By the instant of sending: what is under way when a partition begins still arrives.
            (from..until).contains(&since_start)
        })
    }
}

#[cfg(test)]
mod tests;
