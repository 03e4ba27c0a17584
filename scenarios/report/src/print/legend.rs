//! The names of the curves below a figure.

use super::frame::dashes;
use super::picture::{Anchor, Colour, Point, SIZE, Shape, width_of};
use crate::figure::{Figure, Look};
use crate::plotting::rgb;

const LINE: f64 = 10.0;
/// A curve's sample, and the gap to the next one.
const SAMPLE: f64 = 14.0;
const GAP: f64 = 8.0;

/// Returns the width of the entry of a name.
pub(super) fn width_of_entry(name: &str) -> f64 {
    SAMPLE + 4.0 + width_of(name, SIZE) + GAP
}

/// Draws the names of the groups from left to right, in as many lines as they need. Returns the height.
pub(super) fn legend(
    shapes: &mut Vec<Shape>,
    figure: &Figure,
    (left, right): (f64, f64),
    top: f64,
) -> f64 {
    let mut named: Vec<&str> = Vec::new();
    let (mut x, mut y) = (left, top + SIZE);
    for curve in figure.curves() {
        if named.contains(&curve.group.as_str()) {
            continue;
        }
        named.push(&curve.group);
        let width = width_of_entry(&curve.group);
        // The gap behind the last name of a line needs no room. A name longer than a line has one of its own.
        if x + width > right + GAP && x > left {
            (x, y) = (left, y + LINE);
        }
        // Capitals of Helvetica are 0.72 of the size high: half of that is the middle of a line of text.
        let at = (x, y - 0.35 * SIZE);
        shapes.push(sample(at, curve.look, rgb(&curve.colour)));
        let name = (x + SAMPLE + 4.0, y);
        shapes.push(Shape::text(name, &curve.group, Anchor::Start));
        x += width;
    }
    y + 2.0 - top
}

fn sample((x, y): Point, look: Look, colour: Colour) -> Shape {
    if look == Look::Marks {
        return Shape::Dot {
            at: (x + SAMPLE / 2.0, y),
            radius: 2.0,
            colour,
        };
    }
    Shape::Line {
        points: vec![(x, y), (x + SAMPLE, y)],
        colour,
        width: 1.4,
        dashes: dashes(look),
    }
}
