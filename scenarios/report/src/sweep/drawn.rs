//! The plots of a sweep as figures: curves over one axis, maps over two.

use coaxle_lab::sweep::plot::{Along, Panel as Plotted, Plot};
use coaxle_lab::sweep::statistics::Statistics;

use crate::figure::{Across, Curve, Data, Figure, Look, Map, Maps, Panel, Scale, around};
use crate::plotting::colour;

/// A plot as it is drawn.
pub(super) enum SweepDrawing {
    /// A curve for each receiver or slave.
    Curves(Figure),
    /// A map for each receiver or slave.
    Maps(Maps),
}

/// Returns the n-th plot of a sweep.
pub(super) fn drawn(n: usize, plot: &Plot) -> SweepDrawing {
    match &plot.up {
        None => SweepDrawing::Curves(curves(n, plot)),
        Some(up) => SweepDrawing::Maps(maps(n, plot, up)),
    }
}

fn curves(n: usize, plot: &Plot) -> Figure {
    let cells = || plot.panels.iter().flat_map(|panel| panel.cells.iter());
    let ends = || cells().flatten().flat_map(|cell| [cell.low, cell.high]);
    let scale = Scale::suiting(ends());
    let places = plot.across.places();
    let curves = plot.panels.iter().enumerate();
    let curves = curves.map(|(n, panel)| curve(&colour(n), &places, panel));
    // The margin is a share of the places, so that it looks alike on a logarithmic scale.
    let range = around(ends().map(|end| scale.place(end)), 0.08);
    let panel = Panel {
        height: 420,
        range: range.map(|(low, high)| (scale.value(low), scale.value(high))),
        scale,
        curves: curves.collect(),
        ..Panel::default()
    };
    Figure {
        id: format!("figure-{n}"),
        title: plot.heading.clone(),
        caption: "The median of the seeds; the whiskers and the band between them are its 5 % and 95 % quantiles.".to_owned(),
        across: across(&plot.across),
        panels: vec![panel],
        is_on_one_scale: false,
    }
}

fn across(along: &Along) -> Across {
    Across {
        scale: match &along.numbers {
            Some(numbers) => Scale::suiting(numbers.iter().copied()),
            None => Scale::Words(along.values.clone()),
        },
        is_padded: true,
        ..Across::of(&along.field, "")
    }
}

/// Returns the curve of the medians; a gap where nothing is known.
fn curve(colour: &str, places: &[f64], panel: &Plotted) -> Curve {
    let of = |value: fn(&Statistics) -> f64| {
        let cells = panel.cells.iter();
        // Not a number is a gap. Without the place the others would move up.
        cells.map(move |cell| cell.as_ref().map_or(f64::NAN, value))
    };
    let medians = places.iter().copied().zip(of(|cell| cell.median));
    let ends = of(|cell| cell.low).zip(of(|cell| cell.high));
    Curve {
        look: Look::Dots,
        spread: ends.collect(),
        ..Curve::new(&panel.title, colour, Data::Points(medians.collect()))
    }
}

fn maps(n: usize, plot: &Plot, up: &Along) -> Maps {
    let caption = match plot.more {
        0 => "The median of the seeds.".to_owned(),
        more => format!("The median of the seeds. {more} more maps are left out."),
    };
    let map = |panel: &Plotted| Map {
        title: panel.title.clone(),
        cells: (panel.cells.iter())
            .map(|cell| cell.as_ref().map(|cell| cell.median))
            .collect(),
    };
    Maps {
        id: format!("figure-{n}"),
        title: plot.heading.clone(),
        caption,
        across: (plot.across.field.clone(), plot.across.values.clone()),
        up: (up.field.clone(), up.values.clone()),
        maps: plot.panels.iter().map(map).collect(),
        left_out: plot.more,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along(text: &str) -> Along {
        let axis: coaxle_lab::sweep::SweepAxis = text.parse().unwrap();
        Along::of(&axis)
    }

    fn plot(across: &str, up: Option<&str>, values: &[Option<f64>]) -> Plot {
        let cell = |median: f64| Statistics {
            known: 1,
            median,
            low: 0.5 * median,
            high: 2.0 * median,
            worst: median,
        };
        Plot {
            heading: "error [mm]".to_owned(),
            across: along(across),
            up: up.map(along),
            panels: vec![Plotted {
                title: "observer".to_owned(),
                cells: values.iter().map(|value| value.map(cell)).collect(),
            }],
            more: 3,
        }
    }

    #[test]
    fn a_curve_has_its_medians_their_spread_and_a_gap_where_nothing_is_known() {
        let plot = plot("a=1,2,4", None, &[Some(1.0), None, Some(3.0)]);
        let SweepDrawing::Curves(figure) = drawn(0, &plot) else {
            panic!("curves");
        };
        assert_eq!(figure.across.scale, Scale::Linear);
        let panel = &figure.panels[0];
        let Data::Points(points) = &panel.curves[0].data else {
            panic!("points");
        };
        assert_eq!(points[0], (1.0, 1.0));
        assert!(points[1].1.is_nan());
        assert_eq!(panel.curves[0].spread[2], (1.5, 6.0));
        let (low, high) = panel.range.unwrap();
        assert!(low < 0.5 && high > 6.0 && high < 7.0, "{low} {high}");
    }

    #[test]
    fn what_spans_decades_is_logarithmic_and_words_stand_beside_each_other() {
        let decades = plot("a=1,10,100", None, &[Some(1.0), Some(100.0), Some(1e4)]);
        let SweepDrawing::Curves(figure) = drawn(0, &decades) else {
            panic!("curves");
        };
        assert_eq!(figure.across.scale, Scale::Logarithmic);
        assert_eq!(figure.panels[0].scale, Scale::Logarithmic);
        let (low, high) = figure.panels[0].range.unwrap();
        assert!(low > 0.1 && low < 0.5 && high > 2e4, "{low} {high}");
        let words = plot("a=pt1,sync", None, &[Some(1.0), Some(1.0)]);
        let SweepDrawing::Curves(figure) = drawn(0, &words) else {
            panic!("curves");
        };
        assert_eq!(figure.across.scale.words(), ["pt1", "sync"]);
    }

    #[test]
    fn two_axes_are_maps_and_say_what_is_left_out() {
        let plot = plot("a=1,2", Some("b=3"), &[Some(1.0), None]);
        let SweepDrawing::Maps(maps) = drawn(1, &plot) else {
            panic!("maps");
        };
        assert_eq!(maps.maps[0].cells, [Some(1.0), None]);
        assert!(maps.caption.contains("3 more maps are left out"));
        assert_eq!(maps.id, "figure-1");
    }
}
