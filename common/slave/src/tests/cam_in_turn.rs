//! Plates that are coupled when their master passes a position within its modulo period.

use std::string::ToString;

use super::cams::plate;
use super::*;
use coaxle_axis::{CouplingPhase, Modulo};
use coaxle_cam::{Activation, ActivationMode, CamIn, Tables};

/// An axis at 0 with plate 1, and a master with this velocity that has passed 10 periods of 360 and
/// is at 200 within its period.
fn rig(velocity: f64, modulo: Option<f64>) -> (AxisWithPlates, Master) {
    let mut axis = powered(&PARAMETERS);
    let mut tables = Tables::new(1);
    tables.insert(1, plate(8.0)).expect("room");
    axis.select_cams(tables, 7, 8).expect("limits");
    axis.set_modulo(
        None,
        modulo.map(|length| Modulo::new(length).expect("a length")),
    );
    let mut master = Master::at(3_800.0 - velocity * CYCLE.0, velocity);
    master.lead(&mut axis, 1);
    (axis, master)
}

fn cam_in(mode: ActivationMode, in_turn: f64) -> Command {
    Command::CamIn(CamIn {
        table: 1,
        activation: Activation {
            in_turn: Some(in_turn),
            ..Activation::new(mode)
        },
        ..CamIn::default()
    })
}

#[test]
fn a_plate_is_active_where_its_master_passes_the_position_the_next_time() {
    use ActivationMode as Mode;
    for (mode, velocity, in_turn, expected) in [
        (Mode::AtMasterAxisPos, 200.0, 210.0, 3_810.0),
        (Mode::AtMasterAxisPos, 200.0, 90.0, 4_050.0),
        (Mode::AtMasterAxisPos, -200.0, 90.0, 3_690.0),
        (
            Mode::AtMasterAxisPosPositiveDirection,
            200.0,
            190.0,
            4_150.0,
        ),
        (
            Mode::AtMasterAxisPosNegativeDirection,
            -200.0,
            210.0,
            3_450.0,
        ),
    ] {
        let (mut axis, mut master) = rig(velocity, Some(360.0));
        start(&mut axis, &cam_in(mode, in_turn));
        let waits = |axis: &AxisWithPlates| axis.coupling_phase() == Some(CouplingPhase::Waiting);
        let mut cycles = 0;
        while waits(&axis) {
            master.lead(&mut axis, 1);
            cycles += 1;
            assert!(cycles < 3_000, "{mode:?} {in_turn}");
        }
        let beyond = (master.0.position - expected) * velocity.signum();
        assert!(
            (-1e-6..=0.2 + 1e-6).contains(&beyond),
            "{mode:?} {in_turn}: {:?}",
            master.0
        );
    }
}

#[test]
fn a_position_that_its_master_does_not_have_is_refused() {
    let mode = ActivationMode::AtMasterAxisPos;
    for (modulo, command, expected) in [
        (
            None,
            cam_in(mode, 90.0),
            "0x4b06: activation.in-turn: received in-turn 90 of an axis without a modulo",
        ),
        (
            Some(360.0),
            cam_in(mode, 360.0),
            "0x4b06: activation.in-turn: received in-turn 360, expected 0 up to",
        ),
        (
            Some(360.0),
            cam_in(ActivationMode::NextCycle, 90.0),
            "0x4a1c: activation.in-turn: received 90, expected none but of a coupling at a position of the master axis",
        ),
    ] {
        let (mut axis, _) = rig(200.0, modulo);
        let refused = axis.command(&command).unwrap_err().to_string();
        assert!(refused.starts_with(expected), "{refused}");
    }
}
