use super::*;
use crate::tests::{dynamics, moment, to_position, to_velocity};
use crate::{Check, SyncLimits, SyncMode};
use coaxle_axis::CommandState;
use proptest::prelude::*;
use std::vec::Vec;

const CYCLE: Seconds = Seconds(1e-3);

/// Master that is led by its velocity.
struct Master(Kinematics);

impl Master {
    fn run(&mut self, velocity: f64) -> &Kinematics {
        self.0.velocity = velocity;
        self.0.position += velocity * CYCLE.0;
        &self.0
    }
}

fn couple(command: SawCommand, moment: &CouplingMoment) -> (SawCoupling, Master) {
    let coupling = SawCoupling::start(command, moment, SawTolerances::default())
        .expect("the command is accepted");
    (coupling, Master(moment.master))
}

fn gear_in_pos(mask: SyncMask) -> SawCommand {
    let mode = SyncMode::position_based(mask);
    let limits = dynamics(2_500.0, 5_000.0);
    SawCommand::GearInPos(to_position(1.0, (1_000.0, 1_000.0), mode, limits))
}

fn example() -> CouplingMoment {
    moment((-500.0, 500.0), (-250.0, 250.0))
}

#[test]
fn a_run_to_position_passes_through_the_states() {
    let (mut coupling, mut master) = couple(gear_in_pos(SyncMask::empty()), &example());
    assert_eq!(coupling.axis_state(), AxisState::SlaveSynchronizing);
    let mut in_sync_at = None;
    for _ in 0..4_000 {
        let slave = coupling.update(master.run(500.0), CYCLE);
        if *coupling.state() == CommandState::InSync {
            in_sync_at.get_or_insert(master.0.position);
            assert!((slave.position - master.0.position).abs() < 1e-6);
            assert!((slave.velocity - 500.0).abs() < 1e-6);
        }
    }
    let at = in_sync_at.expect("gets in sync");
    assert!((990.0..=1_000.5).contains(&at), "{at}");
    assert_eq!(coupling.axis_state(), AxisState::SlaveSynchronous);
    assert_eq!(coupling.slave().position, master.0.position);
}

#[test]
fn in_sync_shows_as_soon_as_the_slave_is_on_its_line() {
    let shoots = SyncMask::OVERSHOOT_VELO | SyncMask::UNDERSHOOT_VELO;
    let (mut coupling, mut master) = couple(gear_in_pos(shoots), &example());
    while *coupling.state() != CommandState::InSync {
        assert_eq!(*coupling.state(), CommandState::Active);
        coupling.update(master.run(500.0), CYCLE);
    }
    // The ramp of 1000 u ends half way.
    assert!(
        (master.0.position - 500.0).abs() < 5.0,
        "{}",
        master.0.position
    );
}

#[test]
fn a_start_distance_is_waited_for() {
    let SawCommand::GearInPos(mut command) = gear_in_pos(SyncMask::empty()) else {
        return;
    };
    command.master_start_distance = Some(1_000.0);
    command.slave_sync_position = 1_500.0;
    let (mut coupling, mut master) = couple(SawCommand::GearInPos(command), &example());
    assert_eq!(coupling.axis_state(), AxisState::SlavePrephase);
    assert_eq!(*coupling.state(), CommandState::Waiting);
    assert!(!coupling.has_started_sync());
    while *coupling.state() == CommandState::Waiting {
        let slave = coupling.update(master.run(500.0), CYCLE);
        assert_eq!(slave.velocity, 250.0);
    }
    assert!(
        (master.0.position - 0.0).abs() <= 0.5,
        "{}",
        master.0.position
    );
    assert!(coupling.has_started_sync());
    for _ in 0..2_100 {
        coupling.update(master.run(500.0), CYCLE);
    }
    assert_eq!(*coupling.state(), CommandState::InSync);
    let far = command.master_sync_position;
    assert!((coupling.slave().position - 1_500.0 - (master.0.position - far)).abs() < 1e-9);

    command.master_start_distance = Some(-1.0);
    let refused = SawCoupling::start(
        SawCommand::GearInPos(command),
        &example(),
        SawTolerances::default(),
    );
    assert_eq!(refused.unwrap_err().code(), 0x4b06);
}

/// Runs forwards for `forward` cycles, then backwards until well past the coupling position.
fn there_and_back(mask: SyncMask, forward: usize) -> (SawCoupling, Vec<Kinematics>) {
    let start = moment((0.0, 500.0), (0.0, 250.0));
    let mode = SyncMode::position_based(mask);
    // The slave is at 0 and the line 100 ahead, so that each place shows which of the two led.
    let limits = dynamics(2_500.0, 50_000.0);
    let command = to_position(1.0, (1_000.0, 1_100.0), mode, limits);
    let (mut coupling, mut master) = couple(SawCommand::GearInPos(command), &start);
    let mut slaves = Vec::new();
    for _ in 0..forward {
        coupling.update(master.run(500.0), CYCLE);
    }
    for _ in 0..forward + 1_000 {
        slaves.push(coupling.update(master.run(-500.0), CYCLE));
    }
    (coupling, slaves)
}

#[test]
fn the_eight_cases_of_a_rollback() {
    use RollbackReaction::{Follow, Instant, Ramp};
    let lock = SyncMask::ROLLBACK_LOCK;
    let instant = SyncMask::INSTANT_STOP_ON_ROLLBACK;
    let none = SyncMask::empty();
    let cases = [
        (none, true, Follow),
        (none, false, Ramp),
        (instant, false, Instant),
        (instant, true, Follow),
        (lock, false, Ramp),
        (lock, true, Ramp),
        (lock | instant, false, Instant),
        (lock | instant, true, Instant),
    ];
    for (number, (mask, reached, reaction)) in (1..).zip(cases) {
        assert_eq!(
            RollbackReaction::of(mask, reached),
            reaction,
            "case {number}"
        );
        // 1000 u of the master take 2000 cycles.
        let forward = if reached { 2_500 } else { 1_000 };
        let (coupling, slaves) = there_and_back(mask, forward);
        let slave = *coupling.slave();
        // Position and velocity of the slave as its master passes the coupling position.
        let (position, velocity) = if reached {
            (100.0, -500.0)
        } else {
            (0.0, -250.0)
        };
        let duration: f64 = f64::max(
            1.5 * f64::abs(velocity) / 2_500.0,
            libm::sqrt(6.0 * f64::abs(velocity) / 50_000.0),
        );
        match reaction {
            Follow => {
                assert_eq!(*coupling.state(), CommandState::InSync, "case {number}");
                assert!(
                    (slave.position - (100.0 - 500.0)).abs() < 1e-6,
                    "case {number}"
                );
                assert_eq!(slave.velocity, -500.0);
            }
            Ramp => {
                // A symmetric ramp to zero has half of its velocity on average.
                let end = position + velocity * duration / 2.0;
                assert!(
                    // The default tolerance of 1e-3 u behind the
                    // coupling position, times the slope of the gear.
                    (slave.position - end).abs() < 2e-3,
                    "case {number}: {slave:?}"
                );
                for pair in slaves.windows(2) {
                    let step = (pair[1].velocity - pair[0].velocity).abs();
                    assert!(step <= 2_500.0 * CYCLE.0 * 1.001, "case {number}: {step}");
                }
            }
            Instant => {
                assert!((slave.position - position).abs() < 2e-3, "case {number}");
                let last_moving = slaves.iter().rposition(|s| s.velocity != 0.0);
                let stop = last_moving.expect("it moved") + 1;
                assert!(
                    // No ramp in between: at full speed in one cycle, at rest in the next.
                    slaves[stop - 1].velocity < -200.0,
                    "case {number}: in one cycle"
                );
            }
        }
        if reaction != Follow {
            assert_eq!(*coupling.state(), CommandState::Aborted, "case {number}");
            assert_eq!(coupling.rollback(), Some(reaction));
            assert_eq!((slave.velocity, slave.acceleration), (0.0, 0.0));
            assert_eq!(coupling.axis_state(), AxisState::Inactive);
            assert!(!coupling.is_coupled());
        }
    }
}

#[test]
fn noise_of_the_master_is_no_rollback() {
    let start = moment((0.0, 1.0), (0.0, 0.0));
    let command = to_position(1.0, (10.0, 5.0), SyncMode::default(), SyncLimits::default());
    let tolerances = SawTolerances {
        master_noise: 0.01,
        ..SawTolerances::default()
    };
    let command = SawCommand::GearInPos(command);
    let mut coupling = SawCoupling::start(command, &start, tolerances).unwrap();
    let at = |position| Kinematics {
        position,
        velocity: 0.0,
        acceleration: 0.0,
    };
    for position in [-0.009, 0.002, -0.005] {
        let slave = coupling.update(&at(position), CYCLE);
        assert!(slave.position.abs() < 1e-6);
        assert_eq!(*coupling.state(), CommandState::Active);
    }
    coupling.update(&at(-0.011), CYCLE);
    assert_eq!(*coupling.state(), CommandState::Aborted);
}

#[test]
fn gear_out_keeps_the_velocity_and_leads_the_acceleration_to_zero() {
    let (mut coupling, mut master) = couple(gear_in_pos(SyncMask::empty()), &example());
    for _ in 0..500 {
        coupling.update(master.run(500.0), CYCLE);
    }
    let before = *coupling.slave();
    assert!(before.acceleration > 0.0);
    assert_eq!(coupling.gear_out(), before);
    assert_eq!(*coupling.state(), CommandState::Aborted);
    let jerk = example().axis.dynamics.jerk();
    let mut last = before;
    for _ in 0..2_000 {
        let slave = coupling.update(master.run(500.0), CYCLE);
        let change = (slave.acceleration - last.acceleration).abs();
        assert!(
            change <= jerk * CYCLE.0 * (1.0 + 1e-9),
            "{last:?} {slave:?}"
        );
        last = slave;
    }
    assert_eq!((last.velocity, last.acceleration), (before.velocity, 0.0));
    assert_eq!(coupling.axis_state(), AxisState::ConstantVelocity);
}

#[test]
fn limits_are_watched_while_coupled() {
    let mut start = example();
    start.axis.max_position = Some(1_500.0);
    let (mut coupling, mut master) = couple(gear_in_pos(SyncMask::empty()), &start);
    let mut last = start.slave.position;
    for _ in 0..6_000 {
        let slave = coupling.update(master.run(500.0), CYCLE);
        // 506 u/s at most are 0.506 u per cycle.
        assert!((slave.position - last).abs() < 0.6, "no jump");
        last = slave.position;
    }
    let CommandState::Failed(SawFault::Limit(violation)) = *coupling.state() else {
        panic!("{:?}", coupling.state());
    };
    assert_eq!(violation.check, Check::MaxPos);
    assert_eq!(coupling.slave().velocity, 0.0);

    let (mut coupling, mut master) = couple(gear_in_pos(SyncMask::empty()), &example());
    for _ in 0..6_000 {
        coupling.update(master.run(500.0), CYCLE);
    }
    coupling.update(master.run(2e4), CYCLE);
    let CommandState::Failed(fault) = *coupling.state() else {
        panic!("{:?}", coupling.state());
    };
    assert_eq!(fault.code(), 0x42df, "{fault}");
    let not_a_number = Kinematics::at_rest(f64::NAN);
    let (mut coupling, _) = couple(gear_in_pos(SyncMask::empty()), &example());
    assert!(coupling.update(&not_a_number, CYCLE).position.is_finite());
    let failed = CommandState::Failed(SawFault::MasterNotFinite);
    assert_eq!(*coupling.state(), failed);
}

#[test]
fn time_based_chases_an_accelerating_master() {
    let start = moment((0.0, 100.0), (0.0, 0.0));
    let mode = SyncMode::time_based(SyncMask::empty());
    let command = to_velocity(1.0, mode, dynamics(2_000.0, 50_000.0));
    let (mut coupling, mut master) = couple(SawCommand::GearInVelo(command), &start);
    let mut last = start.slave;
    let mut lead = None;
    for k in 0..2_000_u32 {
        // 500 u/s² for 0.4 s, a quarter of the slave's acceleration.
        let velocity = 100.0 + 0.5 * f64::from(k.min(400));
        let slave = coupling.update(master.run(velocity), CYCLE);
        assert!(slave.acceleration.abs() <= 2_000.0 * 1.001);
        let step = (slave.velocity - last.velocity).abs();
        assert!(step <= 2_000.0 * CYCLE.0 * 1.001, "{step}");
        let jerk = (slave.acceleration - last.acceleration) / CYCLE.0;
        if *coupling.state() == CommandState::Active {
            assert!(jerk.abs() <= 50_000.0 * 1.001, "{jerk}");
        } else {
            let distance = slave.position - master.0.position;
            let lead = *lead.get_or_insert(distance);
            assert!((distance - lead).abs() < 1e-9);
        }
        last = slave;
    }
    assert_eq!(*coupling.state(), CommandState::InSync);
    assert_eq!(last.velocity, 300.0);
}

/// Returns the cycle in which a slave at rest is in sync with a master of this velocity over the seconds.
/// Until then, the acceleration and jerk of its positions are within 2000 and 50000. Afterwards it is on
/// its line.
fn in_sync_after(velocity: impl Fn(f64) -> f64) -> Option<u32> {
    let start = moment((0.0, velocity(0.0)), (0.0, 0.0));
    let mode = SyncMode::time_based(SyncMask::empty());
    let command = to_velocity(1.0, mode, dynamics(2_000.0, 50_000.0));
    let (mut coupling, mut master) = couple(SawCommand::GearInVelo(command), &start);
    let (mut before, mut was) = (start.slave, [0.0; 2]);
    let mut in_sync = None;
    for k in 0..3_000_u32 {
        let at = |k: u32| velocity(f64::from(k) * CYCLE.0);
        let (last, now) = (at(k), at(k + 1));
        master.0.acceleration = (now - last) / CYCLE.0;
        // Led by its mean velocity, like one that moves evenly within its cycles.
        master.0.position += 0.5 * (last + now) * CYCLE.0;
        master.0.velocity = now;
        let slave = coupling.update(&master.0, CYCLE);
        let mean = (slave.position - before.position) / CYCLE.0;
        let acceleration = (mean - was[0]) / CYCLE.0;
        let jerk = (acceleration - was[1]) / CYCLE.0;
        assert!(acceleration.abs() <= 2_000.0 * 1.001, "{k}: {acceleration}");
        assert!(jerk.abs() <= 50_000.0 * 1.001, "{k}: {jerk}");
        (before, was) = (slave, [mean, acceleration]);
        if *coupling.state() == CommandState::InSync {
            in_sync.get_or_insert(k);
            assert_eq!(slave.velocity, now);
        }
    }
    in_sync
}

#[test]
fn time_based_is_in_sync_with_a_master_that_ripples() {
    for hertz in [0.5, 2.0, 5.0, 10.0] {
        // At 10 Hz it has 38 u/s², far within the slave's 2000.
        let ripple = 0.002 * 300.0;
        let rippling = |t: f64| 300.0 + ripple * libm::sin(core::f64::consts::TAU * hertz * t);
        // 0.19 s for a change of 300 with these limits.
        let cycles = in_sync_after(rippling).expect("in sync");
        assert!((180..=200).contains(&cycles), "{hertz} Hz: {cycles}");
    }
    let one_percent = |t: f64| 300.0 + 3.0 * libm::sin(core::f64::consts::TAU * t);
    let cycles = in_sync_after(one_percent).expect("in sync");
    assert!((180..=200).contains(&cycles), "{cycles}");
}

#[test]
fn time_based_is_in_sync_with_a_master_that_accelerates() {
    for acceleration in [100.0, -50.0, 1_000.0] {
        // 200/2000 + 2000/50000 s without an acceleration of the
        // master; at half of the slave's own about twice it.
        let cycles = in_sync_after(|t| 200.0 + acceleration * t).expect("in sync");
        assert!((100..=500).contains(&cycles), "{acceleration}: {cycles}");
    }
    // Faster than the slave may be: it stays behind, within its limits, and arrives afterwards.
    // 900 u/s at 0.2 s. The slave has 2000 u/s², so it is there after 0.45 s and the time of its jerk.
    let racing = |t: f64| 100.0 + 4_000.0 * t.min(0.2);
    let cycles = in_sync_after(racing).expect("in sync");
    assert!((400..=600).contains(&cycles), "{cycles}");
}

/// A master whose increments continue in its direction is not running back, wherever its position seems to be.
#[test]
fn increments_that_go_on_are_no_rollback() {
    let (start, command) = (moment((0.0, 10.0), (0.0, 0.0)), SyncMask::ROLLBACK_LOCK);
    for (travel, runs_back) in [
        (None, true),
        (Some(TravelDirection::Forward), false),
        (Some(TravelDirection::Backward), true),
    ] {
        let command = to_position(
            1.0,
            (10.0, 5.0),
            SyncMode::position_based(command),
            SyncLimits::default(),
        );
        let (mut coupling, _) = couple(SawCommand::GearInPos(command), &start);
        coupling.set_master_travel(travel);
        for position in [0.02, -0.08] {
            let master = Kinematics {
                position,
                velocity: 10.0,
                acceleration: 0.0,
            };
            let _ = coupling.update(&master, CYCLE);
        }
        let was_stopped = *coupling.state() == CommandState::Aborted;
        assert_eq!(was_stopped, runs_back, "{travel:?}");
        // A reversal that the increments show comes later, and is one.
        coupling.set_master_travel(Some(TravelDirection::Backward));
        let master = Kinematics {
            position: -0.1,
            velocity: -10.0,
            acceleration: 0.0,
        };
        let _ = coupling.update(&master, CYCLE);
        assert_eq!(*coupling.state(), CommandState::Aborted);
    }
}

/// A master whose increments turn while its position stays was past the coupling position before: the stop takes all of the
/// cycle, forwards and backwards.
#[test]
fn a_reversal_at_rest_stops_from_the_start_of_the_cycle() {
    let stopped = |direction: f64| -> Vec<f64> {
        let start = moment((0.0, direction * 10.0), (0.0, 0.0));
        let command = to_position(
            1.0,
            (direction * 10.0, direction * 5.0),
            SyncMode::position_based(SyncMask::ROLLBACK_LOCK),
            SyncLimits::default(),
        );
        let (mut coupling, _) = couple(SawCommand::GearInPos(command), &start);
        let ahead = match direction > 0.0 {
            true => [TravelDirection::Forward, TravelDirection::Backward],
            false => [TravelDirection::Backward, TravelDirection::Forward],
        };
        let cycles = [(0.02, ahead[0]), (-0.08, ahead[0]), (-0.08, ahead[1])];
        let run = cycles.map(|(position, travel)| {
            coupling.set_master_travel(Some(travel));
            let master = Kinematics {
                position: direction * position,
                velocity: direction * 10.0,
                acceleration: 0.0,
            };
            direction * coupling.update(&master, CYCLE).position
        });
        assert_eq!(*coupling.state(), CommandState::Aborted);
        run.to_vec()
    };
    let forwards = stopped(1.0);
    assert!(
        forwards.iter().all(|position| position.is_finite()),
        "{forwards:?}"
    );
    assert_eq!(forwards, stopped(-1.0));
}

proptest! {
    #[test]
    fn whatever_the_master_does_the_slave_stays_sane(
        velocities in prop::collection::vec(-600.0..600.0_f64, 1..12),
        mask in any::<u32>().prop_map(SyncMask::from_bits_truncate),
        (slave, gear) in (-300.0..300.0_f64, -2.0..2.0_f64),
        time_based in any::<bool>(),
    ) {
        let mut start = moment((0.0, velocities[0]), (0.0, slave));
        start.axis.min_position = Some(-2_000.0);
        start.axis.max_position = Some(2_000.0);
        let operation = mask - SyncMask::CHECKS;
        let command = if time_based {
            let mode = SyncMode::time_based(operation);
            SawCommand::GearInVelo(to_velocity(gear, mode, dynamics(2_500.0, 5e4)))
        } else {
            let ahead = 400.0_f64.copysign(velocities[0]);
            let mode = SyncMode::position_based(operation);
            let sync = (ahead, gear * ahead);
            SawCommand::GearInPos(to_position(gear, sync, mode, dynamics(2_500.0, 5e4)))
        };
        if let Ok(mut coupling) = SawCoupling::start(command, &start, SawTolerances::default()) {
            let mut master = Master(start.master);
            let mut last = start.slave;
            for velocity in velocities {
                for _ in 0..300 {
                    let slave = coupling.update(master.run(velocity), CYCLE);
                    let numbers = [slave.position, slave.velocity, slave.acceleration];
                    prop_assert!(numbers.iter().all(|number| number.is_finite()));
                    // The axis's highest velocity, with the default margin of 1 %.
                    let fastest = 1e4 * 1.01 * CYCLE.0;
                    prop_assert!((slave.position - last.position).abs() <= fastest * 1.001);
                    last = slave;
                }
            }
        }
    }
}
