//! Results of commands: branches, conditions, and unhandled trouble.

use coaxle_axis::{Job, Origin};

use super::*;

const HANDLING: &str = "
    [[step]]
    do = { move-velocity = { velocity = 5 } }
    [[step]]
    when = { in-sync = true }
    otherwise = { aborted = 'aborted', failed = 'failed', refused = 'refused', rolled-back = 'back', timed-out = 'late' }
    timeout-s = 2
    [[step]]
    label = 'aborted'
    [[step]]
    label = 'failed'
    [[step]]
    label = 'refused'
    [[step]]
    label = 'back'
    [[step]]
    label = 'late'
";

/// A program without any handling.
fn not_handling() -> String {
    let with = |line: &&str| !line.contains("otherwise") && !line.contains("timeout");
    let lines: Vec<_> = HANDLING.lines().filter(with).collect();
    lines.join("\n")
}

const fn job(number: u32, origin: Origin) -> Job {
    Job {
        number,
        command: "MC_MoveVelocity",
        origin,
    }
}

const OWN: Job = job(1, Origin::Program);
const ORDER: Job = job(2, Origin::Order);

/// Situation while the program's command moves the slave.
const MOVING: Situation = Situation {
    status: AxisStatus::SynchronizedMotion,
    outlook: Outlook::Led,
    phase: Some(CouplingPhase::Synchronizing),
    motion: Some(OWN),
    ..NOW
};

/// A program that has given its command and waits.
fn waiting(text: &str) -> Program {
    let mut program = program(text);
    program.take(Ok(Some(OWN)));
    scan(&mut program, &MOVING, None);
    assert_eq!(step_and_state(&program), (2, ProgramState::Running));
    program
}

/// A scan in which no step is taken.
fn scan(program: &mut Program, now: &Situation, own: Option<Outcome>) {
    program.look(now, |job| own.filter(|_| job == OWN));
    program.advance(Seconds(0.5), None);
    assert_eq!(program.due(now, scaling), None);
}

fn step_and_state(program: &Program) -> (u16, ProgramState) {
    let shown = program.snapshot();
    (shown.step, shown.state)
}

#[test]
fn every_outcome_has_its_branch_and_is_handled_by_it() {
    for (outcome, label) in [
        (Outcome::Aborted, 3),
        (Outcome::Failed, 4),
        (Outcome::Refused, 5),
        (Outcome::RolledBack, 6),
    ] {
        let mut program = waiting(HANDLING);
        scan(&mut program, &MOVING, Some(outcome));
        assert_eq!(step_and_state(&program), (label, ProgramState::Running));
        assert_eq!(program.snapshot().outcome, Some(outcome));
        // No trouble is left that would branch again, though the result is still known.
        program.look(&MOVING, |_| Some(outcome));
        assert_eq!(program.due(&MOVING, scaling), Some(None), "{outcome:?}");
    }
}

#[test]
fn a_command_that_is_done_is_no_trouble() {
    let mut program = waiting(HANDLING);
    scan(&mut program, &MOVING, Some(Outcome::Done));
    assert_eq!(step_and_state(&program), (2, ProgramState::Running));
    assert_eq!(program.snapshot().outcome, Some(Outcome::Done));
}

#[test]
fn a_step_that_waits_for_too_long_has_its_branch_or_ends_the_program() {
    let too_long = |program: &mut Program| {
        for _ in 0..2 {
            scan(program, &MOVING, None);
            assert_eq!(step_and_state(program), (2, ProgramState::Running));
        }
        scan(program, &MOVING, None);
    };
    let mut program = waiting(HANDLING);
    too_long(&mut program);
    assert_eq!(step_and_state(&program), (7, ProgramState::Running));

    let unhandled = HANDLING.replace(", timed-out = 'late'", "");
    let mut program = waiting(&unhandled);
    too_long(&mut program);
    assert_eq!(step_and_state(&program), (2, ProgramState::TimedOut));
    let blocked = program.blocked().expect("it is told");
    assert_eq!(
        blocked.to_string(),
        "step 2 of the program waits for in-sync: it has waited for longer than it may"
    );
    // For good.
    let in_sync = Situation {
        phase: Some(CouplingPhase::InSync),
        ..MOVING
    };
    assert_eq!(program.due(&in_sync, scaling), None);
}

#[test]
fn what_comes_in_the_last_moment_is_in_time() {
    let mut program = waiting(HANDLING);
    let in_sync = Situation {
        phase: Some(CouplingPhase::InSync),
        ..MOVING
    };
    program.advance(Seconds(5.0), None);
    assert_eq!(program.due(&in_sync, scaling), Some(None));
}

#[test]
fn a_refusal_at_once_has_its_branch() {
    let text = "[[step]]\nlabel = 'again'\ndo = { reset = {} }\notherwise = { refused = 'no' }\n\
         [[step]]\n[[step]]\nlabel = 'no'\nwhen = { refused = true }\ngo-to = 'again'";
    let mut program = program(text);
    program.take(Err(REFUSAL));
    assert_eq!(step_and_state(&program), (3, ProgramState::Running));
    assert!(!program.is_refused());
    assert_eq!(program.due(&NOW, scaling), Some(None));
    program.take(Ok(None));
    program.take(Ok(Some(job(0, Origin::Program))));
    assert_eq!(program.snapshot().outcome, None);
}

#[test]
fn what_nobody_handles_is_told_as_soon_as_the_step_cannot_come() {
    for (outcome, why) in [
        (Outcome::Aborted, "its command was aborted"),
        (Outcome::Failed, "the slave came to an error stop"),
        (Outcome::RolledBack, "its flying saw was rolled back"),
    ] {
        let mut program = waiting(&not_handling());
        // The condition can still be met.
        scan(&mut program, &MOVING, Some(outcome));
        assert_eq!(step_and_state(&program), (2, ProgramState::Running));
        assert_eq!(program.blocked(), None);
        let uncoupled = Situation {
            phase: None,
            ..MOVING
        };
        scan(&mut program, &uncoupled, Some(outcome));
        assert_eq!(step_and_state(&program), (2, ProgramState::Blocked));
        assert_eq!(
            program.blocked().expect("it is told").to_string(),
            format!("step 2 of the program waits for in-sync, which cannot come by itself: {why}")
        );
        // A foreign command helps.
        scan(&mut program, &MOVING, Some(outcome));
        assert_eq!(step_and_state(&program), (2, ProgramState::Running));
        assert_eq!(program.blocked(), None);
    }
}

#[test]
fn a_refusal_when_due_that_nobody_handles_ends_the_program() {
    let mut program = waiting(&not_handling());
    program.refused_late();
    scan(&mut program, &MOVING, Some(Outcome::Refused));
    assert_eq!(step_and_state(&program), (2, ProgramState::Refused));
    assert!(program.is_refused());
}

#[test]
fn a_refusal_when_due_can_be_asked_for() {
    let text = "[[step]]\ndo = { cam-scaling = {} }\n[[step]]\nwhen = { refused = true }\n[[step]]";
    let mut program = program(text);
    program.take(Ok(Some(OWN)));
    scan(&mut program, &MOVING, None);
    assert_eq!(program.snapshot().waits_for, Some(WaitsFor::Refused));
    program.refused_late();
    assert_eq!(program.due(&MOVING, scaling), Some(None));
    program.take(Ok(None));
    assert_eq!(program.due(&MOVING, scaling), Some(None), "it is handled");
}

#[test]
fn a_refusal_when_due_counts_after_the_last_step_too() {
    let mut program = program("[[step]]");
    program.take(Ok(Some(OWN)));
    assert_eq!(program.snapshot().state, ProgramState::Finished);
    program.refused_late();
    assert_eq!(program.snapshot().state, ProgramState::Refused);
}

#[test]
fn an_error_stop_counts_whatever_was_under_way_and_once() {
    let failed = Situation {
        status: AxisStatus::ErrorStop,
        phase: None,
        outlook: Outlook::AtRest,
        ..MOVING
    };
    let mut program = waiting(HANDLING);
    scan(&mut program, &MOVING, Some(Outcome::Done));
    scan(&mut program, &failed, Some(Outcome::Done));
    assert_eq!(step_and_state(&program), (4, ProgramState::Running));
    program.look(&failed, |_| None);
    assert_eq!(program.due(&failed, scaling), Some(None));
    // Reset from outside, and a second failure.
    program.look(&NOW, |_| None);
    program.look(&failed, |_| None);
    let why = Some(Trouble::Outcome(Outcome::Failed));
    assert_eq!(program.commanded.trouble(), why);
}

#[test]
fn the_programs_own_next_command_is_no_abort() {
    let text = "[[step]]\ndo = { move-velocity = { velocity = 5 } }\n\
         [[step]]\ndo = { move-velocity = { velocity = 6 } }\n[[step]]\nwhen = { in-sync = true }";
    let mut program = program(text);
    program.take(Ok(Some(OWN)));
    program.look(&MOVING, |_| None);
    let next = job(7, Origin::Program);
    program.take(Ok(Some(next)));
    let moving = Situation {
        motion: Some(next),
        ..MOVING
    };
    scan(&mut program, &moving, Some(Outcome::Aborted));
    assert_eq!(program.snapshot().outcome, None);
    assert_eq!(program.commanded.trouble(), None);
}

#[test]
fn power_taken_away_and_a_reset_by_the_program_leave_nothing_behind() {
    for command in ["power = false", "reset = {}"] {
        let text = format!(
            "[[step]]\ndo = {{ move-velocity = {{ velocity = 5 }} }}\n[[step]]\n\
             do = {{ {command} }}\n[[step]]\nwhen = {{ in-sync = true }}"
        );
        let mut program = program(&text);
        program.take(Ok(Some(OWN)));
        program.look(&MOVING, |_| None);
        if command.starts_with("reset") {
            program.look(&MOVING, |_| Some(Outcome::Failed));
        }
        program.take(Ok(Some(job(0, Origin::Program))));
        scan(&mut program, &MOVING, Some(Outcome::Aborted));
        assert_eq!(program.snapshot().outcome, None, "{command}");
        assert_eq!(program.commanded.trouble(), None, "{command}");
    }
}

#[test]
fn what_is_done_at_once_beside_the_motion_does_not_hide_what_becomes_of_it() {
    let text = "[[step]]\ndo = { move-velocity = { velocity = 5 } }\n[[step]]\n\
         do = { set-cam-online-change-mode = { table = 1 } }\n[[step]]\nwhen = { in-sync = true }\n\
         otherwise = { aborted = 'end' }\n[[step]]\nlabel = 'end'";
    let mut program = program(text);
    program.take(Ok(Some(OWN)));
    program.look(&MOVING, |_| None);
    program.take(Ok(Some(job(0, Origin::Program))));
    scan(&mut program, &MOVING, Some(Outcome::Aborted));
    assert_eq!(program.snapshot().step, 4);
}

#[test]
fn what_goes_on_beside_the_coupling_does_not_hide_its_end() {
    let beside = job(7, Origin::Program);
    let text = "[[step]]\ndo = { gear-in = { ratio = 1 } }\n[[step]]\n\
         do = { phasing-absolute = { shift = 5 } }\n[[step]]\nwhen = { done = true }\n[[step]]\n\
         when = { rolled-back = true }\n[[step]]";
    let mut program = program(text);
    program.take(Ok(Some(OWN)));
    program.look(&MOVING, |_| None);
    program.take(Ok(Some(beside)));
    scan(&mut program, &MOVING, None);
    program.look(&MOVING, |job| (job == beside).then_some(Outcome::Done));
    assert_eq!(program.due(&MOVING, scaling), Some(None));
    program.take(Ok(None));
    scan(&mut program, &MOVING, None);
    program.look(&MOVING, |job| (job == OWN).then_some(Outcome::RolledBack));
    assert_eq!(program.due(&MOVING, scaling), Some(None));
    program.take(Ok(None));
    assert_eq!(program.commanded.trouble(), None, "the step asked for it");
}

#[test]
fn an_order_that_takes_over_from_what_is_done_is_trouble() {
    let mut program = waiting(&not_handling());
    scan(&mut program, &MOVING, Some(Outcome::Done));
    let ordered = Situation {
        motion: Some(ORDER),
        phase: None,
        ..MOVING
    };
    scan(&mut program, &ordered, None);
    assert_eq!(step_and_state(&program), (2, ProgramState::Blocked));
    let blocked = program.blocked().expect("it is told");
    assert_eq!(blocked.trouble, Trouble::TakenOver);
}

#[test]
fn an_order_that_was_waited_for_is_none() {
    let mut program = waiting(&not_handling());
    let at_rest = Situation {
        phase: None,
        outlook: Outlook::AtRest,
        ..MOVING
    };
    scan(&mut program, &at_rest, Some(Outcome::Done));
    assert_eq!(step_and_state(&program), (2, ProgramState::WaitingForOrder));
    assert_eq!(program.blocked(), None);
    let ordered = Situation {
        motion: Some(ORDER),
        ..at_rest
    };
    scan(&mut program, &ordered, None);
    assert_eq!(step_and_state(&program), (2, ProgramState::WaitingForOrder));
}

#[test]
fn what_couples_from_the_start_is_followed_too() {
    let start = job(1, Origin::Start);
    let mut program =
        program("[[step]]\nwhen = { aborted = false }\n[[step]]\nwhen = { aborted = true }");
    let coupled = Situation {
        motion: Some(start),
        ..MOVING
    };
    program.started(start);
    program.look(&coupled, |_| None);
    assert_eq!(program.due(&coupled, scaling), Some(None));
    program.take(Ok(None));
    scan(&mut program, &coupled, None);
    assert_eq!(step_and_state(&program), (2, ProgramState::Running));
    program.look(&coupled, |job| (job == start).then_some(Outcome::Aborted));
    assert_eq!(program.due(&MOVING, scaling), Some(None));
}
