//! Listening to a node over the network, and sending it time requests.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use anyhow::bail;
use coaxle_clock::{Instant, Span};
use coaxle_host::network::transport::{Declared, Delivery, Publisher, Transport, Urgency};
use coaxle_node::exchange::{TIME_REQUEST_CAPACITY, encode_time_request};
use coaxle_node::frame::KeySeal;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, TimeRequest};
use coaxle_os::{Interrupt, Machine, machine};

use super::judge::{Requester, SenderJudge};

/// Most messages that wait to be judged: some seconds at the shortest cycle time. A message without room is dropped, and
/// counted as missing.
const MOST: usize = 1 << 16;
/// Startup time allowed for a node to appear.
const STARTUP_TIMEOUT: Span = Span::from_secs(5);
/// Period of time requests, as receivers have it.
const REQUEST_PERIOD: Span = Span::from_millis(100);
/// Period of requests with a wrong check sum, in requests.
const BAD_REQUEST_PERIOD: u32 = 5;
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// A received message.
enum NodeMessage {
    Frame(Instant<Machine>, Vec<u8>, Option<Delivery>),
    Responses(Instant<Machine>, Vec<u8>, Option<Delivery>),
    Status(Instant<Machine>, Vec<u8>),
    Token(String, bool),
}

/// Listener to all messages of a node.
pub(super) struct NodeListener {
    heard: Receiver<NodeMessage>,
    time_requests: TimeRequests,
    _declared: Vec<Declared>,
}

/// Sends time requests.
struct TimeRequests {
    publisher: Box<dyn Publisher>,
    seal: KeySeal,
    requester: Requester,
    next: u32,
    due: Instant<Machine>,
}

/// End of listening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ListeningEnd {
    /// The time was up.
    InTime,
    /// No message came.
    Silent,
    /// Interrupted by the user.
    Interrupted,
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
        let (queue, heard) = sync_channel(MOST);
        let queue = Arc::new(queue);
        let requests = node.channel_key(Channel::TimeRequests);
        let time_requests = TimeRequests {
            publisher: transport.publisher(&requests, Urgency::RealTime)?,
            seal: KeySeal::new(&requests),
            requester,
            next: 0,
            due: machine::now(),
        };
        Ok(Self {
            heard,
            time_requests,
            _declared: declare(transport, node, channel, &queue)?,
        })
    }

    /// Hands all messages to the judge, for this time since the first frame.
    ///
    /// # Errors
    /// The network is gone.
    pub(super) fn listen(
        &mut self,
        judge: &mut SenderJudge,
        listen_for: Span,
        interrupt: &Interrupt,
    ) -> anyhow::Result<ListeningEnd> {
        let mut end = machine::now() + STARTUP_TIMEOUT;
        let mut has_begun = false;
        while machine::now() < end {
            if interrupt.is_received() {
                return Ok(ListeningEnd::Interrupted);
            }
            match self.heard.recv_timeout(POLL_INTERVAL) {
                Ok(heard) => judge.take(heard),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => bail!("the network is gone"),
            }
            if !has_begun && judge.frames() > 0 {
                has_begun = true;
                end = machine::now() + listen_for;
            }
            if has_begun {
                self.time_requests.send_request(judge);
            }
        }
        Ok(if has_begun {
            ListeningEnd::InTime
        } else {
            ListeningEnd::Silent
        })
    }
}

impl SenderJudge {
    fn take(&mut self, heard: NodeMessage) {
        match heard {
            NodeMessage::Frame(at, bytes, delivery) => self.frame(at, &bytes, delivery),
            NodeMessage::Responses(at, bytes, delivery) => self.responses(at, &bytes, delivery),
            NodeMessage::Status(at, bytes) => self.status(at, &bytes),
            NodeMessage::Token(key, is_there) => self.token(&key, is_there),
        }
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

fn declare(
    transport: &dyn Transport,
    node: &NodeName,
    channel: Channel,
    queue: &Arc<SyncSender<NodeMessage>>,
) -> anyhow::Result<Vec<Declared>> {
    // Messages that find no room are dropped.
    let (frames, responses, status) = (Arc::clone(queue), Arc::clone(queue), Arc::clone(queue));
    let on_frame = move |at, bytes: &[u8], delivery| {
        let _ = frames.try_send(NodeMessage::Frame(at, bytes.to_vec(), delivery));
    };
    let on_responses = move |at, bytes: &[u8], delivery| {
        let _ = responses.try_send(NodeMessage::Responses(at, bytes.to_vec(), delivery));
    };
    let on_status = move |at, bytes: &[u8]| {
        let _ = status.try_send(NodeMessage::Status(at, bytes.to_vec()));
    };
    let mut declared = Vec::new();
    for key in [node.alive_key(), node.runs_key()] {
        let tokens = Arc::clone(queue);
        let on_change = move |key: &str, is_there| {
            let _ = tokens.try_send(NodeMessage::Token(key.to_owned(), is_there));
        };
        declared.push(transport.watch(&key, Box::new(on_change))?);
    }
    let responses = node.channel_key(Channel::TimeResponses);
    declared.push(transport.observe(&responses, Box::new(on_responses))?);
    declared.push(transport.subscribe(&node.status_key(), Box::new(on_status))?);
    declared.push(transport.observe(&node.channel_key(channel), Box::new(on_frame))?);
    Ok(declared)
}
