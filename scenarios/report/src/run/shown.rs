//! The receivers as plots show them.

use crate::plotting::{CHOSEN, colour};
use crate::table::{self, MODES};
use coaxle_lab::curves::Curves;

/// A receiver as plots show it.
#[derive(Clone, Debug)]
pub(super) struct ColouredCurves<'a> {
    pub(super) curves: &'a Curves,
    pub(super) colour: String,
}

impl ColouredCurves<'_> {
    pub(super) fn name(&self) -> &str {
        &self.curves.name
    }

    /// Returns the title of a panel of its own.
    pub(super) fn title(&self) -> String {
        let correction = match self.curves.mode {
            "bypass" => "without correction",
            mode => table::correction(mode),
        };
        format!("{} – {correction}", self.curves.name)
    }
}

/// Returns the receivers with a colour each, those without correction first; the first of each mode has the mode's own, in
/// every report.
pub(super) fn coloured(curves: &[Curves]) -> Vec<ColouredCurves<'_>> {
    let mut curves: Vec<_> = curves.iter().collect();
    // By name within a mode, so that equal runs give equal colours.
    curves.sort_by_key(|curves| (table::rank(curves.mode), curves.name.clone()));
    let mut taken = [false; MODES];
    let own: Vec<Option<usize>> = curves
        .iter()
        .map(|curves| {
            let own = usize::from(table::rank(curves.mode)).min(MODES - 1);
            (!std::mem::replace(&mut taken[own], true)).then_some(own)
        })
        .collect();
    // Colours of absent modes come late, so that a colour keeps its meaning as long as possible.
    let absent = (0..MODES).filter(|n| !taken[*n]);
    let mut free = (MODES..CHOSEN.len()).chain(absent).chain(CHOSEN.len()..);
    let all = curves.into_iter().zip(own);
    all.map(|(curves, own)| ColouredCurves {
        curves,
        colour: colour(own.or_else(|| free.next()).unwrap_or(0)),
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::Unit;

    fn curves(name: &str, mode: &'static str) -> Curves {
        let unit = Unit::default;
        Curves::new(name, mode, unit(), 1e-3, [("slave", unit())])
    }

    #[test]
    fn every_mode_keeps_its_colour_and_none_comes_twice() {
        let one = [curves("b", "sync")];
        let mut all = vec![curves("a", "bypass"), curves("b", "sync")];
        all.extend((0..40).map(|n| curves(&format!("c{n:02}"), "sync")));
        let (one, all) = (coloured(&one), coloured(&all));
        assert_eq!(one[0].colour, all[1].colour);
        let mut colours: Vec<_> = all.iter().map(|shown| &shown.colour).collect();
        colours.sort();
        colours.dedup();
        assert_eq!(colours.len(), 42);
    }
}
