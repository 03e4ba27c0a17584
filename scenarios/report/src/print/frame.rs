//! Places of values on paper.

use super::picture::{Anchor, Colour, Point, Shape};
use crate::figure::{Look, Scale};

/// A figure that is being drawn.
pub(super) struct Drawing<'a> {
    pub(super) shapes: Vec<Shape>,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) across: &'a Scale,
    /// Range of the figure along its axis, as places on the scale.
    pub(super) x: (f64, f64),
}

/// Place, scale and range of a panel.
pub(super) struct PanelFrame<'a> {
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) scale: &'a Scale,
    pub(super) y: (f64, f64),
}

impl Drawing<'_> {
    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn text(&mut self, at: Point, text: &str, anchor: Anchor) {
        self.shapes.push(Shape::text(at, text, anchor));
    }

    pub(super) fn line(
        &mut self,
        points: Vec<Point>,
        colour: Colour,
        width: f64,
        dashes: &'static [f64],
    ) {
        // A path of a single point draws nothing.
        if points.len() < 2 {
            return;
        }
        self.shapes.push(Shape::Line {
            points,
            colour,
            width,
            dashes,
        });
    }

    /// Returns the place of a value; one beyond the range at its edge. None for a value that has no place on its scale.
    pub(super) fn at(&self, frame: &PanelFrame<'_>, (x, y): Point) -> Option<Point> {
        let (x, y) = (self.across.place(x), frame.scale.place(y));
        (x.is_finite() && y.is_finite()).then(|| (self.x_of(x), frame.y_of(y)))
    }

    pub(super) fn x_of(&self, place: f64) -> f64 {
        self.left + share(place, self.x) * self.width()
    }
}

impl PanelFrame<'_> {
    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub(super) fn y_of(&self, place: f64) -> f64 {
        self.bottom - share(place, self.y) * self.height()
    }
}

fn share(place: f64, (low, high): (f64, f64)) -> f64 {
    // Clamped, as a picture has no clipping: a spike would be drawn across the other panels.
    ((place - low) / (high - low)).clamp(0.0, 1.0)
}

/// Returns the dashes and gaps of a look.
pub(super) const fn dashes(look: Look) -> &'static [f64] {
    match look {
        Look::Dotted => &[1.0, 1.5],
        Look::Dashed => &[3.5, 2.0],
        Look::Solid | Look::Steps | Look::Dots | Look::Marks => &[],
    }
}
