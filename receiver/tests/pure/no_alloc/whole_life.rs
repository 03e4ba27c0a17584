//! A receiver from its start, over a pause, a loss of its master, another run of it, and orders, without an allocation.

use crate::bench::{Clock, Far, LATENCY, MILLISECOND};
use assert_no_alloc::assert_no_alloc;
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_node::config::parse;
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::{
    Arrived, Channel, CommandOrder, CommandOutcome, Intake, KeptMessage, Message, Node, Outgoing,
    Reader, Rejection, TimeRequest, TimeServer,
};
use coaxle_receiver::{FilterMode, HealthName, Receiver, ReceiverConfig};

/// Orders on the far node, one in ten cycles.
const ORDERS: [&str; 9] = [
    r#"{ "filter-mode": "pt1" }"#,
    r#"{ "filter-mode": "observer" }"#,
    r#"{ "re-initialise": {} }"#,
    r#"{ "set-delay": { "fixed-us": 100 } }"#,
    r#"{ "disable": {} }"#,
    r#"{ "set-parameters": { "time-sync": { "age-of-data-limit": 20 }, "extrapolate": { "t1-factor-pos": 5 } } }"#,
    r#"{ "enable": {} }"#,
    r#"{ "set-delay": "measured" }"#,
    r#"{ "filter-mode": "sync" }"#,
];

fn orders() -> Vec<CommandOrder> {
    let order = |command| {
        let json = format!(r#"{{ "version": 1, "far": "conveyor", "command": {command} }}"#);
        CommandOrder::from_json(json.as_bytes()).expect("an order")
    };
    ORDERS.iter().map(order).collect()
}

pub(super) fn goes_through_its_life_without_allocating(mode: &str) {
    let config: ReceiverConfig = parse(
        "r.toml",
        &format!(
            "name = 'saw'\nmaster.node = 'conveyor'\ncycle-time-us = 1000\nmode = '{mode}'\n\
             sync.time-sync.automatic-re-init = true\n\
             slave = [{{ drive.following-error-window = 1.0 }}]"
        ),
    )
    .expect("a config");
    let mut intake = Intake::new("coaxle/conveyor/axes", &config.far[0].node, &[1]);
    let messages = messages(&mut intake);
    let clock = Clock { ppm: 0 };
    let mut receiver = Receiver::new(&config, clock.read(MILLISECOND / 2), 7).expect("a receiver");

    let mut next = messages.iter().peekable();
    let mut seen = [false; 4];
    let mut bytes = 0;
    let mut master = Master::new(&config);
    let (mut requested, mut responses) = (None, 0);
    let (mut arrived, mut exchanged) = (0, 0);
    let orders = orders();
    let (mut orders, mut executed) = (orders.iter(), 0);
    let (mut exchanges, mut responses_refused) = (0, 0);
    assert_no_alloc(|| {
        while receiver.next_cycle() < clock.read(12_000 * MILLISECOND) {
            let mut now = receiver.next_cycle();
            if now > clock.read(4_000 * MILLISECOND) && now < clock.read(7_000 * MILLISECOND) {
                now = clock.read(7_000 * MILLISECOND);
            }
            while let Some((at, message)) = next.next_if(|(at, _)| *at <= now) {
                receiver.receive(*at, 0, &message.get());
            }
            if now > clock.read((11_000 + 10 * executed as i64) * MILLISECOND)
                && let Some(order) = orders.next()
            {
                // Counters restart with a re-initialisation.
                let counters = &receiver.snapshot().signals.far[0];
                exchanges = exchanges.max(counters.exchanges);
                responses_refused = responses_refused.max(counters.responses_refused);
                executed += usize::from(matches!(
                    receiver.execute(order),
                    CommandOutcome::FarAccepted { .. }
                ));
            }
            let _ = receiver.cycle(now);
            while let Some(outgoing) = receiver.transmit() {
                bytes += outgoing.body.len();
                match outgoing.channel {
                    Channel::TimeRequests => requested = Some(master.request_of(&outgoing)),
                    Channel::TimeResponses => responses += 1,
                    Channel::Axes
                    | Channel::Slaves
                    | Channel::FarAxes
                    | Channel::BeaconRequests
                    | Channel::BeaconResponses
                    | Channel::Plans
                    | Channel::Followers => {}
                }
            }
            while let Some(arrival) = receiver.arrival() {
                match arrival.what {
                    Arrived::Message(_) => arrived += 1,
                    Arrived::Exchange(_) => exchanged += 1,
                }
            }
            if let Some(request) = requested.take() {
                // Time requests also go to the receiver, whenever it sends one.
                receiver.receive(now, 2, &Message::TimeRequest(request));
                master.respond(&request, now, |at, message| {
                    receiver.receive(at, 1, message)
                });
            }
            match receiver.snapshot().health.name() {
                HealthName::WaitingForMaster => seen[0] = true,
                HealthName::StartingUp => seen[1] = true,
                HealthName::Ok => seen[2] = true,
                HealthName::DriveTripped => seen[3] = true,
                _ => {}
            }
        }
    });
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    assert_eq!(executed, ORDERS.len());
    assert_eq!(seen, [true; 4], "all of its life was gone through");
    assert!(bytes > 5_000 * 50);
    let counters = &receiver.snapshot().signals.far[0];
    // A refused message for each 500 of some 10 000.
    assert!(counters.restarts == 1 && counters.rejected > 10);
    assert!(counters.overflow > 0 && counters.stale > 0);
    let used = counters.received - counters.overflow - counters.stale;
    assert!(arrived > 5_000 && arrived <= used, "{arrived} of {used}");
    if config.far[0].mode == FilterMode::Observer {
        assert!(exchanges > 60 && responses_refused > 0);
        assert!(exchanged >= exchanges, "{exchanged}");
        assert!(responses > 60);
    }
}

/// The first run of the sender, reduced to its responses, without a heap.
struct Master {
    clock: Clock,
    start: Instant<Local>,
    time_server: TimeServer,
    requests: KeySeal,
    responses: KeySeal,
    reader: Reader,
    frame: Vec<u8>,
}

impl Master {
    fn new(config: &ReceiverConfig) -> Self {
        let clock = Clock { ppm: 1000 };
        let start = clock.read(100 * MILLISECOND);
        let name = &config.far[0].node;
        let cycle_time = CycleTime::new(CYCLE).expect("a cycle time");
        Self {
            clock,
            start,
            time_server: TimeServer::new(sender_id(name), 1, start, cycle_time),
            requests: KeySeal::new(&name.channel_key(Channel::TimeRequests)),
            responses: KeySeal::new(&name.channel_key(Channel::TimeResponses)),
            reader: Reader::time_responses_of(name, &config.name),
            // Longer than any response, so that it never grows in a cycle.
            frame: Vec::with_capacity(1_000),
        }
    }

    fn request_of(&mut self, outgoing: &Outgoing<'_>) -> TimeRequest {
        let stamp = Some(Span::ZERO);
        self.requests.seal(outgoing.body, stamp, &mut self.frame);
        self.requests
            .open_time_request(&self.frame)
            .expect("a request")
    }

    /// Responds to a request of `requested`, which is true time.
    fn respond(
        &mut self,
        request: &TimeRequest,
        requested: Instant<Local>,
        mut deliver: impl FnMut(Instant<Local>, &Message<'_>),
    ) {
        let received = requested + LATENCY;
        let received_here = self.clock.read(received.as_nanos());
        // A sender responds in its next cycle.
        let count = (received_here - self.start).div_floor(CYCLE) + 1;
        let tick = Tick {
            count: count as u64,
            ideal_start: self.start + CYCLE * count,
            elapsed: 1,
        };
        self.time_server.receive(received_here, request);
        self.time_server.respond(&tick, tick.ideal_start);
        let outgoing = self.time_server.transmit().expect("a response");
        self.responses
            .seal(outgoing.body, Some(Span::ZERO), &mut self.frame);
        let left = Instant::from_nanos(self.clock.truth(tick.ideal_start));
        self.reader
            .read(&self.frame, |message| deliver(left + LATENCY, message));
    }
}

const CYCLE: Span = Span::from_millis(1);

/// Two runs of the sender with a pause between them, and refused frames in between.
fn messages(intake: &mut Intake) -> Vec<(Instant<Local>, KeptMessage)> {
    let clock = Clock { ppm: 0 };
    let mut messages = Vec::new();
    for (start, end, epoch) in [(100, 8_000, 1), (9_000, 11_500, 2)] {
        let mut far = Far::new(1000, 1000, start * MILLISECOND, epoch);
        while far.next() < end * MILLISECOND {
            let sent = far.next();
            let mut message = KeptMessage::new(&intake.message(&far.tick(sent)));
            if sent > 11_050 * MILLISECOND {
                // A step of the axis itself while the far node is disabled, which trips the drive.
                for axis in message.axes_mut().iter_mut().flatten() {
                    axis.set.position += 5_000.0;
                }
            }
            let at = clock.read(sent + LATENCY.as_nanos());
            messages.push((at, message));
            if far.count().is_multiple_of(500) {
                let refused = Message::Rejected(Rejection::WrongChecksum);
                messages.push((at, KeptMessage::new(&refused)));
            }
        }
    }
    messages
}
