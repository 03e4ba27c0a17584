//! Commands, writes and cycles of a cam coupling allocate no memory once it has its plates.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use coaxle_cam::{
    Activation, ActivationMode, CamAdd, CamCoupling, CamExchange, CamInV2, CamLimits, CamOut,
    CamRemove, CamRequest, CamScalingV2, CouplingParameters, JumpHandling, OnlineChangeMode,
    Tables,
};
use coaxle_curve::law::MotionLaw;
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{Course, MotionFunction, MotionPoint, Plate, PointType};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn point(index: u32, slave: f64) -> MotionPoint {
    MotionPoint {
        index,
        function: MotionLaw::Polynom5,
        point_type: PointType::Rest,
        relative_next: 1,
        master: f64::from(index) * 30.0,
        slave,
        velocity: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
    }
}

fn plate() -> Plate {
    let points = (1..=12)
        .map(|index| point(index, f64::from(index % 4)))
        .collect();
    let function = MotionFunction::new(points).expect("the points are right");
    Plate::from_function(function, Course::Cyclic)
}

#[test]
fn commands_writes_and_cycles_do_not_allocate() {
    let mut tables = Tables::new(3);
    for id in 1..=3 {
        tables.insert(id, plate()).expect("there is room");
    }
    let mut coupling = CamCoupling::new(CouplingParameters {
        master_axis_id: 1,
        slave_axis_id: 2,
        limits: CamLimits {
            velocity: 1e9,
            acceleration: 1e12,
            deceleration: 1e12,
            jerk: 6e15,
            cycle: 1e-6,
        },
    })
    .expect("the parameters are right");
    let jump = JumpHandling::RampIn { master_length: 9.0 };
    let activation = Activation::new(ActivationMode::NextCycle);
    let once = Activation::new(ActivationMode::NextCycleOnce);
    let commands = [
        CamRequest::from(CamInV2 {
            table: 1,
            jump,
            ..CamInV2::default()
        }),
        CamRequest::from(CamAdd {
            table: 2,
            jump,
            activation,
            ..CamAdd::default()
        }),
        CamRequest::from(CamScalingV2 {
            table: 2,
            jump,
            activation: once,
            ..CamScalingV2::default()
        }),
        CamRequest::from(CamExchange {
            table: 3,
            reference: 1,
            jump,
            activation: once,
            ..CamExchange::default()
        }),
        CamRequest::from(CamRemove {
            table: 2,
            jump,
            activation,
        }),
    ];
    let mode = OnlineChangeMode {
        activation,
        jump,
        ..OnlineChangeMode::default()
    };
    let last = assert_no_alloc(|| {
        let mut master = Kinematics::default();
        let mut slave = Kinematics::default();
        let mut cycle = |coupling: &mut CamCoupling, tables: &mut Tables| {
            master.position += 7.0;
            slave = coupling.update(tables, &master);
            (master, slave)
        };
        let mut axes = (Kinematics::default(), Kinematics::default());
        for command in &commands {
            coupling
                .start(&mut tables, command, &axes.0, &axes.1)
                .expect("the command is right");
            for id in 1..=3 {
                tables.set_online_change_mode(id, mode).expect("a mode");
                tables
                    .write(id, &[point(3, 0.5), point(5, 2.5)])
                    .expect("points");
            }
            // 1050 of the master are three cycles of 330: enough for a change of one cycle and its return.
            for _ in 0..150 {
                axes = cycle(&mut coupling, &mut tables);
            }
            coupling.info(&tables, 1, Some(40.0)).expect("a coupling");
        }
        coupling
            .start(&mut tables, &CamOut {}.into(), &axes.0, &axes.1)
            .expect("a coupling");
        axes.1.position
    });
    assert!(last.is_finite());
}
