//! The time that this machine has in common with others: TAI, with what its service says of it.

use coaxle_clock::{Instant, Span};
use coaxle_node::beacon::CommonStamp;
use coaxle_node::config::{CommonTimeSetup, GrandmasterId, StatedBy};
use coaxle_node::faults::{FaultyCommonTime, seed_of};
use coaxle_os::machine::{self, Machine};
use coaxle_os::{ClockPair, Os, PtpService, PtpState, System};

use crate::node::outbox::OutgoingFrame;

/// Interval between requests to the service.
const ASKED_EVERY: Span = Span::from_secs(1);
/// Age of its state after which the time is lost.
// Three responses are missing.
const STALE_AFTER: Span = Span::from_secs(4);

/// Requests without a response after which the connection is made again.
const PATIENCE: u32 = 2;

/// Clock of the common time of this machine, read for each beacon.
pub(super) struct CommonClock {
    source: GrandmasterSource,
    bound: Span,
    /// Injected faults, if there are some, and when the node began.
    faults: Option<(FaultyCommonTime, Instant<Machine>)>,
}

/// Source of the grandmaster's identity, as it is asked.
enum GrandmasterSource {
    Stated(GrandmasterId),
    Service(PolledService<<Os as System>::PtpService>),
}

impl CommonClock {
    pub(super) fn new(setup: &CommonTimeSetup, seed: u64) -> Self {
        let faults = (!setup.faults.is_none()).then(|| {
            let faults = FaultyCommonTime::new(&setup.faults, seed_of(seed, "common time"));
            (faults, machine::now())
        });
        Self {
            source: match setup.config.stated_by {
                StatedBy::Config(grandmaster) => GrandmasterSource::Stated(grandmaster),
                StatedBy::Service => GrandmasterSource::Service(PolledService::default()),
            },
            bound: setup.config.bound_us.span(),
            faults,
        }
    }

    /// Reads it for a beacon of this frame, with the span since the ideal start of its cycle; none while it is lost.
    pub(super) fn read(&mut self, frame: &OutgoingFrame) -> Option<CommonStamp> {
        let (grandmaster, off) = match &mut self.source {
            GrandmasterSource::Stated(grandmaster) => (grandmaster.number(), Span::ZERO),
            GrandmasterSource::Service(service) => {
                let state = service.state(machine::now())?;
                (state.grandmaster, Span::from_nanos(state.offset_ns).abs())
            }
        };
        let ClockPair {
            clock,
            other,
            apart,
        } = machine::with_tai()?;
        let at = Instant::from_nanos(clock);
        let bound = self.bound + off + Span::from_nanos(apart);
        let stamp = CommonStamp {
            at_ns: frame.since_ideal_start(at).as_nanos(),
            time_ns: other,
            // One beyond four seconds is as useless as that.
            bound_ns: u32::try_from(bound.as_nanos()).unwrap_or(u32::MAX),
            grandmaster,
        };
        match &mut self.faults {
            Some((faults, began)) => faults.applied(at - *began, stamp),
            None => Some(stamp),
        }
    }
}

/// The PTP service of this machine, asked now and then.
struct PolledService<P> {
    connection: Option<P>,
    asked: Option<Instant<Machine>>,
    /// Requests without a response.
    unanswered: u32,
    newest: Option<(PtpState, Instant<Machine>)>,
    /// State that was logged last.
    logged: Option<LoggedState>,
}

/// State of the service, as it is logged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LoggedState {
    Followed(u64),
    Alone,
    Away,
}

impl<P> Default for PolledService<P> {
    fn default() -> Self {
        Self {
            connection: None,
            asked: None,
            unanswered: 0,
            newest: None,
            logged: None,
        }
    }
}

impl<P: PtpService> PolledService<P> {
    /// Returns its state; none while it does not answer, or follows no grandmaster.
    fn state(&mut self, now: Instant<Machine>) -> Option<PtpState> {
        let answer = self.connection.as_mut().and_then(PtpService::answer);
        if let Some(state) = answer {
            self.newest = Some((state, now));
            self.unanswered = 0;
        }
        if self.asked.is_none_or(|asked| now - asked >= ASKED_EVERY) {
            let is_first = self.asked.replace(now).is_none();
            self.ask();
            if is_first {
                // It has had no time to answer yet.
                return None;
            }
        }
        let fresh = self.newest.filter(|(_, at)| now - *at <= STALE_AFTER);
        self.log(match fresh {
            Some((state, _)) if state.is_present => LoggedState::Followed(state.grandmaster),
            Some(_) => LoggedState::Alone,
            None => LoggedState::Away,
        });
        fresh
            .map(|(state, _)| state)
            .filter(|state| state.is_present)
    }

    fn ask(&mut self) {
        self.unanswered += 1;
        if self.unanswered > PATIENCE {
            // By another address: it may not reach this one.
            self.connection = None;
            self.unanswered = 0;
        }
        if self.connection.is_none() {
            self.connection = P::open().ok();
        }
        // Restarted, it has another socket.
        if self
            .connection
            .as_mut()
            .is_some_and(|service| service.ask().is_err())
        {
            self.connection = None;
        }
    }

    fn log(&mut self, logged: LoggedState) {
        if self.logged.replace(logged) == Some(logged) {
            return;
        }
        match logged {
            LoggedState::Followed(grandmaster) => {
                let grandmaster = GrandmasterId::from(grandmaster);
                tracing::info!("common time: of the grandmaster {grandmaster}, by ptp4l");
            }
            LoggedState::Alone => {
                tracing::warn!("common time: ptp4l follows no grandmaster, so there is none")
            }
            LoggedState::Away => tracing::warn!(
                "common time: ptp4l does not answer at /var/run/ptp4lro or /var/run/ptp4l, so there is none; it has to run, in \
                 domain 0, and its socket to be accessible"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;
    use std::io;

    thread_local! {
        /// Answer of the service; none where it is away.
        static ANSWER: RefCell<Option<PtpState>> = const { RefCell::new(None) };
    }

    /// A service that answers at once.
    struct Toy;

    impl PtpService for Toy {
        fn open() -> io::Result<Self> {
            Ok(Self)
        }

        fn ask(&mut self) -> io::Result<()> {
            let is_there = ANSWER.with_borrow(Option::is_some);
            is_there
                .then_some(())
                .ok_or_else(|| io::ErrorKind::ConnectionRefused.into())
        }

        fn answer(&mut self) -> Option<PtpState> {
            ANSWER.with_borrow(|answer| *answer)
        }
    }

    #[test]
    fn the_service_is_asked_once_a_second_and_lost_when_it_is_silent() {
        let state = PtpState {
            grandmaster: 5,
            offset_ns: -30,
            is_present: true,
        };
        let at = |millis: i64| Instant::from_nanos(millis * 1_000_000);
        let answer = |state| ANSWER.set(state);
        let mut service = PolledService::<Toy>::default();
        answer(Some(state));
        assert_eq!(service.state(at(0)), None);
        assert_eq!(service.state(at(20)), Some(state));
        // Without a grandmaster it is its own.
        answer(Some(PtpState {
            is_present: false,
            ..state
        }));
        assert_eq!(service.state(at(1_100)), None);
        answer(Some(state));
        assert_eq!(service.state(at(2_200)), Some(state));
        answer(None);
        assert_eq!(service.state(at(6_100)), Some(state));
        assert_eq!(service.state(at(6_300)), None);
        answer(Some(state));
        assert_eq!(service.state(at(7_400)), None);
        assert_eq!(service.state(at(7_420)), Some(state));
    }

    #[test]
    fn a_stated_grandmaster_needs_no_service() {
        let setup = CommonTimeSetup {
            config: coaxle_node::config::parse(
                "t",
                "grandmaster = '0000000000000009'\nbound-us = 2",
            )
            .unwrap(),
            faults: Default::default(),
        };
        let frame = OutgoingFrame {
            channel: coaxle_node::Channel::BeaconRequests,
            far: 0,
            ideal_start: machine::now(),
            drift_ppm: 0.0,
        };
        let stamp = CommonClock::new(&setup, 1).read(&frame).unwrap();
        assert_eq!(stamp.grandmaster, 9);
        // 2 µs, and as far apart as the readings are.
        assert!((2_000..1_000_000).contains(&stamp.bound_ns), "{stamp:?}");
        let later = CommonClock::new(&setup, 1).read(&frame).unwrap();
        let passed = later.time_ns - stamp.time_ns - (later.at_ns - stamp.at_ns);
        let bound = i64::from(stamp.bound_ns + later.bound_ns);
        assert!(passed.abs() <= bound, "{passed} ns");
    }
}
