//! Orders about cam plates, as in the document, and their responses.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use crate::document::table;
use coaxle_axis::{Awaits, AxisStatus};
use coaxle_cam::Tables;
use coaxle_plate::MotionPoint;
use coaxle_wire::command::{
    CamFigures, CamOrder, CommandVerdict, InvalidOrder, MAX_ORDER_BYTES, MAX_PLATE_ORDER_BYTES,
    MAX_VALUES_READ, OrderCargo, PlateCommand, SlaveView,
};
use coaxle_wire::{CommandAnswer, CommandOrder, CommandOutcome};
use serde_json::{Value, json};

fn order(command: &str) -> Result<CommandOrder, InvalidOrder> {
    let text = format!(r#"{{"version":1,"slave":"knife","command":{command}}}"#);
    CommandOrder::from_json(text.as_bytes())
}

fn cam(command: &str) -> CamOrder {
    match order(command) {
        Ok(CommandOrder::Plate(order)) => order,
        other => panic!("{command}: {other:?}"),
    }
}

#[test]
fn every_documented_order_is_read_and_written_again() {
    let rows = table("### What a slave can be told about cam plates");
    let mut seen = Vec::new();
    for row in &rows {
        let order = cam(row[0]);
        let (name, _) = row[0].split_once(": {").expect("a command");
        seen.push(name.trim_matches(['{', ' ', '"']).to_owned());
        let order = CommandOrder::from(order);
        let again = CommandOrder::from_json(order.to_json().as_bytes());
        assert_eq!(again.as_ref(), Ok(&order), "{}", row[0]);
        if let (CommandOrder::Plate(order), true) = (&order, row[1].starts_with("MC_")) {
            assert!(row[1].contains(order.command.name()), "{row:?}");
        }
    }
    let is_documented = |name: &&str| seen.iter().any(|other| other == name);
    assert!(
        <PlateCommand>::ROWS
            .iter()
            .map(|row| row.key)
            .all(|key| is_documented(&key)),
        "{seen:?}"
    );
}

const SELECT: &str = r#"{"cam-table-select":{"table":3,"plate":{"course":"cyclic","point":[
    {"law":"polynom5","master":0,"slave":0},{"law":"polynom5","master":180,"slave":50},{"master":360,"slave":0}]}}}"#;

#[test]
fn a_plate_is_what_a_cam_file_holds() {
    let with_words = SELECT.replace(
        "\"course\"",
        "\"title\":\"Up\",\"table-id\":7,\"master-unit\":\"°\",\"slave-unit\":\"mm\",\"course\"",
    );
    assert_eq!(cam(&with_words).command.table(), 3, "the order's own");
    let number_in_plate = with_words.replace("\"table\":3,", "");
    assert_eq!(cam(&number_in_plate).command.table(), 7);
    for (command, expected) in [
        (SELECT.replace("\"law\":\"polynom5\",\"master\":180", "\"master\":180"), "point 2, law: received none"),
        (SELECT.replace("cyclic", "round"), "unknown variant `round`"),
        (SELECT.replace("\"course\"", "\"csv\":\"x\",\"course\""), "unknown field `csv`"),
        (r#"{"cam-table-select":{"table":3,"plate":{}}}"#.to_owned(), "0x4b35: received neither point nor table"),
        (SELECT.replace("\"course\"", "\"table\":{\"rows\":[[0,0],[1,1]]},\"course\""), "0x4b35: received point and table"),
        (r#"{"cam-table-select":{"table":3}}"#.to_owned(), "missing field `plate`"),
        (r#"{"read-motion-function-values":{"table":1,"from":0,"to":1,"increment":1,"values":["snap"]}}"#.to_owned(), "received \"snap\""),
        (r#"{"cam-info":{"tabel":3}}"#.to_owned(), "unknown field `tabel`"),
    ] {
        let error = order(&command).unwrap_err().to_string();
        assert!(error.contains(expected), "{command}: {error}");
    }
}

#[test]
fn only_a_plate_may_be_long() {
    let long = |command: &str, bytes: usize| {
        let text = format!(r#"{{"version":1,"slave":"knife","command":{command}}}"#);
        let blanks = " ".repeat(bytes - text.len());
        CommandOrder::from_json((text + &blanks).as_bytes())
    };
    assert!(long(SELECT, MAX_PLATE_ORDER_BYTES).is_ok());
    for (command, received) in [
        (SELECT, MAX_PLATE_ORDER_BYTES + 1),
        (r#"{"cam-info":{}}"#, MAX_ORDER_BYTES + 1),
        (r#"{"halt":{}}"#, MAX_ORDER_BYTES + 1),
    ] {
        assert_eq!(
            long(command, received),
            Err(InvalidOrder::TooLong { received })
        );
    }
}

#[test]
fn what_makes_no_plate_comes_with_its_error_instead() {
    let descending = SELECT.replace("\"master\":180", "\"master\":400");
    let cargo = CommandOrder::from(cam(&descending)).cargo();
    let OrderCargo::Wrong(error) = cargo else {
        panic!("{cargo:?}");
    };
    assert_eq!((error.code(), error.row()), (0x4A06, Some(2)));
    let huge = SELECT.replace("\"slave\":50", "\"slave\":1e16");
    let cargo = CommandOrder::from(cam(&huge)).cargo();
    assert!(matches!(cargo, OrderCargo::Wrong(error) if error.code() == 0x4A1C));
    let empty = r#"{"cam-table-select":{"table":3,"plate":{"table":{"rows":[]}}}}"#;
    let cargo = CommandOrder::from(cam(empty)).cargo();
    assert!(matches!(cargo, OrderCargo::Wrong(error) if error.code() == 0x4B36));
}

const VIEW: SlaveView = SlaveView {
    status: AxisStatus::Standstill,
    coupling: None,
    position: 0.0,
    velocity: 0.0,
};

/// Returns a document with its numbers rounded.
fn shape(value: &Value) -> Value {
    match value {
        Value::Number(number) => format!("{:.12e}", number.as_f64().unwrap()).into(),
        Value::Array(items) => items.iter().map(shape).collect(),
        Value::Object(fields) => fields
            .iter()
            .map(|(name, value)| (name.clone(), shape(value)))
            .collect(),
        other => other.clone(),
    }
}

/// Returns the response to a reading command on the plate of `SELECT`, whose second point was written
/// since.
fn answered(command: &str) -> CommandAnswer {
    let mut tables = Tables::new(1);
    let mut cargo = CommandOrder::from(cam(SELECT)).cargo();
    let OrderCargo::Table(table) = &mut cargo else {
        panic!("{cargo:?}");
    };
    tables.select(3, false, table, 100).unwrap();
    tables
        .write(3, &[MotionPoint::rest(2, 180.0, 80.0)])
        .unwrap();
    let order = CommandOrder::from(cam(command));
    let mut cargo = order.cargo();
    let OrderCargo::Reading(reading) = &mut cargo else {
        panic!("{cargo:?}");
    };
    tables.read_plate(3, reading).unwrap();
    let taken = CommandOutcome::Accepted {
        job: None,
        awaits: Awaits::empty(),
        slave: VIEW,
        sync_positions: None,
        saw: None,
    };
    let answer = CommandAnswer::with_cargo(&order, &taken, &cargo);
    // A reader may be off by the last bit of a number, so the shape is compared.
    let read = CommandAnswer::from_json(answer.to_json().as_bytes()).unwrap();
    let shape = |answer: &CommandAnswer| shape(&serde_json::from_str(&answer.to_json()).unwrap());
    assert_eq!(shape(&read), shape(&answer), "it is read as it is written");
    answer
}

fn figures(command: &str) -> (CamFigures, Value) {
    let answer = answered(command);
    let json: Value = serde_json::from_str(&answer.to_json()).unwrap();
    match answer.verdict {
        CommandVerdict::Accepted { cam: Some(cam), .. } => (cam, json["cam"].clone()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn points_are_read_as_they_are_in_force() {
    let (_, json) = figures(r#"{"read-motion-function":{"table":3}}"#);
    let points = &json["points"];
    assert_eq!(points["number-of-rows"], 3);
    assert_eq!(points["points"].as_array().map(Vec::len), Some(3));
    assert_eq!(points["points"][1]["slave"], 80.0);
    let (_, json) = figures(r#"{"read-motion-function-point":{"table":3,"point":2}}"#);
    let expected = json!([{ "index": 2, "law": "polynom5", "type": "rest", "relative-next": 1, "master": 180.0, "slave": 80.0,
        "velocity": 0.0, "acceleration": 0.0, "jerk": 0.0 }]);
    assert_eq!(json["points"]["points"], expected);
    let (_, json) = figures(r#"{"read-motion-function":{"table":3,"point":2,"number":1}}"#);
    assert_eq!(json["points"]["points"], expected);
}

#[test]
fn values_come_in_the_columns_that_were_asked_for() {
    let ask = |values: &str| {
        figures(&format!(
            r#"{{"read-motion-function-values":{{"table":3,"from":-180,"to":180,"increment":90,"values":{values}}}}}"#
        ))
        .1["values"]
            .clone()
    };
    let by_name = ask(r#"["velocity","position"]"#);
    assert_eq!(
        by_name["columns"],
        json!(["master", "position", "velocity"])
    );
    assert_eq!(by_name["rows"].as_array().map(Vec::len), Some(5));
    assert_eq!(by_name["rows"][4], json!([180.0, 80.0, 0.0]));
    assert_eq!(ask("3"), by_name);
    assert_eq!(ask("8")["columns"], json!(["master", "jerk"]));
}

#[test]
fn dynamics_characteristics_and_masters_are_those_of_the_plate() {
    let (_, json) = figures(
        r#"{"read-cam-table-slave-dynamics":{"table":3,"master-position":90,"master-velocity":360}}"#,
    );
    let dynamics = &json["slave-dynamics"];
    assert_eq!(dynamics["position"], 40.0);
    // The quintic's largest velocity is 1.875 of the mean one.
    let velocity = dynamics["velocity"].as_f64().unwrap();
    assert!((velocity - 1.875 * 80.0 * 2.0).abs() < 1e-9, "{velocity}");

    let (found, _) = figures(r#"{"read-cam-table-characteristics":{"table":3}}"#);
    let CamFigures::Characteristics(found) = found else {
        panic!("{found:?}");
    };
    assert_eq!(
        (
            found.values.len(),
            found.number_of_rows,
            found.velocity_steps
        ),
        (31, 3, 0)
    );
    let value = |name: &str| found.values.iter().find(|v| v.name == name).unwrap().value;
    assert_eq!(
        (value("fSlavePosMax"), value("fMPosAtSPosMax")),
        (80.0, 180.0)
    );

    let (_, json) = figures(
        r#"{"read-cam-table-master-position":{"table":3,"slave-position":165,"master-start-position":180,
            "slave-offset":5,"slave-scaling":2,"master-offset":-10}}"#,
    );
    // 165 is the top of the scaled plate and its offset, at 180 on the plate.
    for side in ["low", "high"] {
        let found = &json["master-position"][side];
        assert!(
            (found["master-cam-position"].as_f64().unwrap() - 180.0).abs() < 1e-6,
            "{json}"
        );
    }
    assert_eq!(
        json["master-position"]["low"]["master-axis-position"],
        -170.0
    );
    assert_eq!(
        json["master-position"]["high"]["master-axis-position"],
        190.0
    );
}

#[test]
fn what_cannot_be_read_is_refused_with_its_code() {
    for (command, code) in [
        (r#"{"read-motion-function-point":{"table":3,"point":4}}"#.to_owned(), "0x4b33"),
        (r#"{"read-motion-function":{"table":3,"point":0}}"#.to_owned(), "0x4b33"),
        (r#"{"read-motion-function-values":{"table":3,"from":0,"to":9,"increment":-1}}"#.to_owned(), "0x4b38"),
        (r#"{"read-motion-function-values":{"table":3,"from":0,"to":9,"increment":1,"values":[]}}"#.to_owned(), "0x4b37"),
        (r#"{"read-motion-function-values":{"table":3,"from":0,"to":9,"increment":1,"values":16}}"#.to_owned(), "0x4b37"),
        (
            format!(r#"{{"read-motion-function-values":{{"table":3,"from":0,"to":{MAX_VALUES_READ},"increment":1}}}}"#),
            "0x4b36",
        ),
        (r#"{"read-cam-table-characteristics":{"table":3,"master-velocity":0}}"#.to_owned(), "0x4a1c"),
        (r#"{"read-cam-table-master-position":{"table":3,"slave-position":1,"slave-scaling":0}}"#.to_owned(), "0x4a1c"),
    ] {
        match answered(&command).verdict {
            CommandVerdict::Refused { code: received, text, axis, .. } => {
                assert_eq!(received, code, "{command}: {text}");
                assert_eq!(axis, Some(VIEW));
            }
            other => panic!("{command}: {other:?}"),
        }
    }
}
