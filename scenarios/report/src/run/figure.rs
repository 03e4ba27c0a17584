//! A figure of a run, however it is drawn: panels one above the other over one axis.

use crate::plotting::NEUTRAL;
use coaxle_lab::curves::{Series, Stretch, joined};

/// A figure with its words.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    /// Name within the page, and of files.
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    /// What to look at.
    pub(super) caption: &'static str,
    pub(super) across: Across,
    /// From the top.
    pub(super) panels: Vec<Panel>,
    /// Whether the panels have the same scale.
    pub(super) is_on_one_scale: bool,
}

/// What lies from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Across {
    /// The time of the run, s.
    Run,
    /// The time from the beat, ms.
    Beat,
}

impl Across {
    pub(super) const fn unit(self) -> &'static str {
        match self {
            Self::Run => "s",
            Self::Beat => "ms",
        }
    }

    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::Run => "time",
            Self::Beat => "time from the beat",
        }
    }
}

/// Curves over one vertical axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Panel {
    /// What is above it; empty: nothing.
    pub(super) title: String,
    /// What the curves are of; empty if the figure's title says it.
    pub(super) quantity: &'static str,
    pub(super) unit: String,
    /// Pixels in a browser.
    pub(super) height: usize,
    /// Values that have words; empty: they are numbers.
    pub(super) words: &'static [&'static str],
    /// Places to point out.
    pub(super) marks: Vec<f64>,
    pub(super) curves: Vec<Curve>,
}

/// A curve.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub(super) name: String,
    /// Curves of a group are one in the legend, and hidden together.
    pub(super) group: String,
    pub(super) colour: String,
    pub(super) look: Look,
    /// What was before, while it locked in, does not decide the range that the figure begins with.
    pub(super) settled_from: f64,
    pub(super) data: Data,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    Solid,
    Dotted,
    Dashed,
    /// A value holds until the next one.
    Steps,
    /// Points, joined by a line.
    Dots,
}

impl Look {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::Dotted => "dotted",
            Self::Dashed => "dashed",
            Self::Steps => "steps",
            Self::Dots => "dots",
        }
    }
}

/// What a curve goes through.
#[derive(Clone, Debug)]
pub(super) enum Data {
    /// Points; one that is not finite is a gap.
    Points(Vec<(f64, f64)>),
    /// Extremes of stretches of time, and every cycle of some windows.
    Levels {
        stretches: Vec<Stretch>,
        windows: Vec<Vec<(f64, f64)>>,
    },
}

impl Figure {
    /// Whether there is anything to draw.
    pub(super) fn is_empty(&self) -> bool {
        self.curves().all(|curve| curve.data.is_empty())
    }

    pub(super) fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.panels.iter().flat_map(|panel| &panel.curves)
    }

    /// The range that each panel begins with; none of words.
    pub(super) fn ranges(&self) -> Vec<Option<(f64, f64)>> {
        let of = |panels: &[Panel]| {
            let curves = panels.iter().filter(|panel| panel.words.is_empty());
            usual_range(
                curves
                    .flat_map(|panel| &panel.curves)
                    .flat_map(|c| c.data.values_from(c.settled_from)),
            )
        };
        if self.is_on_one_scale {
            return vec![of(&self.panels); self.panels.len()];
        }
        let each = self.panels.iter().map(std::slice::from_ref);
        each.map(of).collect()
    }
}

impl Curve {
    /// A solid line that is a group of its own.
    pub(super) fn new(name: &str, colour: &str, data: Data) -> Self {
        Self {
            name: name.to_owned(),
            group: name.to_owned(),
            colour: colour.to_owned(),
            look: Look::Solid,
            settled_from: f64::NEG_INFINITY,
            data,
        }
    }

    /// A level from one time to another.
    pub(super) fn level(name: &str, value: f64, from: f64, to: f64) -> Self {
        Self {
            look: Look::Dashed,
            ..Self::new(
                name,
                NEUTRAL,
                Data::Points(vec![(from, value), (to, value)]),
            )
        }
    }
}

impl Data {
    /// A series of at most so many stretches, neighbours joined, and its first windows; shifted by an offset.
    pub(super) fn of(series: &Series, room: Room, offset: f64) -> Self {
        let per_group = series.stretches.len().div_ceil(room.stretches.max(1));
        let groups = series.stretches.chunks(per_group.max(1));
        let shifted = |stretch: Stretch| Stretch {
            low: stretch.low + offset,
            high: stretch.high + offset,
            ..stretch
        };
        let windows = series.windows.iter().take(room.windows);
        let cycles = |window: &Vec<(f64, f64)>| {
            let cycles = window.iter();
            cycles.map(|(t, value)| (*t, value + offset)).collect()
        };
        Self::Levels {
            stretches: groups.filter_map(joined).map(shifted).collect(),
            windows: windows.map(cycles).collect(),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        match self {
            Self::Points(points) => points.is_empty(),
            Self::Levels { stretches, .. } => stretches.is_empty(),
        }
    }

    fn values_from(&self, from: f64) -> Vec<f64> {
        match self {
            Self::Points(points) => {
                let points = points.iter().filter(|(at, _)| *at >= from);
                points.map(|(_, value)| *value).collect()
            }
            Self::Levels { stretches, .. } => {
                let stretches = stretches.iter().filter(|stretch| stretch.t_s >= from);
                stretches.flat_map(|s| [s.low, s.high]).collect()
            }
        }
    }
}

/// How much of each series a report has room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Room {
    pub(super) stretches: usize,
    pub(super) windows: usize,
}

impl Room {
    /// Stretches in all curves together, and cycles.
    const MOST_STRETCHES: usize = 60_000;
    const MOST_CYCLES: usize = 260_000;

    /// Shared out among all these. Windows are the same ones of each, the first ones.
    pub(super) fn shared_by<'a>(all: impl Iterator<Item = &'a Series> + Clone) -> Self {
        let known = all.clone().filter(|series| !series.stretches.is_empty());
        let stretches = Self::MOST_STRETCHES / known.count().max(1);
        let most = all.clone().map(|series| series.windows.len()).max();
        let mut cycles = 0;
        let fits = |window: &usize| {
            let lengths = all.clone().filter_map(|series| series.windows.get(*window));
            cycles += lengths.map(Vec::len).sum::<usize>();
            cycles <= Self::MOST_CYCLES
        };
        Self {
            stretches: stretches.clamp(200, 4_000),
            windows: (0..most.unwrap_or(0)).take_while(fits).count(),
        }
    }
}

/// A range that shows all of these values, but for rare ones far beyond the others: a single jump
/// at the start must not flatten everything else. A beat's spike is not that far away.
fn usual_range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    if values.is_empty() {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    let usual_low = values[last / 50];
    let usual_high = values[last - last / 50];
    let reach = 2.0 * usual_low.abs().max(usual_high.abs());
    let (low, high) = if reach > 0.0 {
        (
            values[0].max(usual_low - reach),
            values[last].min(usual_high + reach),
        )
    } else {
        (values[0], values[last])
    };
    // What is constant must not look wild.
    let margin = (0.08 * (high - low)).max(5e-3 * high.abs()).max(1e-9);
    Some((low - margin, high + margin))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joining_keeps_the_extremes() {
        let mut series = Series::default();
        for k in 0..1_000 {
            let value = if k == 500 { 7.0 } else { 1.0 };
            series.push(f64::from(k), Some(value));
        }
        let room = Room {
            stretches: 90,
            windows: 0,
        };
        let Data::Levels { stretches, .. } = Data::of(&series, room, 1.0) else {
            panic!("no levels");
        };
        assert!(stretches.len() <= 90);
        assert_eq!(stretches.iter().filter(|s| s.high == 8.0).count(), 1);
        assert!(stretches.iter().all(|s| s.low == 2.0));
    }

    #[test]
    fn many_curves_share_the_room() {
        let mut series = Series::default();
        series.keep(0.0, 999.0);
        (0..1_500).for_each(|k| series.push(f64::from(k), Some(1.0)));
        series.keep(2_000.0, 2_999.0);
        (1_500..5_000).for_each(|k| series.push(f64::from(k), Some(1.0)));
        let alone = Room::shared_by([&series].into_iter());
        assert_eq!((alone.stretches, alone.windows), (4_000, 2));
        let many = vec![&series; 200];
        let shared = Room::shared_by(many.into_iter());
        assert_eq!((shared.stretches, shared.windows), (300, 1));
    }

    #[test]
    fn how_it_locks_in_does_not_decide_the_range() {
        let points = (0..20).map(|s| (f64::from(s), if s < 5 { -1_000.0 } else { 1.0 }));
        let curve = Curve {
            settled_from: 5.0,
            ..Curve::new("saw", NEUTRAL, Data::Points(points.collect()))
        };
        let figure = |curve| Figure {
            id: "",
            title: "",
            caption: "",
            across: Across::Run,
            panels: vec![Panel {
                curves: vec![curve],
                ..Panel::default()
            }],
            is_on_one_scale: false,
        };
        let low = |curve| figure(curve).ranges()[0].map(|(low, _)| low);
        assert!(low(curve.clone()).is_some_and(|low| low > 0.9));
        let settled_from = f64::NEG_INFINITY;
        let of_all = Curve {
            settled_from,
            ..curve
        };
        assert!(low(of_all).is_some_and(|low| low < -900.0));
    }

    #[test]
    fn a_range_shows_beats_but_not_a_leap() {
        let mut values = vec![500.0; 998];
        values.push(0.0);
        values.push(1e9);
        let (low, high) = usual_range(values.into_iter()).unwrap();
        assert!(low < 0.0 && low > -200.0, "{low}");
        assert!(high > 1000.0 && high < 2000.0, "{high}");
        assert_eq!(usual_range([f64::NAN].into_iter()), None);
    }
}
