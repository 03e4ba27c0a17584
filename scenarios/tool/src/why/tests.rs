use serde_json::{Map, Value, json};

use super::causes::{LimitingCause, findings};
use super::{StatusFields, in_words};
use coaxle_node::keys::NodeName;

/// A receiver with an axis at 500 mm/s and a slave, in order.
fn receiver() -> Value {
    json!({
        "node": "saw", "role": "receiver", "health": "ok", "overruns": 1,
        "sources": { "line": { "frame_age_ms": 1.2, "unseen": null } },
        "far": { "line": {
            "health": "ok", "mode": "observer", "error": null, "cycle_time_us": 1000.0, "delay_state": "measured",
            "delay_uncertainty_us": 0.4, "offset_sigma_us": 0.05, "normal_jitter_us": 3.0, "exponential_jitter_us": 4.0,
            "slew_remaining_us": 0.0, "time_offset_us": 0.0, "timing_state": null, "needed_present_after_us": 3400.0,
            "presentation_margin_us": null, "lost": 10, "expected": 5000, "shifts": 0
        } },
        "axes": { "line.1": {
            "node": "line", "unit": "mm", "continuity": "following", "corrected_velocity": 500.0, "interpolated": null,
            "prediction_sigma": 0.000_03, "position_sigma": null
        } },
        "slaves": { "roll": {
            "unit": "mm", "error": null, "guard": "tracking", "distance": 0.0, "following_error": 0.0001, "drive_velocity": 500.0
        } }
    })
}

fn object(value: &Value) -> Map<String, Value> {
    value.as_object().cloned().expect("an object")
}

/// Findings where a part of the status has these fields.
fn found_with(pointer: &str, fields: &Value) -> Vec<LimitingCause> {
    let before = object(&receiver());
    let mut now = receiver();
    let part = now.pointer_mut(pointer).and_then(Value::as_object_mut);
    part.expect("a part of it").extend(object(fields));
    let now = object(&now);
    let [before, now] = [&before, &now].map(StatusFields::of);
    findings(&before, &now, None)
}

#[test]
fn the_planted_cause_comes_first() {
    let far = "/far/line";
    for (pointer, fields, cause) in [
        ("", json!({ "overruns": 9 }), "skipped-cycles"),
        (
            "/sources/line",
            json!({ "unseen": "no node of that name" }),
            "unseen",
        ),
        (far, json!({ "health": "master-silent" }), "not-in-sync"),
        (
            far,
            json!({ "health": "clocks-disagree" }),
            "clocks-disagree",
        ),
        (far, json!({ "mode": "bypass" }), "mode"),
        (far, json!({ "delay_uncertainty_us": 44.0 }), "delay"),
        (far, json!({ "offset_sigma_us": 9.0 }), "jitter"),
        (far, json!({ "slew_remaining_us": -80.0 }), "slew"),
        (far, json!({ "time_offset_us": 30_000.0 }), "offset"),
        (
            "/axes/line.1",
            json!({ "prediction_sigma": 0.05 }),
            "prediction",
        ),
        (
            "/axes/line.1",
            json!({ "position_sigma": 0.05 }),
            "increments",
        ),
        (
            "/axes/line.1",
            json!({ "continuity": "returning" }),
            "continuity",
        ),
        (
            "/slaves/roll",
            json!({ "guard": "limiting", "distance": 1.5 }),
            "limits",
        ),
        ("/slaves/roll", json!({ "following_error": 2.0 }), "drive"),
        (
            "/slaves/roll",
            json!({ "error": { "code": "0x42a0", "text": "master lost" } }),
            "slave-error",
        ),
    ] {
        let found = found_with(pointer, &fields);
        assert_eq!(found[0].cause, cause, "{fields}: {found:#?}");
    }
}

#[test]
fn an_error_of_time_is_a_distance_at_the_velocity_of_the_axis() {
    let found = found_with("/far/line", &json!({ "delay_uncertainty_us": 44.0 }));
    let way = found[0].way.as_ref().expect("a distance");
    assert_eq!((way.unit.as_str(), way.at_velocity), ("mm", Some(500.0)));
    assert!((way.by - 0.022).abs() < 1e-12, "{way:?}");
    let text = in_words(&NodeName::new("saw").expect("a name"), &found);
    assert!(
        text.contains(
            "1. error: delay of the way from line, at most 44.0 µs or 0.022 mm at 500 mm/s\n"
        ),
        "{text}"
    );
    assert!(text.contains("a timing channel to line"), "{text}");
}

#[test]
fn an_axis_that_is_shown_too_early_says_by_how_much() {
    let late = json!({ "presentation_margin_us": -2_500.0, "lost": 60, "expected": 6_000 });
    let found = found_with("/far/line", &late);
    let prediction = found.iter().find(|finding| finding.cause == "prediction");
    let prediction = prediction.expect("an axis that is predicted");
    let remedy = prediction.remedy.as_deref().unwrap_or_default();
    assert!(remedy.contains("too early by 2.5 ms"), "{remedy}");
    assert!(
        prediction.why.contains("5.0 % of the messages are lost"),
        "{prediction:?}"
    );
    let shown = found_with("/axes/line.1", &json!({ "interpolated": true }));
    assert!(shown.iter().all(|finding| finding.cause != "prediction"));
}

#[test]
fn a_following_error_at_a_velocity_is_a_dead_time() {
    let found = found_with("/slaves/roll", &json!({ "following_error": 2.0 }));
    let remedy = found[0].remedy.as_deref().unwrap_or_default();
    assert!(remedy.contains("dead-time-us = 4000"), "{remedy}");
}

#[test]
fn of_a_node_without_axes_there_is_nothing_to_say() {
    let status = object(&json!({ "node": "line", "role": "sender", "overruns": 0 }));
    let status = StatusFields::of(&status);
    assert_eq!(findings(&status, &status, None), []);
}
