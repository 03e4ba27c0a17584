use serde_json::json;

use super::*;
use crate::samples::{folder, shipped};

fn design() -> SawDesign {
    SawDesign {
        path: PathBuf::from("t.toml"),
        last: None,
    }
}

fn shipped_text(name: &str) -> String {
    std::fs::read_to_string(folder("saws").join(name)).unwrap()
}

#[test]
fn every_shipped_saw_has_a_view_with_its_plan_or_what_refuses_it() {
    for file in shipped("saws") {
        let text = std::fs::read_to_string(&file).unwrap();
        let mut design = design();
        let view = design.view(&text, &Value::Null);
        assert_eq!(view["error"], Value::Null, "{}", file.display());
        let planned = design.saw(&text).unwrap().plan();
        assert_eq!(
            view["refusal"].is_string(),
            planned.is_err(),
            "{}",
            file.display()
        );
        // A refused course is drawn faint, as it would be if nothing were checked.
        let curve = &view["curves"][0];
        assert_eq!(curve["is_faint"], planned.is_err(), "{}", file.display());
        for slider in view["sliders"].as_array().unwrap() {
            let [value, least, most] =
                ["value", "least", "most"].map(|field| slider[field].as_f64());
            let is_within = value.is_none_or(|value| least <= Some(value) && Some(value) <= most);
            assert!(is_within && least < most, "{slider}");
            let path = slider["path"].as_str().unwrap();
            let again = design.changed(&text, &json!({ "set": [[path, value]] }), &Value::Null);
            assert_eq!(design.saw(&again.unwrap()), design.saw(&text), "{path}");
        }
    }
    let text = design().template();
    assert!(design().view(&text, &Value::Null)["plan"].is_object());
}

/// Applies each remedy of a refusal as the page would.
#[test]
fn what_is_said_to_pass_passes() {
    let text = shipped_text("too-close.toml");
    let mut design = design();
    let view = design.view(&text, &Value::Null);
    assert!(
        view["refusal"].as_str().unwrap().contains("refused"),
        "{view}"
    );
    let remedies = view["remedies"].as_array().unwrap().clone();
    assert!(remedies.len() >= 3, "{remedies:?}");
    for remedy in remedies {
        let change = json!({ "set": remedy["set"] });
        let passing = design.changed(&text, &change, &Value::Null).unwrap();
        let plan = design.saw(&passing).unwrap().plan();
        assert!(plan.is_ok(), "{remedy}: {plan:?}");
        assert!(passing.contains("# The belt is measured."), "{passing}");
    }
}

#[test]
fn what_was_planned_stays_faint_where_a_slider_goes_too_far() {
    let mut design = design();
    let text = shipped_text("saw-position-1.toml");
    design.view(&text, &Value::Null);
    let change = json!({ "set": [["gear-in-pos.master-sync-position", -1e6]] });
    let far = design.changed(&text, &change, &Value::Null).unwrap();
    let view = design.view(&far, &Value::Null);
    assert!(
        view["refusal"].is_string() && view["curves"][0]["is_faint"] == true,
        "{view}"
    );
    assert!(design.check(&far).is_ok(), "it is a file in order");
    let view = design.view("x = 1", &Value::Null);
    assert!(
        view["error"].is_string() && view["curves"][0]["is_faint"] == true,
        "{view}"
    );
    assert!(design.check("x = 1").is_err());
}

#[test]
fn flags_come_and_go_and_nothing_else_is_changed_than_a_saw_has() {
    let text = shipped_text("cut-to-length.toml");
    let flag = |flag: &str, on: bool| {
        let change = json!({ "flag": { "flag": flag, "on": on } });
        let changed = design().changed(&text, &change, &Value::Null)?;
        Ok::<_, String>(sync_mode(&design().saw(&changed)?.command).mask)
    };
    let before = sync_mode(&design().saw(&text).unwrap().command).mask;
    assert_eq!(
        flag("max-velo", false).unwrap(),
        before - SyncMask::MAX_VELO
    );
    assert_eq!(
        flag("overshoot-velo", true).unwrap(),
        before | SyncMask::OVERSHOOT_VELO
    );
    assert!(
        flag("no-such-flag", true)
            .unwrap_err()
            .contains("no-such-flag")
    );
    for wrong in [
        json!({ "set": [["colour", 1]] }),
        json!({ "set": [["gear-in-pos.colour", 1]] }),
        json!({ "set": [["master.position", { "a": 1 }]] }),
        json!({ "dance": 1 }),
    ] {
        assert!(
            design().changed(&text, &wrong, &Value::Null).is_err(),
            "{wrong}"
        );
    }
    assert!(design().act(&text, &json!({ "do": "it" })).is_err());
}
