//! Stops of any origin, from any state, with limits of all decades: judged by the output of the
//! axis, as from a trace.
//!
//! The guarantee: unless the axis reports a preset, its set positions keep velocity, acceleration
//! and jerk in their differences while it stops, with a quick stop all but the jerk. A preset to
//! the drive's position is counted, and happens at rest only: the positions of the last two cycles
//! are equal, and the stated velocity and acceleration are 0 before and after.

use proptest::prelude::*;

use super::cams::plate;
use super::invariants::{Conveyor, commands, decades, flying_gear, gear_in_pos};
use super::*;
use crate::SlaveError;
use coaxle_axis::AxisStatus;
use coaxle_axis::drive::DriveState;
use coaxle_cam::{CamIn, JumpHandling, Tables};
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_saw::GearInPos;

/// Motion of the axis; positions are relative to the axes.
#[derive(Clone, Debug)]
enum Moved {
    Command(Command),
    Pos(GearInPos, f64, f64),
    Flying(f64, f64, f64),
}

/// Cause of the stop.
#[derive(Clone, Copy, Debug)]
enum Cause {
    MasterLost,
    Garbage,
    /// Power off.
    PowerOff,
    /// `MC_Stop`, and power off this number of cycles later.
    StopAndPowerOff(u32),
    /// Power off, and on again this number of cycles later.
    PowerOffAndOn(u32),
    /// Jump of the master by this distance.
    Jump(f64),
}

/// A stop: the motion of the axis, its cycles, the cause of the stop, and the interval in cycles of
/// the attempts to reset the error or switch power on again.
#[derive(Clone, Debug)]
struct Try {
    moved: Moved,
    cycles: u32,
    cause: Cause,
    asks_every: u32,
    head: f64,
}

fn causes() -> impl Strategy<Value = Cause> {
    prop_oneof![
        3 => Just(Cause::MasterLost),
        1 => Just(Cause::Garbage),
        3 => Just(Cause::PowerOff),
        2 => (0_u32..60).prop_map(Cause::StopAndPowerOff),
        2 => (1_u32..300).prop_map(Cause::PowerOffAndOn),
        1 => decades(-3.0, 5.0).prop_map(Cause::Jump),
    ]
}

fn moved(parameters: &SlaveParameters) -> impl Strategy<Value = Moved> + use<> {
    let multi = (-2.0..2.0_f64, -2.0..2.0_f64, any::<bool>()).prop_map(|(one, other, position)| {
        Command::GearInMultiMaster(GearInMultiMaster {
            ratios: Ratios::new(&[one, other]).expect("ratios"),
            dynamics: OWN,
            sync_mode: if position {
                MultiMasterSync::PosSync2
            } else {
                MultiMasterSync::PosSync1
            },
        })
    });
    let cam = (1.0..100.0).prop_map(|master_length| {
        Command::CamIn(CamIn {
            table: 1,
            jump: JumpHandling::RampIn { master_length },
            ..CamIn::default()
        })
    });
    let pos = gear_in_pos(parameters).prop_map(|event| match event {
        super::invariants::Event::PosHere(command, way, share) => Moved::Pos(command, way, share),
        other => unreachable!("{other:?}"),
    });
    prop_oneof![
        4 => (-3.0..3.0).prop_map(|ratio| Moved::Command(Command::GearIn(GearIn::of(ratio)))),
        4 => commands(parameters).prop_map(Moved::Command),
        2 => multi.prop_map(Moved::Command),
        2 => cam.prop_map(Moved::Command),
        2 => pos,
        2 => (-3.0..3.0, 1.0..100.0, -100.0..100.0)
            .prop_map(|(ratio, way_in, way_out)| Moved::Flying(ratio, way_in, way_out)),
    ]
}

fn tries(parameters: &SlaveParameters) -> impl Strategy<Value = Try> + use<> {
    (
        moved(parameters),
        1_u32..400,
        causes(),
        1_u32..40,
        -300.0..300.0,
    )
        .prop_map(|(moved, cycles, cause, asks_every, head)| Try {
            moved,
            cycles,
            cause,
            asks_every,
            head,
        })
}

/// Limits of all decades that a config admits, for an axis that covers a distance within a test.
fn any_parameters() -> impl Strategy<Value = SlaveParameters> {
    (
        (decades(0.0, 4.0), decades(1.0, 6.0), decades(1.0, 6.0)),
        prop_oneof![4 => decades(1.0, 9.0), 1 => Just(1e15)],
        any::<bool>(),
    )
        .prop_map(
            |((velocity, acceleration, deceleration), jerk, quick)| SlaveParameters {
                deceleration: Some(deceleration),
                on_master_loss: if quick {
                    OnMasterLoss::QuickStop
                } else {
                    OnMasterLoss::Stop
                },
                ..SlaveParameters::new(velocity, acceleration, jerk)
            },
        )
}

/// An axis, its master, and the checks of its trace.
struct Rig {
    axis: AxisWithPlates,
    master: Conveyor,
    parameters: SlaveParameters,
    differences: Differences,
    set_anew: u32,
    before: [Kinematics; 2],
    since_quick: u32,
}

impl Rig {
    fn new(parameters: &SlaveParameters, following_error_window: f64) -> Self {
        let drive = drive(following_error_window);
        let mut axis = AxisWithPlates::new(parameters, drive, cycle_time()).expect("in range");
        let mut tables = Tables::new(1);
        tables.insert(1, plate(8.0)).expect("room");
        axis.select_cams(tables, 1, 2).expect("limits");
        start(&mut axis, &Command::Power(true));
        Self {
            differences: Differences::of(&axis),
            set_anew: axis.preset_count(),
            before: [axis.set(); 2],
            axis,
            master: Conveyor::at_rest(),
            since_quick: 3,
            parameters: *parameters,
        }
    }

    fn cycle(&mut self, lost: bool, garbage: bool) -> Result<(), TestCaseError> {
        self.master.step(CYCLE.0);
        let mut seen = self.master.state();
        if garbage {
            seen.velocity = f64::NAN;
        }
        let seen = Some(seen).filter(|_| !lost);
        let masters = coaxle_axis::Masters::of([seen, seen, None, None]);
        self.axis.update(masters, CYCLE);
        self.judge()
    }

    /// Checks the trace of this cycle.
    fn judge(&mut self) -> Result<(), TestCaseError> {
        self.judge_set_anew()?;
        let (now, status) = (self.axis.set(), self.axis.status());
        let [older, last] = self.before;
        if matches!(status, AxisStatus::Disabled | AxisStatus::Standstill) {
            let stands = now.velocity == 0.0 && now.acceleration == 0.0;
            prop_assert!(stands, "{status}: {last:?} {now:?}");
        }
        let quick = self.parameters.on_master_loss == OnMasterLoss::QuickStop
            && self.axis.error() == Some(SlaveError::MasterLost);
        self.since_quick = if quick { 0 } else { self.since_quick + 1 };
        let limits = self.limits_now();
        if let Err(why) = self.differences.check(&self.axis, &limits) {
            prop_assert!(false, "{status}: {why} {older:?} {last:?} {now:?}");
        }
        self.before = [last, now];
        Ok(())
    }

    /// A quick stop reverses an acceleration within a cycle; the jerk of four positions contains
    /// its end later.
    fn limits_now(&self) -> SlaveParameters {
        let SlaveParameters {
            acceleration,
            deceleration,
            jerk,
            ..
        } = self.parameters;
        let turned = 2.0 * acceleration.max(deceleration.unwrap_or(0.0)) / CYCLE.0;
        SlaveParameters {
            jerk: if self.since_quick < 3 {
                jerk.max(turned)
            } else {
                jerk
            },
            ..self.parameters
        }
    }

    /// Checks a preset, which may be caused by a command, with a motion in the same cycle.
    fn judge_set_anew(&mut self) -> Result<(), TestCaseError> {
        let set_anew = self.axis.preset_count();
        if set_anew == self.set_anew {
            return Ok(());
        }
        self.set_anew = set_anew;
        let (now, [older, last]) = (self.axis.set(), self.before);
        let stood = last == Kinematics::at_rest(older.position);
        prop_assert!(
            stood && now == Kinematics::at_rest(now.position),
            "{}: set anew in motion: {older:?} {last:?} {now:?}",
            self.axis.status()
        );
        self.before = [now; 2];
        self.differences.begin_anew();
        Ok(())
    }

    /// Sends a command that may be refused.
    fn command(&mut self, command: &Command) -> Result<(), TestCaseError> {
        let _ = self.axis.command(command);
        self.judge_set_anew()
    }

    fn engage(&mut self, moved: &Moved) -> Result<(), TestCaseError> {
        let (set, master) = (self.axis.set(), self.master.state());
        match moved {
            Moved::Command(Command::Home { .. }) => Ok(()),
            Moved::Command(command) => self.command(command),
            Moved::Pos(command, way, share) => {
                let way = way.copysign(master.velocity);
                let command = GearInPos {
                    master_sync_position: master.position + way,
                    slave_sync_position: set.position + command.ratio.numerator * way * share,
                    ..*command
                };
                self.command(&Command::from(command))
            }
            Moved::Flying(ratio, way_in, way_out) => {
                let gear = flying_gear(&set, &master, *ratio, *way_in, *way_out);
                self.command(&Command::from(gear))
            }
        }
    }

    fn stop(&mut self, cause: Cause) -> Result<(), TestCaseError> {
        match cause {
            Cause::MasterLost => self.cycle(true, false),
            Cause::Garbage => self.cycle(false, true),
            Cause::PowerOff => self.command(&Command::Power(false)),
            Cause::StopAndPowerOff(cycles) => {
                self.command(&STOP)?;
                for _ in 0..cycles {
                    self.cycle(false, false)?;
                }
                self.command(&Command::Power(false))
            }
            Cause::PowerOffAndOn(cycles) => {
                self.command(&Command::Power(false))?;
                for _ in 0..cycles {
                    self.cycle(false, false)?;
                }
                self.command(&Command::Power(true))
            }
            Cause::Jump(by) => {
                self.master.jump(by);
                self.cycle(false, false)
            }
        }
    }
}

proptest! {
    #[test]
    fn a_stop_keeps_the_limits_and_the_position_is_set_anew_at_rest_only(
        (parameters, tries) in any_parameters().prop_flat_map(|parameters| {
            let tries = proptest::collection::vec(tries(&parameters), 1..6);
            (Just(parameters), tries)
        }),
        window in prop_oneof![3 => Just(0.0), 1 => decades(-3.0, 1.0)],
    ) {
        let mut rig = Rig::new(&parameters, window);
        rig.cycle(false, false)?;
        for one in tries {
            rig.command(&Command::Power(true))?;
            rig.master.head_for(one.head, 1_000.0);
            rig.engage(&one.moved)?;
            for _ in 0..one.cycles {
                rig.cycle(false, false)?;
            }
            rig.stop(one.cause)?;
            let failed = rig.axis.status() == AxisStatus::ErrorStop;
            for cycle in 0..600_u32 {
                if cycle % one.asks_every == 0 {
                    rig.command(&if failed { Command::Reset {} } else { Command::Power(false) })?;
                }
                rig.cycle(false, false)?;
            }
            // No motion is under way in an axis without power.
            if rig.axis.status() == AxisStatus::Disabled && !rig.axis.is_power_on() {
                prop_assert_eq!(rig.axis.actual().state, DriveState::Off);
            }
        }
    }
}
