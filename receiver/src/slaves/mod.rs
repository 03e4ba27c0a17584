//! The slaves of a receiver: each follows far axes, virtual axes, or other slaves.

mod build;
mod cam_orders;
mod followers;
mod for_program;
mod masters;
mod plates;
mod slave;
mod tool;

use coaxle_axis::{Job, NcToPlcAxis, Origin, TravelDirection};
use coaxle_cam::Tables;
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::CommandOutcome;
use coaxle_node::circles::CircleState;
use coaxle_node::command::{CamOrder, OrderCargo, PlateCommand, SlaveOrder};
use coaxle_slave::{Command, Refusal, SlaveError};

use crate::config::MasterRef;
use crate::health::Health;
use crate::promised::PromisedMotion;
use crate::snapshot::ReceiverSnapshot;
pub(crate) use followers::SlavesOfAxis;
use masters::SlaveMasters;
use plates::room;
use slave::Slave;

/// The slaves of a receiver.
#[derive(Debug)]
pub(crate) struct Slaves {
    /// The slaves in the order of the config.
    slaves: Vec<Slave>,
    /// The cam plates of all slaves.
    plates: Tables,
    /// Numbers of the slaves, masters before their slaves.
    order: Vec<usize>,
    /// Numbers of the slaves, by axis id.
    by_id: Vec<usize>,
    /// True for each slave that leads another.
    leads: Vec<bool>,
    /// Far axes that each slave follows, directly or behind other slaves.
    roots: Box<[Box<[usize]>]>,
    /// Published axes: a place for each slave.
    axes: Box<[NcToPlcAxis]>,
}

/// A master, of this cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Master {
    pub(crate) set: Kinematics,
    /// Direction of travel by its increments; none where its positions are exact.
    pub(crate) travel: Option<TravelDirection>,
    /// True if it is there, without an error.
    pub(crate) is_sound: bool,
    /// True if it is sound, and its clock is known.
    pub(crate) is_ready: bool,
    /// Error code, 0 without an error.
    pub(crate) error_code: u32,
}

/// A slave of a receiver, by its place in the config.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SlaveNumber(pub(crate) usize);

impl Slaves {
    /// Runs one cycle of all slaves, with the far axes and the virtual ones as masters; `promised` returns the promised motion
    /// of a far axis.
    pub(crate) fn update<'a>(
        &mut self,
        far: &[Option<Master>],
        virtual_axes: &[Master],
        promised: impl Fn(usize) -> Option<PromisedMotion<'a>>,
        hold_back: Span,
        elapsed: Seconds,
    ) {
        // By places, because a slave is changed while its masters among the slaves are read.
        for place in 0..self.order.len() {
            let n = self.order[place];
            let mut masters = SlaveMasters::none(self.slaves[n].follows());
            for source in self.slaves[n].sources() {
                masters.add(match *source {
                    MasterRef::Far(axis) => far[axis],
                    MasterRef::Virtual(axis) => Some(virtual_axes[axis]),
                    MasterRef::Slave(master) => self.slaves[master].as_master(),
                });
            }
            if let (true, [MasterRef::Far(axis), ..]) =
                (self.slaves[n].has_program(), self.slaves[n].sources())
            {
                masters.promise(promised(*axis));
            }
            let leads_back = |source: &MasterRef| match source {
                MasterRef::Slave(master) => self.slaves[*master].was_set_back(),
                MasterRef::Far(_) | MasterRef::Virtual(_) => false,
            };
            if self.slaves[n].sources().iter().any(leads_back) {
                self.slaves[n].axis.set_back_with_master();
            }
            self.slaves[n].axis.set_hold_back(hold_back);
            self.slaves[n].cycle(&mut self.plates, &masters, elapsed);
        }
    }

    /// True if no slave moves, and no drive.
    pub(crate) fn rest(&self) -> bool {
        self.slaves.iter().all(Slave::rests)
    }

    /// Executes a command that does not come from a program.
    pub(crate) fn command(
        &mut self,
        SlaveNumber(n): SlaveNumber,
        command: &Command,
    ) -> Result<Job, Refusal> {
        self.slaves[n].command(&mut self.plates, command, Origin::Order)
    }

    /// Executes an order from the network.
    pub(crate) fn execute(
        &mut self,
        SlaveNumber(n): SlaveNumber,
        order: &SlaveOrder,
    ) -> CommandOutcome {
        self.slaves[n].execute(&mut self.plates, order)
    }

    /// Executes an order on the cam plates, whose points and rows are limited in sum as in a config.
    pub(crate) fn execute_cam(
        &mut self,
        SlaveNumber(n): SlaveNumber,
        order: &CamOrder,
        cargo: &mut OrderCargo,
    ) -> CommandOutcome {
        let room = match &order.command {
            // Only a plate that comes in takes room.
            PlateCommand::CamTableSelect { .. } => room(&self.plates),
            _ => 0,
        };
        self.slaves[n].execute_cam(&mut self.plates, order, cargo, room)
    }

    /// The axis structures of all slaves that have set values, by id.
    pub(crate) fn axes(&mut self) -> &[NcToPlcAxis] {
        let mut written = 0;
        for &n in &self.by_id {
            let axis = &mut self.axes[written];
            let has_set_values = self.slaves[n].write_axis(&self.plates, self.leads[n], axis);
            // A slave without set values leaves no hole: receivers find an axis by its id, and not by its place.
            written += usize::from(has_set_values);
        }
        &self.axes[..written]
    }

    /// Fills in their signals and faults.
    pub(crate) fn show(&self, shown: &mut ReceiverSnapshot) {
        let places = shown.signals.slaves.iter_mut().zip(&mut shown.faults);
        for (slave, (signals, faults)) in self.slaves.iter().zip(places) {
            slave.show_faults(faults);
            slave.show(&self.plates, faults, signals);
        }
    }

    /// Takes the circle across nodes that the slave with this id is in.
    pub(crate) fn set_circle(&mut self, id: u32, circle: CircleState) {
        let slave = self.slaves.iter_mut().find(|slave| slave.id() == id);
        if let Some(slave) = slave {
            slave.axis.set_circle(circle);
        }
    }

    /// Fault that keeps a slave from its work: an error of any slave first, then a circle, then a
    /// refusal, then a blocked program.
    pub(crate) fn fault(&self) -> Option<Health> {
        let (mut circle, mut refused, mut blocked) = (None, None, None);
        for (n, slave) in self.slaves.iter().enumerate() {
            match slave.error() {
                // An error returns at once. The others are only noted: a later slave may have an error.
                Some(SlaveError::Drive(_)) => return Some(Health::DriveTripped),
                Some(_) => return Some(Health::SlaveFailed { slave: n }),
                None => {}
            }
            if slave.axis.circle() != CircleState::None {
                circle = Some(Health::Circle);
            }
            if slave.is_refused() {
                refused = refused.or(Some(Health::CommandRefused { slave: n }));
            }
            if slave.blocked_program().is_some() {
                blocked = blocked.or(Some(Health::ProgramBlocked { slave: n }));
            }
        }
        circle.or(refused).or(blocked)
    }

    /// Health of a slave that its limits hold away from the position of its coupling.
    pub(crate) fn behind(&self) -> Option<Health> {
        let slave = self.slaves.iter().position(Slave::is_behind)?;
        Some(Health::SlaveBehind { slave })
    }
}
