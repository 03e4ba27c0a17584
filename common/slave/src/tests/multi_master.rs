//! The axis as a slave of several masters.

use super::*;
use crate::{CouplingPhase, Refusal, SlaveError};
use coaxle_axis::{AxisStatus, CommandState, Masters};
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};

fn gear(ratios: &[f64]) -> Command {
    Command::GearInMultiMaster(GearInMultiMaster {
        ratios: Ratios::new(ratios).expect("ratios"),
        dynamics: OWN,
        sync_mode: MultiMasterSync::PosSync1,
    })
}

fn to_position(ratios: &[f64]) -> Command {
    Command::GearInMultiMaster(GearInMultiMaster {
        ratios: Ratios::new(ratios).expect("ratios"),
        dynamics: OWN,
        sync_mode: MultiMasterSync::PosSync2,
    })
}

/// Two masters, led for a number of cycles; the set positions keep the limits in their differences.
struct Rig {
    axis: AxisWithPlates,
    masters: [Master; 2],
    differences: Differences,
}

impl Rig {
    fn new(velocities: [f64; 2]) -> Self {
        let axis = powered(&PARAMETERS);
        let masters = velocities.map(|velocity| Master::at(100.0, velocity));
        let mut rig = Self {
            differences: Differences::of(&axis),
            axis,
            masters,
        };
        rig.lead(1);
        rig
    }

    fn lead(&mut self, cycles: u32) {
        for _ in 0..cycles {
            for master in &mut self.masters {
                master.0.position += master.0.velocity * CYCLE.0;
            }
            let masters = Masters::of(self.masters.map(|master| Some(master.0)));
            let set_anew = self.axis.preset_count();
            self.axis.update(masters, CYCLE);
            if self.axis.preset_count() != set_anew {
                self.differences.begin_anew();
            }
            self.differences.keep(&self.axis, &PARAMETERS);
        }
    }
}

#[test]
fn the_slave_is_led_to_the_sum_of_its_masters_and_follows_it() {
    let mut rig = Rig::new([200.0, 300.0]);
    let job = start(&mut rig.axis, &gear(&[0.5, -1.0]));
    assert_eq!(rig.axis.status(), AxisStatus::SynchronizedMotion);
    rig.lead(10);
    assert_eq!(rig.axis.progress(job), CommandState::Active);
    assert_eq!(
        rig.axis.coupling_phase(),
        Some(CouplingPhase::Synchronizing)
    );
    rig.lead(400);
    assert_eq!(rig.axis.progress(job), CommandState::InSync);
    assert_eq!(rig.axis.set().velocity, -200.0);
    let sum = |rig: &Rig| 0.5 * rig.masters[0].0.position - rig.masters[1].0.position;
    let apart = rig.axis.set().position - sum(&rig);
    rig.lead(1_000);
    assert!((rig.axis.set().position - sum(&rig) - apart).abs() < 1e-9);

    let out = start(&mut rig.axis, &Command::GearOut {});
    assert_eq!(rig.axis.progress(out), CommandState::Done);
    assert_eq!(rig.axis.progress(job), CommandState::Aborted);
    rig.lead(100);
    assert_eq!(rig.axis.set().velocity, -200.0);
}

#[test]
fn ratios_that_change_in_every_cycle_keep_the_limits_of_the_slave() {
    let mut rig = Rig::new([200.0, 100.0]);
    let job = start(&mut rig.axis, &gear(&[1.0, 1.0]));
    for cycle in 0..3_000_u32 {
        // Slowly, then in jumps, then constant.
        let ratio = match cycle {
            0..1_000 => 1.0 + 1e-3 * f64::from(cycle),
            1_000..2_000 => [2.0, -1.5][(cycle as usize / 100) % 2],
            _ => 1.25,
        };
        assert_eq!(
            start(&mut rig.axis, &gear(&[ratio, 1.0])),
            job,
            "it goes on"
        );
        rig.lead(1);
    }
    assert_eq!(rig.axis.progress(job), CommandState::InSync);
    assert_eq!(rig.axis.set().velocity, 350.0);
    assert_eq!(rig.axis.error(), None);
}

#[test]
fn a_slow_change_of_the_ratio_is_followed_without_a_lag() {
    let mut rig = Rig::new([200.0, 0.0]);
    start(&mut rig.axis, &gear(&[1.0]));
    rig.lead(500);
    for cycle in 0..1_000 {
        let ratio = 1.0 + 1e-3 * f64::from(cycle);
        start(&mut rig.axis, &gear(&[ratio]));
        rig.lead(1);
        if cycle > 100 {
            assert!((rig.axis.set().velocity - 200.0 * ratio).abs() < 1e-6);
        }
    }
}

#[test]
fn the_ramp_is_interrupted_by_a_halt() {
    let mut rig = Rig::new([400.0, 0.0]);
    let job = start(&mut rig.axis, &gear(&[2.0]));
    rig.lead(60);
    start(&mut rig.axis, &HALT);
    assert_eq!(rig.axis.progress(job), CommandState::Aborted);
    rig.lead(1_000);
    assert_eq!(rig.axis.status(), AxisStatus::Standstill);
}

#[test]
fn a_master_counts_if_its_ratio_does() {
    let mut axis = powered(&PARAMETERS);
    let one = Masters::of([Some(Master::at(0.0, 100.0).0), None]);
    axis.update(one, CYCLE);
    let refused = axis.plan(&gear(&[1.0, 0.5])).unwrap_err();
    assert_eq!(refused, Refusal::NoMaster);
    start(&mut axis, &gear(&[1.0, 0.0]));
    assert_eq!(
        [0, 1].map(|number| axis.follows_master(number)),
        [true, false]
    );
    axis.update(one, CYCLE);
    assert_eq!(axis.error(), None);
    axis.update(None, CYCLE);
    assert_eq!(axis.error(), Some(SlaveError::MasterLost));
    let fast = Masters::of([Some(Master::at(0.0, 600.0).0); 2]);
    let mut axis = powered(&PARAMETERS);
    axis.update(fast, CYCLE);
    assert_eq!(
        [0, 1].map(|number| axis.follows_master(number)),
        [true, false]
    );
    assert_eq!(axis.plan(&gear(&[1.0, 1.0])).unwrap_err().code(), 0x42dd);
    assert!(Ratios::new(&[]).is_err() && Ratios::new(&[1.0; 5]).is_err());
    assert!(Ratios::new(&[f64::NAN]).is_err());
}

#[test]
fn a_gear_is_reached_on_its_ramp() {
    let mut axis = powered(&PARAMETERS);
    let mut master = Master::at(50.0, 300.0);
    master.lead(&mut axis, 1);
    let slow = Dynamics {
        acceleration: Some(500.0),
        ..OWN
    };
    let gear = GearIn {
        dynamics: slow,
        ..GearIn::of(2.0)
    };
    let limits = SlaveParameters {
        acceleration: 500.0,
        deceleration: None,
        ..PARAMETERS
    };
    let job = start(&mut axis, &Command::GearIn(gear));
    let mut differences = Differences::of(&axis);
    for _ in 0..1_500 {
        master.lead(&mut axis, 1);
        differences.keep(&axis, &limits);
    }
    assert_eq!(axis.progress(job), CommandState::InSync);
    assert_eq!(axis.set().velocity, 600.0);
    // From there on it is a rigid gear.
    let apart = axis.set().position - 2.0 * master.0.position;
    master.lead(&mut axis, 100);
    assert!((axis.set().position - 2.0 * master.0.position - apart).abs() < 1e-9);
}

#[test]
fn the_way_that_changes_of_the_ratios_leave_behind_is_caught_up_if_asked_for() {
    let mut rig = Rig::new([200.0, 100.0]);
    let mut ideal = rig.axis.set().position;
    let mut lead = |rig: &mut Rig, ratios: [f64; 2], cycles: u32| {
        let before = rig.masters.map(|master| master.0.position);
        rig.lead(cycles);
        for (master, (ratio, before)) in rig.masters.iter().zip(ratios.iter().zip(before)) {
            ideal += ratio * (master.0.position - before);
        }
        (rig.axis.set().position - ideal).abs()
    };
    let job = start(&mut rig.axis, &to_position(&[1.0, 0.0]));
    assert!(lead(&mut rig, [1.0, 0.0], 50) > 1.0);
    assert_eq!(rig.axis.progress(job), CommandState::Active);
    for ratios in [[1.0, 0.0], [1.0, 1.0], [-0.5, 2.0], [0.0, 0.7]] {
        assert_eq!(start(&mut rig.axis, &to_position(&ratios)), job);
        let distance = lead(&mut rig, ratios, 3_000);
        assert_eq!(rig.axis.progress(job), CommandState::InSync);
        assert!(distance < 1e-9, "{ratios:?}: {distance} u");
    }
    // The other mode ignores the distance.
    assert_eq!(start(&mut rig.axis, &gear(&[1.0, 0.0])), job);
    lead(&mut rig, [1.0, 0.0], 3_000);
    assert_eq!(rig.axis.progress(job), CommandState::InSync);
    assert_eq!(rig.axis.set().velocity, 200.0);
}

#[test]
fn a_slave_that_catches_up_is_interrupted_without_a_step() {
    for cycles in [1, 7, 40, 200] {
        for successor in [HALT, STOP, Command::Power(false), gear(&[0.0, -1.0])] {
            let mut rig = Rig::new([200.0, 300.0]);
            start(&mut rig.axis, &to_position(&[1.0, 1.0]));
            rig.lead(cycles);
            start(&mut rig.axis, &successor);
            rig.lead(1_000);
            assert!(rig.axis.error().is_none());
        }
    }
}
