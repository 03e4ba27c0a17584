//! Faults of a plan.

use core::fmt;

/// Kind of a fault of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum PlanFault {
    /// Bytes that are no message with plans.
    Unreadable,
    /// No piece.
    NoPieces,
    /// More pieces than allowed.
    TooManyPieces,
    /// Limits that no motion can keep.
    InvalidLimits,
    /// A number that is none, or out of range.
    OutOfRange,
    /// A piece without duration.
    NoDuration,
    /// A piece that begins before the end of the one before it.
    OutOfOrder,
    /// A piece that begins after the end of the one before it.
    Gap,
    /// A step of the position between two pieces.
    PositionJump,
    /// A step of the velocity.
    VelocityJump,
    /// A step of the acceleration.
    AccelerationJump,
    /// A velocity beyond the limits of the axis.
    VelocityLimit,
    /// An acceleration beyond them.
    AccelerationLimit,
    /// A jerk beyond them.
    JerkLimit,
    /// A promise beyond the last piece, or before the first.
    PromiseBeyondPieces,
    /// A promise that ends sooner than an earlier one.
    PromiseMovedBack,
    /// A motion other than the one that was promised.
    PromiseBroken,
    /// Plan of another run of the node.
    OtherRun,
    /// Plan of which a piece was lost on its way into the node.
    Incomplete,
    /// A sample of the axis beside the plan.
    Contradicted,
}

impl PlanFault {
    /// Every fault, in the order of their numbers in recordings: new ones come last.
    pub const ALL: [Self; 20] = [
        Self::Unreadable,
        Self::NoPieces,
        Self::TooManyPieces,
        Self::InvalidLimits,
        Self::OutOfRange,
        Self::NoDuration,
        Self::OutOfOrder,
        Self::Gap,
        Self::PositionJump,
        Self::VelocityJump,
        Self::AccelerationJump,
        Self::VelocityLimit,
        Self::AccelerationLimit,
        Self::JerkLimit,
        Self::PromiseBeyondPieces,
        Self::PromiseMovedBack,
        Self::PromiseBroken,
        Self::OtherRun,
        Self::Incomplete,
        Self::Contradicted,
    ];

    /// Returns its name in status and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unreadable => "unreadable",
            Self::NoPieces => "no-pieces",
            Self::TooManyPieces => "too-many-pieces",
            Self::InvalidLimits => "invalid-limits",
            Self::OutOfRange => "out-of-range",
            Self::NoDuration => "no-duration",
            Self::OutOfOrder => "out-of-order",
            Self::Gap => "gap",
            Self::PositionJump => "position-jump",
            Self::VelocityJump => "velocity-jump",
            Self::AccelerationJump => "acceleration-jump",
            Self::VelocityLimit => "velocity-limit",
            Self::AccelerationLimit => "acceleration-limit",
            Self::JerkLimit => "jerk-limit",
            Self::PromiseBeyondPieces => "promise-beyond-pieces",
            Self::PromiseMovedBack => "promise-moved-back",
            Self::PromiseBroken => "promise-broken",
            Self::OtherRun => "other-run",
            Self::Incomplete => "incomplete",
            Self::Contradicted => "contradicted",
        }
    }

    /// Returns the part of a plan that it concerns, and what was expected there.
    const fn place(self) -> (&'static str, &'static str) {
        match self {
            Self::Unreadable => ("message", "the fields of docs/WIRE.md"),
            Self::NoPieces | Self::TooManyPieces => ("pieces", "1 to"),
            Self::InvalidLimits => ("limits", "finite numbers above 0"),
            Self::OutOfRange => ("values", "numbers from -1e15 to 1e15"),
            Self::NoDuration => ("duration, s", "above"),
            Self::OutOfOrder | Self::Gap => ("start, s", "the end of the piece before:"),
            Self::PositionJump => ("position", "that of the piece before at its end:"),
            Self::VelocityJump => ("velocity", "that of the piece before at its end:"),
            Self::AccelerationJump => ("acceleration", "that of the piece before at its end:"),
            Self::VelocityLimit => ("velocity", "at most"),
            Self::AccelerationLimit => ("acceleration", "at most"),
            Self::JerkLimit => ("jerk", "at most"),
            Self::PromiseBeyondPieces => ("promised until, s", "within the pieces, which end at"),
            Self::PromiseMovedBack => ("promised until, s", "not before the earlier promise,"),
            Self::PromiseBroken => ("position", "the promised one,"),
            Self::OtherRun => ("run", "the run that is followed"),
            Self::Incomplete => ("pieces", "all of the plan:"),
            Self::Contradicted => ("position", "that of the sample,"),
        }
    }
}

/// A plan that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvalidPlan {
    /// Kind of the fault.
    pub fault: PlanFault,
    /// Number of the faulty piece, from 1; none for the plan as a whole.
    pub piece: Option<usize>,
    /// Value received.
    pub received: f64,
    /// Value expected, or its limit; none where it is no number.
    pub expected: Option<f64>,
}

impl InvalidPlan {
    /// Creates the fault of a plan as a whole.
    #[must_use]
    pub const fn of_plan(fault: PlanFault, received: f64, expected: f64) -> Self {
        Self {
            fault,
            piece: None,
            received,
            expected: Some(expected),
        }
    }
}

impl fmt::Display for InvalidPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (field, expectation) = self.fault.place();
        if let Some(piece) = self.piece {
            write!(f, "piece {piece}, ")?;
        }
        write!(
            f,
            "{field}: received {}, expected {expectation}",
            self.received
        )?;
        match self.expected {
            Some(expected) => write!(f, " {expected}"),
            None => Ok(()),
        }
    }
}

impl core::error::Error for InvalidPlan {}
