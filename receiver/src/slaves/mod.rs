//! The slaves of a receiver: each follows the far axis, or another slave.

mod build;
mod follower;
mod late;
mod slave;
mod tool;

use coaxle_clock::Seconds;
use coaxle_motion::axis::{CoupleState, NcToPlcAxis};
use coaxle_motion::profile::Kinematics;
use coaxle_motion::slave::{Accepted, Command, Refusal, SlaveError};
use coaxle_node::{CommandOrder, CommandOutcome};

use crate::config::MOST_SLAVES;
use crate::snapshot::{Health, SlaveSnapshot};
pub use build::WrongSlave;
use late::Origin;
use slave::{Slave, Source};

/// All slaves.
#[derive(Debug)]
pub(crate) struct Slaves {
    /// In the order of the config.
    slaves: Vec<Slave>,
    /// Their numbers, masters before their slaves.
    order: Vec<usize>,
    /// Their numbers, by axis id.
    by_id: Vec<usize>,
    /// What is published of them.
    axes: Vec<NcToPlcAxis>,
}

/// A master, of this cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Master {
    pub(crate) set: Kinematics,
    /// It is there, without an error.
    pub(crate) is_sound: bool,
    /// So it is, and its clock is known.
    pub(crate) is_ready: bool,
    /// Its error, 0 without one.
    pub(crate) error_code: u32,
}

/// A slave of a receiver, by its place in the config.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SlaveNumber(pub(crate) usize);

impl Slaves {
    /// One cycle of all of them.
    pub(crate) fn update(&mut self, far: Option<&Master>, elapsed: Seconds) {
        for place in 0..self.order.len() {
            let n = self.order[place];
            let master = match self.slaves[n].source() {
                Source::Far => far.copied(),
                Source::Slave(master) => self.slaves[master].as_master(),
            };
            self.slaves[n].cycle(master.as_ref(), elapsed);
            self.slaves[n].watch_tool();
        }
    }

    /// A command that does not come from a program.
    pub(crate) fn command(
        &mut self,
        SlaveNumber(n): SlaveNumber,
        command: &Command,
    ) -> Result<Accepted, Refusal> {
        self.slaves[n].command(command, Origin::Outside)
    }

    /// An order of somebody in the network.
    pub(crate) fn execute(
        &mut self,
        SlaveNumber(n): SlaveNumber,
        order: &CommandOrder,
    ) -> CommandOutcome {
        self.slaves[n].execute(order)
    }

    /// The axis structures of all slaves that have something to say, by id.
    pub(crate) fn axes(&mut self) -> &[NcToPlcAxis] {
        self.axes.clear();
        for n in &self.by_id {
            if let Some(mut axis) = self.slaves[*n].axis_struct() {
                let leads = |slave: &Slave| slave.source() == Source::Slave(*n);
                if self.slaves.iter().any(leads) {
                    axis.couple_state = match axis.couple_state {
                        CoupleState::Slave => CoupleState::MasterSlave,
                        _ => CoupleState::Master,
                    };
                }
                self.axes.push(axis);
            }
        }
        &self.axes
    }

    pub(crate) fn snapshots(&self) -> [Option<SlaveSnapshot>; MOST_SLAVES] {
        std::array::from_fn(|n| self.slaves.get(n).map(Slave::snapshot))
    }

    /// What keeps a slave from its work.
    pub(crate) fn fault(&self) -> Option<Health> {
        let failed = |(n, slave): (usize, &Slave)| match slave.error()? {
            SlaveError::FollowingError { .. } => Some(Health::DriveTripped),
            _ => Some(Health::SlaveFailed { slave: n }),
        };
        let refused = |(n, slave): (usize, &Slave)| {
            slave
                .is_refused()
                .then_some(Health::CommandRefused { slave: n })
        };
        let all = || self.slaves.iter().enumerate();
        all().find_map(failed).or_else(|| all().find_map(refused))
    }
}
