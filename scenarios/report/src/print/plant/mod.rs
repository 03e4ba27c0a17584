//! Nodes of a plant on paper: who follows whom, with the delays, and whether each is interpolated.

mod layout;

use coaxle_topology::{AxisSummary, NodeSummary, PlantAnalysis, Proposal, ShownAs, label, short};

use self::layout::{HEAD, NodeBox, PAD, PlantPlaces, SMALL, layout};
use super::picture::{Anchor, BLACK, Colour, Picture, Point, SIZE, Shape, width_of};

const LEFT: f64 = 14.0;
const TOP: f64 = 30.0;
/// Room of a line of text below the picture.
const LINE: f64 = 9.5;
/// Least width: of the legend.
const LEAST: f64 = 420.0;

/// Ink of secondary text, of the frame of a node and of its head.
const GREY: Colour = (0x6a, 0x72, 0x7c);
const FRAME: Colour = (0xb4, 0xbc, 0xc6);
const SHADE: Colour = (0xee, 0xf2, 0xf6);
const ROOT: Colour = (0xfd, 0xf3, 0xe4);
const GOOD: Colour = (0x0b, 0x8a, 0x6a);
const NOW: Colour = (0xc9, 0x8a, 0x00);
const BAD: Colour = (0xc2, 0x36, 0x2b);

/// Looks of a link, with their words.
const LOOKS: [(ShownAs, &str); 4] = [
    (ShownAs::Interpolated, "shown later: interpolated"),
    (
        ShownAs::Extrapolated,
        "shown later, but too early: extrapolated",
    ),
    (ShownAs::Now, "shown now: extrapolated"),
    (ShownAs::Unknown, "unknown, or as received"),
];

/// Returns the picture, in points.
pub(super) fn picture(plant: &PlantAnalysis) -> Picture {
    let rows: Vec<Vec<String>> = plant
        .nodes
        .iter()
        .map(|node| node.axes.iter().map(row).collect())
        .collect();
    let heads: Vec<String> = plant.nodes.iter().map(head).collect();
    let places = layout(plant, &rows, &heads, (LEFT, TOP));
    let width = (places.size.0 + LEFT).max(LEAST);
    let mut shapes = vec![text(
        (LEFT, 14.0),
        &title(plant),
        SIZE + 2.0,
        Anchor::Start,
        BLACK,
    )];
    shapes.extend(links(plant, &places));
    for (n, node) in plant.nodes.iter().enumerate() {
        shapes.extend(node_shapes(node, places.boxes[n], &heads[n], &rows[n]));
    }
    shapes.extend(labels(plant, &places));
    let mut y = places.size.1 + 18.0;
    shapes.extend(legend(y));
    for (line, colour) in remarks(plant) {
        for part in wrapped(&line, width - 2.0 * LEFT) {
            y += LINE;
            shapes.push(text(
                (LEFT, y + 4.0),
                &part,
                SMALL + 0.6,
                Anchor::Start,
                colour,
            ));
        }
    }
    Picture {
        title: title(plant),
        width,
        height: y + 14.0,
        shapes,
    }
}

fn title(plant: &PlantAnalysis) -> String {
    let (nodes, routes) = (plant.nodes.len(), plant.routes.len());
    format!("Who follows whom: {nodes} nodes, {routes} routes")
}

/// `roll ← far`: an axis with its masters or its unit.
fn row(axis: &AxisSummary) -> String {
    let unit = axis
        .unit
        .as_ref()
        .map_or(String::new(), |unit| format!(" [{unit}]"));
    let name = format!("{}{unit}", axis.axis);
    match axis.masters.as_slice() {
        [] => match axis.present_after_ms {
            Some(delay) => format!("{name}, shown after {} ms", short(delay)),
            None => name,
        },
        masters => format!("{name} ← {}", masters.join(", ")),
    }
}

/// `receiver · 1 ms · drives 11 ms later`.
fn head(node: &NodeSummary) -> String {
    let mut about = vec![node.role.name().to_owned()];
    about.extend(
        node.cycle_time_us
            .map(|cycle| format!("{} ms", short(cycle / 1e3))),
    );
    let held = node.hold_back_ms.filter(|time| *time > 0.0);
    about.extend(held.map(|time| format!("drives {} ms later", short(time))));
    about.join(" · ")
}

fn node_shapes(node: &NodeSummary, place: NodeBox, head: &str, rows: &[String]) -> Vec<Shape> {
    let NodeBox {
        left,
        top,
        width,
        height,
    } = place;
    let is_root = node.axes.iter().all(|axis| axis.follows.is_empty());
    let shade = if is_root { ROOT } else { SHADE };
    let mut shapes = vec![
        filled((left, top), (width, height), (255, 255, 255)),
        filled((left, top), (width, HEAD - 3.0), shade),
        outline((left, top), (width, height)),
    ];
    shapes.push(text(
        (left + PAD, top + 9.0),
        &node.node,
        SIZE + 0.8,
        Anchor::Start,
        BLACK,
    ));
    let at = (left + PAD, top + 17.5);
    shapes.push(text(at, head, SMALL, Anchor::Start, GREY));
    for (n, (axis, row)) in node.axes.iter().zip(rows).enumerate() {
        let middle = place.row(n);
        let colour = if axis.masters.is_empty() { BLACK } else { GREY };
        let row = fitting(row, width - 2.0 * PAD);
        let at = (left + PAD, middle + 0.35 * SIZE);
        shapes.push(text(at, &row, SIZE - 0.4, Anchor::Start, colour));
        if !axis.follows.is_empty() {
            shapes.push(dot((left, middle), GREY));
        }
        if axis.address.is_some() && !axis.is_unused {
            shapes.push(dot((left + width, middle), GREY));
        }
    }
    shapes
}

fn links(plant: &PlantAnalysis, places: &PlantPlaces) -> Vec<Shape> {
    let links = plant.links.iter().zip(&places.ways);
    links
        .map(|(link, way)| {
            let (colour, dashes) = look(link.stage.shown);
            Shape::Line {
                points: curve(way),
                colour,
                width: 1.1,
                dashes,
            }
        })
        .collect()
}

/// Delay and lag of each link, once for all axes that come over one way.
fn labels(plant: &PlantAnalysis, places: &PlantPlaces) -> Vec<Shape> {
    let mut seen: Vec<(usize, usize, String)> = Vec::new();
    let mut shapes = Vec::new();
    for (link, way) in plant.links.iter().zip(&places.ways) {
        let label = label(link);
        let key = (link.from.0, link.to.0, label.clone());
        let Some((x, y)) = way.last().filter(|_| !seen.contains(&key)) else {
            continue;
        };
        seen.push(key);
        let wide = width_of(&label, SMALL);
        let corner = (x - 5.0 - wide, y - 8.6);
        // A link below the label would cross it.
        shapes.push(filled(corner, (wide, SMALL + 1.2), (255, 255, 255)));
        let (colour, _) = look(link.stage.shown);
        shapes.push(text((x - 5.0, y - 3.4), &label, SMALL, Anchor::End, colour));
    }
    shapes
}

fn look(shown: ShownAs) -> (Colour, &'static [f64]) {
    match shown {
        ShownAs::Local | ShownAs::Interpolated => (GOOD, &[]),
        ShownAs::Extrapolated => (BAD, &[]),
        ShownAs::Now => (NOW, &[]),
        ShownAs::AsReceived | ShownAs::Unknown => (GREY, &[3.0, 2.0]),
    }
}

fn legend(y: f64) -> Vec<Shape> {
    let mut x = LEFT;
    let mut shapes = Vec::new();
    for (shown, words) in LOOKS {
        let (colour, dashes) = look(shown);
        shapes.push(Shape::Line {
            points: vec![(x, y - 2.0), (x + 14.0, y - 2.0)],
            colour,
            width: 1.4,
            dashes,
        });
        shapes.push(text((x + 17.0, y), words, SMALL + 0.4, Anchor::Start, GREY));
        x += 17.0 + width_of(words, SMALL + 0.4) + 10.0;
    }
    shapes
}

/// Lines below the picture: proposals, then notes, then contradictions.
fn remarks(plant: &PlantAnalysis) -> Vec<(String, Colour)> {
    let proposals = plant.proposals.iter().filter_map(proposed);
    let notes = plant.notes.iter().map(|note| (note.to_string(), NOW));
    let findings = plant
        .findings
        .iter()
        .map(|finding| (finding.to_string(), BAD));
    proposals
        .map(|line| (line, BLACK))
        .chain(notes)
        .chain(findings)
        .collect()
}

fn proposed(proposal: &Proposal) -> Option<String> {
    let delay = short(proposal.present_after_ms?);
    let (node, axes) = (&proposal.node, proposal.axes.join(", "));
    let stated = match proposal.stated_ms {
        0.0 => "none is stated".to_owned(),
        stated => format!("{} is stated", short(stated)),
    };
    Some(format!(
        "{node} ({axes}): present-after-ms = {delay} would do; {stated}"
    ))
}

/// Breaks a line where it is too long, at spaces.
fn wrapped(line: &str, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in line.split(' ') {
        let last = lines.len() - 1;
        let with = match lines[last].is_empty() {
            true => word.to_owned(),
            false => format!("{} {word}", lines[last]),
        };
        match width_of(&with, SMALL + 0.6) > width && !lines[last].is_empty() {
            true => lines.push(word.to_owned()),
            false => lines[last] = with,
        }
    }
    lines
}

/// As many letters as there is room for.
fn fitting(text: &str, width: f64) -> String {
    if width_of(text, SIZE) <= width + 8.0 {
        return text.to_owned();
    }
    let room = (width / width_of("x", SIZE)) as usize;
    let short: String = text.chars().take(room.saturating_sub(1)).collect();
    format!("{}…", short.trim_end())
}

/// A curve through points that leaves and arrives level: cubic Béziers, as drawn lines.
fn curve(points: &[Point]) -> Vec<Point> {
    /// Pieces of a curve: 16 are smooth on a screen.
    const PIECES: usize = 16;
    let mut all = Vec::new();
    for pair in points.windows(2) {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        // A link that leads back needs room to turn.
        let reach = ((x1 - x0).abs() / 2.0).max(24.0);
        for piece in 0..=PIECES {
            let t = piece as f64 / PIECES as f64;
            let u = 1.0 - t;
            // Bernstein polynomials of degree 3.
            let (a, b, c, d) = (u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t);
            let x = a * x0 + b * (x0 + reach) + c * (x1 - reach) + d * x1;
            all.push((x, (a + b) * y0 + (c + d) * y1));
        }
    }
    all
}

fn text(at: Point, text: &str, size: f64, anchor: Anchor, colour: Colour) -> Shape {
    Shape::Text {
        at,
        text: text.to_owned(),
        size,
        anchor,
        colour,
        is_upward: false,
    }
}

fn corners((x, y): Point, (width, height): (f64, f64)) -> Vec<Point> {
    vec![
        (x, y),
        (x + width, y),
        (x + width, y + height),
        (x, y + height),
    ]
}

fn filled(corner: Point, size: (f64, f64), colour: Colour) -> Shape {
    Shape::Area {
        points: corners(corner, size),
        colour,
        opacity: 1.0,
    }
}

fn outline(corner: Point, size: (f64, f64)) -> Shape {
    let mut points = corners(corner, size);
    points.push(corner);
    Shape::Line {
        points,
        colour: FRAME,
        width: 0.8,
        dashes: &[],
    }
}

fn dot(at: Point, colour: Colour) -> Shape {
    Shape::Dot {
        at,
        radius: 1.7,
        colour,
    }
}
