//! The unit *slave* against a slave axis in a loop of one's own: equal to the last bit.
#![allow(missing_docs)]

use std::path::Path;

use coaxle_axis::drive::{Actual, Drive, DriveState};
use coaxle_cam::Tables;
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_fmi::{Resources, UnitInstance, UnitValue};
use coaxle_saw::{GearInPos, SawCommand};
use coaxle_slave::{Command, SlaveAxis, SlaveParameters};

const SAW: &str = include_str!("../../saws/cut-to-length.toml");
const GEAR: &str = include_str!("../../gears/flying-gear-1.toml");
const CAM: &str = include_str!("../../cams/rotary-knife.toml");
const CYCLE_S: f64 = 0.001;

/// A drive that is where it should be.
#[derive(Debug, Default)]
struct IdealDrive(Actual);

impl Drive for IdealDrive {
    fn power_on(&mut self, position: f64, velocity: f64) {
        self.0 = Actual {
            state: DriveState::Following,
            position,
            velocity,
            ..self.0
        };
    }
    fn reset(&mut self) {
        self.0.state = DriveState::Off;
    }
    fn step(&mut self, set: &Kinematics, _elapsed: Seconds) {
        (self.0.position, self.0.velocity) = (set.position, set.velocity);
    }
    fn actual(&self) -> Actual {
        self.0
    }
}

fn unit(text: &str) -> UnitInstance {
    let resources = Resources::of_slave("slave.toml", text, 1000).expect("a cycle time");
    let mut unit = UnitInstance::new(resources.model(Path::new("")).expect("a slave"));
    unit.enter_initialization(0.0).expect("it is new");
    unit
}

fn set(unit: &mut UnitInstance, name: &str, value: UnitValue) {
    let reference = unit.reference(name).expect(name);
    unit.set(reference, value).expect(name);
}

fn number(unit: &UnitInstance, name: &str) -> f64 {
    match unit.get(unit.reference(name).expect(name)) {
        Ok(UnitValue::Float64(number)) => *number,
        other => panic!("{name}: {other:?}"),
    }
}

fn word(unit: &UnitInstance, name: &str) -> String {
    match unit.get(unit.reference(name).expect(name)) {
        Ok(UnitValue::String(word)) => word.clone(),
        other => panic!("{name}: {other:?}"),
    }
}

/// Steps a unit with a master at a constant velocity; returns the messages to the log.
fn step(unit: &mut UnitInstance, n: u32, from: f64, velocity: f64) -> Option<String> {
    set(
        unit,
        "master.position",
        UnitValue::Float64(from + velocity * f64::from(n) * CYCLE_S),
    );
    set(unit, "master.velocity", UnitValue::Float64(velocity));
    unit.step(f64::from(n) * CYCLE_S, CYCLE_S).expect("a step")
}

#[test]
fn a_saw_is_the_slave_axis_to_the_last_bit() {
    let file = coaxle_files::saw::SawFile::parse("saw.toml", SAW).expect("a saw");
    let SawCommand::GearInPos(saw) = file.command else {
        panic!("a saw to a position");
    };
    let limits = SlaveParameters {
        min_position: Some(-5.0),
        max_position: Some(1500.0),
        ..SlaveParameters::new(1500.0, 4000.0, 40000.0)
    };
    let cycle = CycleTime::new(Span::from_millis(1)).expect("a cycle");
    let mut axis = SlaveAxis::new(&limits, Box::<IdealDrive>::default(), cycle).expect("limits");
    let mut plates = Tables::new(0);

    let mut unit = unit(SAW);
    set(&mut unit, "command.execute", UnitValue::Boolean(true));
    unit.exit_initialization().expect("it starts");
    for n in 0..4000 {
        let command = match n {
            0 => Some(Command::Power(true)),
            1 => Some(Command::from(GearInPos { ..saw })),
            2700 => Some(Command::GearOut {}),
            _ => None,
        };
        if let Some(command) = command {
            axis.command(&mut plates, &command).expect("a command");
        }
        let master = Kinematics {
            position: -1000.0 + 500.0 * f64::from(n) * CYCLE_S,
            velocity: 500.0,
            acceleration: 0.0,
        };
        let expected = axis.update(&mut plates, Some(&master), Seconds(CYCLE_S));
        set(&mut unit, "command.release", UnitValue::Boolean(n >= 2700));
        assert_eq!(step(&mut unit, n, -1000.0, 500.0), None);
        let received = ["position", "velocity", "acceleration"].map(|name| number(&unit, name));
        let expected = [expected.position, expected.velocity, expected.acceleration];
        assert_eq!(
            received.map(f64::to_bits),
            expected.map(f64::to_bits),
            "{n}"
        );
        if n == 2699 {
            assert_eq!(
                (word(&unit, "phase"), word(&unit, "command.state")),
                ("in-sync".to_owned(), "in-sync".to_owned())
            );
        }
    }
    assert!(number(&unit, "position") > 100.0);
}

#[test]
fn a_gear_and_a_cam_lead_their_slaves() {
    let mut gear = unit(GEAR);
    set(&mut gear, "command.execute", UnitValue::Boolean(true));
    gear.exit_initialization().expect("it starts");
    for n in 0..1700 {
        assert_eq!(step(&mut gear, n, 800.0, -200.0), None);
    }
    // Synchronous at 460 and 450, 1.7 s from 800 at −200 u/s.
    assert!(
        (number(&gear, "position") - 450.0).abs() < 1.0,
        "{}",
        number(&gear, "position")
    );
    assert!(number(&gear, "velocity") < -100.0);

    let mut cam = unit(CAM);
    set(&mut cam, "command.execute", UnitValue::Boolean(true));
    cam.exit_initialization().expect("it starts");
    for n in 0..1000 {
        assert_eq!(step(&mut cam, n, 0.0, 90.0), None);
    }
    assert_eq!(word(&cam, "phase"), "in-sync");
    // A quarter of a sheet: between the segments that are as fast as the web.
    assert!(
        (80.0..120.0).contains(&number(&cam, "position")),
        "{}",
        number(&cam, "position")
    );
}

#[test]
fn a_refused_command_is_told_to_the_log() {
    let mut saw = unit(SAW);
    set(&mut saw, "command.execute", UnitValue::Boolean(true));
    saw.exit_initialization().expect("it starts");
    // The master is past its synchronisation position.
    assert_eq!(step(&mut saw, 0, 1000.0, 500.0), None);
    let note = step(&mut saw, 1, 1000.0, 500.0).expect("a refusal");
    assert!(note.starts_with("refused: "), "{note}");
    assert_eq!(word(&saw, "command.state"), "idle");
}

#[test]
fn mistakes_are_refused_with_a_sentence() {
    let mut saw = unit(SAW);
    let position = saw.reference("master.position").expect("an input");
    let output = saw.reference("position").expect("an output");
    for (refused, expected) in [
        (
            saw.set(position, UnitValue::Float64(f64::NAN)),
            "master.position: received NaN, expected a finite number",
        ),
        (
            saw.set(position, UnitValue::Boolean(true)),
            "master.position: received Boolean, expected Float64",
        ),
        (
            saw.set(output, UnitValue::Float64(1.0)),
            "position: received a value in initialization mode, expected a parameter or an input",
        ),
        (
            saw.set(9999, UnitValue::Float64(1.0)),
            "valueReference: received 9999, expected 0 to ",
        ),
        (
            saw.enter_initialization(0.0),
            "fmi3EnterInitializationMode: received a call in initialization mode",
        ),
    ] {
        let refused = refused.expect_err(expected).to_string();
        assert!(refused.starts_with(expected), "{refused}");
    }
    let early = saw
        .step(0.0, CYCLE_S)
        .expect_err("before its start")
        .to_string();
    assert!(
        early.starts_with(
            "fmi3DoStep: received a call in initialization mode, expected one in step mode"
        ),
        "{early}"
    );
    set(&mut saw, "limits.velocity", UnitValue::Float64(-1.0));
    let refused = saw
        .exit_initialization()
        .expect_err("no velocity")
        .to_string();
    assert!(
        refused.starts_with("limits.velocity: received -1, expected "),
        "{refused}"
    );
    for (text, expected) in [
        (
            "title = 'x'",
            "received a file without a coupling, expected gear-in-pos",
        ),
        ("x = ", "slave.toml:"),
        (
            &SAW.replace("velocity = 1500", "velocity = 0"),
            "axis.velocity: received 0",
        ),
    ] {
        let resources = Resources::of_slave("slave.toml", text, 1000).expect("a cycle time");
        let refused = format!("{:#}", resources.model(Path::new("")).expect_err(expected));
        assert!(refused.contains(expected), "{refused}");
    }
    let cycle = Resources::of_slave("slave.toml", SAW, 1)
        .expect_err("too short")
        .to_string();
    assert!(cycle.starts_with("cycle-time-us: "), "{cycle}");
}
