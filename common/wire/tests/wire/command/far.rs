//! Orders about far nodes.

use super::*;
use coaxle_clock::far_clock::DelaySource;
use coaxle_clock::time_sync::{AGE_LIMIT, TimeSyncParameters, WrongParameter};
use coaxle_remote::{AxisSyncParameters, ExtrapolateParameters, FilterMode};
use coaxle_wire::command::{FarOrder, FarRefusal, FarView, ParameterPart};

fn far_order(command: &str) -> Result<FarOrder, InvalidOrder> {
    let text = format!(r#"{{ "version": 1, "far": "belt", "command": {command} }}"#);
    match CommandOrder::from_json(text.as_bytes())? {
        CommandOrder::Far(order) => Ok(order),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_order_is_for_a_slave_or_a_far_node() {
    let text = r#"{ "version": 1, "far": "a", "slave": "s", "command": { "enable": {} } }"#;
    let error = CommandOrder::from_json(text.as_bytes());
    assert_eq!(error, Err(InvalidOrder::TwoAddressees));
    let error = far_order(r#"{ "halt": {} }"#).unwrap_err().to_string();
    assert!(error.contains("halt"), "{error}");
    let error = far_order(r#"{ "set-parameters": { "time-sync": { "age": 1 } } }"#);
    let error = error.unwrap_err().to_string();
    assert!(
        error.starts_with("command.set-parameters.time-sync.age: "),
        "{error}"
    );
    let error = far_order(r#"{ "filter-mode": "fast" }"#)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("expected one of `sync`, `bypass`"),
        "{error}"
    );
}

#[test]
fn every_command_about_a_far_node_is_documented_with_an_example_that_is_one() {
    let mut documented = BTreeSet::new();
    for row in table("### What a node can be told about a far node") {
        let order = far_order(row[0]).unwrap_or_else(|error| panic!("{}: {error}", row[0]));
        documented.insert(order.command.name());
        let again = CommandOrder::from_json(CommandOrder::from(order).to_json().as_bytes());
        assert_eq!(again, Ok(order.into()), "written as it is read");
    }
    let keys = FarCommand::ROWS.iter().map(|row| row.key);
    assert_eq!(documented, keys.collect());
    let error = far_order(r#"{ "dance": {} }"#).unwrap_err().to_string();
    let (_, known) = error.split_once("expected one of").unwrap();
    let known: BTreeSet<_> = known.split('`').skip(1).step_by(2).collect();
    assert_eq!(known, documented);
}

#[test]
fn the_documented_example_of_parameters_has_them_all_at_their_defaults() {
    let rows = table("### What a node can be told about a far node");
    let is_it = |row: &&Vec<&str>| row[0].contains("set-parameters");
    let order = far_order(rows.iter().find(is_it).unwrap()[0]).unwrap();
    let FarCommand::SetParameters(changes) = order.command else {
        panic!("{order:?}");
    };
    let odd = ExtrapolateParameters {
        t1_factor_pos: 1.0,
        use_acc_for_extrapolation: false,
        ..ExtrapolateParameters::default()
    };
    let changed = changes.over(AxisSyncParameters {
        extrapolate: odd,
        ..AxisSyncParameters::default()
    });
    let expected = AxisSyncParameters {
        extrapolate: ExtrapolateParameters {
            max_position_diff: 0.5,
            ..ExtrapolateParameters::default()
        },
        // Stated, it is the manual's default; unstated, it depends on the mode.
        time_sync: TimeSyncParameters {
            age_of_data_limit: Some(AGE_LIMIT),
            ..TimeSyncParameters::default()
        },
        ..AxisSyncParameters::default()
    };
    assert_eq!(changed, expected);
    let written = serde_json::to_value(changes).unwrap();
    assert_eq!(
        written["time-sync"].as_object().map(|all| all.len()),
        Some(14)
    );
}

#[test]
fn the_documented_refusal_about_a_far_node_is_written() {
    let order = far_order(r#"{ "set-parameters": { "extrapolate": { "blending-time-s": -1 } } }"#);
    let far = FarView {
        enabled: true,
        mode: FilterMode::Observer,
        synced: true,
        delay: DelaySource::Measured,
    };
    let refusal = FarRefusal::Parameter {
        part: ParameterPart::Extrapolate,
        wrong: WrongParameter {
            parameter: "blending-time-s",
            received: -1.0,
            expected: "a finite number of at least 0",
        },
    };
    let order = order.unwrap().into();
    let answer = CommandAnswer::new(&order, &CommandOutcome::FarRefused { refusal, far });
    let written: Value = serde_json::from_str(&answer.to_json()).unwrap();
    assert_eq!(written, serde_json::from_str::<Value>(example(5)).unwrap());
    assert_eq!(
        CommandAnswer::from_json(example(5).as_bytes()).unwrap(),
        answer
    );
    let answer = CommandAnswer::new(&order, &CommandOutcome::FarAccepted { far });
    assert!(answer.is_accepted());
    let written: Value = serde_json::from_str(&answer.to_json()).unwrap();
    assert_eq!(written.get("axis"), None);
    assert_eq!(written["far"]["mode"], "observer");
}
