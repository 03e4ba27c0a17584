//! What a figure is drawn with, in points from the top left, whatever file it becomes.

/// Points in a millimetre.
pub(super) const MM: f64 = 72.0 / 25.4;

pub(super) type Point = (f64, f64);
pub(super) type Colour = (u8, u8, u8);

/// A picture.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub(super) title: String,
    pub(super) width: f64,
    pub(super) height: f64,
    /// In the order of drawing.
    pub(super) shapes: Vec<Shape>,
}

/// A part of a picture.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Line {
        points: Vec<Point>,
        colour: Colour,
        width: f64,
        /// Lengths of dashes and gaps; empty: solid.
        dashes: &'static [f64],
    },
    /// A filled outline.
    Area {
        points: Vec<Point>,
        colour: Colour,
        /// 0 to 1.
        opacity: f64,
    },
    Text {
        at: Point,
        text: String,
        size: f64,
        anchor: Anchor,
        /// Read from the bottom to the top.
        is_upward: bool,
    },
}

/// Which part of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// About how wide a text is. Letters of the usual sans-serif fonts are half as wide as high.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    0.52 * size * text.chars().count() as f64
}
