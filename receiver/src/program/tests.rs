use coaxle_motion::axis::AxisStatus;
use coaxle_motion::profile::Kinematics;
use coaxle_motion::slave::CouplingPhase;
use coaxle_node::config::parse;
use serde::Deserialize;

use super::*;

#[derive(Deserialize)]
struct File {
    step: Vec<StepConfig>,
}

fn steps(text: &str) -> Vec<StepConfig> {
    parse::<File>("p.toml", text).expect("valid steps").step
}

fn program(text: &str) -> Program {
    Program::new(&steps(text))
        .expect("a program")
        .expect("with steps")
}

const NOW: Situation = Situation {
    status: AxisStatus::Standstill,
    phase: None,
    set: Kinematics {
        position: 5.0,
        velocity: 0.0,
        acceleration: 0.0,
    },
    master: None,
    master_ready: false,
};

const REFUSAL: Refusal = Refusal::NoMaster;

#[test]
fn steps_are_taken_one_after_the_other_and_the_last_ends_it() {
    let mut program = program("[[step]]\ndo = { power = true }\n[[step]]\ndo = { reset = {} }");
    assert_eq!(program.due(&NOW), Some(Some(Command::Power(true))));
    program.take(Ok(()));
    assert_eq!(program.snapshot().step, 2);
    assert_eq!(program.due(&NOW), Some(Some(Command::Reset {})));
    program.take(Ok(()));
    assert_eq!(program.due(&NOW), None);
    assert_eq!(program.snapshot().state, ProgramState::Finished);
}

#[test]
fn every_part_of_a_condition_has_to_hold() {
    let moving = Kinematics {
        position: 5.0,
        velocity: 1.0,
        acceleration: 0.0,
    };
    let cases: [(&str, Situation); 10] = [
        (
            "in-sync = false",
            Situation {
                phase: Some(CouplingPhase::InSync),
                ..NOW
            },
        ),
        ("standstill = true", Situation { set: moving, ..NOW }),
        (
            "standstill = true, position-above = 4",
            Situation { set: moving, ..NOW },
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
            Situation { set: moving, ..NOW },
        ),
    ];
    for (when, not_yet) in cases {
        let program = program(&format!("[[step]]\nwhen = {{ {when} }}"));
        assert_eq!(program.due(&not_yet), None, "{when}");
        assert_eq!(program.due(&NOW), Some(None), "{when}");
    }
}

#[test]
fn a_position_of_the_master_needs_a_master() {
    let program = program("[[step]]\nwhen = { master-above = -1e9, master-below = 1e9 }");
    assert_eq!(program.due(&NOW), None);
    let with_master = Situation {
        master: Some(0.0),
        ..NOW
    };
    assert_eq!(program.due(&with_master), Some(None));
}

#[test]
fn times_count_from_the_start_and_from_the_step_before() {
    let mut program = program("[[step]]\nwhen = { time-s = 2 }\n[[step]]\nwhen = { after-s = 1 }");
    let half = Seconds(0.5);
    for due in [false, false, false, true] {
        program.advance(half);
        assert_eq!(program.due(&NOW).is_some(), due);
    }
    program.take(Ok(()));
    for due in [false, true] {
        program.advance(half);
        assert_eq!(program.due(&NOW).is_some(), due);
    }
}

#[test]
fn a_program_can_repeat_from_a_label() {
    let mut program =
        program("[[step]]\n[[step]]\nlabel = 'cycle'\n[[step]]\nrepeat-from = 'cycle'");
    let mut seen = Vec::new();
    for _ in 0..6 {
        seen.push(program.snapshot().step);
        program.take(Ok(()));
    }
    assert_eq!(seen, [1, 2, 3, 2, 3, 2]);
}

#[test]
fn a_refusal_ends_the_program_unless_it_is_expected() {
    let code = REFUSAL.code();
    let expecting =
        format!("[[step]]\ndo = {{ gear-out = {{}} }}\nexpect-refusal = {code}\n[[step]]");
    for (text, answer, state) in [
        ("[[step]]\n[[step]]", Err(REFUSAL), ProgramState::Refused),
        (&expecting, Err(REFUSAL), ProgramState::Running),
        (&expecting, Ok(()), ProgramState::NotAsExpected),
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
        assert_eq!(program.due(&NOW).is_some(), state == ProgramState::Running);
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
            "step[0].repeat-from: received \"b\", expected the label of a step",
        ),
        (
            "[[step]]\nexpect-refusal = 1",
            "step[0].do: expected a command",
        ),
    ] {
        let error = Program::new(&steps(text)).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}
