//! Listening to a node over the network, and sending it time requests.

use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_host::network::transport::{Publisher, Transport, Urgency};
use coaxle_node::exchange::{TIME_REQUEST_CAPACITY, encode_time_request};
use coaxle_node::frame::KeySeal;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, TimeRequest};
use coaxle_os::{Interrupt, Machine, machine};

use super::judge::{Requester, SenderJudge};
use crate::conform::queue::{MessageQueue, Source};

/// Most messages that wait to be judged: some seconds at the shortest cycle time.
const MOST: usize = 1 << 16;
/// Startup time allowed for a node to appear.
const STARTUP_TIMEOUT: Span = Span::from_secs(5);
/// Period of time requests, as receivers have it.
const REQUEST_PERIOD: Span = Span::from_millis(100);
/// Period of requests with a wrong check sum, in requests.
const BAD_REQUEST_PERIOD: u32 = 5;
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Listener to all messages of a node.
pub(super) struct NodeListener {
    received: MessageQueue<SenderJudge>,
    time_requests: TimeRequests,
}

/// Sends time requests.
struct TimeRequests {
    publisher: Box<dyn Publisher>,
    seal: KeySeal,
    requester: Requester,
    next: u32,
    due: Instant<Machine>,
}

impl NodeListener {
    /// # Errors
    /// The transport refuses.
    pub(super) fn new(
        transport: &dyn Transport,
        node: &NodeName,
        channel: Channel,
        requester: Requester,
    ) -> anyhow::Result<Self> {
        let requests = node.channel_key(Channel::TimeRequests);
        let time_requests = TimeRequests {
            publisher: transport.publisher(&requests, Urgency::RealTime)?,
            seal: KeySeal::new(&requests),
            requester,
            next: 0,
            due: machine::now(),
        };
        Ok(Self {
            received: MessageQueue::new(transport, MOST, sources(node, channel))?,
            time_requests,
        })
    }

    /// Hands all messages to the judge, for this time since the first frame. Returns false if interrupted.
    ///
    /// # Errors
    /// The network is gone.
    pub(super) fn listen(
        &mut self,
        judge: &mut SenderJudge,
        listen_for: Span,
        interrupt: &Interrupt,
    ) -> anyhow::Result<bool> {
        let mut end = machine::now() + STARTUP_TIMEOUT;
        let mut has_begun = false;
        while machine::now() < end {
            if interrupt.is_received() {
                return Ok(false);
            }
            self.received.hand_over_next(judge, POLL_INTERVAL)?;
            if !has_begun && judge.frames() > 0 {
                has_begun = true;
                end = machine::now() + listen_for;
            }
            if has_begun {
                self.time_requests.send_request(judge);
            }
        }
        Ok(true)
    }
}

impl TimeRequests {
    /// Sends a request if one is due.
    fn send_request(&mut self, judge: &mut SenderJudge) {
        let now = machine::now();
        if now < self.due {
            return;
        }
        self.due = now + REQUEST_PERIOD;
        let number = self.next;
        self.next += 1;
        let is_good = number % BAD_REQUEST_PERIOD != BAD_REQUEST_PERIOD - 1;
        let ideal_start = machine::local(now);
        let mut body = [0; TIME_REQUEST_CAPACITY];
        let Requester { id, run } = self.requester;
        let length = encode_time_request(id, run, number, ideal_start, &mut body);
        let mut sealed = Vec::new();
        let left = machine::now();
        self.seal
            .seal(&body[..length], Some(left - now), &mut sealed);
        if let (false, Some(last)) = (is_good, sealed.last_mut()) {
            *last ^= 1;
        }
        let request = TimeRequest {
            requester: id,
            run,
            number,
            requested: left.as_nanos(),
        };
        judge.request_sent(left, request, is_good);
        if let Err(error) = self.publisher.publish(sealed) {
            tracing::debug!(%error, "the transport refused a time request");
        }
    }
}

fn sources(node: &NodeName, channel: Channel) -> [Source<SenderJudge>; 5] {
    [
        Source::Tokens(node.alive_key(), SenderJudge::token),
        Source::Tokens(node.runs_key(), SenderJudge::token),
        Source::Messages(
            node.channel_key(Channel::TimeResponses),
            SenderJudge::responses,
        ),
        Source::Messages(node.status_key(), |judge, at, bytes, _| {
            judge.status(at, bytes);
        }),
        Source::Messages(node.channel_key(channel), SenderJudge::frame),
    ]
}
