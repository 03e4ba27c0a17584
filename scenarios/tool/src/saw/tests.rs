use coaxle_report::figure::{Curve, Figure, Look, Panel, Scale};

use super::course::SlaveCourse;
use super::*;
use crate::samples::{curves_of, examples_of, folder, shipped, stands_alone};

/// Files that show a refusal.
const REFUSED: [&str; 2] = ["saw-position-2-checked.toml", "too-close.toml"];

fn example(name: &str) -> SawFile {
    SawFile::load(&folder("saws").join(name)).expect("it is shipped")
}

fn answer(name: &str, json: bool) -> String {
    let file = folder("saws").join(name);
    let mut out = Vec::new();
    run(&SawSubcommand::Plan(SawPlanArgs { file, json }), &mut out).expect("an answer");
    String::from_utf8(out).expect("text")
}

fn figure(saw: &SawFile) -> Figure {
    plot::figure(saw, &saw.plan().unwrap())
}

/// The first curve of the name in a panel.
fn named<'a>(panel: &'a Panel, name: &str) -> (&'a Curve, &'a [(f64, f64)]) {
    let mut curves = curves_of(panel).into_iter();
    curves.find(|(curve, _)| curve.name == name).expect(name)
}

#[test]
fn every_saw_file_that_is_shipped_is_what_it_says() {
    let files = shipped("saws");
    assert!(files.len() >= 13);
    for file in files {
        let saw = SawFile::load(&file).unwrap();
        assert!(!saw.title.is_empty(), "{}", file.display());
        let refused = REFUSED.iter().any(|name| file.ends_with(name));
        assert_eq!(saw.plan().is_err(), refused, "{}", file.display());
    }
}

#[test]
fn every_example_of_the_handbook_is_valid() {
    let examples = examples_of("SAWS.md");
    assert!(examples.len() >= 4);
    for example in examples {
        let saw = SawFile::parse("SAWS.md", &example).unwrap();
        saw.plan().unwrap();
    }
}

#[test]
fn phases_follow_each_other_from_the_start_to_the_synchronous_line() {
    for file in shipped("saws") {
        let saw = SawFile::load(&file).unwrap();
        let Ok(plan) = saw.plan() else { continue };
        let course = SlaveCourse::of(&plan);
        let mut along = course.start();
        for phase in &course.phases {
            assert_eq!(phase.begin, along, "{}", file.display());
            along = phase.end;
        }
        assert_eq!(along, course.end());
        assert_eq!(course.time_at(course.start()), 0.0);
        assert!((course.time_at(along) - plan.duration().0).abs() < 1e-12);
        assert!((course.master_at(along) - plan.master_end()).abs() < 1e-9);

        let start = course.slave_at(course.start());
        assert!((start.position - plan.slave_start().position).abs() < 1e-9);
        assert!((start.velocity - plan.slave_start().velocity).abs() < 1e-9);
        let end = course.slave_at(along);
        assert!((end.position - plan.line().slave).abs() < 1e-9);
        let velocity = plan.line().ratio * plan.master_velocity();
        assert!((end.velocity - velocity).abs() < 1e-9);
    }
}

#[test]
fn a_plan_in_words_has_the_phases_and_all_values() {
    let text = answer("saw-position-1-checked.toml", false);
    for part in [
        // 1500 mm at 500 mm/s.
        "P5+P1, 3 s, 1500 mm of the master",
        "position (mm)",
        " 29   fSlaveDynMomMax ",
        "mm²/s³",
        "table 254: motion-function, rows 3, columns 1, not periodic",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let text = answer("saw-velocity-1-time.toml", false);
    assert!(
        text.contains("time-based: phases of constant jerk"),
        "{text}"
    );
}

#[test]
fn a_refusal_in_words_says_what_would_pass() {
    let text = answer("too-close.toml", false);
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), 5, "{text}");
    assert!(lines[0].contains("too-close.toml: refused: 0x42df: "));
    assert!(lines[1].starts_with("checked by max-acc, detailed code 0x4388: "));
    assert!(lines[2].starts_with("would pass with the master at least "));
    assert!(lines[2].ends_with("not 200 mm"));
    assert!(lines[3].starts_with("would pass with the master at most "));
    assert!(lines[3].ends_with("mm/s fast, not 500 mm/s"));
    assert_eq!(lines[4], "would pass with strategy = \"early\"");

    let text = answer("saw-position-2-checked.toml", false);
    assert!(text.trim_end().ends_with("was found to pass"), "{text}");
}

#[test]
fn a_remedy_in_words_is_rounded_to_the_side_that_passes() {
    let mut saw = example("too-close.toml");
    let text = refusal::in_words(PathBuf::new().as_path(), &saw, &saw.plan().unwrap_err());
    let number_after = |words: &str| {
        let (_, rest) = text.split_once(words).expect("these words");
        let number = rest.split(' ').next().unwrap_or_default();
        number.parse::<f64>().expect("a number")
    };
    let distance = number_after("at least ");
    let speed = number_after("at most ");
    let given = saw.clone();
    saw.moment.master.velocity = speed;
    saw.plan().unwrap();
    saw = given;
    if let coaxle_saw::SawCommand::GearInPos(command) = &mut saw.command {
        command.master_sync_position = distance;
    }
    saw.plan().unwrap();
}

#[test]
fn a_standing_master_is_told_without_numbers_that_are_none() {
    let mut saw = example("saw-position-1.toml");
    saw.moment.master.velocity = 0.0;
    saw.moment.slave.velocity = 0.0;
    let plan = saw.plan().unwrap();
    let text = plan::in_words(&saw, &plan);
    assert!(text.contains("for as long as the master stands"), "{text}");
    assert!(plan::json_of(&saw, &plan)["duration"].is_null());
    let panels = figure(&saw).panels;
    let curves: Vec<_> = panels.iter().map(|panel| panel.curves.len()).collect();
    // Course and marks, and besides a limit in both directions; acceleration and deceleration have one each.
    assert_eq!(curves, [2, 2 + 2, 2 + 4, 2 + 2]);
}

#[test]
fn a_slave_that_is_synchronous_already_needs_no_phases() {
    let mut saw = example("saw-velocity-1.toml");
    saw.moment.slave.velocity = 500.0;
    let plan = saw.plan().unwrap();
    let text = plan::in_words(&saw, &plan);
    assert!(text.contains("the slave is synchronous already"), "{text}");
    assert_eq!(plan::json_of(&saw, &plan)["phases"], serde_json::json!([]));
    let figure = figure(&saw);
    let (_, course) = named(&figure.panels[0], "position");
    let along: Vec<_> = course.iter().map(|point| point.0).collect();
    // A second of the synchronous phase at 500 mm/s.
    assert_eq!(along, [0.0, 500.0]);
}

#[test]
fn a_plot_has_four_charts_with_limits_and_marked_phases() {
    for file in shipped("saws") {
        let saw = SawFile::load(&file).unwrap();
        if saw.plan().is_err() {
            continue;
        }
        stands_alone(&plot::page(&saw, &saw.plan().unwrap()));
        let figure = figure(&saw);
        for (n, panel) in figure.panels.iter().enumerate() {
            for (curve, points) in curves_of(panel) {
                assert!(
                    points.iter().all(|(_, value)| value.is_finite()),
                    "{}",
                    curve.name
                );
            }
            let looks = panel.curves.iter().map(|curve| curve.look);
            let limits = looks.filter(|look| matches!(look, Look::Dashed | Look::Dotted));
            assert!(n == 0 || limits.count() >= 2, "{}", file.display());
        }
    }
    let figure = figure(&example("saw-position-1-checked.toml"));
    let (marks, begins) = named(&figure.panels[0], "points");
    assert_eq!(marks.labels, ["polynom5-mm", "polynom1", "synchronous"]);
    for ((begin, _), expected) in begins.iter().zip([-500.0, 500.0, 1000.0]) {
        assert!((begin - expected).abs() < 1e-9);
    }
    let [_, velocity, _, jerk] = figure.panels.as_slice() else {
        panic!("four charts");
    };
    let (limit, at) = named(jerk, "limit of jerk");
    assert_eq!((limit.look, at[0].1), (Look::Dashed, 5000.0));
    assert_eq!(named(velocity, "limit of velocity").0.look, Look::Dotted);
    // Far limits must not flatten the curve.
    assert!(limit.is_aside && jerk.range.unwrap().1 < 1000.0);
}

#[test]
fn a_jump_is_upright_and_time_runs_to_the_right() {
    let over_time = figure(&example("saw-velocity-1-time.toml"));
    let (_, jerk) = named(&over_time.panels[3], "jerk");
    let turn = jerk.iter().position(|(_, jerk)| *jerk < 0.0).unwrap();
    assert_eq!(jerk[turn].0, jerk[turn - 1].0);
    assert_eq!(over_time.across.scale, Scale::Linear);

    let backwards = figure(&example("saw-velocity-3.toml"));
    assert_eq!(backwards.across.scale, Scale::Backwards);
}

#[test]
fn a_plot_loads_nothing_and_runs_nothing_from_the_file() {
    let nasty = "</script><script>alert('x')</script>";
    let mut saw = example("saw-position-1.toml");
    saw.title = nasty.to_owned();
    saw.master_unit = nasty.to_owned();
    saw.slave_unit = nasty.to_owned();
    let page = plot::page(&saw, &saw.plan().unwrap());
    assert!(!page.contains("<script>alert"), "unescaped text");
    stands_alone(&page);
}

#[test]
fn the_scenario_of_diagonal_saws_has_the_ratios_of_their_angles() {
    let source = coaxle_lab::catalog::find("diagonal-saw").unwrap();
    let scenario = source.read(&[]).unwrap();
    let [receiver] = scenario.receivers.as_slice() else {
        panic!("one receiver");
    };
    let ratios = receiver.slaves.iter().map(|slave| {
        let commands = slave
            .steps
            .iter()
            .filter_map(|step| step.slave_command().copied());
        let mut ratios = commands.filter_map(|command| match command {
            coaxle_slave::Command::GearInVelo(saw) => Some(saw.ratio),
            _ => None,
        });
        ratios.next().unwrap()
    });
    for (ratio, angle) in ratios.zip([30.0, 60.0]) {
        let expected = coaxle_saw::diagonal_ratio(angle, 1.0).unwrap();
        assert!(
            (ratio.numerator / expected.numerator - 1.0).abs() < 1e-15,
            "{angle}"
        );
        assert_eq!(ratio.denominator, expected.denominator);
    }
}
