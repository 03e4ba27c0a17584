use super::*;
use crate::samples::{examples_of, folder, shipped, stands_alone};

fn gear(name: &str) -> (GearFile, coaxle_gear::FlyingGear) {
    let file = GearFile::load(&folder("gears").join(name)).unwrap();
    let gear = file.gear().unwrap();
    (file, gear)
}

fn planned(name: &str, json: bool) -> (bool, String) {
    let file = folder("gears").join(name);
    let mut out = Vec::new();
    let good = run(&GearSubcommand::Plan(GearPlanArgs { file, json }), &mut out).unwrap();
    (good, String::from_utf8(out).unwrap())
}

/// The manual's samples: ways of 50 mm take 100 mm of the master.
#[test]
fn plans_are_those_of_the_manual() {
    let (good, text) = planned("flying-gear-1.toml", false);
    assert!(good, "{text}");
    for expected in [
        "engaged over 100 mm",
        "on the way back over 100 mm",
        "560",
        "460",
    ] {
        assert!(text.contains(expected), "{text}");
    }
    let (_, json) = planned("flying-gear-3.toml", true);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["releasing"]["master_coupled"], 460.0);
    assert_eq!(json["releasing"]["master_free"], 260.0);
    assert_eq!(json["returns"], false);
    let (_, json) = planned("flying-gear-2.toml", true);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&json["ratio"], &json["returns"]),
        (&json!(-1.0), &json!(true))
    );
}

#[test]
fn a_refusal_says_how_fast_the_master_may_be() {
    let (good, text) = planned("too-fast.toml", false);
    assert!(
        !good && text.contains("refused: 0x42dd") && text.lines().count() == 1,
        "{text}"
    );
    let (_, json) = planned("too-fast.toml", true);
    let json: Value = serde_json::from_str(&json).unwrap();
    let speed = json["refusal"]["remedy"]["master_speed"].as_f64().unwrap();
    let mut file = GearFile::load(&folder("gears").join("too-fast.toml")).unwrap();
    file.master.velocity = speed;
    assert!(file.gear().is_ok());
    // Just above: the remedy is the limit itself, not only a value that passes.
    file.master.velocity = speed * 1.001;
    assert!(file.gear().is_err());
}

/// Velocity, acceleration and jerk are the derivatives of the drawn positions, and keep the printed demands.
#[test]
fn what_is_drawn_is_a_motion() {
    for name in [
        "flying-gear-1.toml",
        "flying-gear-2.toml",
        "flying-gear-3.toml",
    ] {
        let (file, gear) = gear(name);
        let stretches = gear.ranges(file.master.velocity, file.cycle.0);
        let course = course::course(&file, &gear, &stretches);
        let mut most = [0.0_f64; 2];
        for pair in course.windows(2) {
            let ((a, before), (b, after)) = (pair[0], pair[1]);
            let dt = (b - a).abs() / file.master.velocity.abs();
            if dt == 0.0 {
                continue;
            }
            let slope = (after.position - before.position) / dt;
            assert!(
                (slope - (before.velocity + after.velocity) / 2.0).abs() < 0.1,
                "{name} {a}"
            );
            let slope = (after.velocity - before.velocity) / dt;
            assert!(
                (slope - (before.acceleration + after.acceleration) / 2.0).abs() < 5.0,
                "{name} {a}"
            );
            let slope = (after.acceleration - before.acceleration) / dt;
            // Where a stretch begins or ends the jerk is another one.
            let is_corner = (before.jerk - after.jerk).abs() > 100.0;
            assert!(
                is_corner || (slope - (before.jerk + after.jerk) / 2.0).abs() < 1.0,
                "{name} {a}"
            );
            most = [
                most[0].max(after.acceleration.abs()),
                most[1].max(after.jerk.abs()),
            ];
        }
        let highest =
            |of: fn(&coaxle_gear::FlyingGearRange) -> f64| of(&stretches[0]).max(of(&stretches[1]));
        let expected = [
            highest(|stretch| stretch.acceleration),
            highest(|stretch| stretch.jerk),
        ];
        for (most, expected) in most.into_iter().zip(expected) {
            assert!(
                most <= expected * (1.0 + 1e-9) && most > 0.98 * expected,
                "{name}: {most} {expected}"
            );
        }
    }
}

#[test]
fn a_plot_stands_alone_and_every_file_has_a_title() {
    for path in shipped("gears") {
        let file = GearFile::load(&path).unwrap();
        assert!(!file.title.is_empty(), "{}", path.display());
        let Ok(gear) = file.gear() else { continue };
        stands_alone(&plot::page(&file, &gear));
        let figure = plot::figure(&file, &gear);
        let curves = figure.panels.iter().map(|panel| panel.curves.len());
        // The course, and a limit in both directions in all charts but the first.
        assert_eq!(curves.collect::<Vec<_>>(), [1, 3, 3, 3]);
    }
    let examples = examples_of("GEARS.md");
    assert!(!examples.is_empty());
    for text in examples {
        GearFile::parse("GEARS.md", &text).unwrap().gear().unwrap();
    }
}
