//! The transition from the old course to the new one: the slave's ramp, and its refusal.

use super::change_moment::ChangeMoment;
use super::coupling::CamCoupling;
use super::course_ahead::CourseAhead;
use super::error::CouplingError;
use super::modes::JumpHandling;
use super::placement::{Path, PlacedPlate};
use super::ramp::GapRamp;
use super::tables::Tables;
use coaxle_curve::profile::Kinematics;

/// Change of the slave's course, and its place.
#[derive(Clone, Copy)]
pub(super) struct CourseChange<'a> {
    pub(super) moment: &'a ChangeMoment,
    /// The place that changes, and the plate in it from then on.
    pub(super) index: usize,
    pub(super) next: Option<PlacedPlate<'a>>,
    /// The old course less the new one.
    pub(super) gap: Path,
    pub(super) jump: &'a JumpHandling,
}

impl CamCoupling {
    /// Returns the ramp over the gap between the old course and the new one, if there is one, or the
    /// refusal.
    pub(super) fn bridge(
        &self,
        tables: &Tables,
        to: &CourseChange<'_>,
    ) -> Result<Option<GapRamp>, CouplingError> {
        let CourseChange {
            moment,
            index,
            next,
            gap,
            jump,
        } = *to;
        let finite = [gap.position, gap.slope, gap.curvature]
            .iter()
            .all(|value| value.is_finite());
        // Before any comparison: NaN would pass each limit.
        if !finite {
            return Err(CouplingError::NotFinite);
        }
        let ramp = match *jump {
            // No look at the course either: a slave that cannot follow goes to error stop.
            JumpHandling::Allow => return Ok(self.ramp),
            JumpHandling::Refuse => {
                self.check_jump(tables, to)?;
                self.ramp
            }
            JumpHandling::RampIn { master_length } => {
                let moving = self.slave.velocity;
                // A ramp is a function of the master: beside one at standstill it would stop the slave at once.
                if !self.is_coupled() && self.master.velocity == 0.0 && moving != 0.0 {
                    return Err(CouplingError::SlaveMoving { velocity: moving });
                }
                // A ramp under way is replaced: its remainder is part of the gap that the new one fades out.
                let gap = gap + self.ramp_at(moment);
                Some(GapRamp::new(moment.master, master_length, gap))
            }
        };
        let master = Kinematics {
            // The moment is mostly between two cycles, the velocity that of the cycle before.
            position: moment.master,
            ..self.master
        };
        let course = CourseAhead {
            coupling: self,
            tables,
            index,
            next,
            ramp,
        };
        course.check(&master, &self.parameters.limits)?;
        Ok(ramp)
    }

    /// Checks whether the slave can change its course within a cycle.
    fn check_jump(&self, tables: &Tables, to: &CourseChange<'_>) -> Result<(), CouplingError> {
        let limits = &self.parameters.limits;
        let allowed = limits.farthest();
        // Sums of plates and strokes far out are rounded relative to the position, not to the jump.
        let rounding = 1e-12 * self.position_at(tables, to.moment)?.abs();
        // The gap is the old course less the new one, the jump the new one less the old.
        let distance = -to.gap.position;
        if distance.abs() > allowed + rounding {
            return Err(CouplingError::Jump { distance, allowed });
        }
        let allowed = limits.fastest_change();
        let moves = self.is_coupled() || self.master.velocity != 0.0;
        // The course of an uncoupled slave holds no velocity beside a master that stands.
        let change = if moves {
            -to.gap.slope * self.master.velocity
        } else {
            -self.slave.velocity
        };
        // Both slopes are computed in different ways, and their difference cancels all but rounding.
        let rounding = 1e-9 * limits.velocity;
        if change.abs() > allowed + rounding {
            return Err(CouplingError::VelocityJump { change, allowed });
        }
        Ok(())
    }

    /// Returns the slave values of the plate in a place, or the values that it needs so that the slave
    /// does not jump.
    pub(super) fn reference(
        &self,
        tables: &Tables,
        index: usize,
        moment: &ChangeMoment,
    ) -> Result<Path, CouplingError> {
        match &self.layers[index] {
            Some(layer) => layer.path_at(tables, moment.master),
            // An empty place adds nothing to the sum, so a plate to come must begin with nothing.
            None if self.is_coupled() => Ok(Path::default()),
            None => Ok(self.uncoupled_path()),
        }
    }

    /// Returns the course of an uncoupled slave, as far as the master's motion determines it.
    fn uncoupled_path(&self) -> Path {
        let (slave, master) = (&self.slave, &self.master);
        let mut path = Path {
            position: slave.position,
            ..Path::default()
        };
        if master.velocity != 0.0 {
            // Inverse of the chain rule: v = s·V, and a = c·V² + s·A.
            path.slope = slave.velocity / master.velocity;
            path.curvature = (slave.acceleration - path.slope * master.acceleration)
                / (master.velocity * master.velocity);
        }
        path
    }

    pub(super) fn position_at(
        &self,
        tables: &Tables,
        moment: &ChangeMoment,
    ) -> Result<f64, CouplingError> {
        if self.is_coupled() {
            Ok(self.path_at(tables, moment)?.position)
        } else {
            Ok(self.slave.position)
        }
    }

    /// Returns the course of a coupled slave: the sum of all plates and the ramp.
    pub(super) fn path_at(
        &self,
        tables: &Tables,
        moment: &ChangeMoment,
    ) -> Result<Path, CouplingError> {
        let mut path = self.ramp_at(moment);
        for layer in self.layers.iter().flatten() {
            path += layer.path_at(tables, moment.master)?;
        }
        Ok(path)
    }

    fn ramp_at(&self, moment: &ChangeMoment) -> Path {
        self.ramp
            .and_then(|ramp| ramp.at(moment.master))
            .unwrap_or_default()
    }

    pub(super) fn is_last_plate(&self) -> bool {
        self.layers.iter().flatten().count() == 1
    }

    /// Sets the slave to position and velocity where the last plate ends, so that a plate that ends at
    /// rest leaves it at rest.
    pub(super) fn hand_over_slave(
        &mut self,
        tables: &Tables,
        moment: &ChangeMoment,
    ) -> Result<(), CouplingError> {
        // At the moment and not at the cycle before: there a plate that ends at rest still moves.
        self.slave = self.path_at(tables, moment)?.slave_of(&self.master);
        Ok(())
    }
}
