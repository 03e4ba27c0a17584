//! Start modes on a plate with lift: entering it, leaving it, interruptions on it, and entering it
//! again in every other mode, judged by the differences of the drive's set positions.

use super::*;
use crate::CouplingPhase;
use coaxle_axis::AxisStatus;
use coaxle_cam::{Activation, ActivationMode, CamIn, StartMode, Tables};
use coaxle_plate::{Course, MotionFunction, MotionPoint, Plate};
use std::vec::Vec;

const MODES: [StartMode; 4] = [
    StartMode::Absolute,
    StartMode::Relative,
    StartMode::MasterAbsoluteSlaveRelative,
    StartMode::MasterRelativeSlaveAbsolute,
];

/// Kind of the slave's leaving the plate.
#[derive(Clone, Copy, Debug)]
enum End {
    CamOut,
    Halt,
    MasterLost,
}

const ENDS: [End; 3] = [End::CamOut, End::Halt, End::MasterLost];

const PERIOD: f64 = 360.0;
const LIFT: f64 = 100.0;

/// A lift of a hundred per period, at rest at the seams.
fn with_lift() -> Plate {
    let points = Vec::from([
        MotionPoint::rest(1, 0.0, 0.0),
        MotionPoint::rest(2, PERIOD, LIFT),
    ]);
    let function = MotionFunction::new(points).expect("a motion function");
    Plate::from_function(function, Course::Cyclic)
}

struct Rig {
    axis: AxisWithPlates,
    master: Master,
    differences: Differences,
    plate: Plate,
}

impl Rig {
    /// A slave at rest at 37, and a master at 360 u/s.
    fn new() -> Self {
        let mut axis = powered(&PARAMETERS);
        let mut tables = Tables::new(1);
        tables.insert(1, with_lift()).expect("room");
        axis.select_cams(tables, 7, 8).expect("limits");
        start(&mut axis, &Command::Home { position: 37.0 });
        let mut master = Master::at(-300.0, 360.0);
        master.lead(&mut axis, 1);
        let differences = Differences::of(&axis);
        Self {
            axis,
            master,
            differences,
            plate: with_lift(),
        }
    }

    fn lead(&mut self, cycles: u32) {
        for _ in 0..cycles {
            self.master.lead(&mut self.axis, 1);
            self.differences.keep(&self.axis, &PARAMETERS);
        }
    }

    fn lead_to(&mut self, status: AxisStatus) {
        for _ in 0..5_000 {
            if self.axis.status() == status {
                return;
            }
            self.lead(1);
        }
        panic!("{} instead of {status}", self.axis.status());
    }

    /// Couples the slave at the next seam; returns the positions of master and slave there.
    fn enter(&mut self, mode: StartMode) -> (f64, f64) {
        if !mode.slave_relative() {
            // The plate begins in its base cycle again, after any number of periods.
            self.refuse_elsewhere(mode);
            start(&mut self.axis, &move_absolute(0.0));
            self.lead(1);
            self.lead_to(AxisStatus::Standstill);
        }
        let from = self.axis.set().position;
        let seam = PERIOD * (1.0 + (self.master.0.position / PERIOD).floor());
        start(&mut self.axis, &Command::CamIn(at_seam(mode, seam)));
        self.lead(1_100);
        assert_eq!(self.axis.coupling_phase(), Some(CouplingPhase::InSync));
        (seam, from)
    }

    /// Asserts that far from the base cycle a coupling with an absolute slave would be a jump.
    fn refuse_elsewhere(&self, mode: StartMode) {
        let here = self.axis.set().position;
        if here.abs() < 1.0 {
            return;
        }
        let now = CamIn {
            table: 1,
            start_mode: mode,
            ..CamIn::default()
        };
        // On the base cycle there would by chance be no jump.
        let x = self.master.0.position.rem_euclid(PERIOD);
        let base = if mode.master_relative() { 0.0 } else { x };
        if (self.plate.at(base).position - here).abs() > 1.0 {
            let refused = self.axis.plan(&Command::CamIn(now)).unwrap_err();
            assert_eq!(refused.code(), 0x421a, "{mode:?} at {here}: {refused}");
        }
    }

    /// Asserts for one and a half periods that it is at the plate's position, with the lifts added.
    fn follow(&mut self, (seam, from): (f64, f64), mode: StartMode) {
        for _ in 0..1_500 {
            self.lead(1);
            let x = self.master.0.position - seam;
            let expected = from + self.plate.at(x).position;
            let received = self.axis.set().position;
            assert!(
                (received - expected).abs() < 1e-6,
                "{mode:?}: {received}, expected {expected} at {x}"
            );
        }
        let info = self.axis.cam_info(0, None).expect("a coupling");
        assert_eq!(info.master_absolute, !mode.master_relative());
        assert_eq!(info.slave_absolute, !mode.slave_relative());
        let turns = ((self.master.0.position - seam) / PERIOD).floor();
        assert_eq!(info.sum_of_slave_strokes, LIFT * turns, "{mode:?}");
    }

    fn leave(&mut self, end: End) {
        match end {
            End::CamOut => {
                start(&mut self.axis, &Command::CamOut {});
                self.lead(50);
                assert_eq!(self.axis.status(), AxisStatus::ContinuousMotion);
                start(&mut self.axis, &HALT);
                self.lead(1);
            }
            End::Halt => {
                start(&mut self.axis, &HALT);
                self.lead(1);
            }
            End::MasterLost => {
                let before = self.axis.cam_info(1, None).expect("a coupling");
                for _ in 0..500 {
                    self.axis.update(None, CYCLE);
                    self.differences.keep(&self.axis, &PARAMETERS);
                }
                assert_eq!(self.axis.status(), AxisStatus::ErrorStop);
                assert_eq!(self.axis.set().velocity, 0.0);
                // The last values stay readable, until the error is acknowledged.
                assert_eq!(self.axis.cam_info(1, None), Ok(before));
                start(&mut self.axis, &Command::Reset {});
                assert!(self.axis.cam_info(1, None).is_err());
                // The master is back.
                self.lead(1);
            }
        }
        self.lead_to(AxisStatus::Standstill);
    }
}

fn at_seam(mode: StartMode, seam: f64) -> CamIn {
    CamIn {
        table: 1,
        start_mode: mode,
        activation: if mode.master_relative() {
            Activation::at(ActivationMode::AtMasterAxisPos, seam)
        } else {
            Activation::new(ActivationMode::NextCycle)
        },
        ..CamIn::default()
    }
}

#[test]
fn every_start_mode_leads_into_every_other_after_some_lifts_however_it_ended() {
    for first in MODES {
        for end in ENDS {
            for second in MODES {
                let mut rig = Rig::new();
                let at = rig.enter(first);
                rig.follow(at, first);
                rig.leave(end);
                let at = rig.enter(second);
                rig.follow(at, second);
                rig.leave(end);
            }
        }
    }
}
