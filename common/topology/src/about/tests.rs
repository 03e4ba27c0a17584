//! Descriptions that travel, and what no node can mean.

use super::*;

fn node() -> PlantNode {
    let axis = |name: &str, published, origin| PlantAxis {
        name: name.to_owned(),
        field: format!("axes[{}]", u8::from(name == "carriage")),
        published,
        unit: Some(Unit::new("mm").unwrap()),
        modulo: Modulo::new(360.0).ok(),
        limits: Some(StatedLimits {
            velocity: 1.0,
            acceleration: 2.0,
            deceleration: 3.0,
            jerk: None,
        }),
        origin,
    };
    let far = FarReference {
        field: "axes[0]".to_owned(),
        sources: vec![AxisAddress::read("line/axes/1").unwrap()],
        way: WaySource::Unknown,
        showing: Showing::Later(LagRule::Full),
        measured: None,
    };
    PlantNode {
        file: "about of saw".to_owned(),
        name: NodeName::new("saw").unwrap(),
        role: PlantRole::Receiver,
        cycle_time: CycleTime::new(Span::from_millis(1)).ok(),
        axes: vec![
            axis("conveyor", None, AxisOrigin::Far(far)),
            axis(
                "carriage",
                Some((Channel::Slaves, 7)),
                AxisOrigin::Slave { masters: vec![0] },
            ),
        ],
        is_complete: true,
        hold_back: None,
    }
}

#[test]
fn a_description_survives_being_written_and_read() {
    let json = about_to_json(&node(), 0xf00d);
    assert!(
        json.starts_with(
            r#"{"version":1,"node":"saw","epoch":"000000000000f00d","role":"receiver""#
        ),
        "{json}"
    );
    assert_eq!(about_from_json(json.as_bytes()), Ok((node(), 0xf00d)));
}

#[test]
fn fields_and_kinds_of_later_versions_are_ignored() {
    let json = about_to_json(&node(), 1)
        .replace("\"version\":1", "\"version\":1,\"colour\":\"red\"")
        .replace("\"receiver\"", "\"robot\"")
        .replace("\"far\"", "\"teleported\"");
    let (read, _) = about_from_json(json.as_bytes()).unwrap();
    assert_eq!(read.role, PlantRole::Unknown);
    let is_root = matches!(
        read.axes[0].origin,
        AxisOrigin::Root {
            motion: RootMotion::Unknown,
            ..
        }
    );
    assert!(is_root, "{read:?}");
}

#[test]
fn what_no_node_can_mean_is_refused_by_field() {
    let good = about_to_json(&node(), 1);
    for (from, to, expected) in [
        (
            "\"version\":1",
            "\"version\":2",
            "version: received 2, expected 1",
        ),
        (
            "0000000000000001",
            "x",
            "epoch: received x, expected 16 hexadecimal",
        ),
        (
            "1000.0",
            "1.0",
            "cycle_time_us: received 1, expected 100 to 100000",
        ),
        ("1000.0", "1e999", "about: received "),
        (
            "\"velocity\":1.0",
            "\"velocity\":-1.0",
            "axes[0].limits.velocity: received -1, expected a number above 0",
        ),
        ("360.0", "0.0", "about: received "),
        ("\"mm\"", "\"m m\"", "about: received "),
        (
            "line/axes/1",
            "line",
            "axes[0].follows: received line, expected an address",
        ),
        (
            "\"slaves\"",
            "\"time-requests\"",
            "axes[1].channel: received time-requests, expected axes, slaves",
        ),
        (
            "conveyor",
            "",
            "axes[0].name: received \"\", expected 1 to 64",
        ),
        ("\"saw\"", "\"a/b\"", "about: received "),
    ] {
        assert!(good.contains(from), "{from} {good}");
        let error = about_from_json(good.replace(from, to).as_bytes()).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
    }
    let twice = good.replace(
        "\"channel\":null,\"id\":null",
        "\"channel\":\"slaves\",\"id\":7",
    );
    let error = about_from_json(twice.as_bytes()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "axes: received slaves/7 twice, expected each axis once"
    );
    let long = vec![b' '; LONGEST + 1];
    assert!(about_from_json(&long).unwrap_err().field == "bytes");
}

#[test]
fn the_example_of_the_manual_is_one() {
    let manual = include_str!("../../../../docs/WIRE.md");
    let mut lines = manual.lines();
    let is_it = |line: &&str| line.starts_with("{\"version\":1,\"node\":\"line\",\"epoch\"");
    let example = lines.find(is_it).expect("an example");
    let (node, epoch) = about_from_json(example.as_bytes()).unwrap();
    assert_eq!(about_to_json(&node, epoch), example);
}

#[test]
fn whatever_is_in_a_description_it_is_read_or_refused() {
    let good = about_to_json(&node(), 1).into_bytes();
    for place in 0..good.len() {
        assert!(about_from_json(&good[..place]).is_err());
        for byte in [b'0', b'"', b'}', b'-', 0xff] {
            let mut changed = good.clone();
            changed[place] = byte;
            if let Ok((read, epoch)) = about_from_json(&changed) {
                // What is accepted can be passed on.
                let again = about_to_json(&read, epoch);
                assert_eq!(about_from_json(again.as_bytes()), Ok((read, epoch)));
            }
        }
    }
}
