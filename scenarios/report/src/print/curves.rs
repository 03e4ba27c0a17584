//! The curves of a panel on paper.

use coaxle_lab::curves::{Stretch, joined};

use super::frame::{Drawing, PanelFrame, dashes};
use super::picture::{Colour, Point, Shape};
use crate::figure::{Curve, Data, Look, thinned};
use crate::plotting::rgb;

/// Opacity of the band between two extremes.
const OPACITY: f64 = 0.35;
/// Opacity of the spread of points, where several lie over each other.
const OPACITY_OF_A_SPREAD: f64 = 0.2;
/// Columns per typographic point: finer than a printer needs.
const COLUMNS: f64 = 2.0;
/// Least room for each dot, in typographic points.
// A dot is 3.2 points wide: with less than this for each they would run into a thick line.
const ROOM_OF_A_DOT: f64 = 4.0;

pub(super) fn draw(drawing: &mut Drawing<'_>, curve: &Curve, frame: &PanelFrame) {
    let colour = rgb(&curve.colour);
    match &curve.data {
        Data::Points(points) | Data::Course(points) => {
            spread(drawing, curve, points, frame);
            draw_points(drawing, curve, points, frame);
        }
        Data::Levels { stretches, .. } => {
            let columns = COLUMNS * drawing.width();
            // More stretches than columns only make the file larger.
            let each = (stretches.len() as f64 / columns).ceil().max(1.0) as usize;
            let joined: Vec<_> = stretches.chunks(each).filter_map(joined).collect();
            band(drawing, &joined, colour, frame);
        }
    }
}

fn draw_points(drawing: &mut Drawing<'_>, curve: &Curve, points: &[Point], frame: &PanelFrame) {
    let colour = rgb(&curve.colour);
    let columns = COLUMNS * drawing.width();
    let is_known = |point: &Point| drawing.at(frame, *point).is_some();
    let has_dots = match curve.look {
        Look::Dots => points.len() as f64 * ROOM_OF_A_DOT < drawing.width(),
        look => look == Look::Marks,
    };
    let dots = points.iter().filter(|_| has_dots);
    let dots: Vec<_> = dots.filter_map(|p| drawing.at(frame, *p)).collect();
    let lines: Vec<Vec<Point>> = match curve.look {
        Look::Marks => Vec::new(),
        look => {
            // Thinned before gaps split it: a gap stays a point that is not finite.
            let thin = thinned(points, columns as usize);
            let runs = thin.split(|point| !is_known(point));
            let runs = runs.map(|run| {
                let run = if look == Look::Steps {
                    stairs(run)
                } else {
                    run.to_vec()
                };
                let run = run.into_iter();
                run.filter_map(|point| drawing.at(frame, point)).collect()
            });
            runs.collect()
        }
    };
    for line in lines {
        drawing.line(line, colour, 0.7, dashes(curve.look));
    }
    for at in dots {
        let radius = 1.6;
        drawing.shapes.push(Shape::Dot { at, radius, colour });
    }
}

/// Draws the spread of points: a band from one to the next, and a whisker at each.
fn spread(drawing: &mut Drawing<'_>, curve: &Curve, points: &[Point], frame: &PanelFrame) {
    let colour = rgb(&curve.colour);
    let ends = points
        .iter()
        // A curve without a spread has none here, as the shorter of both ends it.
        .zip(&curve.spread)
        .map(|((x, _), (low, high))| {
            let [low, high] = [low, high].map(|end| drawing.at(frame, (*x, *end)));
            Some((low?, high?))
        });
    let ends: Vec<Option<(Point, Point)>> = ends.collect();
    for run in ends.split(Option::is_none) {
        let run: Vec<_> = run.iter().flatten().copied().collect();
        let highs = run.iter().map(|(_, high)| *high);
        // Along the high ends and back along the low ones: a polygon that does not cross itself.
        let outline = highs.chain(run.iter().rev().map(|(low, _)| *low));
        // A single point has no area, and only a whisker.
        if run.len() > 1 {
            drawing.shapes.push(Shape::Area {
                points: outline.collect(),
                colour,
                opacity: OPACITY_OF_A_SPREAD,
            });
        }
        for (low, high) in run {
            drawing.line(vec![low, high], colour, 0.5, &[]);
        }
    }
}

/// Draws a band from the lowest to the highest values; a line where they are equal.
fn band(drawing: &mut Drawing<'_>, stretches: &[Stretch], colour: Colour, frame: &PanelFrame) {
    let ends = |of: fn(&Stretch) -> f64| -> Vec<Point> {
        let places = stretches.iter().map(|stretch| (stretch.t_s, of(stretch)));
        places.filter_map(|at| drawing.at(frame, at)).collect()
    };
    let (low, high) = (ends(|s| s.low), ends(|s| s.high));
    let mut pairs = low.iter().zip(&high);
    // Places grow downwards. A band thinner than its own lines is a line.
    if !pairs.any(|(low, high)| low.1 - high.1 > 0.2) {
        drawing.line(high, colour, 0.7, &[]);
        return;
    }
    let outline = high.iter().chain(low.iter().rev()).copied();
    drawing.shapes.push(Shape::Area {
        points: outline.collect(),
        colour,
        opacity: OPACITY,
    });
    drawing.line(high, colour, 0.4, &[]);
    drawing.line(low, colour, 0.4, &[]);
}

/// Returns the corners of steps: a value holds until the next one.
fn stairs(points: &[Point]) -> Vec<Point> {
    let pairs = points
        .windows(2)
        .flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    pairs.chain(points.last().copied()).collect()
}
