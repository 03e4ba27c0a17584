//! The cycle thread: the canonical loop of [`coaxle_node::contract`] on the machine's clock.
//!
//! Nothing in the loop allocates, locks, logs or awaits. Messages come in through mailboxes,
//! frames leave through the outbox, records through the telemetry ring; all are wait-free.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::Node;
use coaxle_node::circles::CircleChange;
use coaxle_node::config::{ClockConfig, Wrong};
use coaxle_node::faults::{CycleJitter, DeviatedClock, seed_of};
use coaxle_os::machine::{self, Machine};
use rtrb::{Consumer, Producer};

use crate::files::inputs::InputTap;
use crate::node::commands::OrderQueue;
use crate::node::counters::{Counters, count};
use crate::node::mailbox::Mailbox;
use crate::node::outbox::{Outbox, OutgoingFrame};
use crate::node::telemetry::{ArrivalRecord, Records};

/// Longest sleep between checks of the stop flag.
// A Ctrl-C is noticed within this time also by a node with a cycle of 100 ms, or a clock that starts later.
const NAP: Span = Span::from_millis(50);

/// Time from the start of a clock to its zero, so that the first cycle is not late already.
// Fifty of the shortest cycles.
const RUN_UP: Span = Span::from_millis(5);

/// Everything the cycle thread owns.
pub(crate) struct Cycle<N: Node> {
    pub(crate) node: N,
    pub(crate) clock: NodeClock,
    pub(crate) mailboxes: Vec<Mailbox>,
    pub(crate) orders: OrderQueue,
    pub(crate) outbox: Outbox,
    pub(crate) records: Records<N::Snapshot>,
    pub(crate) arrivals: Producer<ArrivalRecord>,
    /// Tap for the node's inputs, if they are recorded.
    pub(crate) inputs: Option<InputTap>,
    /// Changes of the circles across nodes.
    pub(crate) circles: Consumer<CircleChange>,
    pub(crate) counters: Arc<Counters>,
}

/// The node's clock derived from the machine's, with a deviation and jittery wake-ups.
pub(crate) struct NodeClock {
    deviated: DeviatedClock<Machine>,
    jitter: CycleJitter,
}

impl NodeClock {
    /// The clock that reads zero at `origin`.
    pub(crate) fn new(
        config: &ClockConfig,
        seed: u64,
        origin: Instant<Machine>,
    ) -> Result<Self, Wrong> {
        Ok(Self {
            // Seeds by name: a changed jitter leaves the random walk of the drift as it was.
            deviated: DeviatedClock::new(config, seed_of(seed, "clock"), origin)?,
            jitter: CycleJitter::new(config, seed_of(seed, "jitter")),
        })
    }

    /// Restarts the clock so that it reads zero in a moment.
    pub(crate) fn starting_soon(mut self) -> Self {
        self.deviated.start_at(machine::now() + RUN_UP);
        self
    }

    /// Start of the first cycle of a node with this clock.
    pub(crate) fn first_cycle(config: &ClockConfig) -> Instant<Local> {
        // The deviation of the start is part of the experiment: nodes whose cycles begin at other phases.
        Instant::EPOCH + config.start_phase()
    }
}

/// End of the loop, and its way of waiting.
pub(crate) struct Limits {
    pub(crate) run_for: Option<Span>,
    pub(crate) spin: Span,
}

impl<N: Node> Cycle<N> {
    /// Runs cycle after cycle until the time is up or `stop` is set.
    pub(crate) fn run(mut self, limits: &Limits, stop: &AtomicBool) {
        let end = limits.run_for.map(|run_for| machine::now() + run_for);
        loop {
            let due = self.clock.deviated.reference_at(self.node.next_cycle());
            let wake = due + self.clock.jitter.next();
            if end.is_some_and(|end| wake >= end) {
                // The node also owns the time up to the end.
                wait_until(end.unwrap_or(wake), limits.spin, stop);
                return;
            }
            if !wait_until(wake, limits.spin, stop) {
                return;
            }
            self.scan(machine::now());
        }
    }

    /// Runs one scan that actually begins at `woke`.
    pub(crate) fn scan(&mut self, woke: Instant<Machine>) {
        let Self {
            node,
            clock,
            mailboxes,
            orders,
            outbox,
            records,
            arrivals,
            inputs,
            circles,
            counters,
        } = self;
        let clock = &mut clock.deviated;
        let now = clock.local_at(woke);
        for (subscription, mailbox) in mailboxes.iter_mut().enumerate() {
            mailbox.drain(|arrival, message| {
                let at = clock.local_at(arrival);
                if let Some(inputs) = inputs {
                    inputs.received(at, subscription, message);
                }
                node.receive(at, subscription, message);
            });
        }
        while let Ok(change) = circles.pop() {
            if let Some(inputs) = inputs {
                inputs.circle(change);
            }
            node.set_circle(change);
        }
        orders.execute_all(woke, |order, cargo| {
            if let Some(inputs) = inputs {
                inputs.ordered(order);
            }
            node.execute_with(order, cargo)
        });
        machine::begin_cycle(clock.reference_at(node.ideal_start(now)));
        let tick = node.cycle(now);
        let mut has_frames = false;
        while let Some(outgoing) = node.transmit() {
            let frame = OutgoingFrame {
                channel: outgoing.channel,
                far: outgoing.far as u16,
                ideal_start: clock.reference_at(outgoing.ideal_start),
                drift_ppm: clock.drift_ppm(),
            };
            has_frames = true;
            if !outbox.push(&frame, outgoing.body) {
                count(&counters.publish_dropped);
            }
        }
        if has_frames {
            outbox.wake();
        }
        let ideal_start = clock.reference_at(tick.ideal_start);
        if let Some(inputs) = inputs {
            inputs.scan(ideal_start, woke, now);
        }
        while let Some(arrival) = node.arrival() {
            let record = ArrivalRecord {
                ideal_start,
                tick,
                arrival,
            };
            if arrivals.push(record).is_err() {
                count(&counters.arrivals_dropped);
            }
        }
        if !records.push(ideal_start, woke, node.snapshot()) {
            count(&counters.telemetry_dropped);
        }
        count(&counters.cycles);
    }
}

/// Waits for an instant; returns false if `stop` was set meanwhile.
fn wait_until(wake: Instant<Machine>, spin: Span, stop: &AtomicBool) -> bool {
    while !stop.load(Ordering::Relaxed) {
        // Short naps: the sleep itself cannot be interrupted by the flag.
        let nap = machine::now() + NAP;
        if nap < wake {
            machine::sleep_until(nap);
        } else {
            // Only the last nap is exact, by an absolute deadline with the spin.
            machine::sleep_then_spin_until(wake, spin);
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::transport::Request;
    use crate::node::audit::Audit;
    use crate::node::commands::{CommandServer, RequestSender, commands};
    use crate::node::mailbox::mailbox;
    use crate::node::outbox::{OutgoingFrames, outbox};
    use crate::node::telemetry::{Record, Telemetry, telemetry};
    use crate::node::toy::{Toy, ToySnapshot};
    use assert_no_alloc::assert_no_alloc;
    use coaxle_clock::{CycleIndex, CycleTime};
    use coaxle_node::config::parse;
    use coaxle_node::keys::NodeName;
    use coaxle_node::{Arrival, Arrived, AxisSample, Frame, FrameHeader, Message, Rejection};
    use rtrb::RingBuffer;
    use std::borrow::Cow;

    /// A request that always carries one fixed order and ignores its response.
    struct SameOrder;

    impl Request for SameOrder {
        fn key(&self) -> &str {
            "coaxle/toy/command"
        }

        fn payload(&self) -> Cow<'_, [u8]> {
            ORDER.as_bytes().into()
        }

        fn reply(&self, _json: String, _taken: bool) {}
    }

    const ORDER: &str =
        r#"{ "version": 1, "slave": "toy", "command": { "home": { "position": 3 } } }"#;

    struct Bench {
        cycle: Cycle<Toy>,
        inbox: crate::node::mailbox::Inbox,
        frames: OutgoingFrames,
        telemetry: Telemetry<ToySnapshot>,
        server: CommandServer,
        requests: RequestSender,
        counters: Arc<Counters>,
    }

    /// A toy with a cycle of 1 ms whose clock starts at machine time 0.
    fn bench(clock: &str) -> Bench {
        let config: ClockConfig = parse("test", clock).unwrap();
        let counters = Arc::new(Counters::default());
        // 64 places: few enough to be filled by the test of full rings.
        let (inbox, mailbox) = mailbox(64, 64, Arc::clone(&counters.mailbox_dropped));
        let (outbox, frames) = outbox(4096);
        let (arrivals, arrived) = RingBuffer::new(64);
        let toy = NodeName::new("toy").expect("a name");
        let (orders, server, requests) = commands(&toy, &Audit::new(&toy, 0));
        let cycle_time = CycleTime::new(Span::from_millis(1)).unwrap();
        let node = Toy::new(NodeClock::first_cycle(&config), cycle_time, 1);
        let (records, telemetry) = telemetry(node.snapshot(), usize::MAX, arrived);
        let cycle = Cycle {
            node,
            // Zero at the machine's own zero, so that instants of both clocks are compared by eye.
            clock: NodeClock::new(&config, 1, Instant::EPOCH).unwrap(),
            mailboxes: vec![mailbox],
            orders,
            outbox,
            records,
            arrivals,
            inputs: None,
            circles: RingBuffer::new(1).1,
            counters: Arc::clone(&counters),
        };
        Bench {
            cycle,
            inbox,
            frames,
            telemetry,
            server,
            requests,
            counters,
        }
    }

    impl Bench {
        fn record(&mut self) -> Record<ToySnapshot> {
            let mut taken = None;
            self.telemetry.take(|record| taken = Some(*record));
            taken.unwrap()
        }
    }

    fn at(micros: i64) -> Instant<Machine> {
        Instant::EPOCH + Span::from_micros(micros)
    }

    const REFUSED: Message<'static> = Message::Rejected(Rejection::Malformed);

    fn frame() -> Message<'static> {
        const AXES: &[Option<AxisSample>] = &[None];
        let header = FrameHeader {
            sender: 1,
            epoch: 2,
            index: CycleIndex(3),
            count: 3,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
            present_after: None,
            send_stamp: None,
        };
        Message::Frame(Frame { header, axes: AXES })
    }

    #[test]
    fn a_scan_takes_the_mail_and_leaves_a_frame_and_a_record() {
        let mut bench = bench("");
        bench.inbox.push(at(1_500), &REFUSED);
        bench.cycle.scan(at(2_030));

        let mut body = Vec::new();
        let frame = bench.frames.pop(&mut body).unwrap();
        // The cycle that begins at 2 ms, although its scan began 30 µs late.
        assert_eq!(frame.ideal_start, at(2_000));
        let record = bench.record();
        assert_eq!((record.ideal_start, record.woke), (at(2_000), at(2_030)));
        assert_eq!(record.snapshot.rejected, 1);
        assert_eq!(record.snapshot.last_arrival.as_nanos(), 1_500_000);
    }

    #[test]
    fn the_node_sees_its_own_clock_and_the_record_the_machines() {
        // 1000 ppm fast: local second 1 is at machine time 1/1.001.
        let mut bench = bench("drift-ppm = 1000");
        // 1 s / 1.001 = 999 000.999 µs, and a microsecond of lateness.
        let woke = at(999_002);
        bench.inbox.push(at(500_000), &REFUSED);
        bench.cycle.scan(woke);
        let record = bench.record();
        // 500 ms · 1.001.
        assert_eq!(record.snapshot.last_arrival.as_nanos(), 500_500_000);
        assert_eq!(record.woke, woke);
        // 1 s / 1.001 is 999 000.999 µs, a nanosecond beside the literal.
        assert!((record.ideal_start - at(999_001)).abs() < Span::from_micros(1));
    }

    #[test]
    fn what_a_scan_took_in_is_dated_in_both_clocks() {
        let mut bench = bench("drift-ppm = 1000");
        bench.inbox.push(at(500_000), &frame());
        bench.cycle.scan(at(999_002));
        let record = bench.telemetry.arrival().unwrap();
        assert_eq!(record.tick.count, 1_000);
        assert_eq!(record.tick.ideal_start.as_nanos(), 1_000_000_000);
        assert!((record.ideal_start - at(999_001)).abs() < Span::from_micros(1));
        let Arrival { at, what, .. } = record.arrival;
        let Arrived::Message(header) = what else {
            panic!("{record:?}");
        };
        assert_eq!((at.as_nanos(), header.count), (500_500_000, 3));
    }

    #[test]
    fn full_rings_are_counted_and_do_not_hold_the_scan() {
        let mut bench = bench("");
        for k in 0..200 {
            bench.inbox.push(at(1_000 * k), &frame());
            bench.cycle.scan(at(1_000 * k));
        }
        let read = |counter| crate::node::counters::read(counter);
        assert_eq!(read(&bench.counters.cycles), 200);
        // Each of the 200 scans fills a place, and nobody empties them.
        assert_eq!(read(&bench.counters.telemetry_dropped), 200 - 64);
        assert_eq!(read(&bench.counters.arrivals_dropped), 200 - 64);
        // Nobody takes frames either: of 4096 bytes each takes 100 and its header.
        assert!(read(&bench.counters.publish_dropped) > 0);
    }

    #[test]
    fn a_scan_does_not_allocate() {
        let mut bench = bench(
            "drift-ppm = 100\nrandom-walk-ppm = 0.1\njitter = { normal-us = 5 }\n\
             sine = { amplitude-ppm = 1, period-s = 10 }\n\
             drift-terms-ppm = [{ triangle = { amplitude = 1, period-s = 3 } }, { normal = 1 }]",
        );
        let mut body = Vec::with_capacity(4096);
        let arrival = at(0);
        for _ in 0..4 {
            bench.requests.send(arrival, Box::new(SameOrder), None);
        }
        bench.server.round(arrival);
        assert_no_alloc(|| {
            // Long enough for the clock to forget its oldest pieces.
            for k in 0..10_000 {
                for _ in 0..3 {
                    bench.inbox.push(at(1_000 * k - 100), &REFUSED);
                }
                bench.inbox.push(at(1_000 * k - 100), &frame());
                let wake = bench.cycle.clock.jitter.next();
                bench.cycle.scan(at(1_000 * k + 100) + wake);
                while bench.frames.pop(&mut body).is_some() {}
                while bench.telemetry.take(|_| {}) {}
                while bench.telemetry.arrival().is_some() {}
            }
        });
        assert_eq!(crate::node::counters::read(&bench.counters.cycles), 10_000);
        assert_eq!(bench.cycle.node.snapshot().commands, 4);
    }

    #[test]
    fn the_loop_ends_in_time_and_on_demand() {
        let limits = |run_for| Limits {
            run_for,
            spin: Span::ZERO,
        };
        let start = machine::now();
        let run_for = Span::from_millis(30);
        let mut timed = bench("");
        timed.cycle.clock = timed.cycle.clock.starting_soon();
        timed
            .cycle
            .run(&limits(Some(run_for)), &AtomicBool::new(false));
        // At least: a busy machine may end later.
        assert!(machine::now() - start >= run_for);
        assert!(crate::node::counters::read(&timed.counters.cycles) > 0);

        // A start phase of 100 s: the stop must be seen during the wait for the first cycle.
        let stopped = bench("start-phase-us = 1e8");
        stopped.cycle.run(&limits(None), &AtomicBool::new(true));
        assert_eq!(crate::node::counters::read(&stopped.counters.cycles), 0);
    }
}
