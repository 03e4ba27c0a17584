//! Maps on paper.

use coaxle_lab::number::significant;

use super::picture::{Anchor, Picture, SIZE, Shape, width_of};
use crate::figure::{Map, Maps, Scale, bright, ink};
use crate::plotting::short;

/// Size of a map's cells, and the least room around them, points.
const CELLS: (f64, f64) = (210.0, 160.0);
const LEFT: f64 = 40.0;
const RIGHT: f64 = 10.0;
const ABOVE: f64 = 16.0;
const BELOW: f64 = 30.0;
/// Room above all maps: the title, and the colours.
const HEAD: f64 = 36.0;
/// Distance between two numbers upwards.
const LINE: f64 = 9.0;
/// Steps of the bar of colours.
const STEPS: usize = 32;

/// Returns all maps, with the meaning of their colours.
pub(super) fn picture(maps: &Maps) -> Picture {
    let (columns, rows) = maps.grid();
    let labels = maps.up.1.iter().map(|word| width_of(word, SIZE));
    // Words upwards may be longer than the usual numbers. The rest is for the quantity beside them.
    let left = labels.fold(LEFT, |left, width| left.max(width + 16.0));
    let each = (left + CELLS.0 + RIGHT, ABOVE + CELLS.1 + BELOW);
    let mut shapes = vec![Shape::text((left, 12.0), &maps.title, Anchor::Start)];
    shapes.extend(bar(maps, left));
    for (n, (map, shares)) in maps.maps.iter().zip(maps.shares()).enumerate() {
        let (column, row) = ((n % columns) as f64, (n / columns) as f64);
        let corner = (column * each.0 + left, HEAD + row * each.1 + ABOVE);
        shapes.extend(drawn(maps, map, &shares, corner, left));
    }
    Picture {
        title: maps.title.clone(),
        // A title may be wider than a single map.
        width: (columns as f64 * each.0).max(left + width_of(&maps.title, SIZE) + RIGHT),
        height: HEAD + rows as f64 * each.1,
        shapes,
    }
}

/// Returns the bar of colours from the least to the largest value.
fn bar(maps: &Maps, left: f64) -> Vec<Shape> {
    const LENGTH: f64 = 96.0;
    let Some((low, high)) = maps.range() else {
        return Vec::new();
    };
    let (low, high) = (short(low, 3), short(high, 3));
    let from = left + width_of(&low, SIZE) + 4.0;
    let mut shapes = vec![Shape::text((left, 26.0), &low, Anchor::Start)];
    for n in 0..STEPS {
        let step = LENGTH / STEPS as f64;
        let x = from + n as f64 * step;
        // Each overlaps the next a little: a reader that smooths edges leaves no gaps.
        let corners = rectangle((x, 20.0), (step + 0.3, SIZE));
        shapes.push(filled(corners, n as f64 / (STEPS - 1) as f64));
    }
    let behind = (from + LENGTH + 4.0, 26.0);
    shapes.push(Shape::text(behind, &high, Anchor::Start));
    shapes
}

fn drawn(
    maps: &Maps,
    map: &Map,
    shares: &[Option<f64>],
    (left, top): (f64, f64),
    room: f64,
) -> Vec<Shape> {
    let (columns, rows) = (maps.across.1.len(), maps.up.1.len());
    let each = (
        // Maps of nothing have no cells, but are drawn.
        CELLS.0 / columns.max(1) as f64,
        CELLS.1 / rows.max(1) as f64,
    );
    let bottom = top + CELLS.1;
    let mut shapes = vec![Shape::text((left, top - 5.0), &map.title, Anchor::Start)];
    let numbers = map.cells.iter().flatten();
    let longest = numbers.map(|value| width_of(&significant(*value, 3), SIZE));
    // All numbers of a map or none: single ones that fit would look like a selection.
    let has_numbers = each.1 >= LINE && longest.fold(0.0, f64::max) < each.0;
    for (n, (cell, share)) in map.cells.iter().zip(shares).enumerate() {
        let (Some(value), Some(share)) = (cell, share) else {
            continue;
        };
        let (column, row) = (n % columns.max(1), n / columns.max(1));
        let corner = (
            left + column as f64 * each.0,
            // Rows go upwards, places downwards, and a rectangle hangs from its upper corner.
            bottom - (row + 1) as f64 * each.1,
        );
        shapes.push(filled(rectangle(corner, each), *share));
        if has_numbers {
            shapes.push(Shape::Text {
                at: (
                    corner.0 + each.0 / 2.0,
                    corner.1 + each.1 / 2.0 + 0.35 * SIZE,
                ),
                text: significant(*value, 3),
                size: SIZE,
                anchor: Anchor::Middle,
                colour: ink(*share),
                is_upward: false,
            });
        }
    }
    shapes.extend(labels(maps, (left, bottom), each, room));
    shapes
}

/// Returns the words along both axes, as many as there is room for, and the quantities.
fn labels(maps: &Maps, (left, bottom): (f64, f64), each: (f64, f64), room: f64) -> Vec<Shape> {
    let mut shapes = Vec::new();
    let words = maps.across.1.iter();
    let longest = words.map(|word| width_of(word, SIZE) + 4.0);
    let ticks = |words: &[String], count: f64| {
        let range = (-0.5, words.len() as f64 - 0.5);
        Scale::Words(words.to_vec()).ticks(range, count)
    };
    // As many words as the longest has room for.
    for (n, word) in ticks(&maps.across.1, CELLS.0 / longest.fold(1.0, f64::max)) {
        let at = (left + (n + 0.5) * each.0, bottom + 9.0);
        shapes.push(Shape::text(at, &word, Anchor::Middle));
    }
    for (n, word) in ticks(&maps.up.1, CELLS.1 / LINE) {
        let at = (left - 3.0, bottom - (n + 0.5) * each.1 + 0.35 * SIZE);
        shapes.push(Shape::text(at, &word, Anchor::End));
    }
    let middle = (left + CELLS.0 / 2.0, bottom + 20.0);
    shapes.push(Shape::text(middle, &maps.across.0, Anchor::Middle));
    let beside = (left - room + SIZE, bottom - CELLS.1 / 2.0);
    shapes.push(Shape::upward(beside, maps.up.0.clone()));
    shapes
}

fn filled(points: Vec<(f64, f64)>, share: f64) -> Shape {
    Shape::Area {
        points,
        colour: bright(share),
        opacity: 1.0,
    }
}

fn rectangle((x, y): (f64, f64), (width, height): (f64, f64)) -> Vec<(f64, f64)> {
    vec![
        (x, y),
        (x + width, y),
        (x + width, y + height),
        (x, y + height),
    ]
}
