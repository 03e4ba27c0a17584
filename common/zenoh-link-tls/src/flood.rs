//! Floods of connections: who opens more of them than members that are refused do.

use std::time::Duration;

use tokio::time::Instant;

use crate::source_prefix::SourcePrefix;

/// A level that each refused connection raises by one, and time lowers.
#[derive(Clone, Copy, Debug)]
struct Leak {
    per_second: f64,
    /// A flood from this level on.
    flood: f64,
    /// The level rises no further, so that it is seen soon that a flood is over.
    most: f64,
}

/// Refused connections of one origin. A node that is refused tries again once a second, so five such nodes on one PC
/// are no flood, and nine connects a second are one after 13 s. Ten seconds after the last connect it is over.
const OF_ORIGIN: Leak = Leak {
    per_second: 5.0,
    flood: 50.0,
    most: 100.0,
};

/// Refused connections of all origins: fifty nodes with expired certificates are no flood.
const OF_ALL: Leak = Leak {
    per_second: 50.0,
    flood: 500.0,
    most: 1_000.0,
};

/// Greatest number of origins that are counted one by one. Further ones take the place of the one with the lowest
/// level and continue with it, so that the busiest stays (Metwally et al., "Efficient computation of
/// frequent and top-k elements in data streams", 2005).
pub(crate) const MOST_ORIGINS: usize = 64;

#[derive(Clone, Copy, Debug)]
struct LeakyLevel {
    value: f64,
    at: Instant,
}

impl LeakyLevel {
    fn at(self, now: Instant, leak: Leak) -> f64 {
        let lost = now.duration_since(self.at).as_secs_f64() * leak.per_second;
        (self.value - lost).max(0.0)
    }

    fn raise(&mut self, now: Instant, leak: Leak) {
        self.value = (self.at(now, leak) + 1.0).min(leak.most);
        self.at = now;
    }

    /// Instant at which it falls below the level of a flood; none if it is below.
    fn flood_until(self, leak: Leak) -> Option<Instant> {
        let above = (self.value - leak.flood) / leak.per_second;
        (above >= 0.0).then(|| self.at + Duration::from_secs_f64(above))
    }
}

#[derive(Clone, Copy, Debug)]
struct CountedSource {
    origin: SourcePrefix,
    level: LeakyLevel,
    /// Connections since the last line of the log.
    count: u64,
}

/// Counts of refused connections by their origin.
#[derive(Debug, Default)]
pub(crate) struct FloodWatch {
    origins: Vec<CountedSource>,
    all: Option<LeakyLevel>,
}

impl FloodWatch {
    /// Counts a refused connection.
    pub(crate) fn add(&mut self, now: Instant, origin: SourcePrefix) {
        let empty = LeakyLevel {
            value: 0.0,
            at: now,
        };
        self.all.get_or_insert(empty).raise(now, OF_ALL);
        let counted = self.place_of(now, origin, empty);
        counted.count += 1;
        counted.level.raise(now, OF_ORIGIN);
    }

    /// Instant until which there is a flood, if nothing is added; none without one.
    pub(crate) fn until(&self, now: Instant) -> Option<Instant> {
        let of_origins = self.origins.iter();
        let of_origins = of_origins.filter_map(|counted| counted.level.flood_until(OF_ORIGIN));
        let of_all = self.all.and_then(|level| level.flood_until(OF_ALL));
        let until = of_origins.chain(of_all).max();
        until.filter(|until| *until > now)
    }

    /// The origin with the most connections since [`Self::clear`], and their number.
    pub(crate) fn busiest(&self) -> Option<(SourcePrefix, u64)> {
        let counted = self.origins.iter();
        let counted = counted.map(|counted| (counted.origin, counted.count));
        counted.max_by_key(|(_, count)| *count)
    }

    /// Begins to count for the next line of the log. Levels stay.
    pub(crate) fn clear(&mut self, now: Instant) {
        self.origins
            .retain(|counted| counted.level.at(now, OF_ORIGIN) > 0.0);
        for counted in &mut self.origins {
            counted.count = 0;
        }
    }

    fn place_of(
        &mut self,
        now: Instant,
        origin: SourcePrefix,
        level: LeakyLevel,
    ) -> &mut CountedSource {
        let known = self.origins.iter().position(|one| one.origin == origin);
        let place = match known {
            Some(place) => place,
            None if self.origins.len() < MOST_ORIGINS => {
                let count = 0;
                self.origins.push(CountedSource {
                    origin,
                    level,
                    count,
                });
                self.origins.len() - 1
            }
            None => {
                let level = |counted: &CountedSource| counted.level.at(now, OF_ORIGIN);
                let levels = self.origins.iter().map(level).enumerate();
                let lowest = levels.min_by(|(_, a), (_, b)| a.total_cmp(b));
                let place = lowest.map_or(0, |(place, _)| place);
                self.origins[place].origin = origin;
                place
            }
        };
        &mut self.origins[place]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(n: u16) -> SourcePrefix {
        let [high, low] = n.to_be_bytes();
        SourcePrefix::of(([10, 0, high, low], 40_000).into())
    }

    /// Adds connections of `origins` at a rate for some seconds; returns the first second with a flood.
    fn first_flood(rate: u32, seconds: u32, origins: u16) -> Option<u32> {
        let (mut watch, start) = (FloodWatch::default(), Instant::now());
        (0..rate * seconds).find_map(|n| {
            let now = start + Duration::from_secs(1) * n / rate;
            watch.add(now, origin(n as u16 % origins));
            watch.until(now).map(|_| n / rate)
        })
    }

    #[test]
    fn refused_members_are_no_flood_and_a_storm_is_one() {
        assert_eq!(first_flood(5, 600, 1), None, "five nodes on a PC");
        assert_eq!(first_flood(50, 600, 50), None, "fifty nodes");
        assert_eq!(first_flood(9, 60, 1), Some(12));
        assert_eq!(first_flood(600, 1, 1), Some(0));
        assert_eq!(first_flood(1_000, 2, 1_000), Some(0), "from everywhere");
    }

    #[test]
    fn a_flood_is_over_soon_after_its_last_connect() {
        let (mut watch, start) = (FloodWatch::default(), Instant::now());
        for _ in 0..7_300 {
            watch.add(start, origin(1));
        }
        let until = watch.until(start).expect("a flood");
        assert_eq!(until - start, Duration::from_secs(10));
        assert_eq!(watch.until(until), None);
    }

    #[test]
    fn the_busiest_is_known_among_more_origins_than_are_counted() {
        let (mut watch, start) = (FloodWatch::default(), Instant::now());
        for n in 0..10_000 {
            watch.add(start, origin(1 + n));
            watch.add(start, origin(0));
        }
        assert!(watch.origins.len() <= MOST_ORIGINS);
        assert_eq!(watch.busiest().map(|(origin, _)| origin), Some(origin(0)));
        watch.clear(start + Duration::from_secs(60));
        assert_eq!(watch.busiest(), None);
    }
}
