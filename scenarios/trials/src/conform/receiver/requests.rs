//! The time requests of the receiver, and the responses of the node that is played.

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_node::exchange::{
    MAX_TIME_RESPONSES, ReceivedRequest, TIME_RESPONSES_CAPACITY, TimeResponsesHeader,
    encode_time_responses,
};
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, TimeRequest};
use coaxle_os::Machine;

use super::script::REQUESTS;
use crate::conform::rule::{RuleFinding, RuleOutcome, Tally};

/// Range of the mean pause between two requests, s: some ten come each second.
const PAUSE: (f64, f64) = (0.02, 1.0);

/// Takes time requests and responds.
#[derive(Debug)]
pub(super) struct TimeResponder {
    requests: KeySeal,
    responses: KeySeal,
    sender: u32,
    requester: u32,
    waiting: Vec<(Instant<Machine>, TimeRequest)>,
    newest: Option<(u64, u32)>,
    seen: Tally,
    times: Option<(Instant<Machine>, Instant<Machine>)>,
}

/// The run and cycle of the response.
#[derive(Clone, Copy, Debug)]
pub(super) struct ResponseCycle {
    pub(super) epoch: u64,
    pub(super) count: u64,
    pub(super) cycle_time: CycleTime,
    /// The ideal start of cycle 0.
    pub(super) start: Instant<Machine>,
    /// Departure of the responses.
    pub(super) now: Instant<Machine>,
}

impl TimeResponder {
    /// Requests from the node `receiver` to the node `played`.
    pub(super) fn new(played: &NodeName, receiver: &NodeName) -> Self {
        Self {
            requests: KeySeal::new(&played.channel_key(Channel::TimeRequests)),
            responses: KeySeal::new(&played.channel_key(Channel::TimeResponses)),
            sender: sender_id(played),
            requester: sender_id(receiver),
            waiting: Vec::new(),
            newest: None,
            seen: Tally::default(),
            times: None,
        }
    }

    /// Takes a request that came at `at`; `epoch` is that of the receiver, as its status has it.
    pub(super) fn take(&mut self, at: Instant<Machine>, bytes: &[u8], epoch: Option<u64>) {
        let request = match self.requests.open_time_request(bytes) {
            Ok(request) => request,
            Err(reason) => {
                self.seen.bad(reason.to_string(), "a time request");
                return;
            }
        };
        let wrong = self.wrong(&request, epoch);
        self.seen
            .check(wrong.is_none(), || wrong.unwrap_or_default());
        self.newest = Some((request.run, request.number));
        let first = self.times.map_or(at, |(first, _)| first);
        self.times = Some((first, at));
        if request.requester == self.requester && self.waiting.len() < MAX_TIME_RESPONSES {
            self.waiting.push((at, request));
        }
    }

    /// Begins another run, which drops the waiting requests.
    pub(super) fn forget(&mut self) {
        self.waiting.clear();
    }

    /// Responds to all waiting requests in a frame; with `bad`, adds a frame of wrong responses, and returns their number.
    pub(super) fn respond(&mut self, cycle: &ResponseCycle, bad: bool) -> (Vec<Vec<u8>>, u64) {
        let waiting = std::mem::take(&mut self.waiting);
        let reply = |(at, request): &(Instant<Machine>, TimeRequest)| ReceivedRequest {
            request: *request,
            received: *at - cycle.start,
        };
        let good: Vec<_> = waiting.iter().map(reply).collect();
        if good.is_empty() {
            return (Vec::new(), 0);
        }
        let mut frames = vec![self.frame(cycle, &good)];
        let wrong: Vec<_> = good
            .iter()
            .take(MAX_TIME_RESPONSES / 3)
            .flat_map(wrong_ones)
            .collect();
        if bad {
            frames.push(self.frame(cycle, &wrong));
        }
        (frames, if bad { wrong.len() as u64 } else { 0 })
    }

    /// True if any request came.
    pub(super) const fn any(&self) -> bool {
        self.seen.all() > 0
    }

    pub(super) fn finding(&self) -> RuleFinding {
        let none = "no time request came: it follows with a lag, or was told the delay";
        let outcome = match self.seen.outcome("requests", none) {
            RuleOutcome::Kept { seen } => self.pace(seen),
            other => other,
        };
        RuleFinding::new(&REQUESTS, outcome)
    }

    fn pace(&self, seen: String) -> RuleOutcome {
        let Some((first, last)) = self.times.filter(|(first, last)| last > first) else {
            return RuleOutcome::kept(seen);
        };
        let pause = (last - first).as_secs_f64() / (self.seen.all() - 1) as f64;
        let words = format!("{seen}, one every {pause:.3} s");
        match (PAUSE.0..=PAUSE.1).contains(&pause) {
            true => RuleOutcome::kept(words),
            false => RuleOutcome::broken(words, "some ten a second"),
        }
    }

    fn wrong(&self, request: &TimeRequest, epoch: Option<u64>) -> Option<(String, String)> {
        let TimeRequest {
            requester,
            run,
            number,
            ..
        } = *request;
        if requester != self.requester {
            let expected = format!("{}, the CRC-32 of its name", self.requester);
            return Some((format!("the requester {requester}"), expected));
        }
        if let Some(epoch) = epoch.filter(|epoch| *epoch != run) {
            let expected = format!("{epoch:016x}, the epoch of its status");
            return Some((format!("the run {run:016x}"), expected));
        }
        let before = self.newest.filter(|(before, _)| *before == run);
        let (_, before) = before.filter(|(_, before)| number.wrapping_sub(*before) as i32 <= 0)?;
        Some((
            format!("number {number} after {before}"),
            "numbers that go up".to_owned(),
        ))
    }

    fn frame(&self, cycle: &ResponseCycle, replies: &[ReceivedRequest]) -> Vec<u8> {
        let header = TimeResponsesHeader {
            sender: self.sender,
            epoch: cycle.epoch,
            count: cycle.count,
            cycle_time: cycle.cycle_time,
        };
        let mut body = [0; TIME_RESPONSES_CAPACITY];
        let length = encode_time_responses(&header, replies, &mut body);
        let ideal = cycle.start + cycle.cycle_time.span() * cycle.count as i64;
        let stamp: Span = cycle.now - ideal;
        let mut sealed = Vec::new();
        self.responses
            .seal(&body[..length], Some(stamp), &mut sealed);
        sealed
    }
}

/// Wrong responses: to another run, to a request that was never sent, and a duplicate.
fn wrong_ones(reply: &ReceivedRequest) -> [ReceivedRequest; 3] {
    let with = |change: fn(&mut TimeRequest)| {
        let mut other = *reply;
        change(&mut other.request);
        other
    };
    [
        with(|request| request.run ^= 1),
        with(|request| request.number = request.number.wrapping_add(1_000)),
        *reply,
    ]
}
