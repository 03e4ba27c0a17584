//! Properties of any plate, any placement in the axes and any command.

mod random;

use proptest::prelude::*;

use random::{Action, any_action};

use super::*;

const PLATE: TableId = 9;

/// A cyclic plate of five rest points with a lift.
fn any_points() -> impl Strategy<Value = Vec<(f64, f64)>> {
    (
        -500.0..500.0f64,
        prop::collection::vec(10.0..200.0f64, 4),
        prop::collection::vec(-100.0..100.0f64, 5),
    )
        .prop_map(|(start, widths, slaves)| {
            let mut master = start;
            let mut points = std::vec![(start, slaves[0])];
            for (width, slave) in widths.iter().zip(&slaves[1..]) {
                master += width;
                points.push((master, *slave));
            }
            points
        })
}

fn any_scaling() -> impl Strategy<Value = f64> {
    prop_oneof![0.1..5.0f64, -5.0..-0.1f64]
}

fn rig_on(points: &[(f64, f64)]) -> Rig {
    let mut rig = Rig::new();
    rig.tables
        .insert(PLATE, plate(points, Course::Cyclic))
        .expect("room");
    rig
}

/// Returns the steepest slope of a plate of rest points joined by quintics.
fn slope_bound(points: &[(f64, f64)]) -> f64 {
    let slopes = points
        .windows(2)
        // 30z²(1 - z)² at z = 1/2.
        .map(|w| 1.875 * ((w[1].1 - w[0].1) / (w[1].0 - w[0].0)).abs());
    slopes.fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn the_automatic_offset_never_jumps(
        points in any_points(),
        other in any_points(),
        scalings in prop::array::uniform4(any_scaling()),
        master in -3000.0..3000.0f64,
        keeps_master in any::<bool>(),
        switches in any::<bool>(),
    ) {
        let mut rig = rig_on(&points);
        rig.tables.insert(10, plate(&other, Course::Cyclic)).unwrap();
        rig.start(CamRequest::from(CamIn {
            master_scaling: scalings[0],
            slave_scaling: scalings[1],
            jump: JumpHandling::Allow,
            ..cam_in(PLATE)
        })).unwrap();
        rig.go(0.0);
        let before = rig.go(master);
        let fraction = |info: CamInfo| (info.master_cam_position - info.master_cam_start)
            / info.raw_master_period;
        let part = fraction(rig.coupling.info(&rig.tables, 0, None).unwrap());
        let master_mode = if keeps_master {
            ScalingMode::AutoOffset
        } else {
            ScalingMode::UserDefined
        };
        let change = CamIn {
            table: 10,
            master_scaling_mode: master_mode,
            slave_scaling_mode: ScalingMode::AutoOffset,
            master_scaling: scalings[2],
            slave_scaling: scalings[3],
            ..CamIn::default()
        };
        rig.start(if switches {
            CamRequest::from(change)
        } else {
            CamRequest::from(CamScaling {
                scaling: change.scaling(),
                ..CamScaling::default()
            })
        }).unwrap();
        let after = rig.go(master);
        prop_assert!((after - before).abs() <= 1e-9 * before.abs().max(100.0), "{before} {after}");
        let info = rig.coupling.info(&rig.tables, 0, None).unwrap();
        prop_assert_eq!(info.master_scaling, scalings[2]);
        prop_assert_eq!(info.slave_scaling, scalings[3]);
        if keeps_master {
            let off = (fraction(info) - part).abs();
            // At a seam the part is 0 or 1, by rounding.
            prop_assert!(off.min((off - 1.0).abs()) < 1e-9, "{off}");
        }
    }

    #[test]
    fn an_online_change_never_jumps(
        points in any_points(),
        mode in prop::sample::select(&[
            ActivationMode::Instantaneous,
            ActivationMode::NextCycle,
            ActivationMode::NextCycleOnce,
            ActivationMode::AsSoonAsPossible,
            ActivationMode::AtMasterAxisPos,
        ][..]),
        master_scaling_mode in prop::sample::select(&[ScalingMode::Off, ScalingMode::AutoOffset][..]),
        slave_scaling_mode in prop::sample::select(&[ScalingMode::Off, ScalingMode::AutoOffset][..]),
        index in 1..=5u32,
        slave in -100.0..100.0f64,
        shift in -9.0..9.0f64,
        start in -1000.0..1000.0f64,
        backwards in any::<bool>(),
    ) {
        let mut rig = rig_on(&points);
        rig.start(CamRequest::from(CamIn {
            start_mode: StartMode::Absolute,
            jump: JumpHandling::Allow,
            ..cam_in(PLATE)
        })).unwrap();
        rig.go(start);
        rig.go(start);
        rig.tables.set_online_change_mode(PLATE, OnlineChangeMode {
            activation: activation(mode, start + 50.0),
            master_scaling_mode,
            slave_scaling_mode,
            jump: JumpHandling::Refuse,
        }).unwrap();
        let mut changed = points.clone();
        let row = index as usize - 1;
        changed[row].0 += shift * 0.5;
        changed[row].1 = slave;
        let written = rig.tables.write(PLATE, &[rest(index, changed[row].0, slave)]);
        // A point moved beyond its neighbour is refused, and no subject of this property.
        prop_assume!(written.is_ok());
        let step = 2.0;
        let steepest = slope_bound(&points).max(slope_bound(&changed));
        let way = if backwards { -3000.0 } else { 3000.0 };
        let largest = rig.lead(start + way, step);
        // Besides its course a slave may deviate in one cycle by what a change without a refusal allows.
        let bound = steepest * step + LIMITS.farthest();
        prop_assert!(largest <= bound * (1.0 + 1e-9) + 1e-9, "{largest} over {bound}");
    }

    #[test]
    fn a_cycle_later_the_slave_is_a_lift_further(
        points in any_points(),
        ms in any_scaling(),
        ss in any_scaling(),
        offsets in prop::array::uniform2(-200.0..200.0f64),
        master in -2000.0..2000.0f64,
        turns in -5..5i32,
    ) {
        let mut rig = rig_on(&points);
        rig.start(CamRequest::from(CamIn {
            master_offset: offsets[0],
            slave_offset: offsets[1],
            master_scaling: ms,
            slave_scaling: ss,
            jump: JumpHandling::Allow,
            ..cam_in(PLATE)
        })).unwrap();
        rig.go(0.0);
        let here = rig.go(master);
        let (first, last) = (points[0], points[4]);
        let there = rig.go(master + f64::from(turns) * (last.0 - first.0) * ms);
        let expected = here + f64::from(turns) * (last.1 - first.1) * ss;
        prop_assert!((there - expected).abs() <= 1e-8, "{there} {expected}");
        // And nothing jumps where the cycles meet.
        let step = 1e-3;
        let largest = rig.lead(rig.master.position + 0.5, step);
        let bound = slope_bound(&points) * (ss / ms).abs() * step;
        prop_assert!(largest <= bound * (1.0 + 1e-9) + 1e-9);
    }

    #[test]
    fn a_ramp_is_continuous_in_position_velocity_and_acceleration(
        points in any_points(),
        other in any_points(),
        master in -1000.0..1000.0f64,
        length in 5.0..300.0f64,
        backwards in any::<bool>(),
    ) {
        let mut rig = rig_on(&points);
        rig.tables.insert(10, plate(&other, Course::Cyclic)).unwrap();
        rig.start(CamRequest::from(CamIn { jump: JumpHandling::Allow, ..cam_in(PLATE) })).unwrap();
        rig.go(master);
        rig.go(master);
        // A master at a steady 1 per second: slopes and curvatures are velocities and accelerations.
        let velocity = if backwards { -1.0 } else { 1.0 };
        let at = |position| Kinematics { position, velocity, acceleration: 0.0 };
        let before = rig.coupling.update(&mut rig.tables, &at(master));
        rig.start(CamRequest::from(CamIn {
            table: 10,
            jump: JumpHandling::RampIn { master_length: length },
            ..CamIn::default()
        })).unwrap();
        let after = rig.coupling.update(&mut rig.tables, &at(master));
        let scale = before.position.abs().max(100.0);
        prop_assert!((after.position - before.position).abs() < 1e-9 * scale);
        prop_assert!((after.velocity - before.velocity).abs() < 1e-9 * scale);
        prop_assert!((after.acceleration - before.acceleration).abs() < 1e-8 * scale);
        // At its end the plate continues where the ramp ends.
        let end = master + velocity * length;
        // The rest of the ramp is of third order: 1e-21 of the gap.
        let off = length * 1e-7;
        let near = rig.coupling.update(&mut rig.tables, &at(end - velocity * off));
        prop_assert_eq!(rig.coupling.state(), CommandState::Active);
        let plate = rig.tables.plate(10).unwrap();
        let on_plate = plate.slave_dynamics(&at(end - velocity * off)).position
            - plate.turn(master) * plate.lift();
        prop_assert!((near.position - on_plate).abs() < 1e-9 * scale);
        rig.coupling.update(&mut rig.tables, &at(end + velocity * off));
        prop_assert_eq!(rig.coupling.state(), CommandState::InSync);
    }

    #[test]
    fn no_sequence_of_commands_breaks_it(
        actions in prop::collection::vec(any_action(), 1..60),
    ) {
        let mut rig = Rig::new();
        let mut other = CamCoupling::new(rig.coupling.parameters).unwrap();
        for action in actions {
            match action {
                Action::Command(command) => {
                    let _ = rig.start(command);
                }
                Action::Other(command) => {
                    let _ = other.start(&mut rig.tables, &command, &rig.master, &rig.slave);
                }
                Action::Mode(table, mode) => {
                    let _ = rig.tables.set_online_change_mode(table, mode);
                }
                Action::Write(table, point) => {
                    let _ = rig.tables.write(table, &[point]);
                }
                Action::Go(way) => {
                    let to = rig.master.position + way;
                    rig.lead(to, 37.0);
                }
                Action::Error => rig.coupling.axis_error(&mut rig.tables, 0x4550),
            }
            other.update(&mut rig.tables, &rig.master);
            for slave in [rig.coupling.slave(), other.slave()] {
                prop_assert!(slave.position.is_finite());
                prop_assert!(slave.velocity.is_finite());
                prop_assert!(slave.acceleration.is_finite());
            }
        }
        // Uncoupled, every table is free: none was held too often or too little.
        let _ = rig.start(CamOut {}.into());
        let _ = other.start(&mut rig.tables, &CamOut {}.into(), &rig.master, &rig.slave);
        let ids: Vec<TableId> = rig.tables.ids().collect();
        for id in ids {
            prop_assert!(rig.tables.remove(id).is_ok(), "table {id}");
        }
    }
}
