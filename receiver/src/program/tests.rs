mod outcomes;
mod prospects;

use coaxle_axis::{AxisStatus, StateWord};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::parse;
use coaxle_slave::{Command, CouplingPhase, Outlook};
use serde::Deserialize;

use super::*;

#[derive(Deserialize, schemars::JsonSchema)]
struct File {
    step: Vec<StepConfig>,
}

fn steps(text: &str) -> Vec<StepConfig> {
    parse::<File>("p.toml", text).expect("valid steps").step
}

fn program(text: &str) -> Program {
    Program::new(&steps(text), None, &[])
        .expect("a program")
        .expect("with steps")
}

const NOW: Situation<'static> = Situation {
    status: AxisStatus::Standstill,
    phase: None,
    set: Kinematics {
        position: 5.0,
        velocity: 0.0,
        acceleration: 0.0,
    },
    stands: true,
    outlook: Outlook::AtRest,
    motion: None,
    starts_coupled: false,
    is_switching_on: false,
    master: None,
    master_modulo: None,
    promised: None,
    first_master_ready: false,
    master_ready: false,
    cam_table: 0,
    cam_queued: StateWord::empty(),
};

fn scaling() -> f64 {
    1.0
}

const REFUSAL: Refusal = Refusal::NoMaster;

#[test]
fn steps_are_taken_one_after_the_other_and_the_last_ends_it() {
    let mut program = program("[[step]]\ndo = { power = true }\n[[step]]\ndo = { reset = {} }");
    assert_eq!(
        program.due(&NOW, scaling),
        Some(Some(Due::Slave(Command::Power(true))))
    );
    program.take(Ok(None));
    assert_eq!(program.snapshot().step, 2);
    assert_eq!(
        program.due(&NOW, scaling),
        Some(Some(Due::Slave(Command::Reset {})))
    );
    program.take(Ok(None));
    assert_eq!(program.due(&NOW, scaling), None);
    assert_eq!(program.snapshot().state, ProgramState::Finished);
}

#[test]
fn every_part_of_a_condition_has_to_hold() {
    let moving = Kinematics {
        position: 5.0,
        velocity: 1.0,
        acceleration: 0.0,
    };
    let cases: [(&str, Situation<'static>); 10] = [
        (
            "in-sync = false",
            Situation {
                phase: Some(CouplingPhase::InSync),
                ..NOW
            },
        ),
        (
            "standstill = true",
            Situation {
                set: moving,
                stands: false,
                ..NOW
            },
        ),
        (
            "standstill = true, position-above = 4",
            Situation {
                set: moving,
                stands: false,
                ..NOW
            },
        ),
        (
            "master-ready = false",
            Situation {
                master_ready: true,
                ..NOW
            },
        ),
        (
            "position-above = 4",
            Situation {
                set: Kinematics::at_rest(4.0),
                ..NOW
            },
        ),
        (
            "position-below = 6",
            Situation {
                set: Kinematics::at_rest(6.0),
                ..NOW
            },
        ),
        (
            "state = 'standstill'",
            Situation {
                status: AxisStatus::ErrorStop,
                ..NOW
            },
        ),
        (
            "in-sync = false, state = 'standstill'",
            Situation {
                status: AxisStatus::Disabled,
                ..NOW
            },
        ),
        (
            "position-above = 4, position-below = 6",
            Situation {
                set: Kinematics::at_rest(7.0),
                ..NOW
            },
        ),
        (
            "standstill = true, in-sync = false",
            Situation {
                set: moving,
                stands: false,
                ..NOW
            },
        ),
    ];
    for (when, not_yet) in cases {
        let mut program = program(&format!("[[step]]\nwhen = {{ {when} }}"));
        assert_eq!(program.due(&not_yet, scaling), None, "{when}");
        assert_eq!(program.due(&NOW, scaling), Some(None), "{when}");
    }
}

#[test]
fn a_position_of_the_master_needs_a_master() {
    let mut program = program("[[step]]\nwhen = { master-above = -1e9, master-below = 1e9 }");
    assert_eq!(program.due(&NOW, scaling), None);
    let with_master = Situation {
        master: Some(0.0),
        ..NOW
    };
    assert_eq!(program.due(&with_master, scaling), Some(None));
}

#[test]
fn times_count_from_the_start_and_from_the_step_before() {
    let mut program = program("[[step]]\nwhen = { time-s = 2 }\n[[step]]\nwhen = { after-s = 1 }");
    let half = Seconds(0.5);
    for due in [false, false, false, true] {
        program.advance(half, None);
        assert_eq!(program.due(&NOW, scaling).is_some(), due);
    }
    program.take(Ok(None));
    for due in [false, true] {
        program.advance(half, None);
        assert_eq!(program.due(&NOW, scaling).is_some(), due);
    }
}

#[test]
fn a_program_goes_on_from_a_label() {
    for (text, expected) in [
        (
            "[[step]]\n[[step]]\nlabel = 'cycle'\n[[step]]\nrepeat-from = 'cycle'",
            [1, 2, 3, 2, 3, 2],
        ),
        (
            "[[step]]\ngo-to = 'on'\n[[step]]\nlabel = 'back'\n[[step]]\nlabel = 'on'\ngo-to = 'back'",
            [1, 3, 2, 3, 2, 3],
        ),
    ] {
        let mut program = program(text);
        let seen = expected.map(|_| {
            let step = program.snapshot().step;
            program.take(Ok(None));
            step
        });
        assert_eq!(seen, expected);
    }
}

#[test]
fn a_refusal_ends_the_program_unless_it_is_expected() {
    let code = REFUSAL.code();
    let expecting =
        format!("[[step]]\ndo = {{ gear-out = {{}} }}\nexpect-refusal = {code}\n[[step]]");
    for (text, answer, state) in [
        ("[[step]]\n[[step]]", Err(REFUSAL), ProgramState::Refused),
        (&expecting, Err(REFUSAL), ProgramState::Running),
        (&expecting, Ok(None), ProgramState::NotAsExpected),
        (
            &expecting,
            Err(Refusal::NotAtRest { velocity: 1.0 }),
            ProgramState::NotAsExpected,
        ),
    ] {
        let mut program = program(text);
        program.take(answer);
        assert_eq!(program.snapshot().state, state);
        assert_eq!(program.is_refused(), state != ProgramState::Running);
        assert_eq!(
            program.due(&NOW, scaling).is_some(),
            state == ProgramState::Running
        );
    }
}

/// A program with marks at 1000, 1600 …, detected 700 before.
fn program_with_marks(text: &str) -> Program {
    let marks = parse(
        "m.toml",
        "first = 1000\nspacing = 600\nsensor-distance = 700",
    )
    .expect("valid marks");
    Program::new(&steps(text), Some(&marks), &[])
        .expect("a program")
        .expect("with steps")
}

#[test]
fn a_step_at_a_mark_waits_for_one_and_uses_it_up() {
    let mut program = program_with_marks(
        "[[step]]\nlabel = 'next'\nat-mark = true\ndo = { cam-in = { table = 1 } }\n\
         repeat-from = 'next'",
    );
    let offset = |program: &mut Program| match program.due(&NOW, scaling)? {
        Some(Due::Slave(Command::CamIn(cam_in))) => Some(cam_in.master_offset),
        other => panic!("expected a plate, received {other:?}"),
    };
    let cycle = Seconds(0.001);
    program.advance(cycle, None);
    assert_eq!(offset(&mut program), None);
    program.advance(cycle, Some(290.0));
    assert_eq!(offset(&mut program), None);
    program.advance(cycle, Some(301.0));
    assert_eq!(offset(&mut program), Some(-1000.0));
    program.take(Ok(None));
    assert_eq!(offset(&mut program), None);
    program.advance(cycle, Some(901.0));
    assert_eq!(offset(&mut program), Some(-1600.0));
}

#[test]
fn a_mark_that_was_seen_is_a_condition() {
    let mut program = program_with_marks("[[step]]\nwhen = { mark-seen = true }");
    program.advance(Seconds(0.0), Some(290.0));
    assert_eq!(program.due(&NOW, scaling), None);
    program.advance(Seconds(0.0), Some(310.0));
    assert_eq!(program.due(&NOW, scaling), Some(None));
}

#[test]
fn points_are_put_by_the_distance_of_marks_and_the_scaling_of_the_plate() {
    let mut program = program_with_marks(
        "[[step]]\nat-mark = true\ndo = { write-motion-function = { table = 1, points = [\
         { index = 4, law = 'polynom1', type = 'motion', master = -10, slave = 0 }] } }",
    );
    program.advance(Seconds(0.0), Some(0.0));
    program.advance(Seconds(0.0), Some(300.0));
    let Some(Some(Due::Slave(Command::WriteMotionFunction { points, .. }))) =
        program.due(&NOW, || 2.0)
    else {
        panic!("expected points");
    };
    assert_eq!(points[0].master, 600.0 / 2.0 - 10.0);
}

#[test]
fn a_step_cuts_when_it_is_taken_unless_it_is_refused() {
    let text = "[[step]]\ncut = true\n[[step]]\n[[step]]\ncut = true\n[[step]]\ncut = true";
    let mut program = program(text);
    for (answer, cuts) in [
        (Ok(None), 1),
        (Ok(None), 1),
        (Ok(None), 2),
        (Err(REFUSAL), 2),
    ] {
        program.take(answer);
        assert_eq!(program.cuts(), cuts);
    }
}

#[test]
fn steps_that_ask_for_marks_need_some() {
    for (step, has_marks, expected) in [
        (
            "when = { mark-seen = true }",
            false,
            "step[0].when.mark-seen: received no marks of the slave, expected a slave with marks",
        ),
        (
            "at-mark = true\ndo = { cam-in = { table = 1 } }",
            false,
            "step[0].at-mark: received no marks of the slave, expected a slave with marks",
        ),
        (
            "at-mark = true",
            true,
            "step[0].at-mark: received no command, expected one of: ",
        ),
        (
            "at-mark = true\ndo = { power = true }",
            true,
            "step[0].at-mark: received MC_Power, expected one of: ",
        ),
    ] {
        let marks = parse("m.toml", "spacing = 600\nsensor-distance = 700").expect("marks");
        let steps = steps(&format!("[[step]]\n{step}"));
        let error = Program::new(&steps, has_marks.then_some(&marks), &[]).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
    }
}

#[test]
fn wrong_steps_are_named() {
    for (text, expected) in [
        (
            "[[step]]\nlabel = 'a'\n[[step]]\nlabel = 'a'",
            "step[1].label: received \"a\" twice",
        ),
        (
            "[[step]]\nrepeat-from = 'b'",
            "step[0].repeat-from: received \"b\", expected the label of a step, one of []",
        ),
        (
            "[[step]]\nlabel = 'a'\ngo-to = 'b'\n[[step]]\nlabel = 'c'",
            "step[0].go-to: received \"b\", expected the label of a step, one of [\"a\", \"c\"]",
        ),
        (
            "[[step]]\nlabel = 'a'\ngo-to = 'a'\nrepeat-from = 'a'",
            "step[0].go-to: received one beside repeat-from",
        ),
        (
            "[[step]]\nlabel = 'a'\n[[step]]\notherwise = { rolled-back = 'b' }",
            "step[1].otherwise.rolled-back: received \"b\", expected the label of a step, one of [\"a\"]",
        ),
        (
            "[[step]]\nlabel = 'a'\notherwise = { timed-out = 'a' }",
            "step[0].timeout-s: received none, expected one for otherwise.timed-out",
        ),
        (
            "[[step]]\nlabel = 'a'\ndo = { power = true }\nexpect-refusal = 1\notherwise = { refused = 'a' }",
            "step[0].otherwise.refused: received one beside expect-refusal",
        ),
        (
            "[[step]]\nexpect-refusal = 1",
            "step[0].do: received none, expected a command",
        ),
    ] {
        let error = Program::new(&steps(text), None, &[])
            .unwrap_err()
            .to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}
