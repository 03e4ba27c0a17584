use std::collections::BTreeMap;

use coaxle_receiver::FilterState;
use serde_json::Value;

use crate::page::untold;
use crate::reported::Presentation;
use coaxle_lab::stage::VirtualTime;
use coaxle_lab::summary::{Cut, ReceiverSummary, SlaveSummary};
use coaxle_lab::verdict::Verdict;
use coaxle_node::config::Unit;

use super::*;

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
        routers: BTreeMap::new(),
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
    let mut bare = Curves::new("bare", "bypass", mm(), 1e-3, [("slave", mm())]);
    let mut cured = Curves::new(NASTY, "sync", mm(), 1e-3, [("slave", mm())]);
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
        (0.1, Some(FilterState::Bypass)),
        (2.0, Some(FilterState::Sync)),
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
    super::page_of(&report)
}

/// Returns the figures of a page by their name, as a browser would read them.
fn figures_of(page: &str) -> BTreeMap<String, Value> {
    let mut figures = BTreeMap::new();
    for part in page
        .split("<script type=\"application/json\" id=\"")
        .skip(1)
    {
        let (id, rest) = part.split_once("\">").unwrap();
        let (json, _) = rest.split_once("</script>").unwrap();
        figures.insert(id.to_owned(), serde_json::from_str(json).unwrap());
    }
    figures
}

#[test]
fn nothing_from_the_scenario_becomes_markup() {
    let page = page_of(&summary(), &curves());
    for markup in [NASTY, "<script>alert", "</script>alert"] {
        assert!(!page.contains(markup), "unescaped text");
    }
    // The plots that have data, and the page's own scripts.
    let figures = figures_of(&page);
    let drawn: Vec<_> = figures.keys().map(String::as_str).collect();
    assert_eq!(drawn, ["state-figure", "velocity-figure"]);
    assert_eq!(
        page.matches("</script>").count(),
        drawn.len() + page_of(&summary(), &[]).matches("</script>").count()
    );
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
    let velocity = &figures["velocity-figure"];
    let panels = &velocity["panels"];
    assert_eq!(velocity["oneScale"], true);
    assert_eq!(panels[0]["range"], panels[1]["range"]);
    assert_eq!(panels[0]["title"], "bare – without correction");
    let low = panels[0]["range"][0].as_f64().unwrap();
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
    let mut two = Curves::new(
        "bare",
        "bypass",
        mm(),
        1e-3,
        [("saw", mm()), ("tool", mm())],
    );
    two.slaves[1].position.push(0.0, Some(1.0));
    curves[1] = two;
    let figures = figures_of(&page_of(&summary, &curves));
    let cuts = figures["cuts-figure"]["panels"].as_array().unwrap();
    assert_eq!(cuts.len(), 2, "lengths and positions");
    // -0.4 mm in micrometres.
    assert_eq!(cuts[0]["curves"][0]["data"]["y"], serde_json::json!([-400]));
    assert_eq!(
        (cuts[0]["quantity"].as_str(), cuts[0]["unit"].as_str()),
        (Some("piece too long"), Some("µm"))
    );
    let panels = figures["positions-figure"]["panels"].as_array().unwrap();
    let names: Vec<_> = panels
        .iter()
        .flat_map(|panel| panel["curves"].as_array().unwrap())
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

/// Returns the lowest and the highest value of a curve of a page between two times, from all its data.
fn extremes(data: &Value, from: f64, to: f64) -> (f64, f64) {
    let step = |of: &Value| of["step"].as_f64().unwrap();
    let numbers = |of: &Value, key: &str| untold(of[key].as_str().unwrap(), step(of));
    let stretches = &data["stretches"];
    let lows = numbers(stretches, "low");
    let heights = numbers(stretches, "height");
    let [first, each] = [0, 1].map(|n| stretches["t"][n].as_f64().unwrap());
    let mut all = (f64::INFINITY, f64::NEG_INFINITY);
    for (n, (low, height)) in lows.iter().zip(heights).enumerate() {
        let start = first + n as f64 * each;
        if start < to && start + each > from {
            all = (all.0.min(*low), all.1.max(low + height));
        }
    }
    all
}

#[test]
fn a_spike_of_a_single_cycle_is_seen_at_every_zoom() {
    let mut curves = curves();
    let spike = 123_456;
    let mut drive = Curves::new("bare", "bypass", mm(), 1e-3, [("slave", mm())]);
    for k in 0..200_000 {
        let velocity = if k == spike { -37.0 } else { 500.0 };
        drive.set_velocity.push(f64::from(k) * 1e-3, Some(velocity));
        if k == spike + 100 {
            drive.keep(123.0, 124.0);
        }
    }
    curves[1] = drive;
    let figures = figures_of(&page_of(&summary(), &curves));
    let data = &figures["velocity-figure"]["panels"][0]["curves"][0]["data"];
    let at = f64::from(spike) * 1e-3;
    for span in [200.0, 20.0, 1.0, 0.05, 0.001] {
        let (low, high) = extremes(data, at - span / 2.0, at + span / 2.0);
        assert!(
            // The range of 537 has steps of 0.1 at worst, a four-thousandth down to a power of ten. Low and height are rounded each.
            (low + 37.0).abs() < 0.2 && (high - 500.0).abs() < 0.2,
            "{span}: {low} {high}"
        );
    }
    let cycles = &data["windows"][0];
    let step = cycles["step"].as_f64().unwrap();
    let values = untold(cycles["value"].as_str().unwrap(), step);
    // From 123 to 124 s, both ends included.
    assert_eq!(values.len(), 1_001);
    assert_eq!(values.iter().filter(|value| **value < 499.0).count(), 1);
    assert!((values[456] + 37.0).abs() < 0.01, "{}", values[456]);
}

/// Returns a report of a built-in scenario.
fn report_of(name: &str, duration_s: &str) -> String {
    let scratch = tempfile::tempdir().unwrap();
    let source = coaxle_lab::catalog::find(name).unwrap();
    let options = coaxle_lab::run::Options {
        seed: None,
        overrides: vec![format!("duration-s={duration_s}")],
        receivers: Vec::new(),
        out: scratch.path().to_owned(),
        trace: None,
    };
    let scenario = coaxle_lab::run::prepare(&source, &options).unwrap();
    let outcome = crate::reported::run(
        name,
        &scenario,
        &options,
        &Presentation::default(),
        &VirtualTime,
        &mut (),
    )
    .unwrap();
    std::fs::read_to_string(outcome.report).unwrap()
}

#[test]
fn reports_are_small_and_compare_a_beat_without_correction_with_a_cured_one() {
    let page = report_of("observer", "30");
    // Bounds of docs/REPORTS.md: 2 MB with many axes, and less with few.
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
    let figures = figures_of(&page);
    let panels = figures["beat-figure"]["panels"].as_array().unwrap();
    let quantities: Vec<_> = panels.iter().map(|panel| &panel["quantity"]).collect();
    assert_eq!(quantities, ["position – truth", "velocity", "acceleration"]);
    let curves = panels[1]["curves"].as_array().unwrap();
    let groups: Vec<_> = curves.iter().map(|curve| &curve["group"]).collect();
    assert_eq!(groups, ["bypass", "observer"]);
    let mut places = page
        .lines()
        .filter(|line| line.starts_with("<button data-from"));
    assert!(
        places.any(|place| place.contains("lock-in")),
        "no place to zoom to"
    );
    let page = report_of("many-axes", "10");
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
}

#[test]
fn figures_once_settled_stand_apart_from_those_of_locking_in() {
    let mut summary = summary();
    let receiver = summary.receivers.get_mut(NASTY).unwrap();
    receiver.velocity_ripple_settled_max = Some(1.25);
    receiver.velocity_ripple_lock_in_max = Some(17.5);
    let page = page_of(&summary, &curves());
    let (_, apart) = page.split_once("<h3>Settled").unwrap();
    let (apart, _) = apart.split_once("</table>").unwrap();
    let place = |text: &str| {
        apart
            .find(text)
            .unwrap_or_else(|| panic!("{text}: {apart}"))
    };
    assert!(place(">settled</th>") < place(">locking in</th>"));
    assert!(place("<td>1.25</td>") < place("<td>17.5</td>"));
    assert!(!page.contains("… once settled"));
}

#[test]
fn figures_of_a_run_are_files() {
    let folder = tempfile::tempdir().unwrap();
    let (summary, curves) = (summary(), curves());
    let path = folder.path().join("figures");
    write_figures(&path, &summary, &curves, print::COLUMN_MM).unwrap();
    let names = std::fs::read_dir(&path).unwrap();
    let mut names: Vec<_> = names
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(
        names,
        ["state.pdf", "state.svg", "velocity.pdf", "velocity.svg"]
    );
}
