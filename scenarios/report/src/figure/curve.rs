//! Curves of a panel.

use super::data::Data;
use crate::plotting::NEUTRAL;

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name, shown beside its values.
    pub name: String,
    /// Group: its curves share an entry of the legend and are hidden together.
    pub group: String,
    /// `#rrggbb`.
    pub colour: String,
    /// Style of the line.
    pub look: Look,
    /// Start of the settled part: earlier values, while it locked in, do not decide the initial range of the figure.
    pub settled_from: f64,
    /// True if it does not decide the range: a limit far away must not flatten the curves compared with it.
    pub is_aside: bool,
    /// Points or extremes of the curve.
    pub data: Data,
    /// Spread of each point, from its low to its high end; empty: none.
    pub spread: Vec<(f64, f64)>,
    /// Label of each point; empty: its value.
    pub labels: Vec<String>,
}

/// Style of a curve's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A line.
    Solid,
    /// A line of dots.
    Dotted,
    /// A line of dashes.
    Dashed,
    /// A value holds until the next one.
    Steps,
    /// Points, joined by a line.
    Dots,
    /// Points without a line.
    Marks,
}

impl Look {
    /// Name in a page.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::Dotted => "dotted",
            Self::Dashed => "dashed",
            Self::Steps => "steps",
            Self::Dots => "dots",
            Self::Marks => "marks",
        }
    }
}

impl Curve {
    /// Creates a solid line that is a group of its own.
    #[must_use]
    pub fn new(name: &str, colour: &str, data: Data) -> Self {
        Self {
            name: name.to_owned(),
            group: name.to_owned(),
            colour: colour.to_owned(),
            look: Look::Solid,
            // Every value decides the range unless the caller knows of a lock-in.
            settled_from: f64::NEG_INFINITY,
            is_aside: false,
            data,
            spread: Vec::new(),
            labels: Vec::new(),
        }
    }

    /// Creates a level from one place to another.
    #[must_use]
    pub fn level(name: &str, value: f64, from: f64, to: f64) -> Self {
        Self {
            look: Look::Dashed,
            ..Self::new(
                name,
                NEUTRAL,
                Data::Points(vec![(from, value), (to, value)]),
            )
        }
    }

    /// Returns the values that decide a range.
    pub(super) fn settled(&self) -> Vec<f64> {
        let mut values = self.data.values_from(self.settled_from);
        // Whiskers are part of the picture: a range of the medians alone would cut them off.
        values.extend(self.spread.iter().flat_map(|(low, high)| [*low, *high]));
        values
    }
}
