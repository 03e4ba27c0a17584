//! Curves of a panel.

use super::data::Data;
use crate::plotting::NEUTRAL;

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name beside its values.
    pub name: String,
    /// Curves of a group are one in the legend, and hidden together.
    pub group: String,
    /// `#rrggbb`.
    pub colour: String,
    /// How it is drawn.
    pub look: Look,
    /// What was before, while it locked in, does not decide the range that the figure begins with.
    pub settled_from: f64,
    /// Whether it decides no range: a limit far away must not flatten what is compared with it.
    pub is_aside: bool,
    /// What it goes through.
    pub data: Data,
    /// The spread of each point, from its low to its high end; empty: there is none.
    pub spread: Vec<(f64, f64)>,
    /// The words of each point; empty: it is its value.
    pub labels: Vec<String>,
}

/// How a curve is drawn.
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
    /// A solid line that is a group of its own.
    #[must_use]
    pub fn new(name: &str, colour: &str, data: Data) -> Self {
        Self {
            name: name.to_owned(),
            group: name.to_owned(),
            colour: colour.to_owned(),
            look: Look::Solid,
            settled_from: f64::NEG_INFINITY,
            is_aside: false,
            data,
            spread: Vec::new(),
            labels: Vec::new(),
        }
    }

    /// A level from one place to another.
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

    /// The values that decide a range.
    pub(super) fn settled(&self) -> Vec<f64> {
        let mut values = self.data.values_from(self.settled_from);
        values.extend(self.spread.iter().flat_map(|(low, high)| [*low, *high]));
        values
    }
}
