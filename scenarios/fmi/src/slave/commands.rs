//! Commands of a slave by its inputs: rising edges.

use coaxle_axis::AxisStatus;
use coaxle_gear::FlyingGearParameters;
use coaxle_saw::GearInPos;
use coaxle_slave::{Command, SlaveAxis, SyncPosition};

use super::file::SlaveCoupling;
use super::layout::{CAM, SYNC, SlaveLayout};
use crate::variable::UnitValue;

/// Inputs with rising edges.
const EDGES: [&str; 4] = [
    "command.reset",
    "command.release",
    "command.move_to_start",
    "command.execute",
];

/// The commands of a slave, as its inputs ask for them.
#[derive(Clone, Debug)]
pub(super) struct Commands {
    /// The coupling, with the positions of the file.
    coupling: Command,
    start_position: f64,
    /// Velocity to be reached once it has power.
    start_velocity: Option<f64>,
    /// Inputs with edges in the step before.
    before: [bool; 4],
    /// True if the coupling waits for power.
    is_pending: bool,
}

impl Commands {
    pub(super) fn new(coupling: &SlaveCoupling, position: f64, velocity: f64) -> Self {
        Self {
            coupling: match coupling {
                SlaveCoupling::Saw(saw) => Command::from(*saw),
                SlaveCoupling::Gear(gear) => Command::from(*gear),
                SlaveCoupling::Cam(cam, _) => Command::CamIn(*cam),
            },
            start_position: position,
            start_velocity: (velocity != 0.0).then_some(velocity),
            before: [false; 4],
            is_pending: false,
        }
    }

    /// True for the command that couples the slave.
    pub(super) fn is_coupling(&self, command: &Command) -> bool {
        core::mem::discriminant(command) == core::mem::discriminant(&self.coupling)
    }

    /// Commands that are due in a step, in the order in which they are executed.
    pub(super) fn due(
        &mut self,
        layout: &SlaveLayout,
        values: &[UnitValue],
        axis: &SlaveAxis,
    ) -> Vec<Command> {
        let mut due = Vec::new();
        let power = layout.flag(values, "command.power");
        if power != axis.is_power_on() {
            due.push(Command::Power(power));
        }
        let [reset, release, home, execute] = self.edges(layout, values);
        if reset {
            due.push(Command::Reset {});
        }
        if release {
            due.push(match self.coupling {
                Command::CamIn(_) => Command::CamOut {},
                _ => Command::GearOut {},
            });
        }
        if home {
            due.push(self.move_to_start());
        }
        let has_power = axis.status() != AxisStatus::Disabled;
        if has_power && let Some(velocity) = self.start_velocity.take() {
            due.push(Command::MoveVelocity {
                velocity,
                dynamics: Default::default(),
            });
        }
        self.is_pending = layout.flag(values, "command.execute") && (self.is_pending || execute);
        if self.is_pending && has_power {
            self.is_pending = false;
            due.push(self.coupling_at(layout, values));
        }
        due
    }

    fn edges(&mut self, layout: &SlaveLayout, values: &[UnitValue]) -> [bool; 4] {
        let now = EDGES.map(|name| layout.flag(values, name));
        let before = core::mem::replace(&mut self.before, now);
        core::array::from_fn(|n| now[n] && !before[n])
    }

    fn move_to_start(&self) -> Command {
        Command::MoveAbsolute {
            position: self.start_position,
            velocity: None,
            dynamics: Default::default(),
        }
    }

    /// The coupling with the positions of the inputs.
    fn coupling_at(&self, layout: &SlaveLayout, values: &[UnitValue]) -> Command {
        let number = |name, own| layout.number(values, name).unwrap_or(own);
        let at = |name| SyncPosition::At(number(name, 0.0));
        match self.coupling {
            Command::GearInPos(saw) => Command::GearInPos(GearInPos {
                master_sync_position: at(SYNC[0]),
                slave_sync_position: at(SYNC[1]),
                ..saw
            }),
            Command::FlyingGear(gear) => Command::FlyingGear(FlyingGearParameters {
                master_sync_position: at(SYNC[0]),
                slave_sync_position: at(SYNC[1]),
                ..gear
            }),
            Command::CamIn(mut cam) => {
                cam.master_offset = number(CAM[0], cam.master_offset);
                cam.slave_offset = number(CAM[1], cam.slave_offset);
                cam.master_scaling = number(CAM[2], cam.master_scaling);
                cam.slave_scaling = number(CAM[3], cam.slave_scaling);
                Command::CamIn(cam)
            }
            other => other,
        }
    }
}
