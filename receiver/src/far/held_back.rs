//! Frames that an injected delay holds back over many cycles, and the ones to give up of too many.
//!
//! Real processes store a delayed frame at once, with its later arrival. The first of such frames is
//! the image of the next cycle, and then the first of the rest: if always the first was given up, no
//! cycle would have an image.

use coaxle_clock::{Instant, Local};

/// A frame that waits for its cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct WaitingFrame {
    /// Arrival.
    pub(super) at: Instant<Local>,
    /// Start of the next cycle when it was stored.
    pub(super) due: Instant<Local>,
    /// The sender's cycle count.
    pub(super) count: u64,
}

/// The place of the frame to give up among those that are held back when the next cycle begins at `due`; none if
/// none is.
pub(super) fn spare(
    frames: impl Iterator<Item = (usize, WaitingFrame)>,
    due: Instant<Local>,
) -> Option<usize> {
    // Cycles have begun since it was stored, and it still belongs to one after the next.
    let held_back = frames.filter(|(_, frame)| frame.due < due && due < frame.at);
    // Odd counts first, then every second of the rest, and so on: frames evenly spaced in time remain.
    let spacing = |frame: &WaitingFrame| (frame.count.trailing_zeros(), frame.at);
    let spare = held_back.min_by_key(|(_, frame)| spacing(frame));
    spare.map(|(place, _)| place)
}
