use super::*;
use crate::figure::{Across, Curve, Data, Look, Map, Panel};

fn figure() -> Figure {
    let sine = |n: i32| (f64::from(n), 100.0 * (0.1 * f64::from(n)).sin());
    let curve = |name: &str, look| Curve {
        look,
        ..Curve::new(name, "#d9541e", Data::Points((0..100).map(sine).collect()))
    };
    let panel = |quantity: &str| Panel {
        title: "<b> – none".to_owned(),
        quantity: quantity.to_owned(),
        unit: "µm".to_owned(),
        marks: vec![30.0],
        curves: vec![curve("a & b", Look::Solid), curve("steps", Look::Steps)],
        ..Panel::default()
    };
    Figure {
        id: "x".to_owned(),
        title: "A figure".to_owned(),
        caption: String::new(),
        across: Across::run(),
        panels: vec![panel("length"), panel("width")],
        is_on_one_scale: true,
    }
}

#[test]
fn a_pdf_is_one_page_of_a_column_with_text_and_paths() {
    let [_, pdf] = files_of(&figure(), COLUMN_MM);
    let text = String::from_utf8_lossy(&pdf);
    assert!(text.starts_with("%PDF-1.") && text.trim_end().ends_with("%%EOF"));
    assert_eq!(text.matches("/Type /Page\n").count(), 1, "{text}");
    assert!(text.contains("/Count 1"));
    // 85 mm.
    assert!(text.contains("/MediaBox [0 0 240.9"), "{text}");
    assert!(text.contains("(a & b) Tj") && text.contains("(time (s)) Tj"));
    let strokes = text.lines().filter(|line| *line == "S").count();
    assert!(strokes > 10, "{strokes} strokes");
    // The offset by which a reader finds the objects is right.
    let from = text.rfind("startxref").unwrap();
    let offset: usize = text[from..].lines().nth(1).unwrap().parse().unwrap();
    assert!(pdf[offset..].starts_with(b"xref"));
}

#[test]
fn an_svg_is_whole_and_as_wide_as_a_column() {
    let [svg, _] = files_of(&figure(), COLUMN_MM);
    let text = String::from_utf8(svg).unwrap();
    assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"));
    assert!(text.contains("width=\"85.00mm\""));
    assert!(text.contains("&lt;b&gt; – none") && text.contains("a &amp; b"));
    // Each element is closed, and no text is markup.
    for line in text.lines().skip(1) {
        let is_closed =
            line.ends_with("/>") || line.ends_with("</text>") || line.contains("</title>");
        assert!(is_closed || line == "</svg>", "{line}");
    }
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

fn picture_of(points: Vec<(f64, f64)>, look: Look) -> String {
    let mut figure = figure();
    figure.panels.truncate(1);
    figure.panels[0].curves = vec![Curve {
        look,
        ..Curve::new("a", "#d9541e", Data::Points(points))
    }];
    svg(&figure)
}

#[test]
fn a_spike_of_a_single_cycle_is_drawn_and_few_points_are_written() {
    let value = |n: i32| if n == 777_777 { 1e3 } else { 1.0 };
    let points = (0..1_000_000).map(|n| (f64::from(n), value(n)));
    let text = picture_of(points.collect(), Look::Solid);
    // 764 columns of at most four points, each of some thirteen characters, are 40 kB.
    assert!(text.len() < 100_000, "{} bytes", text.len());
    let heights = |line: &str| -> Vec<f64> {
        let (_, points) = line.split_once("points=\"").unwrap();
        let points = points.trim_end_matches("\"/>").split_whitespace();
        let heights = points.filter_map(|point| point.split_once(',')?.1.parse().ok());
        heights.collect()
    };
    let curve = text
        .lines()
        .find(|line| line.contains("stroke=\"#d9541e\""));
    let heights = heights(curve.unwrap());
    let top = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let at_top = heights.iter().filter(|height| **height < top + 1.0);
    assert_eq!(at_top.count(), 1);
}

#[test]
fn what_is_unknown_single_or_constant_is_drawn_without_numbers_that_are_none() {
    for (points, look, dots) in [
        (vec![], Look::Dots, 0),
        (vec![(0.0, f64::NAN), (1.0, f64::INFINITY)], Look::Solid, 0),
        (vec![(3.0, 5.0)], Look::Dots, 1),
        // One is in the legend.
        (vec![(3.0, 5.0), (4.0, 5.0)], Look::Marks, 3),
        // Beyond any range that is a number: both are drawn at an edge.
        (vec![(-1e308, 5.0), (1e308, f64::MAX)], Look::Dots, 2),
    ] {
        let text = picture_of(points.clone(), look);
        assert!(!text.contains("NaN") && !text.contains("inf"), "{points:?}");
        assert_eq!(text.matches("<circle").count(), dots, "{points:?}");
    }
}

#[test]
fn dots_and_a_spread_are_in_both_files() {
    let mut figure = figure();
    figure.panels.truncate(1);
    figure.panels[0].curves = vec![Curve {
        look: Look::Dots,
        spread: vec![(0.0, 2.0), (1.0, 3.0), (f64::NAN, f64::NAN), (1.0, 1.5)],
        ..Curve::new(
            "a",
            "#d9541e",
            Data::Points(vec![(0.0, 1.0), (1.0, 2.0), (2.0, f64::NAN), (3.0, 1.0)]),
        )
    }];
    let [svg, pdf] = files_of(&figure, COLUMN_MM);
    let svg = String::from_utf8(svg).unwrap();
    assert_eq!(svg.matches("<circle").count(), 3);
    // One band: the last point stands alone.
    assert_eq!(svg.matches("<polygon").count(), 1);
    let pdf = String::from_utf8_lossy(&pdf);
    assert_eq!(
        pdf.lines().filter(|line| line.ends_with(" c")).count(),
        // A dot is a circle of four curves.
        3 * 4
    );
    assert!(pdf.contains("/B gs"));
}

#[test]
fn maps_have_a_cell_for_each_value_and_their_numbers_where_they_fit() {
    let words = |count: usize| (0..count).map(|n| n.to_string()).collect::<Vec<_>>();
    let maps = |columns: usize, rows: usize| Maps {
        title: "<b>".to_owned(),
        across: ("a & b".to_owned(), words(columns)),
        up: ("up".to_owned(), words(rows)),
        maps: vec![Map {
            cells: (0..columns * rows)
                .map(|n| (n > 0).then_some(n as f64))
                .collect(),
            ..Map::default()
        }],
        ..Maps::default()
    };
    let cells = |text: &str| text.matches("<polygon").count();
    // The first cell of each map is unknown, so a map of two has one.
    let bar = cells(&svg_of_maps(&maps(2, 1))) - 1;
    let text = svg_of_maps(&maps(4, 3));
    assert_eq!(cells(&text) - bar, 11, "the first is not known");
    assert!(text.contains(">11.0</text>") && text.contains("a &amp; b"));
    assert!(!text.contains("NaN") && text.contains("&lt;b&gt;"));
    let many = svg_of_maps(&maps(100, 50));
    assert!(!many.contains(">11.0</text>"));
    assert!(!svg_of_maps(&Maps::default()).contains("NaN"));
}
