//! Time requests and responses as bytes.

use coaxle_clock::{Instant, Span};
use coaxle_wire::TimeRequest;
use coaxle_wire::exchange::{
    MAX_TIME_RESPONSES, ReceivedRequest, TIME_REQUEST_CAPACITY, TIME_RESPONSES_CAPACITY,
    TimeResponsesHeader, encode_time_request, encode_time_responses,
};

use crate::failure::Failure;
use crate::far_clock::coaxle_time_response;
use crate::handle::call;
use crate::memory::{read, readable_array, writable, writable_array};
use crate::phase::cycle_time;
use crate::wire::{COAXLE_MOST_BYTES, coaxle_frame_header, coaxle_key, rejected, sealed};

const _: () = assert!(TIME_RESPONSES_CAPACITY + 15 <= COAXLE_MOST_BYTES);

/// A request for the time of a clock. It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_time_request {
    /// Requester: `coaxle_sender_id` of its node name.
    pub requester: u32,
    /// Number of the request in its run.
    pub number: u32,
    /// Run of the requester.
    pub run: u64,
    /// Departure of the request, ns of the requester's clock.
    pub requested_ns: i64,
    /// Arrival of the request, ns of the responder's clock since the ideal start of its cycle 0; the responder fills it in.
    pub received_ns: i64,
}

/// Writes the request number `number` of the run `run`, which leaves `send_stamp_ns` after the ideal start of the cycle that began at
/// `ideal_start_ns` of the own clock. The key is that of the responder: `coaxle/<node>/time-requests`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_time_request_encode(
    key: *mut coaxle_key,
    requester: u32,
    run: u64,
    number: u32,
    ideal_start_ns: i64,
    send_stamp_ns: i64,
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let mut body = [0; TIME_REQUEST_CAPACITY];
            let start = Instant::from_nanos(ideal_start_ns);
            let written = encode_time_request(requester, run, number, start, &mut body);
            let stamp = Some(Span::from_nanos(send_stamp_ns));
            sealed(key, &body[..written], stamp, bytes, capacity, length)
        })
    }
}

/// Reads a request. Its arrival is left to the caller.
///
/// # Errors
/// `COAXLE_REJECTED` and the reason.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_time_request_decode(
    key: *mut coaxle_key,
    bytes: *const u8,
    length: usize,
    out: *mut coaxle_time_request,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let bytes = readable_array(bytes, length, "bytes")?;
            let request = key.seal.open_time_request(bytes).map_err(rejected)?;
            *writable(out, "out")? = coaxle_time_request::of(&request);
            Ok(())
        })
    }
}

/// Writes the responses to `number` requests, 16 at most. `header` is that of a frame of the same cycle, its departure that of the
/// responses. The key is `coaxle/<node>/time-responses`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_time_responses_encode(
    key: *mut coaxle_key,
    header: *const coaxle_frame_header,
    requests: *const coaxle_time_request,
    number: usize,
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let given = read(header)?;
            if number > MAX_TIME_RESPONSES {
                return Err(Failure::range("number", number, "at most 16 requests"));
            }
            let mut replies = [ReceivedRequest::default(); MAX_TIME_RESPONSES];
            for (place, request) in replies
                .iter_mut()
                .zip(readable_array(requests, number, "requests")?)
            {
                *place = request.received();
            }
            let header = TimeResponsesHeader {
                sender: given.sender,
                epoch: given.epoch,
                count: given.count,
                cycle_time: cycle_time(given.cycle_time_ns)?,
            };
            let mut body = [0; TIME_RESPONSES_CAPACITY];
            let written = encode_time_responses(&header, &replies[..number], &mut body);
            let stamp = Some(Span::from_nanos(given.send_stamp_ns));
            sealed(key, &body[..written], stamp, bytes, capacity, length)
        })
    }
}

/// Reads the responses of `sender` to requests of `requester`: up to `capacity`, and passes out how many there are in `number`, which
/// may be more.
///
/// # Errors
/// `COAXLE_REJECTED` and the reason.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_time_responses_decode(
    key: *mut coaxle_key,
    bytes: *const u8,
    length: usize,
    sender: u32,
    requester: u32,
    responses: *mut coaxle_time_response,
    capacity: usize,
    number: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let bytes = readable_array(bytes, length, "bytes")?;
            let places = writable_array(responses, capacity, "responses")?;
            let number = writable(number, "number")?;
            *number = 0;
            let mut found = 0;
            let opened = key
                .seal
                .open_time_responses(bytes, sender, requester, |response| {
                    if let Some(place) = places.get_mut(found) {
                        *place = coaxle_time_response::of(response);
                    }
                    found += 1;
                });
            opened.map_err(rejected)?;
            *number = found;
            Ok(())
        })
    }
}

impl coaxle_time_request {
    const fn of(request: &TimeRequest) -> Self {
        Self {
            requester: request.requester,
            number: request.number,
            run: request.run,
            requested_ns: request.requested,
            received_ns: 0,
        }
    }

    const fn received(&self) -> ReceivedRequest {
        ReceivedRequest {
            request: TimeRequest {
                requester: self.requester,
                run: self.run,
                number: self.number,
                requested: self.requested_ns,
            },
            received: Span::from_nanos(self.received_ns),
        }
    }
}
