use serde_json::json;

use super::*;
use crate::samples::{folder, shipped};

fn design() -> CamDesign {
    CamDesign {
        path: folder("cams").join("t.toml"),
        compared: None,
        target: None,
        last: None,
    }
}

fn changed(text: &str, change: Value) -> Result<String, String> {
    design().changed(text, &change, &Value::Null)
}

const KNIFE: &str = "# A knife.\ntitle = \"Knife\" # short\ncourse = \"cyclic\"\n\n\
    # The cut.\n[[point]]\nlaw = \"polynom5\" # smooth\nmaster = 0\nslave = 0\n\n\
    # The top.\n[[point]]\nlaw = \"polynom5\"\nmaster = 180 # half way\nslave = 50\n\n\
    # The end.\n[[point]]\nmaster = 360\nslave = 0\n";

#[test]
fn a_plate_is_designed_from_scratch() {
    let mut text = design().template();
    for change in [
        json!({ "head": { "field": "title", "value": "Press" } }),
        json!({ "insert": { "along": 180.4, "value": 49.7, "grain": [1.0, 0.5] } }),
        json!({ "set": { "point": 1, "field": "law", "value": "modsinuslinie" } }),
        json!({ "insert": { "along": 300, "value": 1, "grain": [1.0, 1.0] } }),
        json!({ "drag": { "point": 2, "quantity": 0, "along": 270.2, "value": 20.03, "grain": [0.5, 0.05] } }),
        json!({ "set": { "point": 2, "field": "law", "value": "polynom5-mm" } }),
        json!({ "set": { "point": 1, "field": "law", "value": "polynom5-mm" } }),
        json!({ "drag": { "point": 2, "quantity": 1, "along": 270, "value": -0.31, "grain": [1.0, 0.02] } }),
    ] {
        text = changed(&text, change.clone()).unwrap_or_else(|error| panic!("{change}: {error}"));
    }
    let (cam, _) = design().plate(&text).unwrap();
    assert_eq!(cam.title, "Press");
    let coaxle_files::cam::Shape::Points(points) = &cam.shape else {
        panic!("{text}");
    };
    let seen: Vec<_> = points
        .iter()
        .map(|p| (p.master, p.slave, p.velocity, p.function.file_name()))
        .collect();
    assert_eq!(seen[1], (180.0, 49.5, 0.0, "polynom5-mm"));
    assert_eq!(seen[2], (270.0, 20.05, -0.32, "polynom5-mm"));
    assert_eq!(seen.len(), 4);
}

#[test]
fn comments_and_order_stay() {
    let text = changed(
        KNIFE,
        json!({ "insert": { "along": 90, "value": 10, "grain": [1, 1] } }),
    )
    .unwrap();
    let text = changed(
        &text,
        json!({ "set": { "point": 2, "field": "master", "value": 200 } }),
    )
    .unwrap();
    let text = changed(
        &text,
        json!({ "head": { "field": "title", "value": "Other" } }),
    )
    .unwrap();
    let expected = KNIFE
        .replace("\"Knife\"", "\"Other\"")
        .replace("master = 180", "master = 200")
        .replace(
            "# The top.",
            "[[point]]\nlaw = \"polynom5\"\nmaster = 90\nslave = 10\n\n# The top.",
        );
    assert_eq!(text, expected);
    let without = changed(&text, json!({ "remove": { "point": 1 } })).unwrap();
    assert!(
        without.contains("# The cut.")
            && without.contains("# The top.")
            && !without.contains("master = 90"),
        "{without}"
    );
    design().plate(&without).unwrap();
}

#[test]
fn every_shipped_file_comes_back_as_it_is_and_has_a_view() {
    for file in shipped("cams") {
        let text = std::fs::read_to_string(&file).unwrap();
        let mut design = design();
        let settings =
            json!({ "over_time": true, "turns": 3, "selected": 0, "velocity": 1.0, "jerk": 1e3 });
        let view = design.view(&text, &settings);
        assert_eq!(view["error"], Value::Null, "{}", file.display());
        assert!(
            view["curves"][0]["along"].as_array().unwrap().len() > 100,
            "{view}"
        );
        assert_eq!(view["limits"][1].as_array().unwrap().len(), 2);
        let first =
            json!({ "set": { "point": 0, "field": "slave", "value": view["points"][0]["slave"] } });
        if !text.contains("csv =") {
            let again = design.changed(&text, &first, &settings).unwrap();
            let same = |text: &str| design.plate(text).unwrap().0.source();
            assert_eq!(same(&again), same(&text), "{}", file.display());
        }
    }
}

/// Drawn curves are the plate's, with the speed of the master and with its lift.
#[test]
fn curves_are_the_plate_over_time_and_turns() {
    let text = std::fs::read_to_string(folder("cams").join("lift.toml")).unwrap();
    let settings = json!({ "over_time": true, "turns": 2, "master_velocity": 720.0 });
    let view = design().view(&text, &settings);
    let (_, plate) = design().plate(&text).unwrap();
    let curve = &view["curves"][0];
    let along = curve["along"].as_array().unwrap();
    for n in (0..along.len() - 1).step_by(37) {
        let master = along[n].as_f64().unwrap() * 720.0;
        let motion = plate.at(master);
        let values = [
            motion.position,
            motion.velocity * 720.0,
            motion.acceleration * 720.0 * 720.0,
        ];
        for (quantity, expected) in values.into_iter().enumerate() {
            let received = curve["values"][quantity][n].as_f64().unwrap();
            assert!(
                (received - expected).abs() <= 1e-6 * (1.0 + expected.abs()),
                "{master} {received} {expected}"
            );
        }
    }
    let last = curve["values"][0]
        .as_array()
        .unwrap()
        .last()
        .unwrap()
        .as_f64()
        .unwrap();
    assert!((last - 180.0).abs() < 1e-6, "{last}");
}

#[test]
fn what_is_dragged_past_its_neighbour_stays_and_what_is_typed_is_shown_as_wrong() {
    let far =
        json!({ "drag": { "point": 1, "quantity": 0, "along": 400, "value": 0, "grain": [1, 1] } });
    let refused = changed(KNIFE, far).unwrap_err();
    assert!(refused.contains("0x4a06"), "{refused}");
    let typed = changed(
        KNIFE,
        json!({ "set": { "point": 1, "field": "master", "value": 400 } }),
    )
    .unwrap();
    let mut design = design();
    design.view(KNIFE, &Value::Null);
    let view = design.view(&typed, &json!({ "selected": 0 }));
    assert!(view["error"].as_str().unwrap().contains("0x4a06"), "{view}");
    assert_eq!(view["points"][1]["master"], 400.0);
    assert_eq!(view["curves"][0]["is_faint"], true);
    assert!(design.check(&typed).is_err());
    let view = design.view("x = = 1", &Value::Null);
    assert!(
        view["error"].as_str().unwrap().contains("not valid TOML"),
        "{view}"
    );
    for wrong in [
        json!({ "set": { "point": 9, "field": "slave", "value": 1 } }),
        json!({ "set": { "point": 0, "field": "colour", "value": 1 } }),
        json!({ "set": { "point": 0, "field": "slave", "value": [1] } }),
        json!({ "head": { "field": "point", "value": 1 } }),
        json!({ "remove": { "point": 3 } }),
        json!({ "insert": { "along": -5, "value": 1, "grain": [1, 1] } }),
        json!({ "drag": { "point": 1, "quantity": 3, "along": 1, "value": 0, "grain": [1, 1] } }),
        json!({ "dance": 1 }),
    ] {
        assert!(changed(KNIFE, wrong.clone()).is_err(), "{wrong}");
    }
    for settings in [
        json!({ "master_velocity": 0 }),
        json!({ "turns": 0 }),
        json!({ "turn": 1 }),
    ] {
        assert!(
            design.view(KNIFE, &settings)["error"].is_string(),
            "{settings}"
        );
    }
}

#[test]
fn ways_past_points_are_kept_when_points_come_and_go() {
    let text = "point = [\n  { law = 'polynom5', master = 0, slave = 0, relative-next = 2 }, # from\n  \
        { type = 'ignore', master = 50, slave = 10 },\n  { master = 100, slave = 40, index = 3 },\n]\n";
    let more = changed(
        text,
        json!({ "insert": { "along": 70, "value": 20, "grain": [1, 1] } }),
    )
    .unwrap();
    let (cam, plate) = design()
        .plate(&more)
        .unwrap_or_else(|error| panic!("{error}\n{more}"));
    assert_eq!(cam.source().len(), 4);
    assert!(
        more.contains("# from") && more.contains("index = 4"),
        "{more}"
    );
    assert_eq!(plate.at(0.0).position, 0.0);
    let less = changed(text, json!({ "remove": { "point": 1 } })).unwrap();
    let (cam, _) = design()
        .plate(&less)
        .unwrap_or_else(|error| panic!("{error}\n{less}"));
    assert_eq!(cam.source().len(), 2);
}

#[test]
fn rows_of_a_table_are_points_too() {
    let text = "[table]\ninterpolation = 'spline' # smooth\nrows = [\n  [0, 0], # begin\n  [50, 8.0],\n  [90, 9.5],\n  [100, 10],\n]\n";
    let text = changed(
        text,
        json!({ "drag": { "point": 1, "quantity": 0, "along": 40, "value": 7, "grain": [1, 1] } }),
    )
    .unwrap();
    let text = changed(
        &text,
        json!({ "insert": { "along": 70, "value": 9, "grain": [1, 1] } }),
    )
    .unwrap();
    let text = changed(&text, json!({ "remove": { "point": 3 } })).unwrap();
    assert!(
        text.contains("[0, 0], # begin\n") && text.contains("[40, 7]") && text.contains("[70, 9]"),
        "{text}"
    );
    let (_, plate) = design().plate(&text).unwrap();
    assert_eq!(plate.rows(), 4);
}

#[test]
fn rows_of_a_csv_file_are_seen_and_stay() {
    let text = std::fs::read_to_string(folder("cams").join("csv-table.toml")).unwrap();
    assert!(
        design().view(&text, &Value::Null)["points"]
            .as_array()
            .unwrap()
            .len()
            > 3
    );
    let refused = changed(
        &text,
        json!({ "set": { "point": 1, "field": "slave", "value": 1 } }),
    )
    .unwrap_err();
    assert!(refused.contains("CSV file"), "{refused}");
    let titled = changed(
        &text,
        json!({ "head": { "field": "title", "value": "Other" } }),
    )
    .unwrap();
    assert!(
        titled.contains("title = \"Other\"") && titled.contains("csv ="),
        "{titled}"
    );
}

#[test]
fn two_plates_are_compared_and_marks_say_what_goes_on() {
    let mut design = design();
    let done = design.act(KNIFE, &json!({ "do": "compare-with-this" }));
    assert!(done.is_ok(), "{done:?}");
    let other = KNIFE
        .replace("law = \"polynom5\"\n", "law = \"polynom3\"\n")
        .replace("slave = 50", "slave = 40");
    let view = design.view(&other, &json!({ "selected": 1, "acceleration": 1.0 }));
    assert_eq!(view["curves"].as_array().unwrap().len(), 2);
    let range = &view["characteristics"]["ranges"][0];
    assert_eq!(
        (&range["own"]["most"], &range["other"]["most"]),
        (&json!("40"), &json!("50"))
    );
    assert_eq!(view["characteristics"]["ranges"][2]["is_over"], true);
    let top: Vec<_> = (0..3)
        .map(|n| view["points"][1]["joint"][n]["goes_on"].clone())
        .collect();
    assert_eq!(top, [json!(true), json!(false), json!(false)]);
    assert_eq!(view["advice"]["point"], 2);
    assert!(
        design
            .act(
                &other,
                &json!({ "compare": { "name": "x.toml", "text": "x = 1" } })
            )
            .is_err()
    );
    design
        .act(
            &other,
            &json!({ "compare": { "name": "x.toml", "text": KNIFE } }),
        )
        .unwrap();
    assert_eq!(design.view(&other, &Value::Null)["compared"], "x.toml");
    design
        .act(&other, &json!({ "do": "compare-with-none" }))
        .unwrap();
    assert_eq!(design.view(&other, &Value::Null)["compared"], Value::Null);
    let nobody = design.act(&other, &json!({ "do": "load" })).unwrap_err();
    assert!(nobody.contains("--node"), "{nobody}");
}
