//! Checks of a node's responses to time requests.

use std::collections::BTreeMap;

use coaxle_clock::{Instant, Span};
use coaxle_node::exchange::TimeResponsesHeader;
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, TimeRequest};
use coaxle_os::Machine;

use super::rules::{SenderRule, Tallies, UNANSWERED};
use super::{FrameClock, Requester};
use crate::conform::rule::{Mismatch, RuleOutcome, Tally, ensure, mismatch};

/// Margin beyond two cycles within which a response may come: the machines are busy.
const RESPONSE_MARGIN: Span = Span::from_millis(100);
/// Share of responses that may be missing or late.
const MISSING: f64 = 0.2;
/// Greatest difference between the clocks of responses and frames. A comparison in one moment is no more accurate.
const MAX_CLOCK_DIFFERENCE: Span = Span::from_secs(1);

/// Requests sent, and their responses.
#[derive(Debug)]
pub(super) struct ExchangeChecks {
    seal: KeySeal,
    sender: u32,
    requester: Requester,
    requests: BTreeMap<u32, SentRequest>,
    cycle: Span,
}

/// A time request of this tool.
#[derive(Clone, Copy, Debug)]
struct SentRequest {
    request: TimeRequest,
    at: Instant<Machine>,
    /// True if a node may not refuse it.
    is_good: bool,
    /// Arrival of the first response.
    answered: Option<Instant<Machine>>,
}

/// The two stamps of a response, and its arrival.
#[derive(Clone, Copy, Debug)]
struct ResponseStamps {
    /// t2
    received: Span,
    /// t3
    left: Span,
    /// t4, of the clock of this tool as t1 is.
    at: Instant<Machine>,
}

impl ExchangeChecks {
    pub(super) fn new(node: &NodeName, requester: Requester) -> Self {
        Self {
            seal: KeySeal::new(&node.channel_key(Channel::TimeResponses)),
            sender: sender_id(node),
            requester,
            requests: BTreeMap::new(),
            cycle: Span::ZERO,
        }
    }

    /// Notes a request that left at `at`; a node must refuse a bad one.
    pub(super) fn request_sent(
        &mut self,
        at: Instant<Machine>,
        request: TimeRequest,
        is_good: bool,
    ) {
        let sent = SentRequest {
            request,
            at,
            is_good,
            answered: None,
        };
        self.requests.insert(request.number, sent);
    }

    /// Takes a frame of responses that came at `at`.
    pub(super) fn take(
        &mut self,
        at: Instant<Machine>,
        bytes: &[u8],
        frames: Option<&FrameClock>,
        tallies: &mut Tallies,
    ) {
        let mut replies = Vec::new();
        let opened = (self.seal).open_all_time_responses(bytes, |reply| replies.push(*reply));
        let checked = match &opened {
            Ok((header, _)) => self.check_header(header, frames),
            Err(reason) => Err(mismatch(reason.to_string(), "a frame of responses")),
        };
        let is_good = tallies.count(SenderRule::AnswerFrame, checked);
        let Some((header, left)) = opened.ok().filter(|_| is_good) else {
            return;
        };
        self.cycle = header.cycle_time.span();
        for reply in replies {
            let received = reply.received;
            if let Some(sent) = self.answer(at, &reply.request, tallies) {
                let stamps = ResponseStamps { received, left, at };
                let case = check_stamps(&sent, &stamps, frames);
                tallies.count(SenderRule::AnswerStamps, case);
            }
        }
    }

    /// Outcome of the times to respond at `end`, when no more messages come.
    pub(super) fn time(&self, end: Instant<Machine>) -> RuleOutcome {
        let limit = self.cycle * 2 + RESPONSE_MARGIN;
        let all = self.requests.values().filter(|sent| sent.is_good);
        // A response to the most recent requests may still come.
        let due = all.filter(|sent| end - sent.at > limit * 3);
        let mut tally = Tally::default();
        let mut some = false;
        for sent in due {
            let took = sent.answered.map(|at| at - sent.at);
            some |= took.is_some();
            tally.count(ensure(took.is_some_and(|took| took <= limit), || {
                let number = sent.request.number;
                let received = match took {
                    Some(took) => format!("a response after {took} (request {number})"),
                    None => format!("no response (request {number})"),
                };
                mismatch(received, format!("one in the next cycle, {limit} at most"))
            }));
        }
        match some {
            true => tally.outcome_but_for(MISSING, "requests", UNANSWERED),
            false => RuleOutcome::not_seen(UNANSWERED),
        }
    }

    fn check_header(
        &self,
        header: &TimeResponsesHeader,
        frames: Option<&FrameClock>,
    ) -> Result<(), Mismatch> {
        let differs = |what: &str, received: String, expected: String| {
            mismatch(
                format!("the {what} {received}"),
                format!("{expected}, as in its frames"),
            )
        };
        ensure(header.sender == self.sender, || {
            differs("sender", header.sender.to_string(), self.sender.to_string())
        })?;
        let Some(frames) = frames else {
            return Ok(());
        };
        ensure(header.epoch == frames.epoch, || {
            let [own, due] = [header.epoch, frames.epoch].map(|epoch| format!("{epoch:016x}"));
            differs("epoch", own, due)
        })?;
        ensure(header.cycle_time == frames.cycle_time, || {
            let times = [header.cycle_time, frames.cycle_time];
            let [own, due] = times.map(|time| time.span().to_string());
            differs("cycle time", own, due)
        })
    }

    /// The request that is answered for the first time; none for any other.
    fn answer(
        &mut self,
        at: Instant<Machine>,
        request: &TimeRequest,
        tallies: &mut Tallies,
    ) -> Option<SentRequest> {
        // A response to another requester.
        if request.requester != self.requester.id {
            return None;
        }
        let (number, run) = (request.number, request.run);
        let sent = self.requests.get_mut(&number);
        let Some(sent) = sent.filter(|_| run == self.requester.run) else {
            let received = format!("a response to request {number} of run {run:016x}");
            let case = mismatch(received, "requester, run and number of a request");
            tallies.count(SenderRule::AnswerEcho, Err(case));
            return None;
        };
        if !sent.is_good {
            let received = format!("a response to request {number}, whose check sum is wrong");
            let case = mismatch(received, "none to what is no request");
            tallies.count(SenderRule::AnswerOnce, Err(case));
            return None;
        }
        if !tallies.check(SenderRule::AnswerOnce, sent.answered.is_none(), || {
            let received = format!("another response to request {number}");
            mismatch(received, "one to each")
        }) {
            return None;
        }
        sent.answered = Some(at);
        let (received, asked) = (request.requested, sent.request.requested);
        tallies.check(SenderRule::AnswerEcho, received == asked, || {
            let received = format!("t1 = {received} ns of request {number}");
            mismatch(received, format!("{asked} ns, as it asked"))
        });
        Some(*sent)
    }
}

fn check_stamps(
    sent: &SentRequest,
    stamps: &ResponseStamps,
    frames: Option<&FrameClock>,
) -> Result<(), Mismatch> {
    let number = sent.request.number;
    let (dwell, round_trip) = (stamps.left - stamps.received, stamps.at - sent.at);
    ensure(!dwell.is_negative(), || {
        let received = format!("t3 {} before t2 (request {number})", -dwell);
        mismatch(received, "a response to leave after its request came")
    })?;
    ensure(dwell <= round_trip + round_trip / 100, || {
        mismatch(
            format!("{dwell} from t2 to t3 (request {number})"),
            format!("{round_trip} at most, which it was under way and there"),
        )
    })?;
    let apart = frames.map_or(Span::ZERO, |frames| stamps.left - frames.time(stamps.at));
    ensure(apart.abs() <= MAX_CLOCK_DIFFERENCE, || {
        mismatch(
            format!("t3 {apart} off the clock of the frames (request {number})"),
            "nanoseconds since the ideal start of cycle 0",
        )
    })
}
