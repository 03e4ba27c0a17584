//! Shapes of a figure, in points from the top left, for any kind of file.

/// Points in a millimetre.
pub(super) const MM: f64 = 72.0 / 25.4;

pub(super) type Point = (f64, f64);
pub(super) type Colour = (u8, u8, u8);

pub(super) const BLACK: Colour = (0, 0, 0);

/// Size of letters, points.
pub(super) const SIZE: f64 = 7.0;

/// A picture.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub(super) title: String,
    pub(super) width: f64,
    pub(super) height: f64,
    /// Shapes, in the order of drawing.
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
        /// Opacity, 0 to 1.
        opacity: f64,
    },
    Dot {
        at: Point,
        radius: f64,
        colour: Colour,
    },
    Text {
        at: Point,
        text: String,
        size: f64,
        anchor: Anchor,
        colour: Colour,
        /// True if it is read from the bottom to the top.
        is_upward: bool,
    },
}

/// Part of a text that is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Shape {
    /// Returns black text that reads from left to right.
    pub(super) fn text(at: Point, text: &str, anchor: Anchor) -> Self {
        Self::Text {
            at,
            text: text.to_owned(),
            size: SIZE,
            anchor,
            colour: BLACK,
            is_upward: false,
        }
    }

    /// Returns black text that reads upwards, in the middle of its place.
    pub(super) fn upward(at: Point, text: String) -> Self {
        Self::Text {
            at,
            text,
            size: SIZE,
            anchor: Anchor::Middle,
            colour: BLACK,
            is_upward: true,
        }
    }
}

/// Estimates the width of a text. Letters of the usual sans-serif fonts are half as wide as high.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    // Digits of Helvetica are 0.556 wide, lower-case letters 0.49 in the mean.
    0.52 * size * text.chars().count() as f64
}
