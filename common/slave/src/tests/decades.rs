//! Limits that mean "none", and cycles that are long compared with the dynamics of the limits.

use super::*;
use coaxle_axis::CouplingPhase;

/// The states of a slave geared, from rest, to a master at this velocity.
fn geared(parameters: &SlaveParameters, cycle: Seconds, velocity: f64) -> std::vec::Vec<Led> {
    let cycle_time =
        CycleTime::new(Span::from_micros((cycle.0 * 1e6) as i64)).expect("a cycle time");
    let mut axis = AxisWithPlates::new(parameters, drive(0.0), cycle_time).expect("in range");
    start(&mut axis, &Command::Power(true));
    let mut master = Kinematics {
        position: 100.0,
        velocity,
        acceleration: 0.0,
    };
    axis.update(Some(&master), cycle);
    start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    let mut led = std::vec::Vec::new();
    for _ in 0..200 {
        master.position += velocity * cycle.0;
        let set = axis.update(Some(&master), cycle);
        led.push(Led {
            set,
            phase: axis.coupling_phase().expect("it is coupled"),
        });
    }
    led
}

struct Led {
    set: Kinematics,
    phase: CouplingPhase,
}

/// SEW's page of `MC_GearIn`: a slave at rest ramps to a moving master, and is in sync at the end
/// of the ramp.
#[test]
fn a_gear_to_a_moving_master_ramps_and_is_in_sync_at_its_end_whatever_the_jerk() {
    for jerk in [1e5, 1e6, 1e7, 1e9, 1e13, 1e15] {
        let parameters = SlaveParameters::new(500.0, 500.0, jerk);
        let led = geared(&parameters, Seconds(0.01), 45.0);
        let in_sync = led
            .iter()
            .position(|led| led.phase == CouplingPhase::InSync);
        // 45/500 s, and a cycle to either side; the jerk of 1e5 takes 5 ms more.
        let cycles = in_sync.expect("it is in sync") + 1;
        assert!((9..=11).contains(&cycles), "jerk {jerk}: {cycles} cycles");
        let fastest = led.iter().map(|led| led.set.velocity).fold(0.0, f64::max);
        assert!(fastest <= 45.0 + 1e-9, "jerk {jerk}: {fastest}");
        for (before, after) in led.iter().zip(&led[1..]) {
            let mean = (after.set.position - before.set.position) / 0.01;
            assert!(mean <= 45.0 + 1e-9, "jerk {jerk}: {mean}");
            assert!(
                before.phase != CouplingPhase::InSync || after.set.velocity == 45.0,
                "jerk {jerk}: in sync at {}",
                after.set.velocity
            );
        }
    }
}

/// `guard-jerk-order`: a move, a gear and a phasing of an axis whose jerk limit means "none".
#[test]
fn an_axis_without_a_jerk_limit_never_goes_the_wrong_way() {
    let parameters = SlaveParameters::new(1_500.0, 5_000.0, 1e13);
    let mut axis = powered(&parameters);
    let mut master = Master::at(0.0, 200.0);
    start(&mut axis, &move_absolute(100.0));
    let mut before = 0.0;
    for _ in 0..1_000 {
        master.lead(&mut axis, 1);
        let now = axis.set().position;
        assert!((before..=100.0).contains(&now), "{now} after {before}");
        before = now;
    }
    assert_eq!(axis.set(), Kinematics::at_rest(100.0));
    start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    let phasing = Command::PhasingAbsolute {
        shift: 5.0,
        velocity: Some(50.0),
        dynamics: Dynamics {
            acceleration: Some(500.0),
            deceleration: None,
            jerk: Some(5_000.0),
        },
    };
    for cycle in 0..2_000 {
        if cycle == 1_000 {
            start(&mut axis, &phasing);
        }
        master.lead(&mut axis, 1);
        let now = axis.set();
        assert!(now.position >= before, "{now:?} after {before}");
        assert!((0.0..=250.0 + 1e-6).contains(&now.velocity), "{now:?}");
        before = now.position;
    }
    assert_eq!(axis.coupling_phase(), Some(CouplingPhase::InSync));
}
