//! Messages as bytes, as docs/WIRE.md describes them: frames of axes, time requests and responses.
//!
//! A message goes as the payload of any transport: Zenoh, or a datagram of one's own. Its check sum covers the key that it travels
//! under in a Coaxle network, `coaxle/<node>/axes` for frames.

use core::ffi::c_char;

use ::coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, Span};
use coaxle_wire::frame::{
    FrameHeader, KeySeal, MAX_AXES, body_capacity, encode_body, frame_capacity, sender_id,
};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{PresentAfter, Rejection};

use crate::axis_struct::coaxle_axis;
use crate::failure::{COAXLE_CAPACITY, COAXLE_REJECTED, COAXLE_TEXT, Failure};
use crate::handle::{HandleHead, call, free, handle, make, plain};
use crate::memory::{
    fitting, growing, read, readable_array, text, writable, writable_array, write,
};
use crate::phase::cycle_time;

/// Greatest number of axes in a frame.
pub const COAXLE_MOST_AXES: usize = 128;
/// A buffer of this size, in bytes, holds every message.
pub const COAXLE_MOST_BYTES: usize = 20000;

const _: () = assert!(COAXLE_MOST_AXES == MAX_AXES);
const _: () = assert!(frame_capacity(MAX_AXES) <= COAXLE_MOST_BYTES);

/// The messages under one key: checks and makes their check sums.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_key {
    head: HandleHead,
    pub(crate) seal: KeySeal,
    /// Room for a frame up to its axes, and for a message.
    body: Box<[u8]>,
    pub(crate) message: Vec<u8>,
}

handle!(coaxle_key, b"wire key");

/// Everything of a frame besides its axes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_frame_header {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// Sender: `coaxle_sender_id` of its node name.
    pub sender: u32,
    /// Run of the sender, drawn at random when it starts.
    pub epoch: u64,
    /// Cycle count of the sender since then.
    pub count: u64,
    /// Nominal cycle time of the sender, ns.
    pub cycle_time_ns: i64,
    /// Time after the ideal start of its cycle at which the axes are shown, ns; 0: their newest values are moved to now.
    pub present_after_ns: i64,
    /// Departure after the ideal start of its cycle, ns of the sender's clock.
    pub send_stamp_ns: i64,
    /// Other than 0 if the departure is stated.
    pub has_send_stamp: u32,
    /// 0.
    pub reserved: u32,
}

growing! {
    coaxle_frame_header, 56;
}

/// Passes out the id of a node by its name: 1 to 64 letters, digits, `-`, `_` or `.`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_sender_id(name: *const c_char, id: *mut u32) -> i32 {
    // SAFETY: as for this function.
    plain(|| unsafe {
        let name = node_name(text(name, "name")?)?;
        *writable(id, "id")? = sender_id(&name);
        Ok(())
    })
}

/// Makes what the messages under a key need.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_key_new(key: *const c_char, out: *mut *mut coaxle_key) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            Ok(coaxle_key {
                head: HandleHead::new::<coaxle_key>(),
                seal: KeySeal::new(text(key, "key")?),
                body: vec![0; body_capacity(MAX_AXES)].into(),
                message: Vec::with_capacity(COAXLE_MOST_BYTES),
            })
        })
    }
}

/// Frees it; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_key_free(key: *mut coaxle_key) {
    // SAFETY: as for this function.
    unsafe { free(key) }
}

/// Writes a frame of `number` axes into `bytes`, which has room for `capacity`, and passes out its `length`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_frame_encode(
    key: *mut coaxle_key,
    header: *const coaxle_frame_header,
    axes: *const coaxle_axis,
    number: usize,
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let given = read(header)?;
            let stamp = Span::from_nanos(given.send_stamp_ns);
            let stamp = (given.has_send_stamp != 0).then_some(stamp);
            let axes = readable_array(axes, number, "axes")?;
            if axes.len() > MAX_AXES {
                return Err(Failure::range("number", axes.len(), "at most 128 axes"));
            }
            let mut taken = [NcToPlcAxis::default(); MAX_AXES];
            for (place, axis) in taken.iter_mut().zip(axes) {
                *place = axis.checked()?;
            }
            let header = frame_header(&given)?;
            let written = encode_body(&header, &taken[..axes.len()], &mut key.body)
                .map_err(|wrong| Failure::new(COAXLE_CAPACITY, wrong))?;
            (key.seal).seal(&key.body[..written], stamp, &mut key.message);
            pass_out(&key.message, bytes, capacity, length)
        })
    }
}

/// Reads a frame: its header, and up to `capacity` of its axes; passes out how many it has in `number`, which may be more.
///
/// # Errors
/// `COAXLE_REJECTED` and the reason. The axes are void then.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_frame_decode(
    key: *mut coaxle_key,
    bytes: *const u8,
    length: usize,
    header: *mut coaxle_frame_header,
    axes: *mut coaxle_axis,
    capacity: usize,
    number: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let bytes = readable_array(bytes, length, "bytes")?;
            let axes = writable_array(axes, capacity, "axes")?;
            let number = writable(number, "number")?;
            *number = 0;
            let mut found = 0;
            let opened = key.seal.open(bytes, |axis| {
                if let Some(place) = axes.get_mut(found) {
                    *place = coaxle_axis::of(axis);
                }
                found += 1;
            });
            let read = opened.map_err(rejected)?;
            write(header, &coaxle_frame_header::of(&read))?;
            *number = found;
            Ok(())
        })
    }
}

/// Seals a body and copies the message to the caller.
///
/// # Safety
/// As for [`pass_out`].
pub(crate) unsafe fn sealed(
    key: &mut coaxle_key,
    body: &[u8],
    stamp: Option<Span>,
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> Result<(), Failure> {
    (key.seal).seal(body, stamp, &mut key.message);
    // SAFETY: as for this function.
    unsafe { pass_out(&key.message, bytes, capacity, length) }
}

/// Copies a message to the caller.
///
/// # Safety
/// As for `writable_array`.
pub(crate) unsafe fn pass_out(
    message: &[u8],
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> Result<(), Failure> {
    // SAFETY: as for this function.
    let (length, bytes) = unsafe {
        (
            writable(length, "length")?,
            writable_array(bytes, capacity, "bytes")?,
        )
    };
    *length = message.len();
    fitting(bytes, message.len())?.copy_from_slice(message);
    Ok(())
}

fn node_name(name: &str) -> Result<NodeName, Failure> {
    NodeName::new(name).map_err(|wrong| Failure::new(COAXLE_TEXT, wrong))
}

pub(crate) fn rejected(reason: Rejection) -> Failure {
    Failure::new(COAXLE_REJECTED, reason)
}

/// Reads a presentation delay; none for 0.
pub(crate) fn present_after(nanos: i64) -> Result<Option<PresentAfter>, Failure> {
    let delay = PresentAfter::new(Span::from_nanos(nanos));
    if delay.is_none() && nanos != 0 {
        let expected = "0 to 4294967295";
        return Err(Failure::range("present_after_ns", nanos, expected));
    }
    Ok(delay)
}

fn frame_header(given: &coaxle_frame_header) -> Result<FrameHeader, Failure> {
    Ok(FrameHeader {
        sender: given.sender,
        epoch: given.epoch,
        index: CycleIndex::of_count(given.count),
        count: given.count,
        cycle_time: cycle_time(given.cycle_time_ns)?,
        present_after: present_after(given.present_after_ns)?,
        send_stamp: None,
    })
}

impl coaxle_frame_header {
    fn of(header: &FrameHeader) -> Self {
        let after = header.present_after.map_or(0, |delay| delay.nanos().into());
        Self {
            struct_size: 0,
            sender: header.sender,
            epoch: header.epoch,
            count: header.count,
            cycle_time_ns: header.cycle_time.span().as_nanos(),
            present_after_ns: after,
            send_stamp_ns: header.send_stamp.map_or(0, Span::as_nanos),
            has_send_stamp: header.send_stamp.is_some().into(),
            reserved: 0,
        }
    }
}
