//! The frame on the wire: `docs/WIRE.md` describes every byte.
//!
//! A frame is written in two steps. The cycle thread encodes the body, everything up to the axes, into a
//! buffer it owns ([`encode_body`]). The publishing thread appends the send stamp and the check sum at
//! the last moment ([`KeySeal::seal`]).
//!
//! A frame of axes with a presentation delay has a version of its own, with one field more.

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_curve::profile::Kinematics;
use postcard::ser_flavors::Flavor;
use serde::{Deserialize, Serialize};

use crate::keys::NodeName;
use crate::present_after::PresentAfter;
use crate::rejection::Rejection;

/// Version of all messages, and of frames that are not presented later.
pub const FORMAT_VERSION: u8 = 1;

/// Version of the frames of axes with a presentation delay. Others stay at [`FORMAT_VERSION`], byte for byte, so that
/// a network without presentation needs no new nodes.
pub const PRESENTED_VERSION: u8 = 2;

/// Greatest number of axes in one frame.
pub const MAX_AXES: usize = 128;

/// Header of a frame: everything besides its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameHeader {
    /// Sender: the CRC-32 of its node name.
    pub sender: u32,
    /// Run of the sender, drawn at random when it starts: another epoch is another run.
    pub epoch: u64,
    /// The manual's cycle index.
    pub index: CycleIndex,
    /// The sender's cycle count since its epoch; `index` is its low 16 bits.
    pub count: u64,
    /// The sender's nominal cycle time.
    pub cycle_time: CycleTime,
    /// Time after the ideal start of its cycle at which the axes are shown; none where their newest values are moved
    /// to now.
    pub present_after: Option<PresentAfter>,
    /// Departure of the message after the ideal start of its cycle, in the sender's own clock; none from
    /// senders that do not state it.
    pub send_stamp: Option<Span>,
}

/// Values of an axis in a frame that a receiver uses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisSample {
    /// Set values.
    pub set: Kinematics,
    /// State word.
    pub state_word: StateWord,
    /// Error code, 0 without one.
    pub error_code: u32,
}

impl From<&NcToPlcAxis> for AxisSample {
    fn from(axis: &NcToPlcAxis) -> Self {
        Self {
            set: Kinematics {
                position: axis.set_position,
                velocity: axis.set_velocity,
                acceleration: axis.set_acceleration,
            },
            state_word: axis.state_word,
            error_code: axis.error_code,
        }
    }
}

/// Accepted frame, reduced to the axes that its receiver follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    /// Header: everything besides its axes.
    pub header: FrameHeader,
    /// Followed axes, in the order of the request: all of the same cycle. None where the frame has no
    /// such axis, or none with plausible values.
    pub axes: &'a [Option<AxisSample>],
}

/// Returns the id of a node in a frame: the CRC-32 of its name.
#[must_use]
pub fn sender_id(name: &NodeName) -> u32 {
    crc32fast::hash(name.as_str().as_bytes())
}

/// Returns the size of a buffer, in bytes, for the body of every frame with this number of axes.
#[must_use]
pub const fn body_capacity(axes: usize) -> usize {
    MAX_PREFIX_LEN + axes * MAX_AXIS_LEN
}

/// Returns the size of a buffer, in bytes, for every sealed frame with this number of axes.
#[must_use]
pub const fn frame_capacity(axes: usize) -> usize {
    body_capacity(axes) + MAX_STAMP_LEN + CHECKSUM_LEN
}

/// Writes a frame up to its axes into `out` and returns its length. The header's send stamp is left to
/// [`KeySeal::seal`]. Does not allocate.
///
/// # Errors
/// [`EncodeError`]; a buffer of [`body_capacity`] bytes is never too small.
pub fn encode_body(
    header: &FrameHeader,
    axes: &[NcToPlcAxis],
    out: &mut [u8],
) -> Result<usize, EncodeError> {
    if axes.len() > MAX_AXES {
        let received = axes.len();
        return Err(EncodeError::TooManyAxes { received });
    }
    let too_small = EncodeError::BufferTooSmall {
        received: out.len(),
        expected: body_capacity(axes.len()),
    };
    let mut used = write(&Prefix::of(header), out).ok_or(too_small)?;
    if let Some(delay) = header.present_after {
        used += write(&delay.nanos(), &mut out[used..]).ok_or(too_small)?;
    }
    // Loses nothing: the axes are counted above.
    used += write(&(axes.len() as u32), &mut out[used..]).ok_or(too_small)?;
    for axis in axes {
        used += write(axis, &mut out[used..]).ok_or(too_small)?;
    }
    Ok(used)
}

/// Error of a body that cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    /// More axes than a frame holds.
    #[error("received {received} axes, expected at most {MAX_AXES}")]
    TooManyAxes {
        /// Number of axes given.
        received: usize,
    },
    /// The buffer does not hold the body.
    #[error("received a buffer of {received} bytes, expected {expected}")]
    BufferTooSmall {
        /// Length of the buffer.
        received: usize,
        /// Length that is sufficient.
        expected: usize,
    },
}

/// Ties frames to the key they travel under: the check sum covers the key too, so that a frame
/// that strays to another key is refused there.
///
/// Made once per key; the key is not summed again for each frame.
#[derive(Clone, Debug)]
pub struct KeySeal {
    after_key: crc32fast::Hasher,
}

impl KeySeal {
    /// Makes the seal of the frames under `key`.
    #[must_use]
    pub fn new(key: &str) -> Self {
        let mut after_key = crc32fast::Hasher::new();
        after_key.update(key.as_bytes());
        Self { after_key }
    }

    /// Replaces the content of `out` by the complete frame. Does not allocate where `out` has room for
    /// [`frame_capacity`] bytes.
    ///
    /// `send_stamp` is how long after the ideal start of its cycle the frame leaves, in the
    /// sender's own clock.
    pub fn seal(&self, body: &[u8], send_stamp: Option<Span>, out: &mut Vec<u8>) {
        let mut stamp = [0; MAX_STAMP_LEN];
        let stamp_len = write(&send_stamp, &mut stamp).expect("the buffer holds the longest stamp");
        out.clear();
        out.extend_from_slice(body);
        out.extend_from_slice(&stamp[..stamp_len]);
        self.append_checksum(out);
    }

    pub(crate) fn append_checksum(&self, out: &mut Vec<u8>) {
        let checksum = self.checksum(out);
        out.extend_from_slice(&checksum.to_le_bytes());
    }

    /// Checks a frame and passes its axes on one after the other, before it returns the header. If the
    /// frame is refused in the end, the axes passed to `each_axis` are void. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`]: another version, then a wrong check sum, then content that is no frame.
    pub fn open(
        &self,
        payload: &[u8],
        each_axis: impl FnMut(&NcToPlcAxis),
    ) -> Result<FrameHeader, Rejection> {
        let walk = |content: &[u8]| read_content(content, |_| {}).map(drop);
        let content = self.verify_version(payload, PRESENTED_VERSION, walk)?;
        read_content(content, each_axis)
    }

    /// Returns the fields of a message whose version and check sum are right. `walk` goes through them, to
    /// classify the damage of one whose check sum is wrong.
    pub(crate) fn verify<'a>(
        &self,
        payload: &'a [u8],
        walk: impl FnOnce(&[u8]) -> Result<(), Rejection>,
    ) -> Result<&'a [u8], Rejection> {
        self.verify_version(payload, FORMAT_VERSION, walk)
    }

    /// Verifies a message of any version up to the latest one of its kind.
    pub(crate) fn verify_version<'a>(
        &self,
        payload: &'a [u8],
        latest: u8,
        walk: impl FnOnce(&[u8]) -> Result<(), Rejection>,
    ) -> Result<&'a [u8], Rejection> {
        match payload.first() {
            None => return Err(Rejection::Truncated),
            Some(version) if (FORMAT_VERSION..=latest).contains(version) => {}
            Some(_) => return Err(Rejection::WrongVersion),
        }
        let (content, checksum) = payload
            .split_last_chunk::<CHECKSUM_LEN>()
            .ok_or(Rejection::Truncated)?;
        if u32::from_le_bytes(*checksum) != self.checksum(content) {
            return Err(diagnose_damage(walk(content)));
        }
        Ok(content)
    }

    fn checksum(&self, content: &[u8]) -> u32 {
        let mut hasher = self.after_key.clone();
        hasher.update(content);
        hasher.finalize()
    }
}

/// Seals by [`KeySeal::seal`] for a key that is used once.
pub fn seal(key: &str, body: &[u8], send_stamp: Option<Span>, out: &mut Vec<u8>) {
    KeySeal::new(key).seal(body, send_stamp, out);
}

/// Opens by [`KeySeal::open`] for a key that is used once.
///
/// # Errors
/// As [`KeySeal::open`].
pub fn decode(
    key: &str,
    payload: &[u8],
    each_axis: impl FnMut(&NcToPlcAxis),
) -> Result<FrameHeader, Rejection> {
    KeySeal::new(key).open(payload, each_axis)
}

const CHECKSUM_LEN: usize = 4;
/// Option tag and a 64-bit varint.
const MAX_STAMP_LEN: usize = 1 + 10;
/// Version, sender, epoch, index, count, cycle time, presentation delay, number of axes.
const MAX_PREFIX_LEN: usize = 1 + 5 + 10 + 3 + 10 + 5 + 5 + 2;
/// Nine 64-bit reals, twelve 32-bit varints, four 16-bit ones.
const MAX_AXIS_LEN: usize = 9 * 8 + 12 * 5 + 4 * 3;

/// The fields that every version begins with, as they lie on the wire.
#[derive(Serialize, Deserialize)]
struct Prefix {
    version: u8,
    sender: u32,
    epoch: u64,
    index: CycleIndex,
    count: u64,
    cycle_time_ns: u32,
}

impl Prefix {
    fn of(header: &FrameHeader) -> Self {
        Self {
            version: match header.present_after {
                None => FORMAT_VERSION,
                Some(_) => PRESENTED_VERSION,
            },
            sender: header.sender,
            epoch: header.epoch,
            index: header.index,
            count: header.count,
            // Loses nothing: a cycle takes at most 100 ms.
            cycle_time_ns: header.cycle_time.span().as_nanos() as u32,
        }
    }

    fn header(
        &self,
        present_after_ns: u32,
        send_stamp: Option<Span>,
    ) -> Result<FrameHeader, Rejection> {
        Ok(FrameHeader {
            sender: self.sender,
            epoch: self.epoch,
            index: self.index,
            count: self.count,
            cycle_time: cycle_time(self.cycle_time_ns)?,
            present_after: present_after(present_after_ns)?,
            send_stamp,
        })
    }
}

pub(crate) fn cycle_time(nanos: u32) -> Result<CycleTime, Rejection> {
    CycleTime::new(Span::from_nanos(nanos.into())).map_err(|_| Rejection::CycleTimeOutOfRange)
}

fn present_after(nanos: u32) -> Result<Option<PresentAfter>, Rejection> {
    match PresentAfter::new(Span::from_nanos(nanos.into())) {
        // A frame that is not presented later may say so.
        None if nanos > 0 => Err(Rejection::PresentAfterOutOfRange),
        delay => Ok(delay),
    }
}

fn read_content(
    content: &[u8],
    mut each_axis: impl FnMut(&NcToPlcAxis),
) -> Result<FrameHeader, Rejection> {
    let (prefix, rest) = read::<Prefix>(content)?;
    let (present_after_ns, rest) = match prefix.version {
        PRESENTED_VERSION => read::<u32>(rest)?,
        _ => (0, rest),
    };
    let (axes, mut rest) = read::<u32>(rest)?;
    if axes > MAX_AXES as u32 {
        return Err(Rejection::Malformed);
    }
    for _ in 0..axes {
        let axis;
        (axis, rest) = read::<NcToPlcAxis>(rest)?;
        each_axis(&axis);
    }
    prefix.header(present_after_ns, read_send_stamp(rest)?)
}

/// Reads the last field of every frame before its check sum.
pub(crate) fn read_send_stamp(bytes: &[u8]) -> Result<Option<Span>, Rejection> {
    let (send_stamp, rest) = read::<Option<Span>>(bytes)?;
    if rest.is_empty() {
        Ok(send_stamp)
    } else {
        Err(Rejection::TrailingBytes)
    }
}

/// Returns the reason for a frame whose check sum is wrong. Nothing in it is trusted, but one that ends
/// in the middle of its fields was truncated, which points at another cause than a flipped bit does.
#[cold]
fn diagnose_damage(walked: Result<(), Rejection>) -> Rejection {
    match walked {
        Err(Rejection::Truncated) => Rejection::Truncated,
        _ => Rejection::WrongChecksum,
    }
}

pub(crate) fn write<T: Serialize>(value: &T, out: &mut [u8]) -> Option<usize> {
    let room = out.len();
    let left = postcard::serialize_with_flavor(value, Remaining(out)).ok()?;
    Some(room - left)
}

/// Remaining bytes that postcard writes to. Its own slice copies each integer by a call of `memcpy`,
/// which waits for the bytes that were only just written.
struct Remaining<'a>(&'a mut [u8]);

impl Flavor for Remaining<'_> {
    /// Number of bytes left.
    type Output = usize;

    #[inline]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        let place = self.0.split_off_first_mut();
        *place.ok_or(postcard::Error::SerializeBufferFull)? = byte;
        Ok(())
    }

    #[inline]
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        match <&[u8; 8]>::try_from(bytes) {
            Ok(real) => {
                let place = self.0.split_off_mut(..real.len());
                let place = place.ok_or(postcard::Error::SerializeBufferFull)?;
                place.copy_from_slice(real);
                Ok(())
            }
            Err(_) => bytes.iter().try_for_each(|byte| self.try_push(*byte)),
        }
    }

    fn finalize(self) -> postcard::Result<usize> {
        Ok(self.0.len())
    }
}

pub(crate) fn read<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<(T, &'a [u8]), Rejection> {
    postcard::take_from_bytes(bytes).map_err(|error| match error {
        postcard::Error::DeserializeUnexpectedEnd => Rejection::Truncated,
        _ => Rejection::Malformed,
    })
}
