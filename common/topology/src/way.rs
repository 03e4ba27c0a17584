//! Delays of the messages between two nodes.

use coaxle_clock::{CycleTime, Span};
use coaxle_node::config::{LinkConfig, Wrong};
use coaxle_node::faults::LinkModel;
use coaxle_remote::NeededDelay;
use serde::Serialize;

/// Source of the delay of the messages between two nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum WaySource {
    /// Nothing is known.
    Unknown,
    /// A constant delay.
    Constant {
        /// Time of a message.
        delay: Span,
        /// Source of the figure.
        origin: WayOrigin,
    },
    /// Model of a link.
    Link(Box<LinkConfig>),
    /// Measured by the running receiver.
    Measured {
        /// Mean time of a message.
        delay: Span,
        /// Presentation delay that would do, where it is known.
        needed: Option<Span>,
    },
}

impl WaySource {
    /// Delay between nodes of these cycle times; none if it is unknown.
    pub(crate) fn delay(&self, cycles: [CycleTime; 2]) -> Option<WayDelay> {
        match self {
            Self::Unknown => None,
            Self::Constant { delay, origin } => Some(WayDelay::constant(*delay, cycles, *origin)),
            // The files of its terms are checked with the config.
            Self::Link(link) => WayDelay::simulated(link, cycles).ok(),
            Self::Measured { delay, needed } => {
                let constant = WayDelay::constant(*delay, cycles, WayOrigin::Measured);
                Some(WayDelay {
                    needed: needed.unwrap_or(constant.needed),
                    ..constant
                })
            }
        }
    }
}

/// Delay of messages, and the presentation delay that it asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WayDelay {
    /// Mean time of a message.
    pub(crate) delay: Span,
    /// Delay by which 99.9 % of the cycles have the frames that they need, one cycle of each side included.
    pub(crate) needed: Span,
    /// Source of both.
    pub(crate) origin: WayOrigin,
}

/// Source of a delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WayOrigin {
    /// Stated in the config.
    Configured,
    /// Link of a `[lab]` table, as a receiver would measure it.
    Simulated,
    /// Assumed on the command line.
    Assumed,
    /// Measured by the running receiver.
    Measured,
}

impl WayOrigin {
    /// Returns its word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Configured => "configured",
            Self::Simulated => "simulated",
            Self::Assumed => "assumed",
            Self::Measured => "measured",
        }
    }
}

/// Simulated time of a link: the window of a receiver's statistics.
const MINUTE: Span = Span::from_secs(60);
/// Greatest number of simulated frames: 60 beyond the quantile of 99.9 %.
const MOST_FRAMES: i64 = 60_000;
/// Seed of the simulated link: the same config has the same figures each time.
const SEED: u64 = 37;
/// Deviation of the receiver's cycles, so that they pass each phase between two frames: 1 in 1000.
const DRIFT: i64 = 1_000;

impl WayDelay {
    /// A constant delay.
    pub(crate) fn constant(delay: Span, cycles: [CycleTime; 2], origin: WayOrigin) -> Self {
        let [from, to] = cycles.map(CycleTime::span);
        // Just before a frame arrives, the one before is a cycle older: that is the age which a receiver measures. One
        // cycle of each side on top, as there.
        let needed = delay.max(Span::ZERO) + from * 2 + to;
        Self {
            delay,
            needed,
            origin,
        }
    }

    /// Delay of a simulated link between nodes of these cycle times, by the statistics of a receiver.
    ///
    /// # Errors
    /// [`Wrong`] names the file of a term that cannot be read.
    pub(crate) fn simulated(link: &LinkConfig, cycles: [CycleTime; 2]) -> Result<Self, Wrong> {
        let [from, to] = cycles.map(CycleTime::span);
        let mut model = LinkModel::new(link, SEED)?;
        let frames = (MINUTE.as_nanos() / from.as_nanos()).clamp(1, MOST_FRAMES);
        let (mut sum, mut arrived) = (Span::ZERO, 0);
        let mut arrivals = Vec::new();
        for frame in 0..frames {
            let sent = from * frame;
            for delay in model.offer(sent) {
                arrivals.push((sent + delay, sent));
                sum += delay;
                arrived += 1;
            }
        }
        // In the order of their arrival: a frame may overtake another.
        arrivals.sort_unstable();
        let needed = needed_by(&arrivals, to, from * frames) + from + to;
        Ok(Self {
            // A link that loses everything has no delay; its need is then the whole time.
            delay: sum / i64::max(arrived, 1),
            needed,
            origin: WayOrigin::Simulated,
        })
    }
}

/// The age that the newest frame has in nearly all cycles, given arrival and generation of each.
fn needed_by(arrivals: &[(Span, Span)], cycle: Span, end: Span) -> Span {
    let mut statistics = NeededDelay::default();
    let mut next = arrivals.iter().peekable();
    let mut newest: Option<Span> = None;
    let step = cycle + cycle / DRIFT;
    let mut now = Span::ZERO;
    while now < end {
        while let Some((_, generated)) = next.next_if(|(arrival, _)| *arrival <= now) {
            newest = newest.max(Some(*generated));
        }
        // Before the first frame there is no age.
        if let Some(newest) = newest {
            statistics.take(now - newest, step);
        }
        now += step;
    }
    // Calculated every 64 ages: the last figure is that of nearly all of them.
    statistics.needed().unwrap_or(end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn millisecond() -> CycleTime {
        CycleTime::new(Span::from_millis(1)).unwrap()
    }

    fn simulated(link: &str) -> WayDelay {
        let link: LinkConfig = parse("link", link).unwrap();
        WayDelay::simulated(&link, [millisecond(); 2]).unwrap()
    }

    #[test]
    fn a_constant_link_is_as_a_stated_delay() {
        let stated = WayDelay::constant(
            Span::from_millis(20),
            [millisecond(); 2],
            WayOrigin::Configured,
        );
        assert_eq!(stated.needed, Span::from_millis(23));
        let link = simulated("latency-us = 20000");
        assert_eq!(link.delay, Span::from_millis(20));
        // The statistics have a resolution of 6.25 %.
        let over = link.needed - stated.needed;
        assert!(
            (Span::ZERO..=Span::from_micros(1_400)).contains(&over),
            "{link:?}"
        );
    }

    #[test]
    fn losses_and_jitter_cost_time() {
        let good = simulated("latency-us = 20000").needed;
        let losing = simulated("latency-us = 20000\nloss = 0.05").needed;
        // Three lost frames in a row are rarer than a thousandth.
        assert!(
            losing >= good + Span::from_millis(1) && losing <= good + Span::from_millis(5),
            "{losing}"
        );
        let jittery = simulated("latency-us = 10000\njitter = { uniform-us = 20000 }");
        assert!(jittery.delay > Span::from_millis(19), "{jittery:?}");
        assert!(jittery.needed > Span::from_millis(29), "{jittery:?}");
        // A partition of one in two hundred parts of the time counts as well.
        let cut = simulated("latency-us = 1000\npartitions = [{ at-s = 10, for-s = 0.3 }]");
        assert!(cut.needed > Span::from_millis(200), "{cut:?}");
    }

    #[test]
    fn a_link_that_delivers_nothing_needs_all_the_time_there_is() {
        assert!(simulated("loss = 1").needed >= Span::from_secs(60));
    }
}
