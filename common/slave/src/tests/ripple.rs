//! A flying saw whose master ripples by more than the margin of its limits: "in sync" has to be true.

use super::saws::to_position;
use super::*;
use crate::CouplingPhase;
use coaxle_axis::{AxisState, AxisStatus, CommandState};
use coaxle_saw::{GearInPos, SyncLimits, SyncMask, SyncStrategy};

const SAW: SlaveParameters = SlaveParameters {
    min_position: Some(-50.0),
    max_position: Some(1_200.0),
    ..SlaveParameters::new(3_000.0, 5_000.0, 100_000.0)
};

/// 500 mm/s, with a share of ripple at 5 Hz.
struct Rippling {
    share: f64,
    time: f64,
}

impl Rippling {
    fn next(&mut self) -> Kinematics {
        self.time += CYCLE.0;
        let (w, v) = (2.0 * core::f64::consts::PI * 5.0, 500.0);
        let (sin, cos) = (libm::sin(w * self.time), libm::cos(w * self.time));
        Kinematics {
            position: v * (self.time + self.share / w * (1.0 - cos)),
            velocity: v * (1.0 + self.share * sin),
            acceleration: v * self.share * w * cos,
        }
    }
}

fn gear_in_pos(strategy: SyncStrategy, sync: (f64, f64), mask: SyncMask) -> GearInPos {
    GearInPos {
        strategy: Some(strategy),
        ..to_position(sync, mask)
    }
}

/// Pieces one after the other; for each, the distance of the slave from its line when it is first
/// reported in sync.
fn cuts(strategy: SyncStrategy, share: f64) -> std::vec::Vec<f64> {
    let mut master = Rippling { share, time: 0.0 };
    let mut axis = powered(&SAW);
    let mut differences = Differences::of(&axis);
    let mut cycle = |axis: &mut AxisWithPlates| {
        let here = master.next();
        axis.update(Some(&here), CYCLE);
        differences.keep(axis, &SAW);
        assert_ne!(
            axis.status(),
            AxisStatus::ErrorStop,
            "{share}: {:?}",
            axis.error()
        );
        here.position
    };
    let mut cuts = std::vec::Vec::new();
    for piece in 0..8 {
        let sync = 2_000.0 + 1_537.0 * f64::from(piece);
        while cycle(&mut axis) < sync - 1_200.0 {}
        let command = gear_in_pos(strategy, (sync, 300.0), SyncMask::empty());
        let job = start(&mut axis, &Command::from(command));
        let mut cut = None;
        while axis.set().position < 700.0 {
            let here = cycle(&mut axis);
            let off = (axis.set().position - (300.0 + here - sync)).abs();
            let phase = axis.coupling_phase().expect("it is coupled");
            let image = axis.axis_struct(1).axis_state;
            let is_in_sync = axis.progress(job) == CommandState::InSync;
            assert_eq!(is_in_sync, phase.is_in_sync(), "{phase:?}");
            assert_eq!(
                is_in_sync,
                image == AxisState::SlaveSynchronous,
                "{phase:?}"
            );
            let tried = axis.check_cut().map_err(|refusal| refusal.code());
            let is_led = !is_in_sync && phase != CouplingPhase::Waiting;
            assert_eq!(
                tried,
                if is_led { Err(0x4b09) } else { Ok(()) },
                "{phase:?}"
            );
            if phase.is_in_sync() {
                assert!(
                    off <= axis.in_sync_window() + 1e-9,
                    "{share}: {off} off, {phase:?}"
                );
                let _ = cut.get_or_insert(axis.set().position);
            }
        }
        cuts.push(
            cut.unwrap_or_else(|| panic!("{strategy:?} {share}: piece {piece} is not in sync")),
        );
        start(&mut axis, &Command::GearOut {});
        start(&mut axis, &move_absolute(0.0));
        while axis.status() != AxisStatus::Standstill {
            cycle(&mut axis);
        }
    }
    cuts
}

/// `late-ripple`: nine pieces were cut in sync, up to 30.6 mm off their marks, and with 1 % of
/// ripple half of them ended in an error stop.
#[test]
fn in_sync_is_where_the_gear_has_it_whatever_the_master_does() {
    for strategy in SyncStrategy::ALL {
        for share in [0.0, 0.001, 0.005, 0.01, 0.02] {
            let cuts = cuts(strategy, share);
            // At the planned position of a master without ripple, and a few centimetres later with it.
            let latest = cuts.iter().fold(0.0_f64, |most, cut| most.max(*cut));
            assert!(latest < 400.0, "{strategy:?} {share}: {cuts:?}");
        }
    }
}

/// `early-limit`: replanned without its checks, the slave ran back into its software limit, and
/// past a limit of its command.
#[test]
fn planned_again_early_keeps_its_checks_of_position() {
    for (software, asked, lowest) in [(-50.0, None, -50.0), (-600.0, Some(-5.0), -5.0)] {
        let parameters = SlaveParameters {
            min_position: Some(software),
            ..SAW
        };
        let mut axis = powered(&parameters);
        let mut master = Master::at(0.0, 400.0);
        master.lead(&mut axis, 1);
        let mut differences = Differences::of(&axis);
        // The line is 540 u behind the slave.
        let sync = (840.0, 300.0);
        let mask = SyncMask::OPTIONAL_MIN_POS;
        let command = GearInPos {
            limits: SyncLimits {
                min_position: asked,
                ..SyncLimits::default()
            },
            ..gear_in_pos(
                SyncStrategy::Early,
                sync,
                asked.map_or(SyncMask::empty(), |_| mask),
            )
        };
        let job = start(&mut axis, &Command::from(command));
        let mut led = |axis: &mut AxisWithPlates, pull: f64, cycles: u32| {
            for _ in 0..cycles {
                master.accelerate(axis, pull, 50_000.0);
                differences.keep(axis, &parameters);
                assert_ne!(axis.status(), AxisStatus::ErrorStop, "{:?}", axis.error());
                let at = axis.set().position;
                assert!(at >= lowest - 1e-9, "{at} {:?}", axis.coupling_phase());
            }
        };
        // The master slows down, reverses, and returns.
        led(&mut axis, -500.0, 1_000);
        led(&mut axis, 500.0, 1_000);
        assert_eq!(axis.progress(job), CommandState::Active);
        led(&mut axis, 0.0, 3_000);
        assert_eq!(axis.progress(job), CommandState::InSync);
        let off = axis.set().position - (sync.1 + master.0.position - sync.0);
        assert!(off.abs() < 1e-8, "{off}");
    }
}
