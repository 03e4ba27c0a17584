//! A coupling from the start that waits for its master, and commands in the meantime.

use coaxle_axis::AxisStatus;
use coaxle_node::{CommandOrder, CommandOutcome, Node};
use coaxle_receiver::Receiver;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_slave::CouplingPhase;

use crate::nodes::{Far, MILLISECOND, receiver, run};

const KNIFE: &str = "
cams = [{ table-id = 1, course = 'cyclic', point = [
  { law = 'polynom5', type = 'rest', master = 0, slave = 0 },
  { law = 'polynom5', type = 'rest', master = 180, slave = 40 },
  { type = 'rest', master = 360, slave = 0 },
] }]
[[far]]
node = 'belt'
delay = 'off'
[[slave]]
name = 'knife'
couple = 'gear'
gear.ratio = 0.5
limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }
";

const MODE: &str =
    r#"{"set-cam-online-change-mode":{"table":1,"mode":{"activation":{"mode":"next-cycle"}}}}"#;

const POINT: &str = r#"{"write-motion-function":{"table":1,"points":[{"index":2,"type":"rest","law":"polynom5","master":180,"slave":50}]}}"#;

fn execute(receiver: &mut Receiver, command: &str) {
    let text = format!(r#"{{"version":1,"slave":"knife","command":{command}}}"#);
    let order = CommandOrder::from_json(text.as_bytes()).expect("an order");
    let outcome = receiver.execute(&order);
    assert!(
        matches!(outcome, CommandOutcome::Accepted { .. }),
        "{command}: {outcome:?}"
    );
}

/// The slave after these commands, given before there is a master: at once, and with its master.
fn before_and_after(config: &str, commands: &[&str]) -> [SlaveSignals; 2] {
    let mut receiver = receiver(config);
    let mut far = [Far::new(0, MILLISECOND, &[400.0])];
    far[0].silent = true;
    run(&mut receiver, &mut far, 100 * MILLISECOND, |_, _| {});
    for command in commands {
        execute(&mut receiver, command);
    }
    run(&mut receiver, &mut far, 200 * MILLISECOND, |_, _| {});
    let before = receiver.snapshot().signals.slaves[0];
    far[0].silent = false;
    run(&mut receiver, &mut far, 4_000 * MILLISECOND, |_, _| {});
    [before, receiver.snapshot().signals.slaves[0]]
}

fn assert_couples(config: &str, commands: &[&str]) {
    let [before, after] = before_and_after(config, commands);
    assert_eq!(before.position, None, "{commands:?}");
    assert_eq!(before.state, AxisStatus::Disabled);
    assert_eq!(after.phase, Some(CouplingPhase::InSync), "{commands:?}");
    assert_eq!((after.error, after.refusal), (0, 0));
}

#[test]
fn commands_that_leave_the_motion_as_it_is_leave_it_pending() {
    for commands in [&[r#"{"reset":{}}"#][..], &[MODE], &[MODE, POINT]] {
        assert_couples(KNIFE, commands);
    }
}

#[test]
fn steps_of_its_program_that_leave_the_motion_as_it_is_leave_it_pending() {
    let mode =
        "{ set-cam-online-change-mode = { table = 1, mode.activation.mode = 'next-cycle' } }";
    for command in [mode, "{ reset = {} }"] {
        let step = format!("{KNIFE}[[slave.step]]\nwhen = {{ after-s = 0.01 }}\ndo = {command}\n");
        assert_couples(&step, &[]);
    }
}

#[test]
fn a_command_about_the_power_replaces_it() {
    for (power, state) in [
        ("true", AxisStatus::Standstill),
        ("false", AxisStatus::Disabled),
    ] {
        let command = format!(r#"{{"power":{power}}}"#);
        let [before, after] = before_and_after(KNIFE, &[&command]);
        assert_eq!((before.position, before.state), (Some(0.0), state));
        assert_eq!((after.phase, after.state), (None, state));
    }
}
