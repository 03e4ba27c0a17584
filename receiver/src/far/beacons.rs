//! Beacons to a node that is followed, and their responses: exchanges with stamps near the wire.
//!
//! The next beacon carries the departure time of a beacon, so an exchange is known when the
//! response after it arrives. With stamps of the program itself it is known at once.

use coaxle_clock::common_time::{CommonReading, FarCommonReading};
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{Instant, Local, Span};
use coaxle_node::config::TimingLinkConfig;
use coaxle_node::{BeaconResponse, Stamps};

use crate::signals::FarNodeSignals;

/// Number of responses that can wait for their cycle.
const WAITING: usize = 8;
/// Longest duration of an exchange.
const LONGEST: Span = Span::from_secs(1);

/// The beacons to one node.
#[derive(Debug)]
pub(super) struct Beacons {
    /// Run of the own node.
    run: u64,
    interval: Span,
    next_due: Option<Instant<Local>>,
    /// Number of the next beacon.
    number: u32,
    /// Newest response taken, whose stamps are not all known yet.
    responded: Option<u32>,
    before: Option<(Instant<Local>, BeaconResponse)>,
    waiting: [Option<(Instant<Local>, BeaconResponse)>; WAITING],
    stamps: Option<Stamps>,
    /// True if both are to have a common time.
    takes_common_time: bool,
    counters: Counters,
}

/// What a response brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BeaconMeasurement {
    /// An exchange, whose response arrived then.
    Exchange(Instant<Local>, TimeResponse),
    /// Readings of the common time: the own one at an instant, and that of the responder.
    CommonTime {
        here: Instant<Local>,
        own: Option<CommonReading>,
        far: Option<FarCommonReading>,
    },
}

#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    sent: u64,
    answers: u64,
    rejected: u64,
}

impl Beacons {
    pub(super) fn new(config: &TimingLinkConfig, run: u64, takes_common_time: bool) -> Self {
        Self {
            run,
            interval: config.interval(),
            next_due: None,
            number: 0,
            responded: None,
            before: None,
            waiting: [None; WAITING],
            stamps: None,
            takes_common_time,
            counters: Counters::default(),
        }
    }

    /// Returns the number of the beacon to send in the cycle that ideally began at `now`, if one is due.
    pub(super) fn due(&mut self, now: Instant<Local>) -> Option<u32> {
        // The first beacon is due at once.
        let due = *self.next_due.get_or_insert(now);
        if now < due {
            return None;
        }
        // After a standstill there is no burst.
        let next = due + self.interval;
        self.next_due = Some(if next > now {
            next
        } else {
            now + self.interval
        });
        let number = self.number;
        // Numbers wrap after 2³² beacons. All comparisons go by wrapping differences.
        self.number = self.number.wrapping_add(1);
        self.counters.sent = self.counters.sent.saturating_add(1);
        Some(number)
    }

    /// Stores a response that arrived at `at`, for the first cycle that ideally begins no earlier.
    pub(super) fn store(&mut self, at: Instant<Local>, response: &BeaconResponse) {
        match self.waiting.iter_mut().find(|place| place.is_none()) {
            Some(place) => *place = Some((at, *response)),
            None => self.reject(),
        }
    }

    /// Counts a response that was refused.
    pub(super) const fn reject(&mut self) {
        self.counters.rejected = self.counters.rejected.saturating_add(1);
    }

    /// Passes on what is known in the cycle that ideally begins at `now`.
    pub(super) fn take(&mut self, now: Instant<Local>, mut each: impl FnMut(BeaconMeasurement)) {
        // In the order of their numbers, independent of their arrival.
        while let Some((at, response)) = self.next_waiting(now) {
            if !self.is_response(at, &response) {
                self.reject();
                continue;
            }
            self.responded = Some(response.request.number);
            self.counters.answers = self.counters.answers.saturating_add(1);
            self.stamps = Some(response.weakest_stamps());
            if self.takes_common_time {
                each(common_time(&response));
            }
            // A response carries the program's own stamps itself, so that nothing has to wait for the next one.
            if response.weakest_stamps() == Stamps::Application {
                self.before = None;
                let exchange = exchange(&response, response.requested(), response.responded);
                each(BeaconMeasurement::Exchange(at, exchange));
                continue;
            }
            let before = self.before.replace((at, response));
            if let Some((arrived, known)) = before.and_then(|before| completed(before, &response)) {
                each(BeaconMeasurement::Exchange(arrived, known));
            }
        }
    }

    /// Writes its signals.
    pub(super) fn show(&self, signals: &mut FarNodeSignals) {
        signals.timing_stamps = self.stamps;
        signals.beacons_sent = self.counters.sent;
        signals.beacons_received = self.counters.answers;
        signals.beacons_rejected = self.counters.rejected;
    }

    fn next_waiting(&mut self, now: Instant<Local>) -> Option<(Instant<Local>, BeaconResponse)> {
        // By the distance from the newest one responded to: plain numbers would lose their order where they wrap.
        let since = |number: u32| number.wrapping_sub(self.responded.unwrap_or(0));
        let due = self.waiting.iter_mut().filter(|place| {
            let arrived = place.as_ref().map(|(at, _)| *at);
            arrived.is_some_and(|at| at <= now)
        });
        let oldest = due.min_by_key(|place| {
            let number = place.as_ref().map(|(_, response)| response.request.number);
            number.map_or(u32::MAX, since)
        });
        oldest?.take()
    }

    /// Checks that it responds to a beacon of this run that has no response yet and precedes none
    /// that has.
    fn is_response(&self, at: Instant<Local>, response: &BeaconResponse) -> bool {
        let number = response.request.number;
        let is_later = self.responded.is_none_or(|responded| {
            let ahead = number.wrapping_sub(responded) as i32;
            // A repeated response has a difference of 0, and an overtaken one a negative difference.
            ahead > 0
        });
        let was_sent = (self.number.wrapping_sub(number) as i32) > 0;
        let took = at - response.requested();
        response.request.run == self.run
            && is_later
            && was_sent
            // A negative time is that of a forged or foreign stamp.
            && (Span::ZERO..=LONGEST).contains(&took)
    }
}

/// Exchange of the previous response, if both contain its departure time.
fn completed(
    (arrived, answer): (Instant<Local>, BeaconResponse),
    next: &BeaconResponse,
) -> Option<(Instant<Local>, TimeResponse)> {
    let number = answer.request.number;
    let requested = next
        .request
        .before
        .filter(|before| before.number == number)?;
    let responded = next.before.filter(|before| before.number == number)?;
    // The stamps of two runs of the node belong to two clocks.
    if next.epoch != answer.epoch {
        return None;
    }
    let (requested, responded) = (
        Instant::from_nanos(requested.left_ns),
        Span::from_nanos(responded.left_ns),
    );
    Some((arrived, exchange(&answer, requested, responded)))
}

/// The readings of both nodes in one exchange.
fn common_time(response: &BeaconResponse) -> BeaconMeasurement {
    let request = &response.request;
    BeaconMeasurement::CommonTime {
        here: (request.common).map_or(response.requested(), |own| Instant::from_nanos(own.at_ns)),
        own: request.common.map(|own| own.reading()),
        far: response.common.map(|far| FarCommonReading {
            epoch: response.epoch,
            at: Span::from_nanos(far.at_ns),
            common: far.reading(),
        }),
    }
}

fn exchange(answer: &BeaconResponse, requested: Instant<Local>, responded: Span) -> TimeResponse {
    TimeResponse {
        run: answer.request.run,
        number: answer.request.number,
        requested,
        epoch: answer.epoch,
        received: answer.received,
        responded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::BeaconRequest;
    use coaxle_node::beacon::{BeaconBefore, CommonStamp};

    fn beacons() -> Beacons {
        let config = coaxle_node::config::parse("test", "connect = '127.0.0.1:1'\nper-s = 50");
        Beacons::new(&config.unwrap(), 7, false)
    }

    fn at(micros: i64) -> Instant<Local> {
        Instant::EPOCH + Span::from_micros(micros)
    }

    /// Beacon n leaves at 20·n ms for the program, and 3 µs later by its stamp.
    fn answer(number: u32, stamps: Stamps) -> (Instant<Local>, BeaconResponse) {
        let sent = i64::from(number) * 20_000;
        let left = |number: u32| BeaconBefore {
            number,
            left_ns: i64::from(number) * 20_000_000 + 3_000,
        };
        let before = number.checked_sub(1);
        let response = BeaconResponse {
            epoch: 5,
            request: BeaconRequest {
                requester: 1,
                run: 7,
                number,
                requested: sent * 1_000,
                stamps,
                before: before.map(left),
                ..BeaconRequest::default()
            },
            received: Span::from_micros(sent + 10),
            responded: Span::from_micros(sent + 500),
            stamps,
            before: before.map(|number| BeaconBefore {
                number,
                left_ns: i64::from(number) * 20_000_000 + 504_000,
            }),
            common: None,
        };
        (at(sent + 520), response)
    }

    fn exchange_of(measured: &BeaconMeasurement) -> Option<TimeResponse> {
        match measured {
            BeaconMeasurement::Exchange(_, exchange) => Some(*exchange),
            BeaconMeasurement::CommonTime { .. } => None,
        }
    }

    fn take(beacons: &mut Beacons, answers: &[u32], stamps: Stamps) -> Vec<TimeResponse> {
        let mut known = Vec::new();
        for number in answers {
            let (at, response) = answer(*number, stamps);
            beacons.store(at, &response);
            beacons.take(at, |measured| known.extend(exchange_of(&measured)));
        }
        known
    }

    fn sent(beacons: &mut Beacons, count: i64) {
        for n in 0..count {
            assert_eq!(beacons.due(at(n * 20_000)), Some(n as u32));
            assert_eq!(beacons.due(at(n * 20_000 + 19_000)), None);
        }
    }

    #[test]
    fn the_next_answer_tells_when_both_left() {
        let mut beacons = beacons();
        sent(&mut beacons, 4);
        let known = take(&mut beacons, &[0, 1, 2], Stamps::Kernel);
        let numbers: Vec<_> = known.iter().map(|exchange| exchange.number).collect();
        assert_eq!(numbers, [0, 1]);
        assert_eq!(known[1].requested, at(20_003));
        assert_eq!(known[1].received, Span::from_micros(20_010));
        assert_eq!(known[1].responded, Span::from_micros(20_504));
        let mut signals = FarNodeSignals::default();
        beacons.show(&mut signals);
        assert_eq!(signals.timing_stamps, Some(Stamps::Kernel));
        assert_eq!((signals.beacons_sent, signals.beacons_received), (4, 3));
    }

    #[test]
    fn where_one_was_lost_the_exchange_before_it_is() {
        let mut beacons = beacons();
        sent(&mut beacons, 6);
        let known = take(&mut beacons, &[0, 1, 3, 4], Stamps::Kernel);
        let numbers: Vec<_> = known.iter().map(|exchange| exchange.number).collect();
        assert_eq!(numbers, [0, 3]);
    }

    #[test]
    fn stamps_of_the_program_need_no_next_one() {
        let mut beacons = beacons();
        sent(&mut beacons, 3);
        let known = take(&mut beacons, &[0, 1], Stamps::Application);
        assert_eq!(known.len(), 2);
        assert_eq!(known[1].requested, at(20_000));
        assert_eq!(known[1].responded, Span::from_micros(20_500));
    }

    #[test]
    fn readings_of_a_common_time_come_with_the_response_itself() {
        let mut beacons = beacons();
        beacons.takes_common_time = true;
        sent(&mut beacons, 2);
        let stamp = |at_ns| CommonStamp {
            at_ns,
            time_ns: 5_000,
            bound_ns: 100,
            grandmaster: 3,
        };
        let (at, mut response) = answer(0, Stamps::Kernel);
        response.request.common = Some(stamp(2_900));
        response.common = Some(stamp(499_000));
        beacons.store(at, &response);
        let mut measured = Vec::new();
        beacons.take(at, |one| measured.push(one));
        let common = stamp(0).reading();
        let far = FarCommonReading {
            epoch: 5,
            at: Span::from_nanos(499_000),
            common,
        };
        let expected = BeaconMeasurement::CommonTime {
            here: Instant::from_nanos(2_900),
            own: Some(common),
            far: Some(far),
        };
        assert_eq!(measured, [expected]);
    }

    #[test]
    fn answers_to_others_and_those_that_come_twice_are_rejected() {
        let mut beacons = beacons();
        sent(&mut beacons, 3);
        let (came, good) = answer(1, Stamps::Kernel);
        let of_other_run = BeaconResponse {
            request: BeaconRequest {
                run: 8,
                ..good.request
            },
            ..good
        };
        let long_ago = BeaconResponse {
            request: BeaconRequest {
                requested: -2_000_000_000,
                ..good.request
            },
            ..good
        };
        let (_, not_sent) = answer(3, Stamps::Kernel);
        for response in [good, good, of_other_run, long_ago, not_sent] {
            beacons.store(came + Span::from_millis(40), &response);
            beacons.take(came + Span::from_millis(40), |measured| {
                panic!("nothing is known, but {measured:?}")
            });
        }
        assert_eq!(
            (beacons.counters.answers, beacons.counters.rejected),
            (1, 4)
        );
    }

    #[test]
    fn an_answer_waits_for_its_cycle_and_a_standstill_is_no_burst() {
        let mut beacons = beacons();
        sent(&mut beacons, 2);
        let (came, response) = answer(0, Stamps::Application);
        beacons.store(came, &response);
        beacons.take(came - Span::from_micros(1), |_| panic!("too early"));
        let mut known = 0;
        beacons.take(came, |_| known += 1);
        assert_eq!(known, 1);
        assert_eq!(beacons.due(at(10_000_000)), Some(2));
        assert_eq!(beacons.due(at(10_000_100)), None);
        for _ in 0..=WAITING {
            beacons.store(came, &response);
        }
        assert_eq!(beacons.counters.rejected, 1);
    }
}
