//! Features that a swarm schedule switches on or off as a whole.

use coaxle_node::faults::Random;

/// Part of the seeds that have a feature.
// Of 23 features, two of them are on together in an eighth of the seeds, and one is on without another in more than a fifth: a thousand seeds
// have every pair in every combination more than a hundred times, and every three together some 40 times.
const SHARE: f64 = 0.35;

/// A feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// Loss, delay, order and duplication on the links.
    LinkFaults,
    /// Messages that no node has sent.
    Forgeries,
    /// Nodes that are restarted, frozen, stopped, or started twice.
    Absences,
    /// Clocks that step, drift by terms, or walk.
    ClockFaults,
    /// Clocks that leap by seconds.
    Leaps,
    /// First counts just below 2³¹ and 2³².
    FirstCounts,
    /// Faults and orders at one instant.
    OneInstant,
    /// Cycle times of 0.25 to 10 ms, multiples of each other along a link.
    CycleTimes,
    /// Masters with a modulo period.
    Modulo,
    /// Masters whose positions are received within their period.
    WithinTurn,
    /// Limits of slaves from 0.6 to 1.0001 of those of the masters.
    TightLimits,
    /// Limits of far axes.
    FarLimits,
    /// Standby senders.
    Standby,
    /// Receivers that follow receivers, three or more in a row.
    Chain,
    /// Virtual axes of receivers.
    VirtualMasters,
    /// Slaves with two masters.
    TwoMasters,
    /// Cam plates, with every mode of activation.
    Plates,
    /// Points of plates written while slaves are on them.
    WrittenPoints,
    /// Flying saws with strategies.
    Strategies,
    /// Commands with dynamics below the limits of the axis.
    Dynamics,
    /// Orders about the followed nodes, their parameters among them.
    FarOrders,
    /// Routers between the nodes.
    Routers,
    /// Timing channels beside the transport.
    Timing,
}

impl Feature {
    const ALL: [(Self, &str); 23] = [
        (Self::LinkFaults, "link faults"),
        (Self::Forgeries, "forgeries"),
        (Self::Absences, "absences"),
        (Self::ClockFaults, "clock faults"),
        (Self::Leaps, "leaps"),
        (Self::FirstCounts, "first counts"),
        (Self::OneInstant, "one instant"),
        (Self::CycleTimes, "cycle times"),
        (Self::Modulo, "modulo"),
        (Self::WithinTurn, "within turn"),
        (Self::TightLimits, "tight limits"),
        (Self::FarLimits, "far limits"),
        (Self::Standby, "standby"),
        (Self::Chain, "chain"),
        (Self::VirtualMasters, "virtual masters"),
        (Self::TwoMasters, "two masters"),
        (Self::Plates, "plates"),
        (Self::WrittenPoints, "written points"),
        (Self::Strategies, "strategies"),
        (Self::Dynamics, "dynamics"),
        (Self::FarOrders, "far orders"),
        (Self::Routers, "routers"),
        (Self::Timing, "timing channel"),
    ];
}

/// The features of a schedule.
pub(super) struct Features(Vec<Feature>);

impl Features {
    pub(super) fn drawn(random: &mut Random) -> Self {
        let drawn = Feature::ALL
            .into_iter()
            .filter(|_| random.chance(SHARE))
            .map(|(feature, _)| feature);
        Self(drawn.collect())
    }

    pub(super) fn has(&self, feature: Feature) -> bool {
        self.0.contains(&feature)
    }

    /// The names of those that are on.
    pub(super) fn names(&self) -> String {
        let on = Feature::ALL.iter().filter(|(one, _)| self.has(*one));
        let names: Vec<_> = on.map(|(_, name)| *name).collect();
        match names.is_empty() {
            true => "no feature".to_owned(),
            false => names.join(", "),
        }
    }
}
