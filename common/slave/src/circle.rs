//! Circles: axes that follow each other, so that each finally follows itself.

/// The NC error code of axes whose couplings form a circle.
pub const CIRCLE_CODE: u32 = 0x816f;

/// The circle that an axis and its masters form across nodes. An axis cannot detect it itself: it
/// is reported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CircleState {
    /// No known circle.
    #[default]
    None,
    /// A possible circle, with at least one axis not coupled now: no command may close it.
    Open,
    /// A closed circle, with every axis coupled: each set value returns as the next one.
    Closed,
}
