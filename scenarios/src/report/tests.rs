use std::collections::BTreeMap;

use coaxle_receiver::StateName;
use serde_json::Value;

use coaxle_node::config::Unit;

use super::*;
use crate::summary::{Cut, ReceiverSummary, SlaveSummary};

const NASTY: &str = "</script><script>alert('x')</script>";

fn summary() -> Summary {
    let receiver = |mode, ripple| ReceiverSummary {
        mode,
        velocity_ripple_ratio: ripple,
        drift_ppm_true: Some(100.0),
        evaluated_from_s: Some(2.0),
        time_to_sync_s: Some(2.0),
        ..ReceiverSummary::default()
    };
    Summary {
        scenario: "beat".to_owned(),
        title: format!("Beats {NASTY}"),
        world: World::Virtual,
        seed: 7,
        duration_s: 10.0,
        interrupted_at_s: None,
        receivers: BTreeMap::from([
            ("bare".to_owned(), receiver("bypass", Some(1.0))),
            (NASTY.to_owned(), receiver("sync", Some(0.01))),
        ]),
        expectations: vec![Verdict {
            receiver: NASTY.to_owned(),
            slave: None,
            field: "beats".to_owned(),
            expected: format!("\"{NASTY}\""),
            received: Value::Null,
            met: false,
        }],
    }
}

fn mm() -> Unit {
    Unit::new("mm").unwrap()
}

fn curves() -> Vec<Curves> {
    let mut bare = Curves::new("bare", "bypass", mm(), [("slave", mm())]);
    let mut cured = Curves::new(NASTY, "sync", mm(), [("slave", mm())]);
    for k in 0..10_000 {
        let t = f64::from(k) * 1e-3;
        let beat = k % 2_000 == 0;
        bare.set_velocity
            .push(t, Some(if beat { 0.0 } else { 500.0 }));
        bare.drive_velocity.push(t, Some(500.0));
        cured
            .set_velocity
            .push(t, Some(if k == 5 { f64::NAN } else { 500.0 }));
        cured.correction_us.push(t, None);
        cured.drift_ppm.push(t, Some(f64::INFINITY));
    }
    cured.states = vec![
        (0.0, None),
        (0.1, Some(StateName::Bypass)),
        (2.0, Some(StateName::Sync)),
    ];
    vec![cured, bare]
}

fn page_of(summary: &Summary, curves: &[Curves]) -> String {
    let report = Report {
        summary,
        scenario_toml: &format!("title = \"{NASTY}\"\ndescription = \"{NASTY}\"\n"),
        curves,
        command: NASTY,
    };
    page(&summary.title, &body(&report), "")
}

/// The figures of a page by their name, as a browser would read them.
fn figures_of(page: &str) -> BTreeMap<String, Value> {
    let mut figures = BTreeMap::new();
    for part in page
        .split("<script type=\"application/json\" id=\"")
        .skip(1)
    {
        let (id, rest) = part.split_once("\">").unwrap();
        let (json, _) = rest.split_once(SCRIPT_END).unwrap();
        figures.insert(id.to_owned(), serde_json::from_str(json).unwrap());
    }
    figures
}

#[test]
fn nothing_from_the_scenario_becomes_markup() {
    let page = page_of(&summary(), &curves());
    assert!(!page.contains("alert('x')"), "unescaped text");
    // The plots that have data, and the page's own script.
    let figures = figures_of(&page);
    let drawn: Vec<_> = figures.keys().map(String::as_str).collect();
    assert_eq!(drawn, ["state-figure", "velocity-figure"]);
    assert_eq!(page.matches(SCRIPT_END).count(), drawn.len() + 1);
    assert!(page.contains("✗ failed"));
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    assert_eq!(
        page_of(&summary(), &curves()),
        page_of(&summary(), &curves())
    );
}

#[test]
fn velocities_share_one_scale_and_those_without_correction_come_first() {
    let figures = figures_of(&page_of(&summary(), &curves()));
    let layout = &figures["velocity-figure"]["layout"];
    assert_eq!(layout["yaxis"]["range"], layout["yaxis2"]["range"]);
    assert_eq!(layout["yaxis2"]["matches"], "y");
    assert!(
        layout["annotations"][0]["text"]
            .as_str()
            .unwrap()
            .contains("bare")
    );
    let low = layout["yaxis"]["range"][0].as_f64().unwrap();
    assert!(
        low < 0.0,
        "the beat at zero must be seen, the axis ends at {low}"
    );
}

#[test]
fn cuts_and_several_slaves_are_drawn_where_there_are_any() {
    let cut = |number: u64, length_error| Cut {
        number,
        t_s: number as f64,
        position: Some(1e3 * number as f64),
        mark: Some(number),
        position_error: Some(0.1),
        length_error,
    };
    let mut summary = summary();
    let receiver = summary.receivers.get_mut("bare").unwrap();
    let mut slave = SlaveSummary::default();
    slave.cuts.cuts = 2;
    slave.cuts.cut_unit = mm();
    slave.cuts.cut_list = vec![cut(1, None), cut(2, Some(-0.4))];
    receiver.slaves.insert("saw".to_owned(), slave);
    let mut curves = curves();
    let mut two = Curves::new("bare", "bypass", mm(), [("saw", mm()), ("tool", mm())]);
    two.slaves[1].position.push(0.0, Some(1.0));
    curves[1] = two;
    let figures = figures_of(&page_of(&summary, &curves));
    let cuts = figures["cuts-figure"]["data"].as_array().unwrap();
    assert_eq!(cuts.len(), 2, "lengths and positions");
    assert_eq!(cuts[0]["y"], serde_json::json!([-400]));
    let title = &figures["cuts-figure"]["layout"]["yaxis"]["title"]["text"];
    assert_eq!(title, "piece too long (µm)");
    let names: Vec<_> = figures["positions-figure"]["data"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|curve| curve["name"].as_str())
        .collect();
    assert!(names.contains(&"tool"), "{names:?}");
}

#[test]
fn no_curves_still_make_a_page() {
    let page = page_of(&summary(), &[]);
    assert!(figures_of(&page).is_empty());
    assert!(page.contains("anything to show here"));
}

#[test]
fn curves_without_a_summary_are_drawn() {
    let mut summary = summary();
    summary.receivers.clear();
    let figures = figures_of(&page_of(&summary, &curves()));
    assert!(figures.contains_key("velocity-figure"));
}

#[test]
fn the_page_loads_nothing() {
    let page = page_of(&summary(), &curves());
    for reference in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(reference), "{reference}");
    }
}

#[test]
fn the_plotting_library_is_one_script() {
    let script = plotting_script().unwrap();
    assert_eq!(script.matches(SCRIPT_END).count(), 1);
    assert!(script.starts_with("<script") && script.ends_with(SCRIPT_END));
    assert!(script.contains("plotly.js v"));
}
