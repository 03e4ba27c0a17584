//! Admission of connections: which of them may stay, and when a handshake may start.
//!
//! Decides without I/O; time is an argument. A connection is *silent* until its ClientHello is complete. Then it waits
//! for its start, and the handshake is *in progress* until it ends. Each of the two groups has its own limit, so that
//! connections that send nothing cannot displace those that do.
//!
//! No connection is refused because a limit is reached. The oldest of the origin with the most connections makes room
//! instead: an honest handshake is over in milliseconds, a silent client never is. So an origin never gets
//! more than its share while others need theirs, and a member that is alone at its address always gets in.

use std::collections::BTreeMap;
use std::time::Duration;

use tokio::time::Instant;

use crate::source_prefix::SourcePrefix;

/// Greatest number of silent connections. A member sends its ClientHello within a round trip: from an
/// address that opens 10 000 connections a second it still has 12 ms for it. Each takes a descriptor of the 1024 that
/// a process usually has, and some kilobytes.
pub(crate) const MOST_SILENT: usize = 128;

/// Greatest number of connections whose ClientHello is complete and whose handshake is not. At most 128 nodes follow
/// a node; if all of them come back at once, one that is displaced tries again within a second.
pub(crate) const MOST_GREETED: usize = 64;

/// Handshakes of one origin: as many at once as a PC has nodes, then 50 a second. A handshake takes some 0.5 ms of a
/// processor (two verified and one made signature over P-256, one key agreement): 2.5 % of it.
pub(crate) const OF_ORIGIN: HandshakeRate = HandshakeRate {
    interval: Duration::from_millis(20),
    burst: 32,
};

/// Handshakes of all origins: as many at once as a node may have followers, then 200 a second, a tenth of a processor.
pub(crate) const OF_ALL: HandshakeRate = HandshakeRate {
    interval: Duration::from_millis(5),
    burst: 128,
};

/// A rate with a burst.
pub(crate) struct HandshakeRate {
    pub(crate) interval: Duration,
    pub(crate) burst: u32,
}

/// Use of a [`HandshakeRate`]: the generic cell rate algorithm (ITU-T I.371), whose state is one instant.
#[derive(Clone, Copy, Debug)]
struct RateUse {
    /// Instant at which nothing of the burst is used any more.
    until: Instant,
}

impl RateUse {
    /// Earliest start of the next one.
    fn next(self, pace: &HandshakeRate) -> Instant {
        // All of the burst but the one that is asked for.
        let ahead = pace.interval * (pace.burst - 1);
        self.until.checked_sub(ahead).unwrap_or(self.until)
    }

    fn start(&mut self, now: Instant, pace: &HandshakeRate) {
        self.until = self.until.max(now) + pace.interval;
    }
}

/// Number of a connection, in the order of arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ConnectionId(u64);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum HandshakeStage {
    Silent,
    /// The ClientHello is complete, and the handshake has not started.
    Waiting,
    InProgress,
}

#[derive(Clone, Copy, Debug)]
struct Admitted {
    origin: SourcePrefix,
    stage: HandshakeStage,
}

/// Connections without a complete handshake.
#[derive(Debug, Default)]
pub(crate) struct AdmissionControl {
    /// By number: the oldest first.
    connections: BTreeMap<ConnectionId, Admitted>,
    /// Only origins that have used some of their burst, so at most as many as all may start meanwhile.
    paces: BTreeMap<SourcePrefix, RateUse>,
    all: Option<RateUse>,
    next_id: u64,
}

impl AdmissionControl {
    /// Admits a connection. Returns its number, and the connection that is displaced by it.
    pub(crate) fn admit(&mut self, origin: SourcePrefix) -> (ConnectionId, Option<ConnectionId>) {
        let id = ConnectionId(self.next_id);
        self.next_id += 1;
        let displaced = self.make_room(|stage| stage == HandshakeStage::Silent, MOST_SILENT);
        let stage = HandshakeStage::Silent;
        self.connections.insert(id, Admitted { origin, stage });
        (id, displaced)
    }

    /// Notes that a ClientHello is complete. Returns the connection that is displaced by it.
    pub(crate) fn greeted(&mut self, id: ConnectionId) -> Option<ConnectionId> {
        // One that was displaced meanwhile displaces nobody.
        if !self.connections.contains_key(&id) {
            return None;
        }
        let displaced = self.make_room(|stage| stage != HandshakeStage::Silent, MOST_GREETED);
        if let Some(connection) = self.connections.get_mut(&id) {
            connection.stage = HandshakeStage::Waiting;
        }
        displaced
    }

    /// Returns the next connection whose handshake starts now.
    pub(crate) fn start(&mut self, now: Instant) -> Option<ConnectionId> {
        self.paces.retain(|_, used| used.until > now);
        self.all = self.all.filter(|used| used.until > now);
        let (at, id, origin) = self.next()?;
        if at.is_some_and(|at| at > now) {
            return None;
        }
        let unused = RateUse { until: now };
        let of_origin = self.paces.entry(origin).or_insert(unused);
        of_origin.start(now, &OF_ORIGIN);
        self.all.get_or_insert(unused).start(now, &OF_ALL);
        if let Some(connection) = self.connections.get_mut(&id) {
            connection.stage = HandshakeStage::InProgress;
        }
        Some(id)
    }

    /// Instant of the next start; none if no connection waits.
    pub(crate) fn next_start(&self, now: Instant) -> Option<Instant> {
        self.next()
            .map(|(at, _, _)| at.map_or(now, |at| at.max(now)))
    }

    /// Displaces one connection, for want of a descriptor.
    pub(crate) fn displace(&mut self) -> Option<ConnectionId> {
        self.make_room(|_| true, 1)
    }

    /// Notes the end of a connection or its handshake.
    pub(crate) fn end(&mut self, id: ConnectionId) {
        self.connections.remove(&id);
    }

    /// The connection that starts next, and the instant; no instant if nothing holds it up.
    fn next(&self) -> Option<(Option<Instant>, ConnectionId, SourcePrefix)> {
        let waiting = self.connections.iter();
        let waiting = waiting.filter(|(_, connection)| connection.stage == HandshakeStage::Waiting);
        let next = waiting
            .map(|(id, connection)| (self.paces.get(&connection.origin), id, connection.origin))
            // The origin that has used the least of its pace; its oldest connection.
            .min_by_key(|(used, id, _)| (used.map(|used| used.until), **id));
        let (used, id, origin) = next?;
        let of_origin = used.map(|used| used.next(&OF_ORIGIN));
        let of_all = self.all.map(|used| used.next(&OF_ALL));
        Some((of_origin.max(of_all), *id, origin))
    }

    /// Removes and returns the oldest connection of the busiest origin in a group that has reached its limit.
    fn make_room(
        &mut self,
        is_in: impl Fn(HandshakeStage) -> bool,
        limit: usize,
    ) -> Option<ConnectionId> {
        let of_group = self.connections.iter();
        let of_group = of_group.filter(|(_, connection)| is_in(connection.stage));
        // Count and oldest connection of each origin; the oldest comes first.
        let mut origins = BTreeMap::<SourcePrefix, (usize, ConnectionId)>::new();
        let mut count = 0;
        for (id, connection) in of_group {
            count += 1;
            origins.entry(connection.origin).or_insert((0, *id)).0 += 1;
        }
        if count < limit {
            return None;
        }
        let busiest = origins.into_values();
        // Among equals the one with the oldest connection.
        let busiest = busiest.max_by_key(|(count, oldest)| (*count, std::cmp::Reverse(*oldest)));
        let (_, oldest) = busiest?;
        self.connections.remove(&oldest);
        Some(oldest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(n: u8) -> SourcePrefix {
        SourcePrefix::of(([10, 0, 0, n], 40_000).into())
    }

    /// Admits connections that stay; returns the displaced ones.
    fn flood(
        admission: &mut AdmissionControl,
        from: SourcePrefix,
        count: usize,
    ) -> Vec<ConnectionId> {
        let displaced = (0..count).filter_map(|_| admission.admit(from).1);
        displaced.collect()
    }

    /// Admits a connection with a complete ClientHello.
    fn greet(admission: &mut AdmissionControl, from: SourcePrefix) -> ConnectionId {
        let (id, _) = admission.admit(from);
        admission.greeted(id);
        id
    }

    fn starts(admission: &mut AdmissionControl, now: Instant) -> Vec<ConnectionId> {
        std::iter::from_fn(|| admission.start(now)).collect()
    }

    #[test]
    fn silent_connections_stay_under_their_limit_and_the_oldest_make_room() {
        let mut admission = AdmissionControl::default();
        let (first, _) = admission.admit(origin(1));
        let displaced = flood(&mut admission, origin(1), 7_300);
        assert_eq!(displaced.len(), 7_301 - MOST_SILENT);
        assert_eq!(displaced[0], first);
        assert!(displaced.is_sorted(), "in the order of arrival");
        assert_eq!(admission.connections.len(), MOST_SILENT);
    }

    #[test]
    fn a_member_of_another_address_is_not_displaced_by_a_flood() {
        let mut admission = AdmissionControl::default();
        flood(&mut admission, origin(1), 600);
        let (member, _) = admission.admit(origin(2));
        // A flood from 60 addresses at once, each of which gets two places.
        for n in 0..7_300 {
            let displaced = admission.admit(origin(3 + (n % 60) as u8)).1;
            assert_ne!(displaced, Some(member));
        }
        assert_eq!(admission.greeted(member), None);
        assert_eq!(admission.start(Instant::now()), Some(member));
    }

    #[test]
    fn a_member_of_the_flooding_address_gets_in_once_its_hello_is_there() {
        let mut admission = AdmissionControl::default();
        flood(&mut admission, origin(1), 600);
        let (member, _) = admission.admit(origin(1));
        flood(&mut admission, origin(1), MOST_SILENT - 1);
        assert_eq!(admission.greeted(member), None);
        // Silent connections displace silent ones only.
        let displaced = flood(&mut admission, origin(1), 7_300);
        assert!(!displaced.contains(&member));
        assert_eq!(admission.start(Instant::now()), Some(member));
        admission.end(member);
        assert_eq!(admission.connections.len(), MOST_SILENT);
    }

    #[test]
    fn handshakes_of_an_origin_start_in_a_burst_and_then_at_its_pace() {
        let mut admission = AdmissionControl::default();
        let start = Instant::now();
        let greeted: Vec<_> = (0..40).map(|_| greet(&mut admission, origin(1))).collect();
        assert_eq!(starts(&mut admission, start), greeted[..32]);
        let next = start + OF_ORIGIN.interval;
        assert_eq!(admission.next_start(start), Some(next));
        assert_eq!(starts(&mut admission, next), greeted[32..33]);
        // Another origin does not wait for this one.
        let member = greet(&mut admission, origin(2));
        assert_eq!(admission.next_start(next), Some(next));
        assert_eq!(admission.start(next), Some(member));
        // 64 that wait are through within 1.3 s, less than a handshake may take.
        let second = start + Duration::from_secs(1);
        assert_eq!(starts(&mut admission, second), greeted[33..]);
        assert_eq!(admission.next_start(second), None);
    }

    #[test]
    fn handshakes_of_many_origins_share_the_pace_of_all() {
        let mut admission = AdmissionControl::default();
        let start = Instant::now();
        let mut started = 0;
        for n in 0..200 {
            greet(&mut admission, origin(n));
            for id in starts(&mut admission, start) {
                admission.end(id);
                started += 1;
            }
        }
        assert_eq!(started, 128, "the burst");
        assert_eq!(admission.connections.len(), MOST_GREETED);
        let second = start + Duration::from_millis(500);
        assert_eq!(starts(&mut admission, second).len(), MOST_GREETED);
        assert!(admission.paces.len() <= 256, "origins are forgotten");
        starts(&mut admission, second + Duration::from_secs(60));
        assert!(admission.paces.is_empty());
    }

    #[test]
    fn stalled_handshakes_make_room_for_later_ones() {
        let mut admission = AdmissionControl::default();
        let start = Instant::now();
        let mut now = start;
        for _ in 0..2 * MOST_GREETED {
            greet(&mut admission, origin(1));
            now += OF_ORIGIN.interval;
            starts(&mut admission, now);
        }
        assert_eq!(admission.connections.len(), MOST_GREETED);
        let member = greet(&mut admission, origin(1));
        now += OF_ORIGIN.interval;
        assert_eq!(starts(&mut admission, now), [member]);
    }

    #[test]
    fn for_want_of_a_descriptor_one_connection_goes() {
        let mut admission = AdmissionControl::default();
        assert_eq!(admission.displace(), None);
        let (member, _) = admission.admit(origin(2));
        let (first, _) = admission.admit(origin(1));
        admission.admit(origin(1));
        assert_eq!(admission.displace(), Some(first));
        admission.end(member);
        assert!(admission.displace().is_some());
        assert_eq!(admission.displace(), None);
    }
}
