//! The time requests of the receiver, and the responses of the node that is played.

use coaxle_clock::Instant;
use coaxle_node::exchange::{
    MAX_TIME_RESPONSES, ReceivedRequest, TIME_RESPONSES_CAPACITY, TimeResponsesHeader,
    encode_time_responses,
};
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, TimeRequest};
use coaxle_os::Machine;

use crate::conform::rule::{Mismatch, RuleOutcome, Tally, ensure, mismatch};

/// Range of the mean pause between two requests, s: some ten come each second.
const PAUSE: (f64, f64) = (0.02, 1.0);

/// Takes time requests and responds.
#[derive(Debug)]
pub(super) struct TimeResponder {
    requests: KeySeal,
    responses: KeySeal,
    requester: u32,
    waiting: Vec<(Instant<Machine>, TimeRequest)>,
    newest: Option<(u64, u32)>,
    seen: Tally,
    times: Option<(Instant<Machine>, Instant<Machine>)>,
}

impl TimeResponder {
    /// Requests from the node `receiver` to the node `played`.
    pub(super) fn new(played: &NodeName, receiver: &NodeName) -> Self {
        Self {
            requests: KeySeal::new(&played.channel_key(Channel::TimeRequests)),
            responses: KeySeal::new(&played.channel_key(Channel::TimeResponses)),
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
                return self
                    .seen
                    .count(Err(mismatch(reason.to_string(), "a time request")));
            }
        };
        self.seen.count(self.checked(&request, epoch));
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

    /// Responds to all waiting requests in a frame of this cycle of a run that began at `start`; with `bad`, adds a
    /// frame of wrong responses, and returns their number.
    pub(super) fn respond(
        &mut self,
        header: &FrameHeader,
        start: Instant<Machine>,
        bad: bool,
    ) -> (Vec<Vec<u8>>, u64) {
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        let good = waiting.map(|(at, request)| ReceivedRequest {
            request,
            received: at - start,
        });
        let good: Vec<_> = good.collect();
        if good.is_empty() {
            return (Vec::new(), 0);
        }
        let mut frames = vec![self.frame(header, &good)];
        if !bad {
            return (frames, 0);
        }
        let wrong = good.iter().take(MAX_TIME_RESPONSES / 3);
        let wrong: Vec<_> = wrong.flat_map(wrong_ones).collect();
        frames.push(self.frame(header, &wrong));
        (frames, wrong.len() as u64)
    }

    /// True if any request came.
    pub(super) const fn any(&self) -> bool {
        self.seen.all() > 0
    }

    pub(super) fn outcome(&self) -> RuleOutcome {
        let none = "no time request came: it follows with a lag, or was told the delay";
        let outcome = self.seen.outcome("requests", none);
        let times = self.times.filter(|(first, last)| last > first);
        let (RuleOutcome::Kept { seen }, Some((first, last))) = (&outcome, times) else {
            return outcome;
        };
        let pause = (last - first).as_secs_f64() / (self.seen.all() - 1) as f64;
        let is_kept = (PAUSE.0..=PAUSE.1).contains(&pause);
        let words = format!("{seen}, one every {pause:.3} s");
        RuleOutcome::of(is_kept, words, "some ten a second")
    }

    /// Checks a request; `epoch` is that of the receiver.
    fn checked(&self, request: &TimeRequest, epoch: Option<u64>) -> Result<(), Mismatch> {
        let TimeRequest {
            requester,
            run,
            number,
            ..
        } = *request;
        ensure(requester == self.requester, || {
            let expected = format!("{}, the CRC-32 of its name", self.requester);
            mismatch(format!("the requester {requester}"), expected)
        })?;
        let epoch = epoch.unwrap_or(run);
        ensure(run == epoch, || {
            let expected = format!("{epoch:016x}, the epoch of its status");
            mismatch(format!("the run {run:016x}"), expected)
        })?;
        let before = self.newest.filter(|(before, _)| *before == run);
        let before = before.map_or(number.wrapping_sub(1), |(_, before)| before);
        ensure(number.wrapping_sub(before) as i32 > 0, || {
            mismatch(
                format!("number {number} after {before}"),
                "numbers that go up",
            )
        })
    }

    fn frame(&self, header: &FrameHeader, replies: &[ReceivedRequest]) -> Vec<u8> {
        let of_cycle = TimeResponsesHeader {
            sender: header.sender,
            epoch: header.epoch,
            count: header.count,
            cycle_time: header.cycle_time,
        };
        let mut body = [0; TIME_RESPONSES_CAPACITY];
        let length = encode_time_responses(&of_cycle, replies, &mut body);
        let mut sealed = Vec::new();
        self.responses
            .seal(&body[..length], header.send_stamp, &mut sealed);
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
