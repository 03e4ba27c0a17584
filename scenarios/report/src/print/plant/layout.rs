//! Places of nodes and links: layers from the roots to the drives, left to right (Sugiyama, without a search for fewer
//! crossings beyond one sweep).

use coaxle_topology::{LinkSummary, PlantAnalysis};

use super::super::picture::{Point, SIZE, width_of};

/// Size of small letters, points.
pub(super) const SMALL: f64 = 5.6;
/// Room of a row of an axis, and of the head of a node.
pub(super) const ROW: f64 = 11.0;
pub(super) const HEAD: f64 = 24.0;
/// Room around the rows of a node.
pub(super) const PAD: f64 = 7.0;
/// Distance between two layers: a label of a link has room in it.
const GAP: f64 = 78.0;
/// Distance between two nodes of a layer.
const BETWEEN: f64 = 14.0;
/// Room of a link that passes a layer.
const LANE: f64 = 10.0;
/// Widths of a node.
const NARROW: f64 = 84.0;
const WIDE: f64 = 150.0;

/// Place of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NodeBox {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// Places of all nodes and links, within a size.
#[derive(Debug)]
pub(super) struct PlantPlaces {
    pub(super) boxes: Vec<NodeBox>,
    /// Points that each link passes, from its source to its target.
    pub(super) ways: Vec<Vec<Point>>,
    pub(super) size: (f64, f64),
}

/// A part of a layer: a node, or the lane of a link that passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LayerPart {
    Node(usize),
    Lane(usize),
}

impl NodeBox {
    /// Height at which the links of an axis end.
    pub(super) fn row(&self, axis: usize) -> f64 {
        self.top + HEAD + ROW * (axis as f64 + 0.5)
    }
}

/// Places everything, from this corner on.
///
/// `rows` are the lines of each node, `heads` those above them.
pub(super) fn layout(
    plant: &PlantAnalysis,
    rows: &[Vec<String>],
    heads: &[String],
    (left, top): Point,
) -> PlantPlaces {
    let layer = layers(plant);
    let count = layer.iter().max().map_or(0, |last| last + 1);
    let mut parts: Vec<Vec<LayerPart>> = vec![Vec::new(); count];
    for (node, layer) in layer.iter().enumerate() {
        parts[*layer].push(LayerPart::Node(node));
    }
    for (n, link) in plant.links.iter().enumerate() {
        // Along a link that leads back there is no lane.
        let passed = layer[link.from.0] + 1..layer[link.to.0];
        for part in parts.get_mut(passed).into_iter().flatten() {
            part.push(LayerPart::Lane(n));
        }
    }
    let lines = rows.iter().zip(heads);
    let widths: Vec<f64> = lines
        .map(|(rows, head)| width_of_node(rows, head))
        .collect();
    let columns = columns(&parts, &widths, left);
    let heights = |part: &LayerPart| match part {
        LayerPart::Node(node) => HEAD + ROW * rows[*node].len() as f64 + PAD,
        LayerPart::Lane(_) => LANE,
    };
    let tall = parts.iter().map(|parts| height(parts, heights));
    let tall = tall.fold(0.0, f64::max);
    let mut layout = PlantPlaces {
        boxes: vec![NodeBox::default(); plant.nodes.len()],
        ways: vec![Vec::new(); plant.links.len()],
        size: (columns.last().map_or(left, |last| last.1), top + tall),
    };
    for (place, parts) in parts.iter_mut().enumerate() {
        // Each part near those that lead to it: one sweep from the roots on.
        let centre = |part: &LayerPart| centre_of(plant, &layout, *part);
        let mut keyed: Vec<_> = parts.iter().map(|part| (centre(part), *part)).collect();
        keyed.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        *parts = keyed.into_iter().map(|(_, part)| part).collect();
        let mut y = top + (tall - height(parts, heights)) / 2.0;
        let (left, right) = columns[place];
        for part in parts {
            let high = heights(part);
            match part {
                LayerPart::Node(node) => {
                    layout.boxes[*node] = NodeBox {
                        left,
                        top: y,
                        width: widths[*node],
                        height: high,
                    };
                }
                LayerPart::Lane(link) => {
                    let middle = y + high / 2.0;
                    layout.ways[*link].extend([(left, middle), (right, middle)]);
                }
            }
            y += high + BETWEEN;
        }
    }
    for (way, link) in layout.ways.iter_mut().zip(&plant.links) {
        let [from, to] = [link.from, link.to].map(|(node, axis)| (layout.boxes[node], axis));
        way.insert(0, (from.0.left + from.0.width, from.0.row(from.1)));
        way.push((to.0.left, to.0.row(to.1)));
    }
    layout
}

/// Layer of each node: behind all that it follows. Of nodes that follow each other, the first given is in front.
fn layers(plant: &PlantAnalysis) -> Vec<usize> {
    let count = plant.nodes.len();
    let mut layer: Vec<Option<usize>> = vec![None; count];
    let leads = |to: usize| {
        let links = plant.links.iter();
        links.filter(move |link: &&LinkSummary| link.to.0 == to && link.from.0 != to)
    };
    for _ in 0..count {
        let open: Vec<usize> = (0..count).filter(|node| layer[*node].is_none()).collect();
        let free = |node: &&usize| leads(**node).all(|link| layer[link.from.0].is_some());
        // Without a free one they are a circle: it is opened at the first.
        let Some(next) = open.iter().find(free).or(open.first()) else {
            break;
        };
        let before = leads(*next).filter_map(|link| layer[link.from.0]);
        layer[*next] = Some(before.max().map_or(0, |layer| layer + 1));
    }
    layer.into_iter().map(Option::unwrap_or_default).collect()
}

/// Left and right of each layer.
fn columns(parts: &[Vec<LayerPart>], widths: &[f64], left: f64) -> Vec<(f64, f64)> {
    let mut x = left;
    let mut columns = Vec::new();
    for parts in parts {
        let wide = parts.iter().map(|part| match part {
            LayerPart::Node(node) => widths[*node],
            LayerPart::Lane(_) => 0.0,
        });
        let wide = wide.fold(0.0, f64::max);
        columns.push((x, x + wide));
        x += wide + GAP;
    }
    columns
}

fn height(parts: &[LayerPart], height: impl Fn(&LayerPart) -> f64) -> f64 {
    let all: f64 = parts.iter().map(height).sum();
    all + BETWEEN * parts.len().saturating_sub(1) as f64
}

/// The mean height of all links that lead to a part; zero for a root, which keeps its place.
fn centre_of(plant: &PlantAnalysis, layout: &PlantPlaces, part: LayerPart) -> f64 {
    let height = |n: usize| {
        let (node, axis) = plant.links[n].from;
        let source = layout.boxes[node];
        let lane = layout.ways[n].last().map(|point| point.1);
        // A source that has no place yet is of a circle.
        lane.or((source.width > 0.0).then(|| source.row(axis)))
    };
    let links: Vec<usize> = match part {
        LayerPart::Lane(link) => vec![link],
        LayerPart::Node(node) => {
            let links = plant.links.iter().enumerate();
            links
                .filter(|(_, link)| link.to.0 == node)
                .map(|(n, _)| n)
                .collect()
        }
    };
    let heights: Vec<f64> = links.into_iter().filter_map(height).collect();
    match heights.len() {
        0 => 0.0,
        count => heights.iter().sum::<f64>() / count as f64,
    }
}

fn width_of_node(rows: &[String], head: &str) -> f64 {
    let longest = rows.iter().map(|row| width_of(row, SIZE));
    let longest = longest.fold(width_of(head, SMALL), f64::max);
    (longest + 2.0 * PAD + 4.0).clamp(NARROW, WIDE)
}
