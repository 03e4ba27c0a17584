//! Places of a run that are kept cycle by cycle, of all receivers together.

use coaxle_lab::curves::{CurveWindow, Curves};

/// A part of the run, and what happened there.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EventInterval {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    pub(super) words: String,
}

/// Returns the places in order; overlapping ones are joined.
pub(super) fn of(curves: &[Curves]) -> Vec<EventInterval> {
    let mut windows: Vec<&CurveWindow> = curves.iter().flat_map(|curves| &curves.windows).collect();
    windows.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    let mut places: Vec<EventInterval> = Vec::new();
    for window in windows {
        let words = window.what.words();
        match places.last_mut() {
            // Sorted by their beginnings, a window can only meet the last place.
            Some(last) if window.from_s <= last.to_s => {
                last.to_s = last.to_s.max(window.to_s);
                if !last.words.split(", ").any(|known| known == words) {
                    last.words = format!("{}, {words}", last.words);
                }
            }
            _ => places.push(EventInterval {
                // A window around the first message begins before the run.
                from_s: window.from_s.max(0.0),
                to_s: window.to_s,
                words: words.to_owned(),
            }),
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_lab::curves::WindowEvent;
    use coaxle_node::config::Unit;

    #[test]
    fn what_overlaps_is_one_place() {
        let window = |from_s, to_s, what| CurveWindow { from_s, to_s, what };
        let mut one = Curves::new("one", "sync", Unit::default(), 1e-3, []);
        let mut two = one.clone();
        one.windows = vec![
            window(-0.1, 0.5, WindowEvent::Start),
            window(2.0, 3.0, WindowEvent::Beat),
        ];
        two.windows = vec![
            window(2.1, 2.8, WindowEvent::Beat),
            window(2.5, 4.0, WindowEvent::Sync),
        ];
        let places = of(&[one, two]);
        let told: Vec<_> = places
            .iter()
            .map(|place| (place.from_s, place.to_s, place.words.as_str()))
            .collect();
        assert_eq!(
            told,
            [(0.0, 0.5, "first data"), (2.0, 4.0, "beat, lock-in")]
        );
    }
}
