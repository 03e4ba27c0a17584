//! Where everything of a figure lies on paper.

use super::picture::{Anchor, Colour, MM, Picture, Point, Shape, width_of};
use crate::plotting::{NEUTRAL, rgb, short};
use crate::run::figure::{Curve, Data, Figure, Look, Panel};
use coaxle_lab::curves::Stretch;

/// Letters, points.
const SIZE: f64 = 7.0;
/// Room at the left for numbers and the quantity, and at the right.
const LEFT: f64 = 40.0;
const RIGHT: f64 = 8.0;
/// Of a panel, without what is above and below it.
const PANEL: f64 = 62.0;
const ONLY_PANEL: f64 = 110.0;
/// Above a panel with a title or without, and below it.
const ABOVE: f64 = 12.0;
const ABOVE_NONE: f64 = 6.0;
const BELOW: f64 = 11.0;
const LINE: f64 = 10.0;

const BLACK: Colour = (0, 0, 0);
const RULE: Colour = (0xdd, 0xdd, 0xdd);
const OPACITY: f64 = 0.35;

/// The figure, so many millimetres wide.
pub(super) fn picture(figure: &Figure, width_mm: f64) -> Picture {
    let width = width_mm * MM;
    let mut drawing = Drawing {
        shapes: Vec::new(),
        left: LEFT,
        right: width - RIGHT,
        x: extent(figure),
    };
    let mut top = 2.0;
    let count = figure.panels.len();
    let ranges = figure.ranges();
    for (n, (panel, range)) in figure.panels.iter().zip(ranges).enumerate() {
        let is_last = n + 1 == count;
        top += drawing.panel(panel, range, top, count == 1, is_last);
    }
    let words = format!("{} ({})", figure.across.words(), figure.across.unit());
    let middle = (drawing.left + drawing.right) / 2.0;
    drawing.text((middle, top + 7.0), &words, Anchor::Middle);
    top += LINE + 2.0;
    top += drawing.legend(figure, top);
    Picture {
        title: figure.title.to_owned(),
        width,
        height: top + 3.0,
        shapes: drawing.shapes,
    }
}

struct Drawing {
    shapes: Vec<Shape>,
    left: f64,
    right: f64,
    /// From where to where the figure goes.
    x: (f64, f64),
}

/// Where a panel is, and what it shows.
struct Frame {
    top: f64,
    bottom: f64,
    y: (f64, f64),
}

impl Drawing {
    /// Draws a panel and gives its height with all that is around it.
    fn panel(
        &mut self,
        panel: &Panel,
        range: Option<(f64, f64)>,
        top: f64,
        is_only: bool,
        is_last: bool,
    ) -> f64 {
        let above = if panel.title.is_empty() {
            ABOVE_NONE
        } else {
            ABOVE
        };
        let height = if is_only { ONLY_PANEL } else { PANEL };
        let words = (-0.5, panel.words.len() as f64 - 0.5);
        let frame = Frame {
            top: top + above,
            bottom: top + above + height,
            y: if panel.words.is_empty() {
                range.unwrap_or((0.0, 1.0))
            } else {
                words
            },
        };
        if !panel.title.is_empty() {
            self.text((self.left, frame.top - 3.0), &panel.title, Anchor::Start);
        }
        self.grid(panel, &frame, is_last);
        for mark in &panel.marks {
            let at = self.place(&frame, (*mark, 0.0)).0;
            let points = vec![(at, frame.top), (at, frame.bottom)];
            self.line(points, rgb(NEUTRAL), 0.5, &[1.0, 2.0]);
        }
        for curve in &panel.curves {
            self.curve(curve, &frame);
        }
        self.outline(&frame);
        above + height + if is_last { BELOW } else { 2.0 }
    }

    fn grid(&mut self, panel: &Panel, frame: &Frame, is_last: bool) {
        let room = self.right - self.left;
        for mark in ticks(self.x, room / 45.0) {
            let at = self.place(frame, (mark, 0.0)).0;
            self.line(vec![(at, frame.top), (at, frame.bottom)], RULE, 0.4, &[]);
            if is_last {
                self.text((at, frame.bottom + 8.0), &short(mark, 6), Anchor::Middle);
            }
        }
        let marks = match panel.words {
            [] => {
                let marks = ticks(frame.y, (frame.bottom - frame.top) / 16.0).into_iter();
                marks.map(|mark| (mark, short(mark, 6))).collect()
            }
            words => {
                let words = words.iter().enumerate();
                words
                    .map(|(n, word)| (n as f64, (*word).to_owned()))
                    .collect::<Vec<_>>()
            }
        };
        for (mark, words) in marks {
            let at = self.place(frame, (self.x.0, mark)).1;
            self.line(vec![(self.left, at), (self.right, at)], RULE, 0.4, &[]);
            self.text((self.left - 3.0, at + 0.35 * SIZE), &words, Anchor::End);
        }
        let label = match (panel.quantity, panel.unit.as_str()) {
            ("", unit) => unit.to_owned(),
            (quantity, unit) => format!("{quantity} ({unit})"),
        };
        let at = (SIZE, (frame.top + frame.bottom) / 2.0);
        self.shapes.push(Shape::Text {
            at,
            text: label,
            size: SIZE,
            anchor: Anchor::Middle,
            is_upward: true,
        });
    }

    fn outline(&mut self, frame: &Frame) {
        let (left, right) = (self.left, self.right);
        let corners = [
            (left, frame.top),
            (left, frame.bottom),
            (right, frame.bottom),
            (right, frame.top),
            (left, frame.top),
        ];
        self.line(corners.to_vec(), BLACK, 0.5, &[]);
    }

    fn curve(&mut self, curve: &Curve, frame: &Frame) {
        let colour = rgb(&curve.colour);
        let dashes: &[f64] = match curve.look {
            Look::Dotted => &[1.0, 1.5],
            Look::Dashed => &[3.5, 2.0],
            Look::Solid | Look::Steps | Look::Dots => &[],
        };
        match &curve.data {
            Data::Points(points) => {
                for run in points.split(|(_, value)| !value.is_finite()) {
                    let run = if curve.look == Look::Steps {
                        stairs(run)
                    } else {
                        run.to_vec()
                    };
                    let run: Vec<_> = run.into_iter().map(|at| self.place(frame, at)).collect();
                    self.line(run, colour, 0.7, dashes);
                }
            }
            Data::Levels { stretches, .. } => {
                // Finer than a printer needs.
                let columns = 2.0 * (self.right - self.left);
                let each = (stretches.len() as f64 / columns).ceil().max(1.0) as usize;
                let joined: Vec<_> = stretches
                    .chunks(each)
                    .filter_map(coaxle_lab::curves::joined)
                    .collect();
                self.band(&joined, colour, frame);
            }
        }
    }

    /// From the lowest to the highest values; a line where they are the same.
    fn band(&mut self, stretches: &[Stretch], colour: Colour, frame: &Frame) {
        let low = stretches.iter().map(|s| self.place(frame, (s.t_s, s.low)));
        let low: Vec<_> = low.collect();
        let high = stretches.iter().map(|s| self.place(frame, (s.t_s, s.high)));
        let high: Vec<_> = high.collect();
        let is_band = low
            .iter()
            .zip(&high)
            .any(|(low, high)| low.1 - high.1 > 0.2);
        if !is_band {
            self.line(high, colour, 0.7, &[]);
            return;
        }
        let outline = high.iter().chain(low.iter().rev()).copied();
        self.shapes.push(Shape::Area {
            points: outline.collect(),
            colour,
            opacity: OPACITY,
        });
        self.line(high, colour, 0.4, &[]);
        self.line(low, colour, 0.4, &[]);
    }

    /// The names of the groups, in as many lines as they need. Gives the height.
    fn legend(&mut self, figure: &Figure, top: f64) -> f64 {
        let mut told: Vec<&str> = Vec::new();
        let (mut x, mut y) = (self.left, top + SIZE);
        for curve in figure.curves() {
            if told.contains(&curve.group.as_str()) {
                continue;
            }
            told.push(&curve.group);
            let width = 18.0 + width_of(&curve.group, SIZE) + 8.0;
            if x + width > self.right + RIGHT && x > self.left {
                (x, y) = (self.left, y + LINE);
            }
            let height = y - 0.35 * SIZE;
            self.line(
                vec![(x, height), (x + 14.0, height)],
                rgb(&curve.colour),
                1.4,
                &[],
            );
            self.text((x + 18.0, y), &curve.group, Anchor::Start);
            x += width;
        }
        y + 2.0 - top
    }

    fn text(&mut self, at: Point, text: &str, anchor: Anchor) {
        self.shapes.push(Shape::Text {
            at,
            text: text.to_owned(),
            size: SIZE,
            anchor,
            is_upward: false,
        });
    }

    fn line(&mut self, points: Vec<Point>, colour: Colour, width: f64, dashes: &'static [f64]) {
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

    /// Where a value lies; one beyond the range at its edge.
    fn place(&self, frame: &Frame, (x, y): Point) -> Point {
        let share =
            |value: f64, (low, high): (f64, f64)| ((value - low) / (high - low)).clamp(0.0, 1.0);
        (
            self.left + share(x, self.x) * (self.right - self.left),
            frame.bottom - share(y, frame.y) * (frame.bottom - frame.top),
        )
    }
}

/// From where to where the curves go.
fn extent(figure: &Figure) -> (f64, f64) {
    let ends = figure.curves().flat_map(|curve| match &curve.data {
        Data::Points(points) => [points.first().map(|p| p.0), points.last().map(|p| p.0)],
        Data::Levels { stretches, .. } => [
            stretches.first().map(|s| s.t_s),
            stretches.last().map(|s| s.t_s),
        ],
    });
    let (low, high) = ends
        .flatten()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), end| {
            (low.min(end), high.max(end))
        });
    if low < high {
        (low, high)
    } else {
        (low - 1.0, low + 1.0)
    }
}

/// A value holds until the next one.
fn stairs(points: &[Point]) -> Vec<Point> {
    let pairs = points
        .windows(2)
        .flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    pairs.chain(points.last().copied()).collect()
}

/// Steps of 1, 2 or 5 times a power of ten, so that there are about so many.
fn ticks((from, to): (f64, f64), count: f64) -> Vec<f64> {
    let raw = (to - from) / count.max(1.0);
    let power = 10_f64.powf(raw.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let step = steps.into_iter().find(|step| *step >= raw).unwrap_or(raw);
    let (first, last) = ((from / step).ceil() as i64, (to / step).floor() as i64);
    (first..=last).map(|n| n as f64 * step).collect()
}
