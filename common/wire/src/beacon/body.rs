//! Body of a beacon, as the node writes it: everything before the departures.

use coaxle_clock::{CycleTime, Instant, Local, Span};
use serde::{Deserialize, Serialize};

use super::{
    BeaconBefore, BeaconRequest, BeaconResponse, COMMON_TIME_VERSION, CommonStamp, Stamps,
};
use crate::channel::Channel;
use crate::frame::{FORMAT_VERSION, cycle_time, read, write};
use crate::rejection::Rejection;

/// A buffer of this many bytes holds the body of every beacon.
pub const BEACON_CAPACITY: usize =
    1 + 5 + 10 + 10 + 5 + (5 + 10 + 5 + 10 + 1 + 16) + 10 + COMMON_CAPACITY;

/// Length of the longest reading of a common time.
pub(super) const COMMON_CAPACITY: usize = 1 + 10 + 10 + 5 + 10;

/// Responder and its cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BeaconResponseHeader {
    /// CRC-32 of its node name.
    pub sender: u32,
    /// Run of the responder.
    pub epoch: u64,
    /// Cycle count of the responder.
    pub count: u64,
    /// Nominal cycle time of the responder.
    pub cycle_time: CycleTime,
}

/// Part of a beacon that the sending thread has to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BeaconLabel {
    /// The requester: of a response, who it is for.
    pub requester: u32,
    /// The requester's run.
    pub run: u64,
    /// The number of the request.
    pub number: u32,
}

impl BeaconLabel {
    /// Reads the label of a body or of a whole beacon; none if the bytes are not a beacon.
    #[must_use]
    pub fn of(channel: Channel, body: &[u8]) -> Option<Self> {
        match channel {
            Channel::BeaconRequests => {
                let (body, _) = read::<RequestBody>(body).ok()?;
                Some(Self {
                    requester: body.requester,
                    run: body.run,
                    number: body.number,
                })
            }
            Channel::BeaconResponses => {
                let (body, _) = read::<ResponseBody>(body).ok()?;
                Some(Self {
                    requester: body.requester,
                    run: body.run,
                    number: body.number,
                })
            }
            _ => None,
        }
    }
}

/// Writes the beacon of a node that follows another one into `out` and returns its length. It leaves in
/// the cycle that ideally began at `ideal_start`. `takes_common_time`: its beacons have readings of one, and those of the
/// responder are asked for.
pub fn encode_beacon_request(
    label: &BeaconLabel,
    takes_common_time: bool,
    ideal_start: Instant<Local>,
    out: &mut [u8; BEACON_CAPACITY],
) -> usize {
    let body = RequestBody {
        version: version(takes_common_time),
        requester: label.requester,
        run: label.run,
        number: label.number,
        ideal_start: ideal_start.as_nanos(),
    };
    write(&body, out).expect("the buffer holds the longest beacon")
}

/// Writes the response to a beacon that arrived `received` after the ideal start of the own cycle 0.
pub fn encode_beacon_response(
    header: &BeaconResponseHeader,
    request: &BeaconRequest,
    received: Span,
    out: &mut [u8; BEACON_CAPACITY],
) -> usize {
    let body = ResponseBody {
        version: version(request.takes_common_time),
        sender: header.sender,
        epoch: header.epoch,
        count: header.count,
        // A cycle takes at most 100 ms.
        cycle_time_ns: header.cycle_time.span().as_nanos() as u32,
        requester: request.requester,
        run: request.run,
        number: request.number,
        requested: request.requested,
        requester_stamps: request.stamps.code(),
        request_before: request.before,
        received,
    };
    let length = write(&body, out).expect("the buffer holds the longest beacon");
    match request.takes_common_time {
        true => length + write(&request.common, &mut out[length..]).expect("it has room for that"),
        false => length,
    }
}

const fn version(takes_common_time: bool) -> u8 {
    match takes_common_time {
        true => COMMON_TIME_VERSION,
        false => FORMAT_VERSION,
    }
}

#[derive(Serialize, Deserialize)]
struct RequestBody {
    version: u8,
    requester: u32,
    run: u64,
    number: u32,
    ideal_start: i64,
}

#[derive(Serialize, Deserialize)]
struct ResponseBody {
    version: u8,
    sender: u32,
    epoch: u64,
    count: u64,
    cycle_time_ns: u32,
    requester: u32,
    run: u64,
    number: u32,
    requested: i64,
    requester_stamps: u8,
    request_before: Option<BeaconBefore>,
    received: Span,
}

/// Departures as written: spans since an ideal start.
pub(super) struct DepartureSpans {
    pub(super) left: Span,
    pub(super) stamps: Stamps,
    pub(super) before: Option<(u32, Span)>,
    /// A reading of the common time, with the span to its instant.
    pub(super) common: Option<CommonStamp>,
}

impl DepartureSpans {
    fn before_since(&self, ideal_start_ns: i64) -> Option<BeaconBefore> {
        self.before.map(|(number, left)| BeaconBefore {
            number,
            left_ns: ideal_start_ns.saturating_add(left.as_nanos()),
        })
    }

    fn common_since(&self, ideal_start_ns: i64) -> Option<CommonStamp> {
        self.common.map(|common| CommonStamp {
            at_ns: ideal_start_ns.saturating_add(common.at_ns),
            ..common
        })
    }
}

/// Reads the request, and the bytes after its body.
pub(super) fn read_request(
    content: &[u8],
    departed: impl FnOnce(&[u8], bool) -> Result<DepartureSpans, Rejection>,
) -> Result<BeaconRequest, Rejection> {
    let (body, rest) = read::<RequestBody>(content)?;
    let takes_common_time = body.version == COMMON_TIME_VERSION;
    let departed = departed(rest, takes_common_time)?;
    Ok(BeaconRequest {
        requester: body.requester,
        run: body.run,
        number: body.number,
        requested: (body.ideal_start).saturating_add(departed.left.as_nanos()),
        stamps: departed.stamps,
        before: departed.before_since(body.ideal_start),
        takes_common_time,
        common: departed.common_since(body.ideal_start),
    })
}

/// Reads the response with the id of its responder.
pub(super) fn read_response(
    content: &[u8],
    departed: impl FnOnce(&[u8], bool) -> Result<DepartureSpans, Rejection>,
) -> Result<(u32, BeaconResponse), Rejection> {
    let (body, rest) = read::<ResponseBody>(content)?;
    let takes_common_time = body.version == COMMON_TIME_VERSION;
    let (request_common, rest) = match takes_common_time {
        true => read::<Option<CommonStamp>>(rest)?,
        false => (None, rest),
    };
    let departed = departed(rest, takes_common_time)?;
    let stamps = Stamps::of_code(body.requester_stamps).ok_or(Rejection::Malformed)?;
    let cycle_ns = cycle_time(body.cycle_time_ns)?.span().as_nanos();
    let ideal_start = cycle_ns.saturating_mul(i64::try_from(body.count).unwrap_or(i64::MAX));
    let response = BeaconResponse {
        epoch: body.epoch,
        request: BeaconRequest {
            requester: body.requester,
            run: body.run,
            number: body.number,
            requested: body.requested,
            stamps,
            before: body.request_before,
            takes_common_time,
            common: request_common,
        },
        received: body.received,
        responded: Span::from_nanos(ideal_start.saturating_add(departed.left.as_nanos())),
        stamps: departed.stamps,
        before: departed.before_since(ideal_start),
        common: departed.common_since(ideal_start),
    };
    Ok((body.sender, response))
}
