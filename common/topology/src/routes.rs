//! Routes from each root of a motion to each end of it.

use std::collections::BTreeMap;

use coaxle_clock::Span;

use crate::graph::{AxisGraph, AxisNumber};
use crate::plant::AxisOrigin;

/// Greatest number of routes: 128 roots and 128 slaves of one node, or a plant beyond what a table shows.
const MOST_ROUTES: usize = 16_384;

/// Way from a root to an end, over the axes between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct AxisRoute {
    /// The root, the axes between, the end.
    pub(crate) axes: Vec<AxisNumber>,
}

/// Routes, and the number of those left out.
pub(crate) struct AxisRoutes {
    pub(crate) found: Vec<AxisRoute>,
    pub(crate) left_out: usize,
}

/// Length of a route. A way without a known delay may be the longest of all.
type Length = (usize, Span, usize);

/// The longest route of several between a root and an axis, by the axis before.
#[derive(Clone, Copy)]
struct Longest {
    length: Length,
    before: Option<AxisNumber>,
}

/// Finds the routes: of several between a root and an end the longest one.
pub(crate) fn routes(graph: &AxisGraph<'_>) -> AxisRoutes {
    let mut by_root: Vec<BTreeMap<AxisNumber, Longest>> = vec![BTreeMap::new(); graph.count()];
    for axis in graph.order() {
        let mut own = BTreeMap::new();
        if let AxisOrigin::Root { .. } = graph.axis(*axis).origin {
            let length = (0, Span::ZERO, 0);
            own.insert(
                *axis,
                Longest {
                    length,
                    before: None,
                },
            );
        }
        for master in graph.masters(*axis) {
            for (root, longest) in &by_root[*master] {
                let length = longer(graph, *axis, longest.length);
                let known: Option<&Longest> = own.get(root);
                if known.is_none_or(|known| known.length < length) {
                    let before = Some(*master);
                    own.insert(*root, Longest { length, before });
                }
            }
        }
        by_root[*axis] = own;
    }
    let mut routes = AxisRoutes {
        found: Vec::new(),
        left_out: 0,
    };
    for end in (0..graph.count()).filter(|axis| is_end(graph, *axis)) {
        for root in by_root[end].keys() {
            if routes.found.len() >= MOST_ROUTES {
                routes.left_out += 1;
                continue;
            }
            let axes = back_to(*root, end, &by_root);
            routes.found.push(AxisRoute { axes });
        }
    }
    // Root by root, as a reader asks; ends keep the order of the files.
    routes
        .found
        .sort_by_key(|route| route.axes.first().copied());
    routes
}

fn longer(graph: &AxisGraph<'_>, axis: AxisNumber, (unknown, needed, count): Length) -> Length {
    match graph.far(axis).map(|_| graph.way(axis)) {
        None => (unknown, needed, count + 1),
        Some(None) => (unknown + 1, needed, count + 1),
        Some(Some(way)) => (unknown, needed + way.needed, count + 1),
    }
}

/// True for slaves, axes for a PLC, and axes that are followed but lead nothing.
fn is_end(graph: &AxisGraph<'_>, axis: AxisNumber) -> bool {
    match graph.axis(axis).origin {
        AxisOrigin::Root { .. } => false,
        AxisOrigin::Slave { .. } | AxisOrigin::Output(_) => true,
        AxisOrigin::Far(_) => graph.followers(axis).is_empty(),
    }
}

fn back_to(
    root: AxisNumber,
    end: AxisNumber,
    by_root: &[BTreeMap<AxisNumber, Longest>],
) -> Vec<AxisNumber> {
    let mut axes = vec![end];
    let mut at = end;
    while let Some(before) = by_root[at].get(&root).and_then(|longest| longest.before) {
        axes.push(before);
        at = before;
    }
    // Collected from the end.
    axes.reverse();
    axes
}
