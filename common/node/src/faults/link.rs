//! A link that delays, loses, repeats and reorders.

use coaxle_clock::Span;

use super::random::Random;
use crate::config::LinkConfig;

/// A link's model. It never holds a message: it only says when each would arrive.
#[derive(Clone, Debug)]
pub struct LinkModel {
    config: LinkConfig,
    random: Random,
    /// Arrival of the newest message that keeps its place, since the start.
    newest: Span,
}

/// The delays after which a message arrives: none, one or two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deliveries {
    delays: [Span; 2],
    count: u8,
    next: u8,
}

impl Deliveries {
    /// One arrival.
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
    /// A link that behaves as configured, with random parts drawn from `seed`.
    #[must_use]
    pub fn new(config: &LinkConfig, seed: u64) -> Self {
        Self {
            config: config.clone(),
            random: Random::new(seed),
            newest: Span::from_nanos(i64::MIN),
        }
    }

    /// What becomes of a message sent `since_start`. Messages are offered in the order they were
    /// sent; they arrive in that order but for those that `reorder` holds back.
    pub fn offer(&mut self, since_start: Span) -> Deliveries {
        let mut deliveries = Deliveries::default();
        // Drawn for every message, so that one fault does not shift the numbers of another.
        let lost = self.random.chance(self.config.loss.get());
        let twice = self.random.chance(self.config.duplication.get());
        let held = self.random.chance(self.config.reorder.get());
        let delay = self.delay(since_start);
        if lost || self.is_cut(since_start) {
            return deliveries;
        }
        if held {
            let most = self.config.reorder_us.get();
            deliveries.push(delay + Span::from_micros_f64(most * self.random.uniform()));
        } else {
            // A link with one queue does not reorder: who comes early waits for who is late.
            self.newest = self.newest.max(since_start + delay);
            deliveries.push(self.newest - since_start);
        }
        if twice {
            let second = self.delay(since_start);
            deliveries.push(second.max(deliveries.delays[0]));
        }
        deliveries
    }

    fn delay(&mut self, since_start: Span) -> Span {
        let steps: f64 = self
            .config
            .delay_steps
            .iter()
            .filter(|step| since_start >= Span::from_secs_f64(step.at_s.get()))
            .map(|step| step.by_us)
            .sum();
        let jitter = match &self.config.jitter {
            Some(jitter) => self.random.jitter_us(jitter),
            None => 0.0,
        };
        let spike = match &self.config.spikes {
            Some(spikes) if self.random.chance(spikes.share.get()) => {
                let (from, to) = (spikes.from_us.get(), spikes.to_us.get());
                from + (to - from) * self.random.uniform()
            }
            _ => 0.0,
        };
        let micros = self.config.latency_us.get() + steps + jitter + spike;
        Span::from_micros_f64(micros.max(0.0))
    }

    fn is_cut(&self, since_start: Span) -> bool {
        self.config.partitions.iter().any(|partition| {
            let from = Span::from_secs_f64(partition.at_s.get());
            let until = from + Span::from_secs_f64(partition.for_s.get());
            (from..until).contains(&since_start)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    fn link(config: &str) -> LinkModel {
        LinkModel::new(&parse("test", config).unwrap(), 11)
    }

    fn millis(k: i64) -> Span {
        Span::from_millis(k)
    }

    /// Arrivals of `n` messages sent a millisecond apart, in the order of sending.
    fn arrivals(link: &mut LinkModel, n: i64) -> Vec<Span> {
        (0..n)
            .flat_map(|k| link.offer(millis(k)).map(move |delay| millis(k) + delay))
            .collect()
    }

    #[test]
    fn a_plain_link_only_delays() {
        let mut link = link("latency-us = 200");
        let delays: Vec<_> = link.offer(millis(5)).collect();
        assert_eq!(delays, [Span::from_micros(200)]);
    }

    #[test]
    fn loss_and_duplication_come_in_their_shares() {
        let mut lossy = link("loss = 0.1");
        assert!((8_700..9_300).contains(&arrivals(&mut lossy, 10_000).len()));
        let mut doubling = link("duplication = 0.1");
        assert!((10_700..11_300).contains(&arrivals(&mut doubling, 10_000).len()));
    }

    #[test]
    fn order_is_kept_unless_reordering_is_asked_for() {
        let mut jittery = link("jitter = { exponential-us = 2000 }");
        assert!(arrivals(&mut jittery, 10_000).is_sorted());
        let mut reordering = link("reorder = 0.1\nreorder-us = 5000");
        assert!(!arrivals(&mut reordering, 10_000).is_sorted());
    }

    #[test]
    fn a_delay_step_lasts_and_a_partition_ends() {
        let mut link = link(
            "latency-us = 100\ndelay-steps = [{ at-s = 1, by-us = 50 }]\npartitions = [{ at-s = 2, for-s = 1 }]",
        );
        let delay = |link: &mut LinkModel, at| link.offer(at).next();
        assert_eq!(delay(&mut link, millis(999)), Some(Span::from_micros(100)));
        assert_eq!(delay(&mut link, millis(1000)), Some(Span::from_micros(150)));
        assert_eq!(delay(&mut link, millis(2000)), None);
        assert_eq!(delay(&mut link, millis(2999)), None);
        assert_eq!(delay(&mut link, millis(3000)), Some(Span::from_micros(150)));
    }

    #[test]
    fn spikes_stay_within_their_bounds() {
        let mut link = link("spikes = { share = 0.5, from-us = 1000, to-us = 5000 }");
        let longest = (0..1000)
            .flat_map(|k| link.offer(Span::from_secs(k)))
            .max()
            .unwrap();
        assert!((Span::from_millis(4)..=Span::from_millis(5)).contains(&longest));
    }
}
