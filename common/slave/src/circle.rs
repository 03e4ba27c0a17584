//! Circles: axes that follow each other, so that each follows itself in the end.

/// The NC's code of axes whose couplings form a circle.
pub const CIRCLE_CODE: u32 = 0x816f;

/// The circle that an axis and its masters form over other nodes. An axis cannot see it by itself: it is reported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CircleState {
    /// No circle is known.
    #[default]
    None,
    /// The masters can follow the axis, and at least one axis between does not do so now: nothing may close the circle.
    Open,
    /// Every axis of the circle is coupled: each set value comes back as the next one.
    Closed,
}
