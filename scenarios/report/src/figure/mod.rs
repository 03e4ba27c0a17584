//! A figure, however it is drawn: [panels](Panel) of [curves](Curve) one above the other over one axis, or [maps](Maps) of
//! coloured cells. [`page`](crate::page) draws it in a browser, [`print`](mod@crate::print) as SVG and PDF.
//!
//! Curves hold values; a [`Scale`] maps them to places for every drawing.

mod curve;
mod data;
mod map;
mod range;
mod scale;
mod thin;

pub use curve::{Curve, Look};
pub use data::Data;
pub(crate) use data::Room;
pub use map::{Map, Maps};
pub(crate) use map::{bright, ink};
pub use range::around;
pub use scale::Scale;
pub use thin::thinned;

use self::range::{extent, usual};

/// A figure with its words.
#[derive(Clone, Debug, Default)]
pub struct Figure {
    /// Name within the page, and of files.
    pub id: String,
    /// The subject, in a line.
    pub title: String,
    /// Caption: the feature to look at.
    pub caption: String,
    /// Horizontal axis.
    pub across: Across,
    /// Panels, from the top.
    pub panels: Vec<Panel>,
    /// True if the panels have the same scale.
    pub is_on_one_scale: bool,
}

/// Horizontal axis of a figure.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Across {
    /// The quantity.
    pub name: String,
    /// Unit; empty: none.
    pub unit: String,
    /// Scale of its values.
    pub scale: Scale,
    /// True if there is room at both ends, for points that lie there.
    pub is_padded: bool,
}

/// Curves over one vertical axis.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Title above the panel; empty: none.
    pub title: String,
    /// Quantity of the curves; empty if the figure's title names it.
    pub quantity: String,
    /// Unit of the values; empty: none.
    pub unit: String,
    /// Pixels in a browser.
    pub height: usize,
    /// Scale of the values.
    pub scale: Scale,
    /// Initial range of values; none: the usual range of the curves.
    pub range: Option<(f64, f64)>,
    /// Places to mark.
    pub marks: Vec<f64>,
    /// Curves, in the order of drawing.
    pub curves: Vec<Curve>,
}

impl Across {
    /// Returns the axis of the time of a run.
    pub(crate) fn run() -> Self {
        Self::of("time", "s")
    }

    /// Returns the axis of the time from a beat.
    pub(crate) fn beat() -> Self {
        Self::of("time from the beat", "ms")
    }

    /// Returns the axis of a quantity in a unit, which may be empty.
    #[must_use]
    pub fn of(name: &str, unit: &str) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            ..Self::default()
        }
    }

    /// Returns the quantity with its unit.
    #[must_use]
    pub fn words(&self) -> String {
        with_unit(&self.name, &self.unit)
    }
}

impl Panel {
    /// Returns the quantity with its unit.
    #[must_use]
    pub fn words(&self) -> String {
        with_unit(&self.quantity, &self.unit)
    }
}

fn with_unit(quantity: &str, unit: &str) -> String {
    match (quantity, unit) {
        ("", only) | (only, "") => only.to_owned(),
        (quantity, unit) => format!("{quantity} ({unit})"),
    }
}

impl Figure {
    /// Reports whether there is nothing to draw.
    pub(crate) fn is_empty(&self) -> bool {
        self.curves().all(|curve| curve.data.is_empty())
    }

    /// Returns the curves of all panels.
    pub(crate) fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.panels.iter().flat_map(|panel| &panel.curves)
    }

    /// Returns the range of the curves, as places on the scale.
    pub(crate) fn extent(&self) -> (f64, f64) {
        let scale = &self.across.scale;
        if let Scale::Words(words) = scale {
            // Each word has a place of width 1 around its number.
            return (-0.5, words.len() as f64 - 0.5);
        }
        let ends = self.curves().flat_map(|curve| curve.data.ends());
        match extent(ends.map(|end| scale.place(end))) {
            Some((low, high)) if low < high => {
                // 3 % at each end of a column's 193 points are more than 5: a dot at the edge, of radius 1.6, is whole.
                let room = if self.across.is_padded { 0.03 } else { 0.0 };
                let room = room * (high - low);
                (low - room, high + room)
            }
            // A single point lies in the middle.
            Some((only, _)) => (only - 1.0, only + 1.0),
            None => (0.0, 1.0),
        }
    }

    /// Returns the initial range of each panel, as places; none for words, and where nothing is known.
    pub(crate) fn ranges(&self) -> Vec<Option<(f64, f64)>> {
        let of = |panels: &[Panel]| {
            let places = panels.iter().flat_map(Panel::places);
            usual(places)
        };
        // Panels are compared by height, so all their values decide one range.
        if self.is_on_one_scale {
            return vec![of(&self.panels); self.panels.len()];
        }
        let range = |panel: &Panel| match panel.range {
            Some((low, high)) => Some((panel.scale.place(low), panel.scale.place(high))),
            None => of(std::slice::from_ref(panel)),
        };
        self.panels.iter().map(range).collect()
    }
}

impl Panel {
    /// Returns the places of the values that decide the range.
    fn places(&self) -> Vec<f64> {
        // Words have the range of their count: unused ones at the ends are part of the scale.
        if matches!(self.scale, Scale::Words(_)) {
            return Vec::new();
        }
        let curves = self.curves.iter().filter(|curve| !curve.is_aside);
        let values = curves.flat_map(Curve::settled);
        values.map(|value| self.scale.place(value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(points: Vec<(f64, f64)>) -> Figure {
        let curve = Curve::new("a", "#000000", Data::Points(points));
        Figure {
            panels: vec![Panel {
                curves: vec![curve],
                ..Panel::default()
            }],
            ..Figure::default()
        }
    }

    #[test]
    fn a_figure_without_values_one_point_and_a_constant_have_places() {
        assert_eq!(figure(vec![]).extent(), (0.0, 1.0));
        assert_eq!(figure(vec![]).ranges(), [None]);
        let one = figure(vec![(3.0, 5.0)]);
        assert_eq!(one.extent(), (2.0, 4.0));
        let (low, high) = one.ranges()[0].unwrap();
        // Half a percent of 5 at either side.
        assert!(low < 5.0 && high > 5.0 && high - low < 0.1);
        let unknown = figure(vec![(0.0, f64::NAN), (1.0, f64::INFINITY)]);
        assert_eq!(
            (unknown.extent(), unknown.ranges()),
            ((0.0, 1.0), vec![None])
        );
    }

    #[test]
    fn what_is_aside_does_not_decide_the_range() {
        let mut figure = figure(vec![(0.0, 1.0), (1.0, 2.0)]);
        let mut limit = Curve::level("limit", 1e6, 0.0, 1.0);
        limit.is_aside = true;
        figure.panels[0].curves.push(limit);
        assert!(figure.ranges()[0].unwrap().1 < 3.0);
    }

    #[test]
    fn a_logarithmic_figure_has_its_decades_as_places() {
        let mut figure = figure(vec![(10.0, 1e-3), (1000.0, 1e3), (2000.0, 0.0)]);
        figure.across.scale = Scale::Logarithmic;
        figure.panels[0].scale = Scale::Logarithmic;
        let (low, high) = figure.ranges()[0].unwrap();
        assert!(
            low < -3.0 && low > -4.0 && high > 3.0 && high < 4.0,
            "{low} {high}"
        );
        assert_eq!(figure.extent().0, 1.0);
    }

    #[test]
    fn how_it_locks_in_does_not_decide_the_range() {
        let points = (0..20).map(|s| (f64::from(s), if s < 5 { -1_000.0 } else { 1.0 }));
        let curve = Curve {
            settled_from: 5.0,
            ..Curve::new("saw", "#8a8a8a", Data::Points(points.collect()))
        };
        let figure = |curve| Figure {
            panels: vec![Panel {
                curves: vec![curve],
                ..Panel::default()
            }],
            ..Figure::default()
        };
        let low = |curve| figure(curve).ranges()[0].map(|(low, _)| low);
        assert!(low(curve.clone()).is_some_and(|low| low > 0.9));
        let settled_from = f64::NEG_INFINITY;
        let of_all = Curve {
            settled_from,
            ..curve
        };
        assert!(low(of_all).is_some_and(|low| low < -900.0));
    }
}
