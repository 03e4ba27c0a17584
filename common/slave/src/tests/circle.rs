//! An axis that follows itself across nodes, with a reported circle.

use super::*;
use crate::{CIRCLE_CODE, CircleState, Refusal, SlaveError};
use coaxle_axis::AxisStatus;
use coaxle_saw::SyncMode;

/// An axis in a gear with a master that moves at 800 u/s.
fn coupled(parameters: &SlaveParameters) -> (AxisWithPlates, Master) {
    let mut axis = powered(parameters);
    let mut master = Master::at(0.0, 0.0);
    master.lead(&mut axis, 1);
    start(&mut axis, &move_velocity(800.0));
    run(&mut axis, 500);
    let mut master = Master::at(axis.set().position, 800.0);
    master.lead(&mut axis, 1);
    start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    master.lead(&mut axis, 100);
    assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
    (axis, master)
}

#[test]
fn a_circle_that_is_known_refuses_what_couples_and_nothing_else() {
    for circle in [CircleState::Open, CircleState::Closed] {
        let mut axis = powered(&PARAMETERS);
        Master::at(0.0, 0.0).lead(&mut axis, 1);
        axis.set_circle(circle);
        for command in [
            Command::GearIn(GearIn::of(1.3)),
            super::saws::to_velocity(SyncMode::default()),
        ] {
            let refusal = axis.command(&command).unwrap_err();
            assert_eq!(refusal.code(), CIRCLE_CODE, "{refusal}");
            assert!(matches!(refusal, Refusal::FollowsItself { .. }));
        }
        start(&mut axis, &move_absolute(10.0));
        run(&mut axis, 1_000);
        assert_eq!(axis.set().position, 10.0);
        axis.set_circle(CircleState::None);
        Master::at(0.0, 0.0).lead(&mut axis, 1);
        start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    }
}

#[test]
fn an_open_circle_leaves_an_axis_coupled() {
    let (mut axis, mut master) = coupled(&PARAMETERS);
    axis.set_circle(CircleState::Open);
    master.lead(&mut axis, 100);
    assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
    assert_eq!(axis.set().velocity, 800.0);
}

#[test]
fn a_closed_circle_stops_an_axis_as_a_lost_master_does_even_one_that_follows_on() {
    for (on_master_loss, cycles) in [
        (OnMasterLoss::Stop, 239..=242),
        (OnMasterLoss::QuickStop, 199..=202),
        (OnMasterLoss::Follow, 239..=242),
    ] {
        let parameters = SlaveParameters {
            on_master_loss,
            ..PARAMETERS
        };
        let (mut axis, mut master) = coupled(&parameters);
        axis.set_circle(CircleState::Closed);
        let mut taken = 0;
        while axis.set().velocity != 0.0 {
            let before = axis.set().velocity;
            master.lead(&mut axis, 1);
            assert!(before - axis.set().velocity <= 4_000.0 * CYCLE.0 * (1.0 + 1e-9));
            taken += 1;
        }
        assert!(cycles.contains(&taken), "{on_master_loss:?}: {taken}");
        assert_eq!(axis.error(), Some(SlaveError::FollowsItself));
        assert_eq!(axis.status(), AxisStatus::ErrorStop);
        start(&mut axis, &Command::Reset {});
        let refusal = axis.command(&Command::GearIn(GearIn::of(1.0))).unwrap_err();
        assert_eq!(refusal.code(), CIRCLE_CODE);
    }
}
