//! Time requests and responses on the wire: `docs/WIRE.md` describes every byte.
//!
//! Both are written like the frames of axes: the body in the cycle, the send stamp and the check sum by
//! the publishing thread at the last moment ([`KeySeal::seal`]). So the send stamp of a request is its
//! `t1`, and that of a frame of responses their `t3`.

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use serde::{Deserialize, Serialize};

use crate::frame::{FORMAT_VERSION, KeySeal, cycle_time, read, read_send_stamp, write};
use crate::rejection::Rejection;

/// Greatest number of responses in one frame.
pub const MAX_TIME_RESPONSES: usize = 16;

/// A buffer of this many bytes holds the body of every request.
pub const TIME_REQUEST_CAPACITY: usize = 1 + 5 + 10 + 5 + 10;

/// A buffer of this many bytes holds the body of every frame of responses.
pub const TIME_RESPONSES_CAPACITY: usize =
    1 + 5 + 10 + 10 + 5 + 1 + MAX_TIME_RESPONSES * (5 + 10 + 5 + 10 + 10);

/// Request for the time of another node's clock. The responder returns all of it unchanged in its
/// response.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimeRequest {
    /// Requester: the CRC-32 of its node name.
    pub requester: u32,
    /// The requester's run.
    pub run: u64,
    /// Sequence number of the request in that run.
    pub number: u32,
    /// Departure of the request, ns of the requester's own clock: of no meaning to other nodes.
    pub requested: i64,
}

/// Request with its response, without the departure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReceivedRequest {
    /// Request responded to.
    pub request: TimeRequest,
    /// Arrival of the request, in the responder's clock since the ideal start of its cycle 0.
    pub received: Span,
}

/// Responder and its cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeResponsesHeader {
    /// CRC-32 of its node name.
    pub sender: u32,
    /// Run of the responder.
    pub epoch: u64,
    /// Cycle count of the responder.
    pub count: u64,
    /// Nominal cycle time of the responder.
    pub cycle_time: CycleTime,
}

/// Writes a request up to its send stamp into `out` and returns its length. It leaves in the cycle that
/// ideally began at `ideal_start`.
pub fn encode_time_request(
    requester: u32,
    run: u64,
    number: u32,
    ideal_start: Instant<Local>,
    out: &mut [u8; TIME_REQUEST_CAPACITY],
) -> usize {
    let body = TimeRequestBody {
        version: FORMAT_VERSION,
        requester,
        run,
        number,
        ideal_start: ideal_start.as_nanos(),
    };
    write(&body, out).expect("the buffer holds the longest request")
}

/// Writes a frame of responses up to its send stamp into `out` and returns its length. Of more than
/// [`MAX_TIME_RESPONSES`] the first are taken.
pub fn encode_time_responses(
    header: &TimeResponsesHeader,
    replies: &[ReceivedRequest],
    out: &mut [u8; TIME_RESPONSES_CAPACITY],
) -> usize {
    const ROOM: &str = "the buffer holds the longest responses";
    let replies = &replies[..replies.len().min(MAX_TIME_RESPONSES)];
    let prefix = TimeResponsesPrefix {
        version: FORMAT_VERSION,
        sender: header.sender,
        epoch: header.epoch,
        count: header.count,
        // A cycle takes at most 100 ms.
        cycle_time_ns: header.cycle_time.span().as_nanos() as u32,
        responses: replies.len() as u32,
    };
    let mut used = write(&prefix, out).expect(ROOM);
    for reply in replies {
        let body = ReplyBody {
            requester: reply.request.requester,
            run: reply.request.run,
            number: reply.request.number,
            requested: reply.request.requested,
            received: reply.received,
        };
        used += write(&body, &mut out[used..]).expect(ROOM);
    }
    used
}

impl KeySeal {
    /// Checks and reads a request. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies.
    pub fn open_time_request(&self, payload: &[u8]) -> Result<TimeRequest, Rejection> {
        let content = self.verify(payload, |content| read_time_request(content).map(drop))?;
        read_time_request(content)
    }

    /// Checks a frame of responses of `sender` and passes those for `requester` to `each`. Does not
    /// allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies. Nothing is handed out then.
    pub fn open_time_responses(
        &self,
        payload: &[u8],
        sender: u32,
        requester: u32,
        mut each: impl FnMut(&TimeResponse),
    ) -> Result<(), Rejection> {
        let responses = self.verified_time_responses(payload)?;
        if responses.header.sender != sender {
            return Err(Rejection::ForeignSender);
        }
        let (epoch, responded) = (responses.header.epoch, responses.responded);
        responses.each(|reply| {
            if reply.request.requester == requester {
                each(&TimeResponse {
                    run: reply.request.run,
                    number: reply.request.number,
                    requested: Instant::from_nanos(reply.request.requested),
                    epoch,
                    received: reply.received,
                    responded,
                });
            }
        })
    }

    /// Checks a frame of responses of any responder and passes all of them on, for any requester. Returns
    /// its header and its departure, in the responder's clock since the ideal start of its cycle 0. Does
    /// not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies. Nothing is handed out then.
    pub fn open_all_time_responses(
        &self,
        payload: &[u8],
        each: impl FnMut(&ReceivedRequest),
    ) -> Result<(TimeResponsesHeader, Span), Rejection> {
        let responses = self.verified_time_responses(payload)?;
        let (header, responded) = (responses.header, responses.responded);
        responses.each(each)?;
        Ok((header, responded))
    }

    fn verified_time_responses<'a>(
        &self,
        payload: &'a [u8],
    ) -> Result<TimeResponses<'a>, Rejection> {
        let content = self.verify(payload, |content| TimeResponses::read(content).map(drop))?;
        TimeResponses::read(content)
    }
}

#[derive(Serialize, Deserialize)]
struct TimeRequestBody {
    version: u8,
    requester: u32,
    run: u64,
    number: u32,
    ideal_start: i64,
}

#[derive(Serialize, Deserialize)]
struct TimeResponsesPrefix {
    version: u8,
    sender: u32,
    epoch: u64,
    count: u64,
    cycle_time_ns: u32,
    responses: u32,
}

#[derive(Serialize, Deserialize)]
struct ReplyBody {
    requester: u32,
    run: u64,
    number: u32,
    requested: i64,
    received: Span,
}

fn read_time_request(content: &[u8]) -> Result<TimeRequest, Rejection> {
    let (body, rest) = read::<TimeRequestBody>(content)?;
    let left = read_send_stamp(rest)?.ok_or(Rejection::Malformed)?;
    Ok(TimeRequest {
        requester: body.requester,
        run: body.run,
        number: body.number,
        requested: body.ideal_start.saturating_add(left.as_nanos()),
    })
}

/// Frame of responses, read to its end.
struct TimeResponses<'a> {
    header: TimeResponsesHeader,
    responded: Span,
    count: u32,
    /// Bytes that begin with the replies.
    replies: &'a [u8],
}

impl<'a> TimeResponses<'a> {
    fn read(content: &'a [u8]) -> Result<Self, Rejection> {
        let (prefix, replies) = read::<TimeResponsesPrefix>(content)?;
        if prefix.responses > MAX_TIME_RESPONSES as u32 {
            return Err(Rejection::Malformed);
        }
        let mut rest = replies;
        for _ in 0..prefix.responses {
            (_, rest) = read::<ReplyBody>(rest)?;
        }
        let left = read_send_stamp(rest)?.ok_or(Rejection::Malformed)?;
        let cycle_time = cycle_time(prefix.cycle_time_ns)?;
        Ok(Self {
            header: TimeResponsesHeader {
                sender: prefix.sender,
                epoch: prefix.epoch,
                count: prefix.count,
                cycle_time,
            },
            responded: cycle_time.span() * prefix.count as i64 + left,
            count: prefix.responses,
            replies,
        })
    }

    fn each(self, mut each: impl FnMut(&ReceivedRequest)) -> Result<(), Rejection> {
        let mut rest = self.replies;
        for _ in 0..self.count {
            let reply;
            (reply, rest) = read::<ReplyBody>(rest)?;
            each(&ReceivedRequest {
                request: TimeRequest {
                    requester: reply.requester,
                    run: reply.run,
                    number: reply.number,
                    requested: reply.requested,
                },
                received: reply.received,
            });
        }
        Ok(())
    }
}
