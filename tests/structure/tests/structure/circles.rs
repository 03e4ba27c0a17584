//! Circles between the modules of a crate.

use std::collections::{BTreeMap, BTreeSet};

use super::modules::{Crate, ModuleId};

/// Uses between sibling modules, including all modules below them.
type Uses = BTreeMap<ModuleId, BTreeSet<ModuleId>>;

/// Circles as lists of modules, in the order in which they use one another.
pub(crate) fn of(read: &Crate) -> Vec<String> {
    let mut levels = BTreeMap::<ModuleId, Uses>::new();
    // Uses are lifted to siblings below their common parent: a circle of deep modules is one of those.
    for user in read.modules() {
        for used in read.used_by(user) {
            if let Some((parent, user, used)) = side_by_side(read, user, used) {
                let uses = levels.entry(parent).or_default();
                uses.entry(user).or_default().insert(used);
            }
        }
    }
    let mut circles = Vec::new();
    for uses in levels.values() {
        for &start in uses.keys() {
            // A circle is listed once: from the module that comes first in it.
            let way = way_back(uses, start);
            circles.extend(
                way.filter(|way| way.iter().min() == Some(&start))
                    .map(|way| {
                        let names: Vec<_> = way.iter().map(|&module| read.name(module)).collect();
                        names.join(" -> ")
                    }),
            );
        }
    }
    circles
}

/// The common parent of two modules, and its children that they belong to; none where one is
/// above the other.
fn side_by_side(
    read: &Crate,
    user: ModuleId,
    used: ModuleId,
) -> Option<(ModuleId, ModuleId, ModuleId)> {
    let above: Vec<_> = read.lineage(user).collect();
    let mut child = None;
    for module in read.lineage(used) {
        if let Some(place) = above.iter().position(|&parent| parent == module) {
            // A place of 0 is the user itself, above the used one: no siblings.
            return Some((module, *above.get(place.checked_sub(1)?)?, child?));
        }
        child = Some(module);
    }
    None
}

/// The shortest way from a module back to itself.
fn way_back(uses: &Uses, start: ModuleId) -> Option<Vec<ModuleId>> {
    let mut ways = vec![vec![start]];
    let mut seen = BTreeSet::new();
    // Breadth first, so that the shortest circle is reported.
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            let last = way.last()?;
            for &next in uses.get(last).into_iter().flatten() {
                let mut way = way.clone();
                way.push(next);
                if next == start {
                    return Some(way);
                }
                // Each module once: a longer way to it closes no shorter circle.
                if seen.insert(next) {
                    longer.push(way);
                }
            }
        }
        ways = longer;
    }
    None
}
