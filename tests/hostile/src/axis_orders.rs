//! Orders to a slave axis, in any sequence and with any motion of its masters: its set positions keep its limits in
//! every cycle.

use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_axis::{AxisStatus, Masters, Modulo};
use coaxle_cam::Tables;
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_plate::{Course, Interpolation, MotionFunction, MotionPoint, Plate, PositionTable};
use coaxle_saw::SyncMask;
use coaxle_sim::{ReportedCheck, SetValueCheck};
use coaxle_slave::{CircleState, Command, OnMasterLoss, SlaveAxis, SlaveParameters};

use crate::Outcome;
use crate::axis_commands::{Around, COMMANDS, command};
use crate::bytes::Bytes;

/// Cycle time of the axis.
const CYCLE: Span = Span::from_millis(1);
/// Most cycles that an input is run for: with more, orders are tried less often.
const MOST_CYCLES: u32 = 3_000;

/// Orders and events of masters, one after the other, each with a number of cycles after it.
pub(crate) fn axis_orders(data: &[u8]) -> Outcome {
    let mut bytes = Bytes::new(data);
    let too_short = || "ends within the parameters of the axis".to_owned();
    let parameters = parameters(&mut bytes).ok_or_else(too_short)?;
    let mut bench = Bench::new(parameters).map_err(|error| error.to_string())?;
    bench.command(&Command::Power(true));
    bench.cycle();
    while bench.cycles < MOST_CYCLES && bench.step(&mut bytes).is_some() {}
    Ok(())
}

fn parameters(bytes: &mut Bytes<'_>) -> Option<SlaveParameters> {
    let velocity = bytes.decades(0.0, 4.0)?;
    let acceleration = bytes.decades(1.0, 5.5)?;
    let kinds = bytes.byte()?;
    let given = |bit: u8| kinds & bit != 0;
    let reactions = [
        OnMasterLoss::Stop,
        OnMasterLoss::QuickStop,
        OnMasterLoss::Follow,
    ];
    let mut parameters = SlaveParameters {
        on_master_loss: reactions[usize::from(kinds >> 6) % 3],
        ..SlaveParameters::new(velocity, acceleration, bytes.decades(2.0, 8.0)?)
    };
    if given(1) {
        parameters.deceleration = Some(bytes.decades(1.0, 5.5)?);
    }
    if given(2) {
        parameters.min_position = Some(-100.0);
        parameters.max_position = Some(1_000.0);
    }
    if given(4) {
        parameters.distance.policy = coaxle_axis::set_value_guard::DistancePolicy::VeloSync;
    }
    if given(8) {
        parameters.distance.window = Some(0.0);
    }
    if given(16) {
        parameters.master_increment = Some(0.01);
    }
    Some(parameters)
}

/// An axis with its plates, its masters, and the checks of its set values.
struct Bench {
    parameters: SlaveParameters,
    axis: SlaveAxis,
    plates: Tables,
    masters: [Conveyor; 2],
    /// Cycles for which the master is lost, and for which its velocity is no number.
    lost: u8,
    garbage: u8,
    /// Cycles that each update passes.
    at_once: u32,
    cycles: u32,
    /// A saw may stop it within a cycle.
    stops_instantly: bool,
    /// Presets of the position before the newest cycle.
    presets: u32,
    check: SetValueCheck,
    reported: ReportedCheck,
}

impl Bench {
    fn new(parameters: SlaveParameters) -> Result<Self, Box<dyn std::error::Error>> {
        let drive = Box::new(SimulatedDrive::new(DriveParameters::default())?);
        let mut axis = SlaveAxis::new(&parameters, drive, CycleTime::new(CYCLE)?)?;
        axis.prepare_cams(1, 2)?;
        let turn = Modulo::new(360.0).ok();
        axis.set_modulo(turn, turn);
        let limits = Limits::new(
            parameters.velocity,
            parameters.acceleration,
            parameters.deceleration.unwrap_or(parameters.acceleration),
            parameters.jerk,
        )?;
        let walls = [
            parameters.min_position.unwrap_or(f64::NEG_INFINITY),
            parameters.max_position.unwrap_or(f64::INFINITY),
        ];
        let cycle_time = CYCLE.as_secs_f64();
        Ok(Self {
            parameters,
            axis,
            plates: plates()?,
            masters: [Conveyor::default(); 2],
            lost: 0,
            garbage: 0,
            at_once: 1,
            cycles: 0,
            stops_instantly: false,
            presets: 0,
            check: SetValueCheck::new(&limits, walls, cycle_time),
            reported: ReportedCheck::new(&limits, cycle_time),
        })
    }

    /// Reads an order or an event, and runs the cycles after it; none at the end of the input.
    fn step(&mut self, bytes: &mut Bytes<'_>) -> Option<()> {
        let number = bytes.byte()?;
        let which = usize::from(number & 1);
        match number {
            ..=199 => {
                let around = Around {
                    limits: self.parameters,
                    slave: self.axis.set(),
                    master: self.masters[0].set,
                };
                let command = command(number % COMMANDS, bytes, &around)?;
                self.command(&command);
            }
            200..=219 => {
                self.masters[which].target = 1.5 * self.parameters.velocity * bytes.share()?;
                self.masters[which].push =
                    self.parameters.acceleration * bytes.decades(-2.0, 1.0)?;
            }
            220..=227 => self.masters[which].set.position += 50.0 * bytes.share()?,
            228..=233 => self.lost = bytes.byte()?,
            234..=237 => self.garbage = bytes.byte()? % 4,
            238..=245 => self.at_once = 1 + u32::from(bytes.byte()? % 3),
            246..=249 => self.axis.hold_stop(bytes.bit()?),
            _ => self.axis.set_circle(bytes.one_of(&[
                CircleState::None,
                CircleState::Open,
                CircleState::Closed,
            ])?),
        }
        // Few cycles mostly: orders in quick succession meet all phases of a motion.
        let count = match bytes.byte()? {
            few @ ..=127 => u32::from(few % 16),
            many => 2 * u32::from(many - 127),
        };
        for _ in 0..count {
            self.cycle();
        }
        Some(())
    }

    fn command(&mut self, command: &Command) {
        let before = self.axis.status();
        let accepted = self.axis.command(&mut self.plates, command).is_ok();
        if let (true, Some(mask)) = (accepted, mask_of(command)) {
            self.stops_instantly = mask.contains(SyncMask::INSTANT_STOP_ON_ROLLBACK);
        }
        // An error stop lasts until it is reset.
        let stays = before != AxisStatus::ErrorStop
            || matches!(command, Command::Reset {} | Command::Power(_))
            || self.axis.status() == AxisStatus::ErrorStop;
        assert!(stays, "{command:?} ended the error stop");
    }

    fn cycle(&mut self) {
        let elapsed = CYCLE.as_secs_f64() * f64::from(self.at_once);
        for master in &mut self.masters {
            master.step(elapsed);
        }
        let [mut first, second] = self.masters.map(|master| master.set);
        if self.garbage > 0 {
            first.velocity = f64::NAN;
        }
        let heard = self.lost == 0;
        (self.lost, self.garbage) = (self.lost.saturating_sub(1), self.garbage.saturating_sub(1));
        let masters = Masters::of([heard.then_some(first), Some(second)]);
        let before = self.axis.status();
        let set = self
            .axis
            .update(&mut self.plates, masters, Seconds(elapsed));
        self.cycles += 1;
        let now = self.axis.status();
        let failed = now == AxisStatus::ErrorStop;
        assert_eq!(failed, self.axis.error().is_some(), "{now:?}");
        assert!(failed || before != AxisStatus::ErrorStop, "left error stop");
        self.judge(&set, before);
    }

    /// Checks the set values of a cycle.
    fn judge(&mut self, set: &Kinematics, before: AxisStatus) {
        let numbers = [set.position, set.velocity, set.acceleration];
        assert!(numbers.into_iter().all(f64::is_finite), "{set:?}");
        let now = self.axis.status();
        let stops_now = self.stops_instantly
            && before == AxisStatus::SynchronizedMotion
            && matches!(now, AxisStatus::Standstill | AxisStatus::DiscreteMotion)
            && set.velocity == 0.0;
        // A preset position, or a stop within a cycle, is a step that differences would take for a motion.
        let presets = std::mem::replace(&mut self.presets, self.axis.preset_count());
        let is_preset = presets != self.presets || now == AxisStatus::Disabled;
        if is_preset || stops_now || now == AxisStatus::Homing {
            self.check.restart();
            self.reported.restart();
        }
        let is_quick = self.parameters.on_master_loss == OnMasterLoss::QuickStop
            && (self.axis.error()).is_some_and(|error| error.is_loss_of_master());
        if is_quick {
            self.check.free_jerk();
            self.reported.free_jerk();
        }
        let at = self.cycles;
        self.check.push(set.position, self.at_once, |excess| {
            panic!("cycle {at}, {now:?}: {excess:?}");
        });
        let mut wrong = self.reported.push(set, self.at_once).into_iter().flatten();
        assert_eq!(wrong.next(), None, "cycle {at}, {now:?}");
    }
}

/// A master that heads for a velocity.
#[derive(Clone, Copy)]
struct Conveyor {
    set: Kinematics,
    target: f64,
    push: f64,
}

impl Default for Conveyor {
    fn default() -> Self {
        Self {
            set: Kinematics::at_rest(0.0),
            target: 0.0,
            push: 1_000.0,
        }
    }
}

impl Conveyor {
    fn step(&mut self, dt: f64) {
        let most = self.push * dt;
        let change = (self.target - self.set.velocity).clamp(-most, most);
        self.set.acceleration = change / dt;
        self.set.position += (self.set.velocity + change / 2.0) * dt;
        self.set.velocity += change;
    }
}

/// A cyclic motion function, one passed once, and a table.
fn plates() -> Result<Tables, Box<dyn std::error::Error>> {
    let point = |row: u32| MotionPoint::rest(row, 60.0 * f64::from(row), 20.0 * f64::from(row % 3));
    let points: Vec<_> = (1..=6).map(point).collect();
    let function = MotionFunction::new(points)?;
    let rows = [(0.0, 0.0), (90.0, 10.0), (180.0, 40.0), (360.0, 0.0)];
    let table = PositionTable::new(&rows, Interpolation::Spline, Course::Cyclic)?;
    let mut tables = Tables::new(3);
    tables.insert(1, Plate::from_function(function.clone(), Course::Cyclic))?;
    tables.insert(2, Plate::from_function(function, Course::Linear))?;
    tables.insert(3, Plate::from_table(table))?;
    Ok(tables)
}

const fn mask_of(command: &Command) -> Option<SyncMask> {
    match command {
        Command::GearInPos(command) => Some(command.sync_mode.mask),
        Command::GearInVelo(command) => Some(command.sync_mode.mask),
        _ => None,
    }
}

/// Sequences with a move, a gear, a saw and a cam plate.
pub(crate) fn good_orders() -> Vec<(String, Vec<u8>)> {
    // Limits of 100 u/s, 1 800 u/s² and 100 000 u/s³; none of the options.
    let axis = [128, 128, 0, 128];
    let master = [200, 255, 31, 200, 255, 220, 255, 63, 200, 255];
    let named = |name: &str, orders: &[u8]| {
        let all = [axis.as_slice(), &master, orders].concat();
        (name.to_owned(), all)
    };
    vec![
        named("move", &[2, 255, 15, 0, 1, 255, 3, 0, 8, 0, 0, 1, 60]),
        named(
            "gear",
            &[8, 0, 255, 31, 1, 255, 10, 255, 7, 0, 0, 1, 255, 13, 200],
        ),
        named(
            "saw",
            &[
                15, 0, 255, 31, 255, 31, 2, 255, 31, 2, 0, 0, 0, 1, 255, 13, 200,
            ],
        ),
        named(
            "cam",
            &[
                20, 0, 0, 0, 2, 0, 2, 128, 1, 1, 1, 255, 19, 0, 0, 2, 1, 0, 8, 0, 8, 255,
            ],
        ),
    ]
}
