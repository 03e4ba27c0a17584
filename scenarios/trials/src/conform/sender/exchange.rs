//! Checks of a node's responses to time requests.

use std::collections::BTreeMap;

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_node::exchange::{ReceivedRequest, TimeResponsesHeader};
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, TimeRequest};
use coaxle_os::Machine;

use super::rules::{ANSWER_ECHO, ANSWER_FRAME, ANSWER_ONCE, ANSWER_STAMPS, ANSWER_TIME};
use crate::conform::rule::{RuleFinding, RuleOutcome, Tally};

/// Margin beyond two cycles within which a response may come: the machines are busy.
const RESPONSE_MARGIN: Span = Span::from_millis(100);
/// Share of responses that may be missing or late.
const MISSING: f64 = 0.2;
/// Share of responses that may differ in run from the newest frame: a restarting node responds before it sends, or after.
const BETWEEN_RUNS: f64 = 0.1;
/// Greatest difference between the clocks of responses and frames. A comparison in one moment is no more accurate.
const MAX_CLOCK_DIFFERENCE: Span = Span::from_secs(1);

/// The clock of the node, as the newest frame shows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameClock {
    pub(super) epoch: u64,
    pub(super) cycle_time: CycleTime,
    /// Departure, or due time, since the ideal start of the node's cycle 0 …
    pub(super) left: Span,
    /// … and arrival.
    pub(super) at: Instant<Machine>,
}

/// Requests sent, and their responses.
#[derive(Debug)]
pub(super) struct ExchangeChecks {
    seal: KeySeal,
    node: NodeName,
    requester: u32,
    run: u64,
    requests: BTreeMap<u32, SentRequest>,
    frame: Tally,
    echo: Tally,
    once: Tally,
    stamps: Tally,
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

impl ExchangeChecks {
    pub(super) fn new(node: &NodeName, requester: u32, run: u64) -> Self {
        Self {
            seal: KeySeal::new(&node.channel_key(Channel::TimeResponses)),
            node: node.clone(),
            requester,
            run,
            requests: BTreeMap::new(),
            frame: Tally::default(),
            echo: Tally::default(),
            once: Tally::default(),
            stamps: Tally::default(),
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
    pub(super) fn take(&mut self, at: Instant<Machine>, bytes: &[u8], frames: Option<&FrameClock>) {
        let mut replies = Vec::new();
        let opened = self
            .seal
            .open_all_time_responses(bytes, |reply| replies.push(*reply));
        let (header, left) = match opened {
            Ok(opened) => opened,
            Err(reason) => {
                self.frame.bad(reason.to_string(), "a frame of responses");
                return;
            }
        };
        if self.judge_header(&header, frames) {
            self.cycle = header.cycle_time.span();
            for reply in replies {
                self.judge(at, &reply, left, frames);
            }
        }
    }

    /// Findings at `end`, when no more messages come.
    pub(super) fn findings(&self, end: Instant<Machine>) -> Vec<RuleFinding> {
        let none = "no request was answered: nobody can follow the node without lag";
        vec![
            RuleFinding::new(
                &ANSWER_FRAME,
                self.frame.outcome_but_for(BETWEEN_RUNS, "frames", none),
            ),
            RuleFinding::new(&ANSWER_TIME, self.time(end, none)),
            RuleFinding::new(&ANSWER_ECHO, self.echo.outcome("responses", none)),
            RuleFinding::new(&ANSWER_ONCE, self.once.outcome("responses", none)),
            RuleFinding::new(
                &ANSWER_STAMPS,
                self.stamps.outcome_but_for(BETWEEN_RUNS, "responses", none),
            ),
        ]
    }

    fn judge_header(&mut self, header: &TimeResponsesHeader, frames: Option<&FrameClock>) -> bool {
        let words = |what: &str, received: String, expected: String| {
            (format!("the {what} {received}"), expected)
        };
        let sender = sender_id(&self.node);
        let wrong = if header.sender != sender {
            Some(words(
                "sender",
                header.sender.to_string(),
                sender.to_string(),
            ))
        } else {
            frames.and_then(|frames| {
                let time = |time: CycleTime| time.span().to_string();
                let hex = |epoch: u64| format!("{epoch:016x}");
                if header.epoch != frames.epoch {
                    Some(words("epoch", hex(header.epoch), hex(frames.epoch)))
                } else if header.cycle_time != frames.cycle_time {
                    let (own, due) = (time(header.cycle_time), time(frames.cycle_time));
                    Some(words("cycle time", own, due))
                } else {
                    None
                }
            })
        };
        let is_good = wrong.is_none();
        self.frame.check(is_good, || {
            let (received, expected) = wrong.unwrap_or_default();
            (received, format!("{expected}, as in its frames"))
        });
        is_good
    }

    fn judge(
        &mut self,
        at: Instant<Machine>,
        reply: &ReceivedRequest,
        left: Span,
        frames: Option<&FrameClock>,
    ) {
        let request = &reply.request;
        // A response to another requester.
        if request.requester != self.requester {
            return;
        }
        let number = request.number;
        let Some(sent) = self
            .requests
            .get_mut(&number)
            .filter(|_| request.run == self.run)
        else {
            let received = format!("a response to request {number} of run {:016x}", request.run);
            self.echo
                .bad(received, "requester, run and number of a request");
            return;
        };
        if !sent.is_good {
            let received = format!("a response to request {number}, whose check sum is wrong");
            self.once.bad(received, "none to what is no request");
            return;
        }
        let is_first = sent.answered.is_none();
        self.once.check(is_first, || {
            let received = format!("another response to request {number}");
            (received, "one to each".to_owned())
        });
        if !is_first {
            return;
        }
        sent.answered = Some(at);
        let sent = *sent;
        self.echo
            .check(request.requested == sent.request.requested, || {
                (
                    format!("t1 = {} ns of request {number}", request.requested),
                    format!("{} ns, as it asked", sent.request.requested),
                )
            });
        self.judge_stamps(at, &sent, (reply.received, left), frames);
    }

    /// `received` is t2, `left` t3; t1 and t4 are of the clock of this tool.
    fn judge_stamps(
        &mut self,
        at: Instant<Machine>,
        sent: &SentRequest,
        (received, left): (Span, Span),
        frames: Option<&FrameClock>,
    ) {
        let number = sent.request.number;
        let (dwell, round_trip) = (left - received, at - sent.at);
        let expected_at = frames.map(|frames| frames.left + (at - frames.at));
        let wrong = if dwell.is_negative() {
            let received = format!("t3 {} before t2", -dwell);
            Some((
                received,
                "a response to leave after its request came".to_owned(),
            ))
        } else if dwell > round_trip + round_trip / 100 {
            let expected = format!("{round_trip} at most, which it was under way and there");
            Some((format!("{dwell} from t2 to t3"), expected))
        } else {
            let apart = expected_at.map(|due| left - due);
            let apart = apart.filter(|apart| apart.abs() > MAX_CLOCK_DIFFERENCE);
            apart.map(|apart| {
                let received = format!("t3 {apart} off the clock of the frames");
                (
                    received,
                    "nanoseconds since the ideal start of cycle 0".to_owned(),
                )
            })
        };
        self.stamps.check(wrong.is_none(), || {
            let (received, expected) = wrong.unwrap_or_default();
            (format!("{received} (request {number})"), expected)
        });
    }

    fn time(&self, end: Instant<Machine>, none: &str) -> RuleOutcome {
        let limit = self.cycle * 2 + RESPONSE_MARGIN;
        let all = self.requests.values().filter(|sent| sent.is_good);
        // A response to the most recent requests may still come.
        let due = all.filter(|sent| end - sent.at > limit * 3);
        let mut tally = Tally::default();
        let mut some = false;
        for sent in due {
            let took = sent.answered.map(|at| at - sent.at);
            some |= took.is_some();
            tally.check(took.is_some_and(|took| took <= limit), || {
                let received = match took {
                    Some(took) => format!("a response after {took}"),
                    None => "no response".to_owned(),
                };
                let expected = format!("one in the next cycle, {limit} at most");
                (
                    format!("{received} (request {})", sent.request.number),
                    expected,
                )
            });
        }
        match some {
            true => tally.outcome_but_for(MISSING, "requests", none),
            false => RuleOutcome::not_seen(none),
        }
    }
}
