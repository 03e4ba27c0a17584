//! TF5050 chapters 4.5 and 8.4: scaling, automatic offsets, cycles put on hold.

use super::*;

fn axis(mode: ScalingMode, scaling: f64) -> AxisScaling {
    AxisScaling {
        mode,
        scaling,
        ..AxisScaling::default()
    }
}

fn scale(mode: ActivationMode, at: f64, master: AxisScaling, slave: AxisScaling) -> CamRequest {
    CamRequest::from(CamScaling {
        activation: activation(mode, at),
        scaling: ScalingData { master, slave },
        jump: JumpHandling::Refuse,
    })
}

#[test]
fn the_manual_s_example_360_scaled_to_720_at_90() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    rig.start(scale(
        ActivationMode::AtMasterCamPos,
        90.0,
        axis(ScalingMode::AutoOffset, 2.0),
        axis(ScalingMode::Off, 1.0),
    ))
    .unwrap();
    rig.lead(89.5, 1.0);
    rig.lead(90.5, 1.0);
    let info = rig.coupling.info(&rig.tables, 0, Some(90.0)).unwrap();
    // A quarter of the cycle before is a quarter after; scaled, that is 180.
    assert_near(info.master_cam_position, 90.0);
    assert_near(info.master_cam_position * info.master_scaling, 180.0);
    assert_near(info.slave_axis_position, rig.raw(BACK_AND_FORTH, 90.0));
    // The rest of the cycle, scaled, takes 540.
    rig.lead(90.0 + 540.0, 1.0);
    assert_near(rig.slave.position, 0.0);
}

#[test]
fn the_master_comes_before_the_slave() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    rig.lead(90.0, 1.0);
    let before = rig.slave.position;
    rig.start(scale(
        ActivationMode::Instantaneous,
        0.0,
        axis(ScalingMode::AutoOffset, 3.0),
        axis(ScalingMode::AutoOffset, 2.0),
    ))
    .unwrap();
    rig.go(90.0);
    assert_near(rig.slave.position, before);
    let info = rig.coupling.info(&rig.tables, 0, None).unwrap();
    assert_near(info.master_cam_position, 90.0);
    assert_near(
        info.slave_offset,
        before - 2.0 * rig.raw(BACK_AND_FORTH, 90.0),
    );
}

#[test]
fn a_scaling_that_is_off_leaves_its_axis_alone() {
    let mut rig = Rig::new();
    rig.start(CamRequest::from(CamIn {
        master_offset: 10.0,
        master_scaling: 2.0,
        slave_scaling: 4.0,
        slave_offset: -4.0 * rig.raw(BACK_AND_FORTH, 5.0),
        ..cam_in(BACK_AND_FORTH)
    }))
    .unwrap();
    rig.lead(700.0, 1.0);
    rig.start(scale(
        ActivationMode::NextCycle,
        0.0,
        axis(ScalingMode::Off, 9.0),
        axis(ScalingMode::AutoOffset, 1.0),
    ))
    .unwrap();
    rig.lead(900.0, 1.0);
    let info = rig.coupling.info(&rig.tables, 0, None).unwrap();
    assert_eq!((info.master_offset, info.master_scaling), (10.0, 2.0));
    assert_eq!(info.slave_scaling, 1.0);
}

#[test]
fn strokes_done_are_kept_when_the_slave_is_scaled_at_a_seam() {
    for direction in [1.0, -1.0] {
        let mut rig = Rig::coupled(WITH_LIFT);
        rig.lead(direction * (3.0 * 360.0 + 50.0), 7.0);
        rig.start(scale(
            ActivationMode::NextCycle,
            0.0,
            axis(ScalingMode::Off, 1.0),
            axis(ScalingMode::UserDefined, 2.5),
        ))
        .unwrap();
        let largest = rig.lead(direction * (5.0 * 360.0), 0.5);
        assert!(largest < 1.0, "{largest}");
        // Four cycles as before the scaling, the fifth by 2.5.
        assert_near(rig.slave.position, direction * (400.0 + 250.0));
    }
}

#[test]
fn switching_at_a_seam_with_both_automatic_offsets_is_seamless() {
    let mut rig = Rig::coupled(WITH_LIFT);
    rig.start(CamRequest::from(CamIn {
        activation: Activation::new(ActivationMode::NextCycle),
        master_scaling_mode: ScalingMode::AutoOffset,
        slave_scaling_mode: ScalingMode::AutoOffset,
        master_scaling: 0.5,
        ..cam_in(SPARE)
    }))
    .unwrap();
    let largest = rig.lead(360.0 + 100.0, 0.25);
    assert!(largest < 0.3, "{largest}");
    // From its start, at once: 100 of the master are one cycle of 200 scaled by a half.
    assert_near(rig.slave.position, 110.0);
}

#[test]
fn linear_plates_follow_one_another_in_both_directions() {
    for (direction, first) in [(1.0, 0.0), (-1.0, 100.0)] {
        let mut rig = Rig::new();
        rig.master.position = first;
        rig.slave.position = rig.raw(LINEAR, first);
        rig.start(CamRequest::from(cam_in(LINEAR))).unwrap();
        for turn in 1..=3 {
            rig.lead(first + direction * (100.0 * f64::from(turn) - 50.0), 0.75);
            rig.start(CamRequest::from(CamIn {
                activation: Activation::new(ActivationMode::NextCycle),
                master_scaling_mode: ScalingMode::AutoOffset,
                slave_scaling_mode: ScalingMode::AutoOffset,
                ..cam_in(LINEAR)
            }))
            .unwrap();
        }
        let largest = rig.lead(first + direction * 400.0, 0.75);
        assert!(largest < 1.0, "{largest}");
        // Four strokes of 40, each from where the last one ended.
        let expected = if direction > 0.0 { 160.0 } else { 40.0 - 160.0 };
        assert_near(rig.slave.position, expected);
    }
}

#[test]
fn a_scaling_for_one_cycle_returns_and_keeps_what_the_slave_has_gained() {
    let mut rig = Rig::coupled(WITH_LIFT);
    rig.lead(100.0, 1.0);
    let ticket = rig
        .start(scale(
            ActivationMode::NextCycleOnce,
            0.0,
            axis(ScalingMode::AutoOffset, 2.0),
            axis(ScalingMode::UserDefined, 3.0),
        ))
        .unwrap();
    let largest = rig.lead(360.0 + 700.0, 0.5);
    assert_eq!(rig.state(ticket), CommandState::Active);
    let largest = largest.max(rig.lead(360.0 + 720.0 + 360.0, 0.5));
    assert!(largest < 1.0, "{largest}");
    assert_eq!(rig.state(ticket), CommandState::Done);
    // A cycle before, one of 720 by 3, and a cycle after.
    assert_near(rig.slave.position, 100.0 + 300.0 + 100.0);
}

#[test]
fn a_plate_for_one_cycle_with_automatic_offsets_is_seamless() {
    let mut rig = Rig::coupled(WITH_LIFT);
    rig.lead(100.0, 1.0);
    rig.start(CamRequest::from(CamIn {
        activation: Activation::new(ActivationMode::NextCycleOnce),
        master_scaling_mode: ScalingMode::AutoOffset,
        slave_scaling_mode: ScalingMode::AutoOffset,
        ..cam_in(SPARE)
    }))
    .unwrap();
    let largest = rig.lead(360.0 + 200.0 + 360.0, 0.5);
    assert!(largest < 0.5, "{largest}");
    // A cycle of 360, one of the other plate, 200 long with a lift of 10, and a cycle of 360.
    assert_near(rig.slave.position, 100.0 + 10.0 + 100.0);
    let info = rig.coupling.info(&rig.tables, 0, None).unwrap();
    assert_eq!(info.table, WITH_LIFT);
}

#[test]
fn a_negative_master_scaling_runs_the_plate_backwards() {
    let mut rig = Rig::coupled(WITH_LIFT);
    rig.lead(200.0, 1.0);
    let before = rig.slave.position;
    rig.start(scale(
        ActivationMode::Instantaneous,
        0.0,
        axis(ScalingMode::AutoOffset, -1.0),
        axis(ScalingMode::AutoOffset, 1.0),
    ))
    .unwrap();
    rig.lead(400.0, 1.0);
    // 200 of the master backwards, from 200 to 0 on the plate.
    assert_near(rig.slave.position, before - rig.raw(WITH_LIFT, 200.0));
}

#[test]
fn a_seam_far_out_is_still_a_seam() {
    let mut rig = Rig::new();
    let far = 1e6 * 360.0;
    rig.master.position = far + 0.1;
    rig.start(CamRequest::from(CamIn {
        master_offset: -far - 0.1,
        ..cam_in(WITH_LIFT)
    }))
    .unwrap();
    rig.lead(far + 300.0, 7.0);
    rig.start(scale(
        ActivationMode::NextCycle,
        0.0,
        axis(ScalingMode::Off, 1.0),
        axis(ScalingMode::UserDefined, 2.0),
    ))
    .unwrap();
    let largest = rig.lead(far + 360.1 + 360.0, 0.5);
    assert!(largest < 1.0, "{largest}");
    // 100 and twice 100. At 3.6e8 neighbouring doubles of the master are 6e-8 apart.
    assert!((rig.slave.position - 300.0).abs() < 1e-6);
}
