//! Orders to slaves and their responses: `docs/WIRE.md` against the code, and bytes that are not an
//! order.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

mod far;

use std::collections::BTreeSet;

use crate::document::{section, table};
use coaxle_axis::guard::GuardRefusal;
use coaxle_axis::{Awaits, AxisStatus};
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_saw::{CouplingMoment, LimitGuard, SlaveLimits};
use coaxle_slave::{Command, CouplingPhase, Dynamics, Refusal};
use coaxle_wire::command::{
    CommandAnswer, CommandOrder, CommandOutcome, CommandVerdict, FarCommand, FarName, InvalidOrder,
    ListedCommand, MAX_KNOWN, MAX_ORDER_BYTES, NotTaken, PlateCommand, SawAttempt, SawRefused,
    SawView, SlaveName, SlaveOrder, SlaveView,
};
use proptest::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

fn name(name: &str) -> SlaveName {
    SlaveName::new(name).unwrap()
}

/// Returns the n-th JSON example of the document's section.
fn example(n: usize) -> &'static str {
    let blocks = section("\n## Commands\n").split("```json").skip(1);
    let example = blocks
        .map(|block| block.split("```").next().unwrap())
        .nth(n);
    example.unwrap()
}

fn documented_order() -> SlaveOrder {
    SlaveOrder {
        addressee: name("carriage"),
        command: Command::MoveAbsolute {
            position: 100.0,
            velocity: Some(200.0),
            dynamics: Dynamics {
                jerk: Some(5000.0),
                ..Dynamics::default()
            },
        },
        dry_run: false,
    }
}

#[test]
fn the_documented_order_is_read_and_read_again_as_written() {
    let order = CommandOrder::from(documented_order());
    let read = CommandOrder::from_json(example(0).as_bytes());
    assert_eq!(read.as_ref(), Ok(&order));
    let again = CommandOrder::from_json(order.to_json().as_bytes());
    assert_eq!(again, Ok(order));
}

#[test]
fn the_documented_answers_are_written() {
    let view = |status, coupling, position, velocity| SlaveView {
        status,
        coupling,
        position,
        velocity,
    };
    let outcomes = [
        CommandOutcome::Accepted {
            job: Some(7),
            awaits: Awaits::empty(),
            slave: view(AxisStatus::DiscreteMotion, None, 12.5, 0.0),
            sync_positions: None,
            saw: None,
        },
        CommandOutcome::Refused {
            refusal: Refusal::Guard(GuardRefusal::AboveLimit {
                field: "velocity",
                received: 900.0,
                limit: 500.0,
            }),
            slave: view(
                AxisStatus::SynchronizedMotion,
                Some(CouplingPhase::InSync),
                812.25,
                250.0,
            ),
            saw: None,
        },
        CommandOutcome::NotTaken(NotTaken::NoSlaves),
    ];
    for (n, outcome) in outcomes.iter().enumerate() {
        let answer = CommandAnswer::new(&documented_order().into(), outcome);
        let documented = example(n + 1);
        let written: Value = serde_json::from_str(&answer.to_json()).unwrap();
        assert_eq!(written, serde_json::from_str::<Value>(documented).unwrap());
        let read = CommandAnswer::from_json(documented.as_bytes()).unwrap();
        assert_eq!(read, answer);
        assert_eq!((answer.is_accepted(), answer.is_taken()), (n == 0, n < 2));
    }
}

fn slave_order(json: &str) -> SlaveOrder {
    match CommandOrder::from_json(json.as_bytes()).unwrap() {
        CommandOrder::Slave(order) => order,
        other => panic!("{other:?}"),
    }
}

/// Returns an order to a slave at rest that is too near, and its coupling moment.
fn too_near() -> (SlaveOrder, CouplingMoment) {
    let order = r#"{ "version": 1, "slave": "s", "dry-run": true, "command": { "gear-in-pos": {
        "ratio": { "numerator": 1.0 }, "master-sync-position": 100.0, "slave-sync-position": 50.0 } } }"#;
    let moment = CouplingMoment {
        master: Kinematics {
            velocity: 1000.0,
            ..Kinematics::default()
        },
        encoder: None,
        slave: Kinematics::default(),
        axis: SlaveLimits {
            dynamics: Limits::new(2000.0, 5000.0, 5000.0, 1e6).unwrap(),
            min_position: None,
            max_position: None,
            guard: Some(LimitGuard { reserve: 0.01 }),
        },
    };
    (slave_order(order), moment)
}

const STANDING: SlaveView = SlaveView {
    status: AxisStatus::Standstill,
    coupling: None,
    position: 0.0,
    velocity: 0.0,
};

#[test]
fn the_documented_refusal_of_a_flying_saw_is_written() {
    let (order, moment) = too_near();
    let saw = order.command.as_saw().unwrap();
    let outcome = CommandOutcome::Refused {
        refusal: Refusal::Coupling(saw.plan(&moment).unwrap_err().into()),
        slave: STANDING,
        saw: Some(SawAttempt {
            command: saw,
            moment,
        }),
    };
    let answer = CommandAnswer::new(&order.into(), &outcome);
    let written: Value = serde_json::from_str(&answer.to_json()).unwrap();
    let documented: Value = serde_json::from_str(example(4)).unwrap();
    assert_eq!(written, documented, "{}", answer.to_json());
    assert!(CommandAnswer::from_json(example(4).as_bytes()).is_ok());

    // The suggested values are accepted.
    let SawRefused { remedy, .. } = match answer.verdict {
        CommandVerdict::Refused { saw: Some(saw), .. } => saw,
        other => panic!("{other:?}"),
    };
    let mut slower = moment;
    slower.master.velocity = remedy.master_speed.unwrap();
    assert!(saw.plan(&slower).is_ok());
    let mut earlier = moment;
    earlier.master.position = 100.0 - remedy.master_distance.unwrap();
    assert!(saw.plan(&earlier).is_ok());
}

#[test]
fn a_flying_saw_is_answered_with_its_figures() {
    let (order, mut moment) = too_near();
    moment.master.velocity = 100.0;
    let plan = order.command.as_saw().unwrap().plan(&moment).unwrap();
    let answered = |order: &SlaveOrder, axis_id| {
        let outcome = CommandOutcome::Accepted {
            job: None,
            awaits: Awaits::empty(),
            slave: STANDING,
            sync_positions: None,
            saw: Some(SawView { plan, axis_id }),
        };
        let answer = CommandAnswer::new(&CommandOrder::from(*order), &outcome);
        assert!(CommandAnswer::from_json(answer.to_json().as_bytes()).is_ok());
        serde_json::from_str::<Value>(&answer.to_json()).unwrap()["saw"].clone()
    };
    let figures = answered(&order, 3);
    assert_eq!(figures["form"], "quintic");
    assert_eq!(figures["duration"], 1.0);
    assert_eq!(figures["slave-sync-position"], 50.0);
    assert_eq!(figures["peak-velocity"], 100.0);
    assert_eq!(figures["characteristics"], Value::Null);

    let read = SlaveOrder {
        command: Command::ReadFlyingSawCharacteristics {},
        ..order
    };
    let figures = answered(&read, 3);
    assert_eq!(figures["table"]["id"], 253);
    let values = figures["characteristics"].as_array().unwrap();
    assert_eq!(values.len(), 31);
    assert_eq!(values[7], json!({ "name": "fSlavePosEnd", "value": 50.0 }));
    assert_eq!(answered(&read, 256)["table"], Value::Null);
}

#[test]
fn every_command_is_documented_with_an_example_that_is_one() {
    let mut documented = BTreeSet::new();
    for row in table("### What a slave can be told") {
        let text = format!(r#"{{ "version": 1, "slave": "s", "command": {} }}"#, row[0]);
        let order = CommandOrder::from_json(text.as_bytes())
            .unwrap_or_else(|error| panic!("{}: {error}", row[0]));
        assert!(row[1].starts_with(order.command_name()), "{row:?}");
        let command: Value = serde_json::from_str(row[0]).unwrap();
        documented.extend(command.as_object().unwrap().keys().cloned());
    }
    assert_eq!(documented, commands());
}

/// Returns the keys of all commands to slaves but those about plates, as the code lists them.
fn commands() -> BTreeSet<String> {
    let keys = Command::ROWS.iter().map(|row| row.key.to_owned());
    keys.collect()
}

/// Names in an error that lists the expected ones.
fn expected_in(error: &str) -> Vec<&str> {
    let (_, known) = error.split_once("expected one of").unwrap();
    known.split('`').skip(1).step_by(2).collect()
}

fn serde_error<T: DeserializeOwned>(command: Value) -> String {
    serde_json::from_value::<T>(command)
        .err()
        .unwrap()
        .to_string()
}

#[test]
fn the_keys_in_the_table_are_those_that_serde_reads() {
    let dance = json!({ "dance": {} });
    let slave = Command::ROWS.iter().map(|row| row.key);
    let error = serde_error::<Command>(dance.clone());
    assert_eq!(expected_in(&error), slave.collect::<Vec<_>>());
    let plate = <PlateCommand>::ROWS.iter().map(|row| row.key);
    let error = serde_error::<PlateCommand>(dance.clone());
    assert_eq!(expected_in(&error), plate.collect::<Vec<_>>());
    let far = FarCommand::ROWS.iter().map(|row| row.key);
    let error = serde_error::<FarCommand>(dance);
    assert_eq!(expected_in(&error), far.collect::<Vec<_>>());
}

#[test]
fn an_unknown_command_is_answered_with_those_of_its_addressee() {
    for addressee in ["slave", "far"] {
        let order = json!({ "command": { "dance": {} }, addressee: "x", "version": 1 });
        let error = CommandOrder::from_json(order.to_string().as_bytes()).unwrap_err();
        let text = error.to_string();
        let expected = ListedCommand::all()
            .filter(|command| command.family.is_about_far_node() == (addressee == "far"))
            .map(|command| command.key);
        assert_eq!(expected_in(&text), expected.collect::<Vec<_>>(), "{text}");
        assert!(
            text.starts_with("command: unknown variant `dance`"),
            "{text}"
        );
    }
}

#[test]
fn a_key_belongs_to_a_single_command() {
    let keys: BTreeSet<_> = ListedCommand::all().map(|command| command.key).collect();
    assert_eq!(keys.len(), ListedCommand::all().count());
}

#[test]
fn every_reason_is_documented() {
    let documented: BTreeSet<_> = table("| reason |").into_iter().map(|row| row[0]).collect();
    let mut expected = BTreeSet::from(["malformed"]);
    expected.extend(
        [
            NotTaken::NoSlaves,
            NotTaken::UnknownSlave {
                received: name("x"),
                known: [None; MAX_KNOWN],
            },
            NotTaken::NoFarNodes,
            NotTaken::UnknownFarNode {
                received: FarName::new("x").unwrap(),
                known: [None; MAX_KNOWN],
            },
            NotTaken::Busy,
            NotTaken::NoAnswer,
            NotTaken::Stopped,
        ]
        .iter()
        .map(NotTaken::name),
    );
    assert_eq!(documented, expected);
}

#[test]
fn what_is_wrong_with_an_order_is_named() {
    let halt = json!({ "halt": {} });
    for (order, expected) in [
        (json!({}), "missing field `version`"),
        (json!([1, 2]), "trailing characters"),
        (
            json!({ "version": 2, "anything": "else" }),
            "version: received 2, expected 1",
        ),
        (
            json!({ "version": 1, "command": halt }),
            "missing field `slave`",
        ),
        (
            json!({ "version": 1, "slave": "a b", "command": halt }),
            "slave: \"a b\" is no slave name",
        ),
        (
            json!({ "version": 1, "slave": "s", "command": halt, "dryrun": true }),
            "dryrun: unknown field `dryrun`",
        ),
        (
            json!({ "version": 1, "slave": "s", "command": { "home": { "position": "x" } } }),
            "command.home.position: invalid type",
        ),
        (
            json!({ "version": 1, "slave": "s", "command": { "home": {} } }),
            "missing field `position`",
        ),
        (
            json!({ "version": 1, "slave": "s", "command": { "halt": {}, "reset": {} } }),
            "command",
        ),
    ] {
        let error = CommandOrder::from_json(order.to_string().as_bytes()).unwrap_err();
        let answer = CommandAnswer::malformed(&error);
        let CommandVerdict::NotTaken { reason, text } = answer.verdict else {
            panic!("{order} is taken");
        };
        assert_eq!(reason, "malformed");
        assert!(text.contains(expected), "{order}: {text}");
    }
    let twice = format!("{0}{0}", CommandOrder::from(documented_order()).to_json());
    assert!(CommandOrder::from_json(twice.as_bytes()).is_err());
}

#[test]
fn an_order_that_is_too_long_is_not_even_looked_at() {
    let mut text = CommandOrder::from(documented_order()).to_json();
    text.extend(std::iter::repeat_n(' ', MAX_ORDER_BYTES - text.len()));
    assert!(CommandOrder::from_json(text.as_bytes()).is_ok());
    text.push(' ');
    let received = MAX_ORDER_BYTES + 1;
    let error = CommandOrder::from_json(text.as_bytes());
    assert_eq!(error, Err(InvalidOrder::TooLong { received }));
}

#[test]
fn somebody_who_asks_for_an_unknown_slave_hears_which_there_are() {
    let mut known = [None; MAX_KNOWN];
    known[0] = Some(name("carriage"));
    known[1] = Some(name("tool"));
    let unknown = NotTaken::UnknownSlave {
        received: name("cariage"),
        known,
    };
    let text = unknown.to_string();
    assert_eq!(text, "slave: received \"cariage\", expected carriage, tool");
}

#[test]
fn an_answer_of_another_version_or_with_more_fields() {
    let mut answer: Value = serde_json::from_str(example(1)).unwrap();
    answer["weather"] = json!("fine");
    assert!(CommandAnswer::from_json(answer.to_string().as_bytes()).is_ok());
    answer["version"] = json!(2);
    let error = CommandAnswer::from_json(answer.to_string().as_bytes()).unwrap_err();
    assert!(
        error.to_string().contains("received 2, expected 1"),
        "{error}"
    );
}

#[test]
fn a_dry_run_has_no_job() {
    let order = SlaveOrder {
        dry_run: true,
        ..documented_order()
    };
    let outcome = CommandOutcome::Accepted {
        job: Some(7),
        awaits: Awaits::empty(),
        slave: SlaveView {
            status: AxisStatus::Standstill,
            coupling: None,
            position: 0.0,
            velocity: 0.0,
        },
        sync_positions: None,
        saw: None,
    };
    let CommandVerdict::Accepted { dry_run, job, .. } =
        CommandAnswer::new(&order.into(), &outcome).verdict
    else {
        panic!("not accepted");
    };
    assert_eq!((dry_run, job), (true, None));
}

/// Every documented command.
fn any_order() -> impl Strategy<Value = String> {
    let commands: Vec<_> = table("### What a slave can be told")
        .into_iter()
        .map(|row| row[0])
        .collect();
    let with = |command| format!(r#"{{"version":1,"slave":"s","command":{command}}}"#);
    proptest::sample::select(commands).prop_map(with)
}

proptest! {
    #[test]
    fn no_bytes_make_the_decoder_panic(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        let _ = CommandOrder::from_json(&bytes);
        let _ = CommandAnswer::from_json(&bytes);
    }

    #[test]
    fn a_damaged_order_is_refused_or_means_something(
        text in any_order(),
        place in any::<proptest::sample::Index>(),
        byte in any::<u8>(),
        length in any::<proptest::sample::Index>(),
    ) {
        let mut bytes = text.into_bytes();
        let place = place.index(bytes.len());
        bytes[place] = byte;
        if let Ok(order) = CommandOrder::from_json(&bytes) {
            let again = CommandOrder::from_json(order.to_json().as_bytes());
            let again = again.map(|again| again.command_name());
            prop_assert_eq!(again, Ok(order.command_name()));
        }
        bytes.truncate(length.index(bytes.len()));
        prop_assert!(CommandOrder::from_json(&bytes).is_err());
    }

    #[test]
    fn every_finite_position_survives_but_for_its_last_bits(
        position in proptest::num::f64::NORMAL,
    ) {
        let order = CommandOrder::from(SlaveOrder {
            command: Command::Home { position },
            ..documented_order()
        });
        let read = slave_order(&order.to_json());
        let Command::Home { position: read } = read.command else {
            panic!("another command");
        };
        prop_assert!((read - position).abs() <= position.abs() * 4.0 * f64::EPSILON);
    }

    #[test]
    fn deep_nesting_is_refused(depth in 1_usize..2000) {
        let text = "[".repeat(depth);
        prop_assert!(CommandOrder::from_json(text.as_bytes()).is_err());
    }
}
