//! A flying saw allocates no memory: planning, refusing, dry runs, running, reading.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_cam::Tables;
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_plc::ReadFlyingSawCharacteristicsBlock;
use coaxle_saw::{GearInPos, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode, SyncStrategy};
use coaxle_slave::{Command, Dynamics, SlaveAxis, SlaveParameters};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn axis() -> SlaveAxis {
    let parameters = SlaveParameters {
        min_position: Some(-10_000.0),
        max_position: Some(10_000.0),
        ..SlaveParameters::new(2_000.0, 20_000.0, 1e6)
    };
    let drive =
        SimulatedDrive::new(DriveParameters::default()).expect("the constants are in range");
    let cycle = CycleTime::new(Span::from_millis(1)).expect("1 ms is a cycle time");
    SlaveAxis::new(&parameters, Box::new(drive), cycle).expect("the parameters are in range")
}

fn gear_in_velo(sync_mode: SyncMode) -> Command {
    Command::GearInVelo(GearInVelo {
        ratio: Ratio::of(1.5),
        sync_mode,
        limits: SyncLimits::default(),
    })
}

fn gear_in_pos(
    ahead: f64,
    mask: SyncMask,
    start_distance: Option<f64>,
) -> impl Fn(f64, f64) -> Command {
    move |master, slave| {
        Command::from(GearInPos {
            ratio: Ratio::of(1.0),
            master_sync_position: master + ahead,
            slave_sync_position: slave + 0.6 * ahead,
            master_start_distance: start_distance,
            strategy: None,
            sync_mode: SyncMode::position_based(mask),
            limits: SyncLimits::default(),
        })
    }
}

#[test]
fn a_flying_saw_does_not_allocate() {
    let mut axis = axis();
    let mut master = Kinematics {
        position: 0.0,
        velocity: 500.0,
        acceleration: 0.0,
    };
    let mut lead = |axis: &mut SlaveAxis, velocity: f64, cycles: u32| {
        master.velocity = velocity;
        for _ in 0..cycles {
            master.position += velocity * 1e-3;
            axis.update(&mut Tables::new(0), Some(&master), Seconds(1e-3));
        }
        master.position
    };
    let all = SyncMask::CHECKS - SyncMask::MAX_JERK;
    let by = |strategy| {
        move |master, slave| match gear_in_pos(300.0, SyncMask::empty(), None)(master, slave) {
            Command::GearInPos(command) => Command::GearInPos(GearInPos {
                strategy: Some(strategy),
                ..command
            }),
            other => other,
        }
    };
    let strategies = SyncStrategy::ALL.map(by);
    let saws = [
        gear_in_pos(200.0, SyncMask::empty(), None),
        gear_in_pos(300.0, SyncMask::OVERSHOOT_VELO | SyncMask::MAX_JERK, None),
        gear_in_pos(300.0, SyncMask::PREFER_CONST_VELO, None),
        gear_in_pos(300.0, SyncMask::empty(), Some(250.0)),
        // A position too near, and one already passed: refusals must not allocate either.
        gear_in_pos(1.0, all, None),
        gear_in_pos(-1.0, all, None),
    ];
    let mut read = ReadFlyingSawCharacteristicsBlock::default();
    let coupled = assert_no_alloc(|| {
        let mut coupled = [false; 8];
        let mut by_strategy = [false; 3];
        let _ = axis.command(&mut Tables::new(0), &Command::Power(true));
        let mut at = lead(&mut axis, 500.0, 1);
        for (n, saw) in saws.iter().enumerate() {
            let command = saw(at, axis.set().position);
            let tried = axis.plan(&Tables::new(0), &command).is_ok();
            let accepted = axis.command(&mut Tables::new(0), &command).is_ok();
            // Formatted messages would allocate, so that this has none.
            assert!(tried == accepted);
            coupled[n] = accepted;
            lead(&mut axis, 500.0, 800);
            read.scan(true, 1, &axis);
            read.scan(false, 1, &axis);
            let _ = axis.command(
                &mut Tables::new(0),
                &Command::MoveAbsolute {
                    position: 0.0,
                    velocity: None,
                    dynamics: Dynamics::default(),
                },
            );
            at = lead(&mut axis, 500.0, 1_500);
        }
        for (n, saw) in strategies.iter().enumerate() {
            by_strategy[n] = axis
                .command(&mut Tables::new(0), &saw(at, axis.set().position))
                .is_ok();
            // With the strategy early, the plan is renewed as its master changes its velocity.
            let swing = if n == 2 { 5.0 } else { 0.0 };
            for velocity in [500.0, 500.0 + swing, 500.0 - swing, 500.0] {
                lead(&mut axis, velocity, 200);
            }
            let _ = axis.command(
                &mut Tables::new(0),
                &Command::MoveAbsolute {
                    position: 0.0,
                    velocity: None,
                    dynamics: Dynamics::default(),
                },
            );
            at = lead(&mut axis, 500.0, 1_500);
        }
        assert!(by_strategy == [true; 3]);
        for (n, sync_mode) in [SyncMode::default(), SyncMode::time_based(all)]
            .into_iter()
            .enumerate()
        {
            coupled[6 + n] = axis
                .command(&mut Tables::new(0), &gear_in_velo(sync_mode))
                .is_ok();
            lead(&mut axis, 500.0, 100);
            // Back past the coupling position, where it is stopped.
            lead(&mut axis, -10.0, 10_000);
            let _ = axis.command(&mut Tables::new(0), &Command::Reset {});
            let _ = axis.command(
                &mut Tables::new(0),
                &Command::Halt {
                    dynamics: Dynamics::default(),
                },
            );
            lead(&mut axis, 500.0, 1_000);
        }
        coupled
    });
    assert_eq!(coupled, [true, true, true, true, false, false, true, true]);
}
