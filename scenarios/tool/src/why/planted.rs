//! Runs in virtual time with a planted cause, which has to be named first.

use coaxle_lab::read;
use coaxle_lab::run::Options;
use coaxle_lab::stage::VirtualTime;
use coaxle_node::fields_of;
use coaxle_report::reported::{self, Presentation};
use serde_json::{Map, Value, json};

use super::StatusFields;
use super::causes::{LimitingCause, findings};

/// A belt, 300 µs away, whose delay is known. The last cycle of a run is the one of which is asked.
const PLANT: &str = r#"
title = "A planted cause"
duration-s = 20
network = { latency-us = 300, jitter = { exponential-us = 5 } }

[[sender]]
name = "line"
cycle-time-us = 1000
clock = { drift-ppm = 50 }

[[sender.axis]]
id = 1
name = "belt"
unit = "mm"

[sender.axis.program]
start-velocity = 500
limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }

[[receiver]]
name = "saw"
cycle-time-us = 1000
master = { node = "line", axis = 1, unit = "mm" }
delay = { fixed-us = 300 }
clock = { start-phase-us = 350 }
sync.time-sync = { age-of-data-limit = 500, max-cycle-index-difference = 500, automatic-re-init = true }
"#;

/// A belt that speeds up and slows down all the time.
const IN_MOTION: &str = "sender.line.axis.belt.program.steps=[{ enable = true }, { loop = { count = 100, steps = [{ velocity = { value = 900, \
                         for-s = 0.2 } }, { velocity = { value = 100, for-s = 0.2 } }] } }]";

/// Findings of the plant with these changes.
fn found(overrides: &[&str]) -> Vec<LimitingCause> {
    let out = tempfile::tempdir().expect("a scratch folder");
    let mut table: toml::Table = PLANT.parse().expect("TOML");
    for set in overrides {
        coaxle_lab::overrides::apply(&mut table, set).expect("a field of the plant");
    }
    let scenario = read::scenario("plant", table).expect("a scenario");
    let options = Options {
        seed: None,
        overrides: Vec::new(),
        receivers: Vec::new(),
        out: out.path().to_owned(),
        trace: None,
    };
    let finished = reported::run(
        "plant",
        &scenario,
        &options,
        &Presentation::default(),
        &VirtualTime,
        &mut (),
    );
    let summary = finished.expect("it runs").summary;
    let last = &summary.receivers["saw"].last;
    let with = |mut fields: Map<String, Value>, more: Value| {
        fields.extend(more.as_object().cloned().unwrap_or_default());
        Value::Object(fields)
    };
    // A status nests them, and words its faults.
    let far = with(fields_of(&last.far), json!({ "error": null }));
    let axis = with(
        fields_of(&last.axis),
        json!({ "node": "line", "unit": "mm" }),
    );
    let age = f64::from(last.far.age_cycles);
    let status = json!({
        "overruns": 0, "far": { "line": far }, "axes": { "line.1": axis }, "sources": { "line": { "frame_age_ms": age } }
    });
    let status = status.as_object().expect("an object");
    let status = StatusFields::of(status);
    findings(&status, &status, None)
}

#[test]
fn the_cause_that_was_planted_is_named_first() {
    for (cause, overrides) in [
        (
            "delay",
            &["receiver.saw.delay=measured", "network.latency-us=20000"][..],
        ),
        (
            "delay",
            &["receiver.saw.delay=off", "network.latency-us=20000"],
        ),
        ("jitter", &["network.jitter={ normal-us = 2000 }"]),
        (
            "offset",
            &["receiver.saw.sync.time-sync.delay-time-offset-s=0.03"],
        ),
        ("mode", &["receiver.saw.mode=bypass"]),
        (
            "mode",
            &["receiver.saw.mode=sync", "sender.line.clock.drift-ppm=500"],
        ),
        (
            "prediction",
            &[
                IN_MOTION,
                "network.latency-us=20000",
                "receiver.saw.delay={ fixed-us = 20000 }",
            ],
        ),
        (
            "prediction",
            &[
                IN_MOTION,
                "network.latency-us=20000",
                "receiver.saw.delay={ fixed-us = 20000 }",
                "sender.line.axis.belt.present-after-ms=5",
            ],
        ),
        (
            "not-in-sync",
            &["receiver.saw.faults.partitions=[{ at-s = 15, for-s = 10 }]"],
        ),
        ("not-in-sync", &["receiver.saw.faults.corruption=1"]),
    ] {
        let found = found(overrides);
        let first = found.first().map(|finding| finding.cause);
        assert_eq!(first, Some(cause), "{overrides:?}: {found:#?}");
    }
}

#[test]
fn a_plant_in_order_has_nothing_wrong_and_errors_of_micrometres() {
    let found = found(&[]);
    assert!(found.iter().all(|finding| !finding.is_wrong), "{found:#?}");
    let way = found.first().and_then(|finding| finding.way.as_ref());
    assert!(way.is_none_or(|way| way.by < 0.005), "{found:#?}");
}
