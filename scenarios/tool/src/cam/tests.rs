mod exchanged;

use std::collections::BTreeSet;

use clap::Parser;
use coaxle_curve::law::MotionLaw;
use coaxle_files::cam::Shape;
use coaxle_report::figure::Panel;
use serde_json::Value;

use super::text::{heading, master_heading};
use super::*;
use crate::samples::{self, curves_of, examples_of, stands_alone};

#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: CamSubcommand,
}

fn folder() -> PathBuf {
    samples::folder("cams")
}

fn shipped() -> Vec<PathBuf> {
    samples::shipped("cams")
}

/// Output of `coaxle cam` for `words` about a shipped file.
fn answer(command: &str, file: &str, words: &str) -> Result<String, String> {
    let file = folder().join(file);
    let mut arguments = vec!["cam", command, file.to_str().expect("a plain path")];
    arguments.extend(words.split_whitespace());
    let cli = Cli::try_parse_from(arguments).map_err(|error| error.to_string())?;
    let mut out = Vec::new();
    run(&cli.command, &mut out).map_err(|error| format!("{error:#}"))?;
    Ok(String::from_utf8(out).expect("text"))
}

#[test]
fn every_cam_file_that_is_shipped_is_valid_and_has_a_title() {
    let files = shipped();
    assert!(files.len() >= 14);
    for file in files {
        let (cam, _) = load(&file).unwrap();
        assert!(!cam.title.is_empty(), "{}", file.display());
    }
}

#[test]
fn a_check_refuses_a_plate_whose_slave_would_have_no_finite_motion() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("steep.toml");
    let points = [
        ("polynom5", "0", "0"),
        ("polynom9", "1e-300", "1e15"),
        ("polynom5", "180", "0"),
    ];
    let points = points.map(|(law, master, slave)| {
        format!("[[point]]\nlaw = {law:?}\nmaster = {master}\nslave = {slave}\n")
    });
    std::fs::write(&file, points.concat()).unwrap();
    let mut out = Vec::new();
    let is_good = check(&[file], &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert!(!is_good && text.contains("0x42da: law"), "{text}");
    assert!(text.contains("received 1e-300, expected"), "{text}");
}

#[test]
fn every_law_is_in_a_shipped_file() {
    let mut laws = BTreeSet::new();
    for file in shipped() {
        if let Shape::Points(points) = load(&file).unwrap().0.shape {
            laws.extend(points.iter().map(|point| point.function));
        }
    }
    assert!(laws.iter().eq(MotionLaw::ALL));
}

/// The curve passes all points and, but for the table of straight lines, no velocity jumps.
#[test]
fn shipped_courses_are_continuous() {
    for file in shipped() {
        let (cam, plate) = load(&file).unwrap();
        let Shape::Points(points) = &cam.shape else {
            continue;
        };
        let most = plate.characteristics(1.0).unwrap().extremes;
        for point in &points[1..points.len() - 1] {
            let before = plate.at(point.master.next_down());
            let after = plate.at(point.master);
            let name = file.display();
            let position = (before.position - after.position).abs();
            let velocity = (before.velocity - after.velocity).abs();
            assert!(position <= 1e-9 * most.position.magnitude(), "{name}");
            assert!(velocity <= 1e-9 * most.velocity.magnitude(), "{name}");
        }
    }
}

#[test]
fn every_example_of_the_handbook_is_valid() {
    let examples = examples_of("CAMS.md");
    assert!(examples.len() >= 5);
    for example in examples {
        // CSV files are looked for beside the shipped ones.
        let cam = CamFile::parse(&folder().join("CAMS.md"), &example).unwrap();
        cam.plate().unwrap();
    }
}

#[test]
fn the_knife_is_synchronous_around_the_cut() {
    let (_, plate) = load(&folder().join("rotary-knife.toml")).unwrap();
    for turn in [-360.0, 0.0, 720.0] {
        for master in [-72.0, -10.0, 0.0, 23.9] {
            let motion = plate.at(turn + master);
            assert!((motion.velocity - 1.25).abs() < 1e-12);
            assert!((motion.position - (turn + 1.25 * master)).abs() < 1e-9);
        }
    }
    assert_eq!(plate.lift(), 360.0);
}

#[test]
fn a_check_says_what_a_file_is_and_goes_on_after_a_bad_one() {
    let good = folder().join("lift.toml");
    let command = CamSubcommand::Check {
        files: vec![good.clone(), folder(), good.clone()],
    };
    let mut out = Vec::new();
    assert!(!run(&command, &mut out).unwrap());
    let text = String::from_utf8(out).unwrap();
    let lines: Vec<_> = text.lines().collect();
    let about = "ok, motion function of 3 points, cyclic, master 0 to 360 °, lift 90 °";
    assert_eq!(lines[0], format!("{}: {about}", good.display()));
    assert!(lines[1].starts_with(&format!("{}: cannot be read: ", folder().display())));
    assert_eq!(lines[2], lines[0]);
}

#[test]
fn values_are_a_table_over_the_master() {
    let csv = answer(
        "values",
        "reading-back.toml",
        "--from -360 --to 360 --increment 90 --csv",
    );
    let csv = csv.unwrap();
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some("master,position,velocity,acceleration,jerk")
    );
    // 720/90 steps, and the first place.
    assert_eq!(lines.clone().count(), 9);
    let row: Vec<f64> = lines
        .nth(2)
        .into_iter()
        .flat_map(|line| line.split(','))
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    assert_eq!(row[..2], [-180.0, 100.0]);
    // Behind the point at 180°: from 100 down to 80 at 225°, a straight line.
    assert!((row[2] + 20.0 / 45.0).abs() < 1e-12, "{row:?}");
    assert_eq!(row[3..], [0.0, 0.0]);

    let table = answer("values", "lift.toml", "").unwrap();
    let headings: Vec<_> = table.lines().next().unwrap().split("  ").collect();
    let headings: Vec<_> = headings.iter().map(|cell| cell.trim()).collect();
    for heading in ["master (°)", "velocity (°/°)", "jerk (°/°³)"] {
        assert!(headings.contains(&heading), "{headings:?}");
    }
    // The headings, a hundred steps, and the first place.
    assert_eq!(table.lines().count(), 102);
    assert!(table.lines().last().unwrap().contains(" 360 "));

    let backwards = answer(
        "values",
        "lift.toml",
        "--from 9 --to 0 --increment -3 --csv",
    )
    .unwrap();
    // The header, and 9, 6, 3 and 0.
    assert_eq!(backwards.lines().count(), 5);
    let one = answer("values", "lift.toml", "--from 360 --to 360 --csv").unwrap();
    assert_eq!(one.lines().nth(1), Some("360,90,0,0,0"));
    let nowhere = answer("values", "lift.toml", "--increment 0").unwrap_err();
    assert!(
        nowhere.starts_with("0x4b38: increment: received 0"),
        "{nowhere}"
    );
    let infinite = answer("values", "lift.toml", "--from inf").unwrap_err();
    assert!(infinite.contains("expected a finite number"), "{infinite}");
}

#[test]
fn characteristics_are_read_by_people_and_programs() {
    let text = answer("characteristics", "cam-tables-a.toml", "").unwrap();
    for expected in [
        "motion function of 5 points",
        "velocity (mm/s)",
        "acceleration (mm/s²)",
    ] {
        assert!(text.contains(expected), "{text}");
    }
    let json = answer(
        "characteristics",
        "cam-tables-a.toml",
        "--json --master-velocity -2",
    );
    let json: Value = serde_json::from_str(&json.unwrap()).unwrap();
    // The 3-4-5 polynomial: 1.875·H/B, forwards over 120° and, the master reversed, twice as fast.
    let fastest = json["velocity"]["minimum"]["value"].as_f64().unwrap();
    assert!((fastest + 2.0 * 1.875 * 100.0 / 120.0).abs() < 1e-9);
    let place = json["velocity"]["minimum"]["master"].as_f64().unwrap();
    assert!((place - 60.0).abs() < 1e-6);
    let hardest = json["acceleration"]["maximum"]["value"].as_f64().unwrap();
    // Its greatest acceleration is 10/√3·H/B², times the square of the master velocity of 2.
    let cubed = 10.0 / 3.0_f64.sqrt();
    assert!((hardest - 4.0 * cubed * 100.0 / 120.0_f64.powi(2)).abs() < 1e-9);
    assert_eq!(json["position"]["maximum"]["value"], 100.0);
    assert_eq!(json["end"]["master"], 360.0);
    assert_eq!(json["table_type"], "motion-function");
    assert_eq!(json["slave_unit"], "mm");
    assert!(json["acceleration"]["minimum"]["velocity"].is_number());
    // Up and down again by 100 mm in one turn.
    let mean = json["mean_velocity"].as_f64().unwrap();
    assert!((mean - 2.0 * 200.0 / 360.0).abs() < 1e-9);

    let still = answer("characteristics", "lift.toml", "--master-velocity 0").unwrap_err();
    assert!(
        still.starts_with("0x4a1c: master velocity: received 0"),
        "{still}"
    );
}

#[test]
fn a_slave_position_has_its_masters() {
    for (words, below, above, all) in [
        ("--slave 80 --start 180", "135", "225", "135, 225"),
        ("--slave 80 --start 90", "-135", "135", "135, 225"),
        ("--slave 101 --start 90", "none", "none", "none"),
        ("--slave 100 --start 0", "-180", "180", "180"),
    ] {
        let text = answer("inverse", "reading-back.toml", words).unwrap();
        let found = text.lines().skip(1).map(|line| line.split(": ").nth(1));
        assert!(found.eq([Some(below), Some(above), Some(all)]), "{text}");
    }
    // Several turns on, as far as the lift carries.
    let text = answer("inverse", "lift.toml", "--slave 315 --start 0").unwrap();
    // Three turns lift by 270; the other 45 are reached at 270° of the fourth.
    assert!(text.contains("above 0: 1350\n"), "{text}");
    assert!(text.contains("below 0: none\n"), "{text}");
}

#[test]
fn a_plot_has_four_charts_over_one_master_and_names_its_points() {
    for file in shipped() {
        let (cam, plate) = load(&file).unwrap();
        stands_alone(&plot::page(&cam, &plate));
        let figure = plot::figure(&cam, &plate);
        assert_eq!(figure.across.words(), master_heading(&cam));
        let headings: Vec<_> = figure.panels.iter().map(Panel::words).collect();
        let expected: Vec<_> = (0..4).map(|quantity| heading(&cam, quantity)).collect();
        assert_eq!(headings, expected);
        for panel in &figure.panels {
            let curves = curves_of(panel);
            assert_eq!(curves.len(), 2);
            for (curve, points) in curves {
                assert!(points.is_sorted_by(|a, b| a.0 <= b.0), "{}", curve.name);
                assert!(points.iter().all(|point| point.1.is_finite()));
            }
        }
    }
    let (cam, plate) = load(&folder().join("cam-tables-a.toml")).unwrap();
    let labels = &plot::figure(&cam, &plate).panels[0].curves[1].labels;
    assert_eq!(labels.len(), 4, "the ignored point is not on the course");
    assert_eq!(labels[2], "point 4, rest, polynom5");
}

#[test]
fn a_plot_loads_nothing_and_runs_nothing_from_the_file() {
    let nasty = "</script><script>alert('x')</script>";
    let text = format!(
        "title = \"{nasty}\"\nmaster-unit = \"{nasty}\"\nslave-unit = \"{nasty}\"\n\
         [table]\nrows = [[0, 0], [1, 1]]"
    );
    let cam = CamFile::parse(Path::new("t.toml"), &text).unwrap();
    let page = plot::page(&cam, &cam.plate().unwrap());
    assert!(!page.contains("<script>alert"), "unescaped text");
    stands_alone(&page);
}

#[test]
fn a_plot_of_a_long_table_stays_small_and_passes_over_no_row() {
    use std::fmt::Write as _;
    let mut text = "[table]\nrows = [\n".to_owned();
    for row in 0..50_000 {
        let slave = if row == 31_007 { 40 } else { row % 7 };
        let _ = writeln!(text, "[{row}, {slave}],");
    }
    text += "]";
    let cam = CamFile::parse(Path::new("t.toml"), &text).unwrap();
    let plate = cam.plate().unwrap();
    stands_alone(&plot::page(&cam, &plate));
    let figure = plot::figure(&cam, &plate);
    let (_, course) = curves_of(&figure.panels[0])[0];
    assert_eq!(course.last().unwrap().0, 49_999.0);
    assert!(course.contains(&(31_007.0, 40.0)));
}

/// Result of `coaxle cam` with these words.
fn output(words: &[&str]) -> Result<(bool, String), String> {
    let cli = Cli::try_parse_from([&["cam"], words].concat()).map_err(|error| error.to_string())?;
    let mut out = Vec::new();
    let good = run(&cli.command, &mut out).map_err(|error| format!("{error:#}"))?;
    Ok((good, String::from_utf8(out).expect("text")))
}

#[test]
fn a_law_is_advised_that_the_slave_can_follow() {
    let words = "--segment 2 --master-velocity 360 --least jerk";
    let text = answer("advise", "lift.toml", words).unwrap();
    assert!(
        text.starts_with("from point 2, with the least jerk: "),
        "{text}"
    );
    let file = folder().join("lift.toml").display().to_string();
    let (passes, text) = output(&[
        "advise",
        &file,
        "--segment",
        "2",
        "--max-acceleration",
        "1e-6",
    ])
    .unwrap();
    assert!(
        !passes && text.contains("no law that its points allow"),
        "{text}"
    );
    assert!(text.contains("too much acceleration"), "{text}");
    let (passes, json) = output(&[
        "advise",
        &file,
        "--segment",
        "2",
        "--json",
        "--least",
        "velocity",
    ])
    .unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let laws = json["laws"].as_array().unwrap();
    assert!(passes && laws.len() > 10, "{json}");
    let best = laws[0]["velocity"].as_f64().unwrap();
    let passing = laws
        .iter()
        .filter(|law| law["passes"] == true && law["acceleration_step"] == 0.0);
    assert!(
        passing
            .into_iter()
            .all(|law| law["velocity"].as_f64().unwrap() >= best)
    );
    let nothing = answer("advise", "measured.toml", "--segment 1").unwrap_err();
    assert!(nothing.starts_with("0x4262: "), "{nothing}");
    let nothing = answer("advise", "lift.toml", "--segment 9").unwrap_err();
    assert!(
        nothing.starts_with("0x4b33: received point index 9"),
        "{nothing}"
    );
}
