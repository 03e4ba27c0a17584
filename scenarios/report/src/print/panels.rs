//! Places of the panels of a figure on paper.

use super::curves;
use super::frame::{Drawing, PanelFrame};
use super::legend::{legend, width_of_entry};
use super::picture::{Anchor, BLACK, Colour, MM, Picture, SIZE, Shape, width_of};
use crate::figure::{Figure, Panel};
use crate::plotting::{NEUTRAL, rgb};

/// Room at the left for numbers and the quantity, and at the right.
const LEFT: f64 = 40.0;
const RIGHT: f64 = 8.0;
/// Room above a panel with a title or without, and below it.
const ABOVE: f64 = 12.0;
const ABOVE_NONE: f64 = 6.0;
const BELOW: f64 = 11.0;
const LINE: f64 = 10.0;
/// Distance between two labels, from left to right and upwards.
// Twelve characters of 3.6 points: the longest number in six digits is like -1.23457e-10.
const LABEL: f64 = 45.0;
// Twice the size of letters.
const LABEL_UP: f64 = 16.0;

const RULE: Colour = (0xdd, 0xdd, 0xdd);

/// Paper of a figure, points.
pub(super) struct Paper {
    width: f64,
    /// Height of a panel among others, and of one alone, without what is above and below it.
    panel: f64,
    only_panel: f64,
}

impl Paper {
    /// Returns a column of a paper.
    pub(super) fn column(width_mm: f64) -> Self {
        Self {
            width: width_mm * MM,
            panel: 62.0,
            only_panel: 110.0,
        }
    }

    /// Returns a window, wide enough for each of the names.
    pub(super) fn screen(figure: &Figure) -> Self {
        const WIDTH: f64 = 430.0;
        // A name cannot be broken, and would be cut by the edge.
        let names = figure.curves().map(|curve| width_of_entry(&curve.group));
        Self {
            width: names.map(|width| LEFT + width).fold(WIDTH, f64::max),
            panel: 120.0,
            only_panel: 220.0,
        }
    }
}

/// Returns the figure on this paper.
pub(super) fn picture(figure: &Figure, paper: &Paper) -> Picture {
    let mut drawing = Drawing {
        shapes: Vec::new(),
        left: LEFT,
        right: paper.width - RIGHT,
        across: &figure.across.scale,
        x: figure.extent(),
    };
    let mut top = 2.0;
    let count = figure.panels.len();
    // A panel alone may be higher, as there is no other to share a page with.
    let height = if count == 1 {
        paper.only_panel
    } else {
        paper.panel
    };
    let ranges = figure.ranges();
    for (n, (panel, range)) in figure.panels.iter().zip(ranges).enumerate() {
        let is_last = n + 1 == count;
        top += draw_panel(&mut drawing, panel, range, (top, height), is_last);
    }
    let middle = (drawing.left + drawing.right) / 2.0;
    drawing.text((middle, top + 7.0), &figure.across.words(), Anchor::Middle);
    top += LINE + 2.0;
    let sides = (drawing.left, drawing.right);
    top += legend(&mut drawing.shapes, figure, sides, top);
    Picture {
        title: figure.title.clone(),
        width: paper.width,
        height: top + 3.0,
        shapes: drawing.shapes,
    }
}

/// Draws a panel and returns its height with everything around it.
fn draw_panel(
    drawing: &mut Drawing<'_>,
    panel: &Panel,
    range: Option<(f64, f64)>,
    (top, height): (f64, f64),
    is_last: bool,
) -> f64 {
    let above = if panel.title.is_empty() {
        ABOVE_NONE
    } else {
        ABOVE
    };
    let words = panel.scale.words().len();
    let frame = PanelFrame {
        top: top + above,
        bottom: top + above + height,
        scale: &panel.scale,
        y: match words {
            0 => range.unwrap_or((0.0, 1.0)),
            // Each word has a place of height 1 around its number.
            words => (-0.5, words as f64 - 0.5),
        },
    };
    if !panel.title.is_empty() {
        drawing.text((drawing.left, frame.top - 3.0), &panel.title, Anchor::Start);
    }
    // Shapes cover those before them: rules lie below the curves, the outline above curves that are at its edge.
    grid(drawing, panel, &frame, is_last);
    for mark in &panel.marks {
        let at = drawing.x_of(drawing.across.place(*mark));
        let points = vec![(at, frame.top), (at, frame.bottom)];
        drawing.line(points, rgb(NEUTRAL), 0.5, &[1.0, 2.0]);
    }
    for curve in &panel.curves {
        curves::draw(drawing, curve, &frame);
    }
    outline(drawing, &frame);
    above + height + if is_last { BELOW } else { 2.0 }
}

fn grid(drawing: &mut Drawing<'_>, panel: &Panel, frame: &PanelFrame<'_>, is_last: bool) {
    // Words may be longer than numbers.
    let words = drawing.across.words().iter();
    let longest = words.map(|word| width_of(word, SIZE) + 6.0);
    let each = longest.fold(LABEL, f64::max);
    for (mark, words) in drawing.across.ticks(drawing.x, drawing.width() / each) {
        let at = drawing.x_of(mark);
        drawing.line(vec![(at, frame.top), (at, frame.bottom)], RULE, 0.4, &[]);
        // Panels have one axis in common, with its numbers below the last one.
        if is_last {
            drawing.text((at, frame.bottom + 8.0), &words, Anchor::Middle);
        }
    }
    for (mark, words) in frame.scale.ticks(frame.y, frame.height() / LABEL_UP) {
        let at = frame.y_of(mark);
        drawing.line(
            vec![(drawing.left, at), (drawing.right, at)],
            RULE,
            0.4,
            &[],
        );
        drawing.text((drawing.left - 3.0, at + 0.35 * SIZE), &words, Anchor::End);
    }
    let at = (SIZE, (frame.top + frame.bottom) / 2.0);
    drawing.shapes.push(Shape::upward(at, panel.words()));
}

fn outline(drawing: &mut Drawing<'_>, frame: &PanelFrame<'_>) {
    let (left, right) = (drawing.left, drawing.right);
    let corners = [
        (left, frame.top),
        (left, frame.bottom),
        (right, frame.bottom),
        (right, frame.top),
        (left, frame.top),
    ];
    drawing.line(corners.to_vec(), BLACK, 0.5, &[]);
}
