//! Completeness of the recorded arrivals: an observer that is fed with them reproduces the receiver's results,
//! bit for bit.

use std::collections::BTreeMap;
use std::path::Path;

use coaxle_clock::delay::{DelayExchange, TimeResponse};
use coaxle_clock::observer::{ObserverOutput, ObserverParameters, PhaseObserver};
use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_node::arrival::{ArrivalRow, ExchangeRow};
use serde::de::DeserializeOwned;

use crate::common;

/// Many faults of messages, and a restart of the sender.
const OVERRIDES: [&str; 9] = [
    "duration-s=12",
    "expect=[]",
    "sender.master.clock.drift-ppm=80",
    "sender.master.clock.random-walk-ppm=1",
    "receiver.observer.clock.jitter={ normal-us = 30 }",
    "receiver.observer.faults.loss=0.02",
    "receiver.observer.faults.duplication=0.02",
    "receiver.observer.faults.spikes={ share = 0.005, from-us = 1000, to-us = 20000 }",
    "event=[{ at-s = 7, node = \"master\", action = \"restart\", for-s = 0.4 }]",
];

#[test]
fn an_observer_that_is_given_the_arrivals_finds_the_same_to_the_bit() {
    for delay in ["\"off\"", "\"measured\""] {
        let out = tempfile::tempdir().expect("a scratch folder");
        let delay_set = format!("receiver.observer.delay={delay}");
        let mut sets = OVERRIDES.to_vec();
        sets.push(&delay_set);
        common::trace_into("observer", &sets, &["observer"], out.path());

        let arrivals = rows::<ArrivalRow>(&out.path().join("nodes/observer-arrivals.csv"));
        let exchanges = rows::<ExchangeRow>(&out.path().join("nodes/observer-exchanges.csv"));
        // A frame per millisecond for 11.6 s, of which 2 % are lost and 2 % repeated.
        assert!(arrivals.len() > 10_000, "{}", arrivals.len());
        assert_eq!(exchanges.is_empty(), delay == "\"off\"");
        let late = |row: &&ArrivalRow| row.arrival_ns > row.cycle_start_ns;
        assert!(
            arrivals.iter().find(late).is_none(),
            "taken in before it came"
        );

        let mut replay = Replay::new(&arrivals, exchanges);
        let mut compared = 0;
        for line in trace(&out.path().join("trace.csv")) {
            let cycle: u64 = line["cycle"].parse().expect("a number");
            let Some(seen) = replay.cycle(cycle) else {
                continue;
            };
            assert_eq!(
                // Text has the shortest digits that give the number back, so equal texts are equal bits.
                line["far.drift_ppm"],
                shown(seen.drift_ppm),
                "cycle {cycle}"
            );
            let sigma = shown(seen.offset_sigma.as_micros());
            assert_eq!(line["far.offset_sigma_us"], sigma, "cycle {cycle}");
            assert_eq!(line["far.shifts"], seen.shifts.to_string(), "cycle {cycle}");
            // While the axis is brought back, its set values stand for no instant.
            if line["axis.state"] == "observer" && line["axis.continuity"] == "following" {
                let count: u64 = line["far.count"].parse().expect("a number");
                let far_time = replay.far_time_ns(&seen, count);
                assert_eq!(
                    line["axis.far_time_ns"],
                    far_time.to_string(),
                    "cycle {cycle}"
                );
                compared += 1;
            }
        }
        assert!(compared > 5_000, "{compared} with delay = {delay}");
    }
}

/// Replay of the receiver's processing of the arrivals.
struct Replay {
    observer: PhaseObserver,
    delay: DelayExchange,
    arrivals: BTreeMap<u64, Vec<ArrivalRow>>,
    exchanges: BTreeMap<u64, Vec<ExchangeRow>>,
    /// Cycles are a cycle time apart, with or without arrivals.
    start_ns: i64,
    measured: bool,
    received: bool,
}

/// Cycle time of the receiver and of the sender, ns.
const CYCLE: i64 = 1_000_000;
/// Run of the requester in requests; here it is constant.
const RUN: u64 = 1;

impl Replay {
    fn new(arrivals: &[ArrivalRow], exchanges: Vec<ExchangeRow>) -> Self {
        let first = &arrivals[0];
        assert_eq!(first.cycle_time_ns, CYCLE);
        let cycle_time = CycleTime::new(Span::from_nanos(CYCLE)).expect("a cycle time");
        let parameters = ObserverParameters::default();
        Self {
            observer: PhaseObserver::new(cycle_time, parameters).expect("an observer"),
            delay: DelayExchange::new(RUN),
            start_ns: first.cycle_start_ns - first.cycle as i64 * CYCLE,
            measured: !exchanges.is_empty(),
            arrivals: by_cycle(arrivals.to_vec(), |row| row.cycle),
            exchanges: by_cycle(exchanges, |row| row.cycle),
            received: false,
        }
    }

    /// Runs a cycle. Returns none before the first message.
    fn cycle(&mut self, cycle: u64) -> Option<ObserverOutput> {
        let now = Instant::from_nanos(self.start_ns + cycle as i64 * CYCLE);
        for row in self.arrivals.remove(&cycle).unwrap_or_default() {
            assert_eq!(row.cycle_start_ns, now.as_nanos());
            let arrived = Instant::from_nanos(row.arrival_ns);
            let stamp = row.send_stamp_ns.map(Span::from_nanos);
            self.observer.observe(row.epoch, row.count, arrived, stamp);
            self.received = true;
        }
        // The receiver runs no observer before it has a frame, and so shows none.
        if !self.received {
            return None;
        }
        if self.measured {
            self.measure_delay(cycle);
        }
        // The delay is measured before the cycle: the far time of a cycle already has the exchanges that came in it.
        let seen = self.observer.cycle(now);
        if self.measured {
            // Each request is numbered: without asking, the responses of the file would answer nothing that is pending.
            let _ = self.delay.ask(now);
        }
        Some(seen)
    }

    fn measure_delay(&mut self, cycle: u64) {
        if let Some(line) = self.observer.line() {
            // Before the exchanges, as in the receiver: they are compared with the line as it is after the jump.
            if let Some(jump) = self.delay.follow(&line) {
                self.observer.attribute_step_to_path(jump);
            }
            for row in self.exchanges.remove(&cycle).unwrap_or_default() {
                let arrived = Instant::<Local>::from_nanos(row.t4_ns);
                let _ = self.delay.take(&response(&row), arrived, &line);
            }
        }
        // Until the first exchange the far time lags by the whole delay, as with none measured.
        let delay = self.delay.delay().unwrap_or(Span::ZERO);
        self.observer.set_delay(delay);
    }

    /// Far time as the receiver shows it: by how much it moves the newest message.
    fn far_time_ns(&self, seen: &ObserverOutput, count: u64) -> i64 {
        let far = seen.far_time.expect("known");
        let sent = self.observer.far_time_of(count).expect("known");
        count as i64 * CYCLE + far.since(sent).to_span().as_nanos()
    }
}

fn response(row: &ExchangeRow) -> TimeResponse {
    TimeResponse {
        run: RUN,
        number: row.number,
        requested: Instant::from_nanos(row.t1_ns),
        epoch: row.epoch,
        received: Span::from_nanos(row.t2_ns),
        responded: Span::from_nanos(row.t3_ns),
    }
}

fn by_cycle<T>(rows: Vec<T>, cycle: impl Fn(&T) -> u64) -> BTreeMap<u64, Vec<T>> {
    let mut sorted = BTreeMap::<u64, Vec<T>>::new();
    for row in rows {
        sorted.entry(cycle(&row)).or_default().push(row);
    }
    sorted
}

fn rows<T: DeserializeOwned>(path: &Path) -> Vec<T> {
    let mut csv = csv::Reader::from_path(path).expect("the run left the file");
    csv.deserialize().map(|row| row.expect("a row")).collect()
}

/// The lines of a trace, by the names of their columns.
fn trace(path: &Path) -> Vec<BTreeMap<String, String>> {
    rows(path)
}

/// A number as in files: all of its digits.
fn shown(number: f64) -> String {
    let mut csv = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    csv.serialize(number).expect("written");
    let bytes = csv.into_inner().expect("written");
    String::from_utf8(bytes).expect("text").trim().to_owned()
}
