//! The master's path in a cycle, and the place on it of an event.

/// The master's path in this cycle, u of its axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct MasterStep {
    pub(super) from: f64,
    pub(super) to: f64,
}

/// Place on the path at which a change takes effect: exact for any cycle time.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChangeMoment {
    /// Position of the master axis, u.
    pub(super) master: f64,
    /// Direction in which the plate was passing to another cycle or out of its range, if it was.
    pub(super) edge: Option<Direction>,
}

/// Direction, in positions of the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Forwards,
    Backwards,
}

impl ChangeMoment {
    pub(super) const fn at(master: f64) -> Self {
        Self { master, edge: None }
    }
}
