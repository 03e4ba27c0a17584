//! Statuses of nodes, for tests.

use serde_json::{Map, Value};

pub(super) const SENDER: &str = r#"{
    "node": "conveyor", "role": "sender", "health": "ok", "epoch": "91d10b5a3f2c7e08", "uptime_s": 25.25,
    "cycle": 25248, "cycles": 25245, "cycle_time_us": 1000.0, "overruns": 3, "seen_by": ["saw"], "followed": true,
    "axes": { "conveyor": { "id": 1, "unit": "mm", "position": 12478.5, "velocity": 500.0 } }
}"#;

pub(super) const RECEIVER: &str = r#"{
    "node": "saw", "role": "receiver", "health": "error", "epoch": "0d5c1f6a90b3e427", "uptime_s": 25.0,
    "cycle": 24996, "cycles": 24995, "cycle_time_us": 1000.0, "overruns": 1, "seen_by": [],
    "error": { "code": "0x4B52", "text": "no data" },
    "last_fault": { "age_s": 3.0, "text": "1 frame lost" },
    "sources": { "conveyor": { "alive": true, "frame_age_ms": 0.41, "unseen": null } },
    "far": { "conveyor": {
        "health": "ok", "mode": "observer", "error": null, "synced": true, "drift_ppm": 500.1, "drift_sigma_ppm": 0.2,
        "cycle_time_us": 1000.0, "observer_state": "synced", "correction_us": -212.5, "offset_sigma_us": 0.08,
        "slew_remaining_us": -2.0, "delay_state": "measured", "delay_us": 131.2, "delay_uncertainty_us": 104.6,
        "normal_jitter_us": 3.0, "exponential_jitter_us": 4.0, "epoch": 11, "received": 25010, "lost": 3, "late": 2,
        "duplicates": 0, "beats": 4, "rejected": 3, "rejected_wrong_checksum": 2, "rejected_malformed": 1
    } },
    "axes": { "conveyor.3": {
        "node": "conveyor", "id": 3, "unit": "mm", "state": "observer", "synced": true, "error": null,
        "received_position": 12598.0, "corrected_position": 12597.89375
    } },
    "slaves": { "slave": {
        "unit": "mm", "state": "synchronized-motion", "phase": "in-sync", "error": null, "position": 12597.5,
        "master_position": 12598.0, "program": "waiting", "program_step": 2, "label": "cut",
        "program_waits_for": "master-position"
    } }
}"#;

pub(super) fn object(json: &str) -> Map<String, Value> {
    match serde_json::from_str(json) {
        Ok(Value::Object(fields)) => fields,
        other => panic!("{other:?}"),
    }
}
