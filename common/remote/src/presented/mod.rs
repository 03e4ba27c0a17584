//! A far axis shown later: a point between two received frames, where the newest one moved to now would be a guess.
//!
//! A generated master is shown by everybody a while after its generation. By then the frames around the instant shown
//! have arrived, and the motion between two of them is a quintic through the position, velocity and acceleration of
//! both. It is exact while the jerk does not change between them. A change by Δj within a gap of T moves the position
//! by at most Δj·T³/768, the velocity by Δj·T²/211 and the acceleration by Δj·T/16 (the deviation of Hermite's
//! interpolation from a cubic spline with its knot in the middle). At 100 000 mm/s³ and 1 ms that is 1.3e-7 mm. Lost
//! frames are spanned: over ten of them it is 1.7e-4 mm.
//!
//! Not in the manual, which extrapolates.

mod history;
mod needed_delay;
mod presentation;

pub use history::FrameHistory;
pub use needed_delay::NeededDelay;
pub use presentation::{AxisPresentation, FrameDelay, PresentedNow, ShownChange};

use coaxle_clock::Seconds;

/// Presentation of an axis in a cycle: its frames, and the time by which they are shown after their generation.
#[derive(Clone, Copy, Debug)]
pub struct ShownLater<'a> {
    /// The newest frames.
    pub frames: &'a FrameHistory,
    /// Time between the generation of a frame and the instant at which its values are shown.
    pub by: Seconds,
}
