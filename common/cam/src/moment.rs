//! The master's way in a cycle, and where on it something happens.

/// The master's way in this cycle, u of its axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) from: f64,
    pub(super) to: f64,
}

/// Where on the way a change takes effect: exactly there, whatever the cycle time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Position of the master axis, u.
    pub(super) master: f64,
    /// Which way the plate was passing to another cycle or out of its range, if it was.
    pub(super) edge: Option<Direction>,
}

/// Which way, in positions of the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Forwards,
    Backwards,
}

impl Moment {
    pub(super) const fn at(master: f64) -> Self {
        Self { master, edge: None }
    }
}
