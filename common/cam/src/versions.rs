//! A plate whose points change while slaves are on it.
//!
//! A motion function is kept twice: in force and as changed. A change is compiled into the second when it
//! is written; when it is due, a slave only has to switch to the other one. Each slave does so at its own
//! moment; once all have, the two have changed roles.

use alloc::vec::Vec;
use core::ops::Range;

use super::checks::{check_activation, check_mode};
use super::command::{Activation, AxisScaling, ScalingData};
use super::error::{CouplingError, TableId};
use super::modes::{ActivationMode, JumpHandling, ScalingMode};
use super::rules::Operation;
use coaxle_plate::{Course, MotionPoint, Plate};

/// The inputs of `MC_SetCamOnlineChangeMode`, TF5050 chapter 6.5: activation of points that are written
/// from now on.
///
/// A change that would make a slave jump stays queued until it would not, unless `jump` permits it.
#[doc(alias = "MC_SetCamOnlineChangeMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct OnlineChangeMode {
    /// Activation of the change.
    pub activation: Activation,
    /// `AutoOffset` keeps the relative position of the master if the period changes; otherwise the
    /// placement of the plate is kept.
    #[doc(alias = "MasterScalingMode")]
    pub master_scaling_mode: ScalingMode,
    /// `AutoOffset` keeps the position of the slave; otherwise the placement of the plate is kept.
    #[doc(alias = "SlaveScalingMode")]
    pub slave_scaling_mode: ScalingMode,
    /// Handling of a jump of a slave.
    pub jump: JumpHandling,
}

impl OnlineChangeMode {
    /// Keeps offsets and scalings, except automatic ones.
    pub(super) fn scaling(&self, master_scaling: f64, slave_scaling: f64) -> ScalingData {
        let axis = |mode, scaling| AxisScaling {
            mode: match mode {
                ScalingMode::AutoOffset => ScalingMode::AutoOffset,
                ScalingMode::UserDefined | ScalingMode::Off => ScalingMode::Off,
            },
            scaling,
            ..AxisScaling::default()
        };
        ScalingData {
            master: axis(self.master_scaling_mode, master_scaling),
            slave: axis(self.slave_scaling_mode, slave_scaling),
        }
    }
}

/// A slave's use of a plate: which of the two versions it is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lease {
    epoch: u32,
    phase: LeasePhase,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LeasePhase {
    /// Slave on the version in force.
    Old,
    /// Slave on the changed version.
    New,
    /// Slave back on the version in force, after a change for one cycle.
    Returned,
}

/// Next action of a slave for a queued change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LeaseAction {
    Take,
    GiveBack,
}

#[derive(Debug)]
pub(super) struct Versions {
    /// Two versions of a motion function, one of a position table.
    plates: Vec<Plate>,
    in_force: usize,
    mode: OnlineChangeMode,
    /// Points in which the plates may differ, ascending by index.
    points: Vec<MotionPoint>,
    /// The indices of all points that were ever written, ascending.
    touched: Vec<u32>,
    /// Set while `points` wait for slaves to take them.
    queued: Option<OnlineChangeMode>,
    /// Range in which the two courses differ, in masters of the base cycle.
    changed: Range<f64>,
    /// Counter of changes, so that a lease knows whether its phase belongs to the present one.
    epoch: u32,
    /// Number of leases, of all slaves.
    leases: u32,
    /// Number of leases that have taken the queued change.
    taken: u32,
    /// Number of leases that have given it back.
    returned: u32,
}

impl Versions {
    pub(super) fn new(plate: Plate) -> Self {
        let rows = plate
            .function()
            .map_or(0, |function| function.points().len());
        // Position tables have no points to write, so one copy is enough.
        let mut plates = Vec::with_capacity(2);
        if rows > 0 {
            plates.push(plate.clone());
        }
        plates.push(plate);
        Self {
            plates,
            in_force: 0,
            mode: OnlineChangeMode::default(),
            points: Vec::with_capacity(rows),
            touched: Vec::with_capacity(rows),
            queued: None,
            changed: 0.0..0.0,
            epoch: 0,
            leases: 0,
            taken: 0,
            returned: 0,
        }
    }

    /// Returns the plate in force.
    pub(super) fn plate(&self) -> &Plate {
        &self.plates[self.in_force]
    }

    /// Returns the plate that a slave is on.
    #[inline]
    pub(super) fn plate_of(&self, lease: &Lease) -> &Plate {
        match self.phase(lease) {
            LeasePhase::New => self.changed_plate(),
            LeasePhase::Old | LeasePhase::Returned => self.plate(),
        }
    }

    /// Returns the plate with the change.
    pub(super) fn changed_plate(&self) -> &Plate {
        // The other of two. With a single plate it is that one.
        &self.plates[self.plates.len() - 1 - self.in_force]
    }

    pub(super) const fn mode(&self) -> &OnlineChangeMode {
        &self.mode
    }

    /// Returns the mode of the change that waits for slaves, if there is one.
    #[inline]
    pub(super) const fn queued(&self) -> Option<&OnlineChangeMode> {
        self.queued.as_ref()
    }

    /// Returns the range in which the queued change alters the course, in masters of the base cycle.
    pub(super) const fn changed(&self) -> &Range<f64> {
        &self.changed
    }

    /// Checks whether points can take effect with this mode.
    pub(super) fn check_mode(
        &self,
        id: TableId,
        mode: &OnlineChangeMode,
    ) -> Result<(), CouplingError> {
        let activation = &mode.activation;
        check_mode(Operation::OnlineChange, activation.mode)?;
        mode.jump.check()?;
        check_activation(
            activation,
            id,
            self.plate(),
            self.plate().course() == Course::Cyclic,
        )?;
        match activation.mode {
            ActivationMode::DeleteQueuedData => self.check_not_under_way(id),
            _ => Ok(()),
        }
    }

    /// `MC_SetCamOnlineChangeMode`, checked.
    pub(super) fn set_mode(&mut self, mode: OnlineChangeMode) {
        if mode.activation.mode == ActivationMode::DeleteQueuedData {
            self.queued = None;
        } else {
            self.mode = mode;
        }
    }

    /// Checks whether the points could be queued.
    pub(super) fn check_write(
        &self,
        id: TableId,
        points: &[MotionPoint],
    ) -> Result<(), CouplingError> {
        self.check_not_under_way(id)?;
        // Queued changes add up; otherwise the change begins with the plate in force. Until then the
        // other one still has the points from before the last change, in mode `Off` too.
        let before = if self.queued.is_some() {
            self.changed_plate()
        } else {
            self.plate()
        };
        Ok(before.check_change(points)?)
    }

    /// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: queues the points, on top of what is
    /// queued already.
    pub(super) fn write(
        &mut self,
        id: TableId,
        points: &[MotionPoint],
    ) -> Result<(), CouplingError> {
        self.check_write(id, points)?;
        if self.mode.activation.mode == ActivationMode::Off {
            return Ok(());
        }
        let changed = self.plates.len() - 1 - self.in_force;
        if self.queued.is_none() {
            self.make_equal()?;
        }
        self.plates[changed].change(points)?;
        for point in points {
            match self.points.binary_search_by_key(&point.index, |p| p.index) {
                Ok(at) => self.points[at] = *point,
                // Each index once, so the capacity of all rows is never exceeded.
                Err(at) => self.points.insert(at, *point),
            }
            if let Err(at) = self.touched.binary_search(&point.index) {
                self.touched.insert(at, point.index);
            }
        }
        // For all queued points together, not only for those written now.
        self.changed = self.plates[self.in_force].segments_changed(&self.points)?;
        self.queued = Some(self.mode);
        self.settle();
        Ok(())
    }

    /// Queues all points of another plate in place of these, which `new` holds afterwards. It has been
    /// checked that both are motion functions with equal numbers of points. Their differences are not
    /// searched for: the whole plate counts as changed.
    pub(super) fn replace(&mut self, new: &mut Self) {
        let changed = self.plates.len() - 1 - self.in_force;
        core::mem::swap(&mut self.plates[changed], &mut new.plates[0]);
        self.queue_all();
    }

    /// Queues all points of another plate, which stays unchanged.
    pub(super) fn replace_by_copy(&mut self, new: &Plate) {
        let changed = self.plates.len() - 1 - self.in_force;
        self.plates[changed].copy_from(new);
        self.queue_all();
    }

    /// Restores the plate without slaves to its source: this plate. Nothing is allocated.
    pub(super) fn restore(&mut self, new: &Plate) {
        // Without written points both plates are still those of the source.
        if !self.touched.is_empty() {
            for plate in &mut self.plates {
                plate.copy_from(new);
            }
        }
        self.mode = OnlineChangeMode::default();
        self.points.clear();
        self.touched.clear();
        self.queued = None;
        self.leases = 0;
        self.end_change();
    }

    /// Queues all points of the plate that is not in force.
    fn queue_all(&mut self) {
        let changed = self.plates.len() - 1 - self.in_force;
        self.points.clear();
        self.touched.clear();
        if let Some(function) = self.plates[changed].function() {
            self.points.extend_from_slice(function.points());
            self.touched
                .extend(function.points().iter().map(|point| point.index));
        }
        let range = |plate: &Plate| plate.master_range();
        let (old, next) = (
            range(&self.plates[self.in_force]),
            range(&self.plates[changed]),
        );
        self.changed = old.0.min(next.0)..old.1.max(next.1);
        self.queued = Some(self.mode);
        self.settle();
    }

    /// Returns the indices of all points that were written since the plate was made.
    pub(super) fn touched(&self) -> &[u32] {
        &self.touched
    }

    /// Counts a slave that comes onto the plate.
    pub(super) fn acquire(&mut self) -> Lease {
        self.leases += 1;
        Lease {
            epoch: self.epoch,
            phase: LeasePhase::Old,
        }
    }

    /// Counts a slave that leaves the plate.
    pub(super) fn leave(&mut self, lease: &Lease) {
        self.leases = self.leases.saturating_sub(1);
        match self.phase(lease) {
            LeasePhase::Old => {}
            LeasePhase::New => self.taken = self.taken.saturating_sub(1),
            LeasePhase::Returned => self.returned = self.returned.saturating_sub(1),
        }
        self.settle();
    }

    /// Returns the next action of a slave for the queued change, if there is one.
    pub(super) fn next_of(&self, lease: &Lease) -> Option<(LeaseAction, &OnlineChangeMode)> {
        let mode = self.queued.as_ref()?;
        match self.phase(lease) {
            LeasePhase::Old => Some((LeaseAction::Take, mode)),
            LeasePhase::New if is_once(mode) => Some((LeaseAction::GiveBack, mode)),
            LeasePhase::New | LeasePhase::Returned => None,
        }
    }

    /// Applies the change for a slave, or gives it back after its cycle.
    pub(super) fn advance(&mut self, lease: &mut Lease, next: LeaseAction) {
        let phase = match next {
            LeaseAction::Take => {
                self.taken += 1;
                LeasePhase::New
            }
            LeaseAction::GiveBack => {
                self.taken = self.taken.saturating_sub(1);
                self.returned += 1;
                LeasePhase::Returned
            }
        };
        *lease = Lease {
            epoch: self.epoch,
            phase,
        };
        self.settle();
    }

    /// Checks that no change is in progress: one that is in force for some slaves can neither be extended
    /// nor cancelled.
    pub(super) const fn check_not_under_way(&self, id: TableId) -> Result<(), CouplingError> {
        if self.queued.is_some() && self.is_under_way() {
            Err(CouplingError::Pending { table: id })
        } else {
            Ok(())
        }
    }

    /// Ends the change once every slave has completed it. A plate without slaves changes at once, unless
    /// the change is for one cycle: that waits for a slave to run through it.
    fn settle(&mut self) {
        let Some(mode) = &self.queued else {
            return;
        };
        if is_once(mode) {
            // At least one must have run through it: without slaves both counts are 0.
            if self.returned > 0 && self.returned == self.leases {
                self.end_change();
            }
        } else if self.taken == self.leases {
            // The roles change, so no points are copied when the last slave arrives.
            self.in_force = self.plates.len() - 1 - self.in_force;
            self.end_change();
        }
    }

    fn end_change(&mut self) {
        self.queued = None;
        // Leases of the old epoch count as on the plate in force, without a walk over all slaves.
        self.epoch = self.epoch.wrapping_add(1);
        self.taken = 0;
        self.returned = 0;
    }

    /// Makes the plate that is not in force equal to the one that is.
    fn make_equal(&mut self) -> Result<(), CouplingError> {
        let other = self.plates.len() - 1 - self.in_force;
        if let Some(function) = self.plates[self.in_force].function() {
            for point in &mut self.points {
                // Only the points of the last change can differ: a plate of 4096 points is not copied for one.
                *point = *function.point(point.index)?;
            }
        }
        if !self.points.is_empty() {
            self.plates[other].change(&self.points)?;
            self.points.clear();
        }
        Ok(())
    }

    const fn is_under_way(&self) -> bool {
        self.taken > 0 || self.returned > 0
    }

    #[inline]
    fn phase(&self, lease: &Lease) -> LeasePhase {
        if lease.epoch == self.epoch {
            lease.phase
        } else {
            LeasePhase::Old
        }
    }
}

fn is_once(mode: &OnlineChangeMode) -> bool {
    mode.activation.mode == ActivationMode::NextCycleOnce
}
