use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use coaxle_lab::catalog;

use coaxle_lab::sweep::{Setup, prepare};

use super::*;

/// Returns a short scenario with two axes, a grid of four points.
fn setup(axes: &[&str]) -> Setup {
    let strings = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
    Setup {
        axes: axes.iter().map(|axis| axis.parse().unwrap()).collect(),
        overrides: strings(&["duration-s=3", "expect=[]"]),
        receivers: strings(&["observer"]),
        ..Setup::default()
    }
}

const DRIFT: &str = "sender.master.clock.drift-ppm=400,800";
const LOSS: &str = "network.loss=0.0,0.1";

fn prepared(setup: &Setup) -> Prepared {
    prepare(&catalog::find("observer-sweep").unwrap(), setup).unwrap()
}

fn options(out: &Path) -> Options {
    Options {
        out: out.to_owned(),
        ..Options::default()
    }
}

fn run(setup: &Setup, out: &Path) -> SweepOutcome {
    super::run(&prepared(setup), &options(out), "", &|_| true).unwrap()
}

/// Returns the rows of a file in CSV, by the names of its columns.
fn rows(path: &Path) -> Vec<std::collections::HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn seeds(count: usize) -> NonZeroUsize {
    NonZeroUsize::new(count).unwrap()
}

#[test]
fn every_point_seed_and_receiver_has_a_row_in_full() {
    let scratch = tempfile::tempdir().unwrap();
    let setup = Setup {
        seeds: seeds(3),
        ..setup(&[DRIFT, LOSS])
    };
    let outcome = run(&setup, scratch.path());
    // Two drifts, two losses and three seeds.
    assert_eq!((outcome.runs, outcome.points.len()), ((12, 12), 4));
    assert_eq!(outcome.table.lines().count(), 2 + 4);
    let points = rows(&scratch.path().join("points.csv"));
    let places: Vec<_> = (points.iter())
        .map(|row| {
            [
                &row["sender.master.clock.drift-ppm"],
                &row["network.loss"],
                &row["seed"],
            ]
        })
        .collect();
    assert_eq!(places.len(), 12);
    // The last axis runs fastest, and seeds within a point: the fifth row is the second seed of the second point.
    assert_eq!(places[4], ["400.0", "0.1", "2"]);
    let ripples: Vec<f64> = (points.iter())
        .map(|row| row["velocity_ripple_max [mm/s]"].parse().unwrap())
        .collect();
    let full = points
        .iter()
        // Full precision has 15 to 17 digits. Some numbers end earlier by chance.
        .filter(|row| row["velocity_ripple_max [mm/s]"].len() > 12);
    assert!(full.count() > 6, "{ripples:?}");
    let summary = rows(&scratch.path().join("summary.csv"));
    let of = |figure: &str| {
        let first = (summary.iter()).find(|row| row["figure"] == figure);
        first.unwrap()
    };
    let ripple = of("velocity_ripple_max");
    assert_eq!(
        (ripple["unit"].as_str(), ripple["known"].as_str()),
        ("mm/s", "3")
    );
    let mut first: Vec<f64> = ripples[..3].to_vec();
    first.sort_by(f64::total_cmp);
    assert_eq!(ripple["median"].parse::<f64>().unwrap(), first[1]);
    assert_eq!(ripple["worst"].parse::<f64>().unwrap(), first[2]);
    assert_eq!(of("synced_at_end")["worst"], "1.0");
}

#[test]
fn a_sweep_that_is_ended_goes_on_and_leaves_what_one_in_one_go_does() {
    let scratch = tempfile::tempdir().unwrap();
    let (ended, whole) = (scratch.path().join("ended"), scratch.path().join("whole"));
    let setup = setup(&[DRIFT, LOSS]);
    let until_one = |so_far: &SweepProgress| so_far.done < 1;
    let first = super::run(&prepared(&setup), &options(&ended), "", &until_one).unwrap();
    assert!(!first.is_whole() && first.runs.0 >= 1, "{:?}", first.runs);
    assert_eq!(rows(&ended.join("points.csv")).len(), first.runs.0);
    assert!(first.report.exists());

    let kept = AtomicUsize::new(0);
    let on_progress = |so_far: &SweepProgress| {
        kept.store(so_far.kept, Ordering::Relaxed);
        true
    };
    let second = super::run(&prepared(&setup), &options(&ended), "", &on_progress).unwrap();
    assert!(second.is_whole());
    assert_eq!(kept.into_inner(), first.runs.0);

    run(&setup, &whole);
    for file in [
        "points.csv",
        "points.parquet",
        "summary.csv",
        "plot.svg",
        "report.html",
    ] {
        let read = |folder: &Path| fs::read(folder.join(file)).unwrap();
        assert_eq!(read(&ended), read(&whole), "{file}");
    }
}

#[test]
fn a_larger_grid_takes_over_what_there_is_and_another_sweep_is_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let small = setup(&["network.loss=0.0"]);
    run(&small, scratch.path());
    let kept = AtomicUsize::new(0);
    let on_progress = |so_far: &SweepProgress| {
        kept.store(so_far.kept, Ordering::Relaxed);
        true
    };
    let larger = Setup {
        seeds: seeds(2),
        ..setup(&[LOSS])
    };
    let outcome = super::run(
        &prepared(&larger),
        &options(scratch.path()),
        "",
        &on_progress,
    )
    .unwrap();
    assert_eq!((outcome.runs, kept.into_inner()), ((4, 4), 1));
    let other = prepared(&setup(&[DRIFT]));
    let refused = super::run(&other, &options(scratch.path()), "", &|_| true).unwrap_err();
    let refused = refused.to_string();
    assert!(
        refused.contains("over the fields network.loss"),
        "{refused}"
    );
    let fresh = Options {
        is_fresh: true,
        ..options(scratch.path())
    };
    assert!(
        super::run(&other, &fresh, "", &|_| true)
            .unwrap()
            .is_whole()
    );
}

#[test]
fn expectations_are_judged_at_every_point() {
    let scratch = tempfile::tempdir().unwrap();
    let expected = "expect=[{ receiver = \"observer\", field = \"drift_ppm\", at-most = 500 }]";
    let setup = Setup {
        overrides: vec!["duration-s=3".to_owned(), expected.to_owned()],
        ..setup(&[DRIFT])
    };
    let outcome = run(&setup, scratch.path());
    let failed: Vec<_> = outcome.failed().collect();
    assert_eq!((outcome.points.len(), failed.len()), (2, 1));
    assert_eq!(failed[0].name, "sender.master.clock.drift-ppm=800");
    let (seed, line) = &failed[0].failures[0];
    assert_eq!(*seed, 1);
    assert!(line.starts_with("observer.drift_ppm is ") && line.ends_with("expected at most 500"));
    let report = fs::read_to_string(&outcome.report).unwrap();
    assert!(report.contains("1 of 2 met") && report.contains("expected at most 500"));
}

#[test]
fn what_cuts_has_its_cuts_for_each_slave_and_is_plotted_by_them() {
    let scratch = tempfile::tempdir().unwrap();
    let source = catalog::find("cut-to-length").unwrap();
    let setup = Setup {
        axes: vec!["network.loss=0.0,0.01".parse().unwrap()],
        overrides: vec!["duration-s=12".to_owned(), "expect=[]".to_owned()],
        ..Setup::default()
    };
    let outcome = prepare(&source, &setup).unwrap();
    let outcome = super::run(&outcome, &options(scratch.path()), "", &|_| true).unwrap();
    let points = rows(&scratch.path().join("points.csv"));
    let cutting = points
        .iter()
        .filter(|row| row["slave.cuts"].parse() != Ok(0));
    assert!(cutting.count() > 0);
    assert!(points.iter().all(|row| !row["slave"].is_empty()));
    let plot = fs::read_to_string(outcome.plot.unwrap()).unwrap();
    assert!(plot.contains("slave.cut_length_error_max [mm]"));
}

#[test]
fn a_figure_may_be_chosen_and_must_be_there() {
    let scratch = tempfile::tempdir().unwrap();
    let with = |figure: &str| Options {
        figure: Some(figure.to_owned()),
        ..options(scratch.path())
    };
    let sweep = prepared(&setup(&[LOSS]));
    let outcome = super::run(&sweep, &with("messages_lost"), "", &|_| true).unwrap_err();
    assert!(
        outcome
            .to_string()
            .contains("--figure: received \"messages_lost\"")
    );
    let outcome = super::run(&sweep, &with("lost"), "", &|_| true).unwrap();
    let plot = fs::read_to_string(outcome.plot.unwrap()).unwrap();
    assert!(plot.contains("observer-sweep: lost"));
    let single = prepared(&setup(&["network.loss=0.1"]));
    let outcome = super::run(&single, &with("lost"), "", &|_| true).unwrap();
    assert_eq!(outcome.plot, None);
    assert!(!scratch.path().join("plot.svg").exists());
}

#[test]
fn a_scenario_brings_its_own_grid() {
    let sweep = prepared(&Setup::default());
    assert_eq!((sweep.axes().len(), sweep.points()), (3, 36));
    let sweep = prepared(&setup(&["seed=1,2"]));
    assert_eq!(sweep.axes()[0].field, "seed");
}

#[test]
fn a_value_that_does_not_fit_is_named_before_anything_runs() {
    let source = catalog::find("beat").unwrap();
    let setup = Setup {
        axes: vec!["network.loss=0.1,1.5".parse().unwrap()],
        ..Setup::default()
    };
    let error = prepare(&source, &setup).unwrap_err();
    assert!(format!("{error:#}").contains("network.loss: received 1.5"));
    let last = Setup {
        overrides: vec![format!("seed={}", i64::MAX)],
        seeds: seeds(2),
        ..Setup::default()
    };
    let scratch = tempfile::tempdir().unwrap();
    let last = prepare(&source, &last).unwrap();
    let error = super::run(&last, &options(scratch.path()), "", &|_| true).unwrap_err();
    assert!(error.to_string().contains("seed: received"), "{error}");
}
