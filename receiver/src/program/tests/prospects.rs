//! Prospects of the conditions waited for.

use super::*;

/// A slave that keeps a velocity.
const fn keeping(velocity: f64) -> Situation<'static> {
    Situation {
        status: AxisStatus::ContinuousMotion,
        outlook: Outlook::ConstantVelocity(velocity),
        set: Kinematics {
            position: 5.0,
            velocity,
            acceleration: 0.0,
        },
        stands: velocity == 0.0,
        ..NOW
    }
}

const COUPLED: Situation = Situation {
    status: AxisStatus::SynchronizedMotion,
    outlook: Outlook::Led,
    phase: Some(CouplingPhase::Waiting),
    ..NOW
};

const WITH_MASTER: Situation = Situation {
    master: Some(0.0),
    first_master_ready: true,
    master_ready: true,
    ..NOW
};

fn in_state(status: AxisStatus) -> Situation<'static> {
    Situation { status, ..NOW }
}

fn state_of(when: &str, now: &Situation) -> (ProgramState, Option<WaitsFor>) {
    let mut program = program(&format!("[[step]]\nwhen = {{ {when} }}"));
    assert_eq!(program.due(now, scaling), None, "{when}");
    let shown = program.snapshot();
    (shown.state, shown.waits_for)
}

#[test]
fn who_can_bring_what_is_waited_for() {
    use ProgramState::{Blocked, Running, WaitingForMaster, WaitingForOrder};
    let under_way = Situation {
        outlook: Outlook::UnderWay,
        status: AxisStatus::DiscreteMotion,
        ..NOW
    };
    let starts = Situation {
        starts_coupled: true,
        ..in_state(AxisStatus::Disabled)
    };
    let starts_with_master = Situation {
        starts_coupled: true,
        status: AxisStatus::Disabled,
        ..WITH_MASTER
    };
    let switching_on = Situation {
        is_switching_on: true,
        ..in_state(AxisStatus::Disabled)
    };
    let lost = Situation {
        master: Some(0.0),
        ..NOW
    };
    for (when, now, expected) in [
        ("time-s = 1", NOW, Running),
        ("after-s = 1", NOW, Running),
        ("in-sync = true", NOW, WaitingForOrder),
        ("in-sync = true", COUPLED, Running),
        ("in-sync = true", starts, WaitingForMaster),
        ("in-sync = true", starts_with_master, Running),
        ("standstill = true", keeping(3.0), WaitingForOrder),
        ("standstill = false", NOW, WaitingForOrder),
        ("standstill = false", under_way, Running),
        ("standstill = false", COUPLED, Running),
        ("master-ready = true", NOW, WaitingForMaster),
        ("master-ready = false", WITH_MASTER, Running),
        ("master-above = 7", NOW, WaitingForMaster),
        ("master-above = 7", lost, WaitingForMaster),
        ("master-above = 7", WITH_MASTER, Running),
        ("master-below = -7", lost, WaitingForMaster),
        ("position-above = 7", NOW, WaitingForOrder),
        ("position-above = 7", under_way, Running),
        ("position-above = 7", COUPLED, Running),
        ("position-above = 7", keeping(3.0), Running),
        ("position-above = 7", keeping(-3.0), WaitingForOrder),
        ("position-below = 3", keeping(-3.0), Running),
        ("position-below = 3", keeping(3.0), WaitingForOrder),
        ("position-below = 3", switching_on, Running),
        ("state = 'disabled'", NOW, WaitingForOrder),
        (
            "state = 'disabled'",
            in_state(AxisStatus::Stopping),
            Running,
        ),
        ("state = 'standstill'", switching_on, Running),
        ("state = 'standstill'", under_way, Running),
        ("state = 'standstill'", COUPLED, Running),
        ("state = 'standstill'", keeping(3.0), WaitingForOrder),
        (
            "state = 'standstill'",
            in_state(AxisStatus::Disabled),
            WaitingForOrder,
        ),
        (
            "state = 'standstill'",
            in_state(AxisStatus::ErrorStop),
            WaitingForOrder,
        ),
        ("state = 'synchronized-motion'", NOW, WaitingForOrder),
        ("state = 'synchronized-motion'", starts, WaitingForMaster),
        ("state = 'error-stop'", NOW, Running),
        ("error-stop = true", NOW, Running),
        (
            "error-stop = false",
            in_state(AxisStatus::ErrorStop),
            WaitingForOrder,
        ),
        ("failed = true", NOW, Running),
        // No command was given that could.
        ("done = true", NOW, Blocked),
        ("aborted = true", NOW, Blocked),
        ("rolled-back = true", NOW, Blocked),
        ("timed-out = true", NOW, Blocked),
    ] {
        assert_eq!(state_of(when, &now).0, expected, "{when} {now:?}");
    }
}

#[test]
fn of_several_parts_the_one_that_is_hardest_to_come_by_is_named() {
    for (when, now, expected) in [
        (
            "after-s = 1, in-sync = true",
            NOW,
            (ProgramState::WaitingForOrder, Some(WaitsFor::InSync)),
        ),
        (
            "after-s = 1, in-sync = true, master-ready = true",
            COUPLED,
            (ProgramState::WaitingForMaster, Some(WaitsFor::MasterReady)),
        ),
        (
            "after-s = 1, in-sync = true",
            COUPLED,
            (ProgramState::Running, Some(WaitsFor::AfterS)),
        ),
    ] {
        assert_eq!(state_of(when, &now), expected, "{when}");
    }
}

#[test]
fn a_mark_needs_a_master() {
    let text = "[[step]]\nat-mark = true\ndo = { cam-in = { table = 1 } }\n[[step]]\nwhen = { mark-seen = false }";
    let mut program = program_with_marks(text);
    assert_eq!(program.due(&NOW, scaling), None);
    let shown = program.snapshot();
    assert_eq!(shown.state, ProgramState::WaitingForMaster);
    assert_eq!(shown.waits_for, Some(WaitsFor::AtMark));
    assert_eq!(program.due(&WITH_MASTER, scaling), None);
    assert_eq!(program.snapshot().state, ProgramState::Running);
}

#[test]
fn what_is_waited_for_is_spelled_as_in_a_config() {
    for (name, shown) in [
        ("in-sync", WaitsFor::InSync),
        ("position-above", WaitsFor::PositionAbove),
        ("time-s", WaitsFor::TimeS),
        ("rolled-back", WaitsFor::RolledBack),
    ] {
        assert_eq!(shown.to_string(), name);
        #[derive(Deserialize, schemars::JsonSchema)]
        struct File {
            #[schemars(with = "String")]
            name: WaitsFor,
        }
        let file: File = parse("n", &format!("name = '{name}'")).expect("a name");
        assert_eq!(file.name, shown);
    }
}
