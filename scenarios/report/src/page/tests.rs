use super::*;
use crate::figure::{Across, Curve, Data, Look, Map, Panel};

const NASTY: &str = "</script><script>alert('x')</script>";

fn figure() -> Figure {
    let curve = Curve {
        look: Look::Marks,
        labels: vec![NASTY.to_owned()],
        ..Curve::new(NASTY, "#000000", Data::Points(vec![(1.0, 2.0)]))
    };
    Figure {
        id: "figure".to_owned(),
        title: NASTY.to_owned(),
        caption: NASTY.to_owned(),
        across: Across::of(NASTY, NASTY),
        panels: vec![Panel {
            title: NASTY.to_owned(),
            quantity: NASTY.to_owned(),
            unit: NASTY.to_owned(),
            curves: vec![curve],
            ..Panel::default()
        }],
        is_on_one_scale: false,
    }
}

fn maps() -> Maps {
    let words = |n: usize| (NASTY.to_owned(), vec![NASTY.to_owned(); n]);
    Maps {
        id: "maps".to_owned(),
        title: NASTY.to_owned(),
        caption: NASTY.to_owned(),
        across: words(2),
        up: words(1),
        maps: vec![Map {
            title: NASTY.to_owned(),
            cells: vec![Some(1.0), None],
        }],
        left_out: 0,
    }
}

#[test]
fn no_name_becomes_markup_and_the_page_loads_nothing() {
    let body = figure_element(&figure()) + &maps_element(&maps());
    let page = document(NASTY, &body);
    assert!(!page.contains("<script>alert"), "unescaped text");
    // Two of JSON, of the figure and of the maps.
    assert_eq!(page.matches("</script>").count(), 2 + SCRIPTS.len());
    for reference in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert!(page.len() < 60_000, "{} bytes", page.len());
}

#[test]
fn a_course_of_many_places_is_short_and_comes_back_to_six_digits() {
    let sine = |n: usize| (0.12 * n as f64, 50.0 - 50.0 * (0.003 * n as f64).cos());
    let points: Vec<_> = (0..3_000).map(sine).collect();
    let mut figure = figure();
    let curve = Curve::new("course", "#000000", Data::Course(points.clone()));
    figure.panels[0].curves = vec![curve];
    let json = encoding::figure(&figure);
    assert!(
        // Places are regular, and take one character each as second differences. Three are left for each value.
        json.to_string().len() < 3_000 * 4,
        "{}",
        json.to_string().len()
    );
    let data = &json["panels"][0]["curves"][0]["data"];
    let numbers = |of: &str| {
        let step = data[of]["step"].as_f64().unwrap();
        untold(data[of]["value"].as_str().unwrap(), step)
    };
    for (point, (x, y)) in points.iter().zip(numbers("x").iter().zip(numbers("y"))) {
        // Steps of 1e-5 for ranges of 360 and 100: a ten-millionth, down to a power of ten.
        assert!((point.0 - x).abs() < 1e-4 && (point.1 - y).abs() < 1e-5);
    }
    let Data::Course(course) = &mut figure.panels[0].curves[0].data else {
        panic!("a course");
    };
    course[7].1 = f64::NAN;
    let json = encoding::figure(&figure);
    let values = &json["panels"][0]["curves"][0]["data"]["y"];
    assert!(values[7].is_null() && values[8].is_number());
}

#[test]
fn a_figure_of_nothing_is_a_page_too() {
    let mut figure = figure();
    figure.panels[0].curves[0].data = Data::Course(Vec::new());
    let json = encoding::figure(&figure);
    assert!(json["panels"][0]["range"].is_null());
    assert_eq!(json["extent"], serde_json::json!([0.0, 1.0]));
    let empty = maps::encoded(&Maps::default());
    assert!(empty["range"].is_null());
}
