//! From the old course to the new one: what the slave does where they meet, and whether it may.

use super::error::CouplingError;
use super::machine::CamCoupling;
use super::modes::JumpHandling;
use super::moment::Moment;
use super::placement::Path;
use super::ramp::Ramp;
use super::tables::Tables;

impl CamCoupling {
    /// Lets the slave over the gap between its old course and the new one, or refuses to.
    pub(super) fn bridge(
        &mut self,
        tables: &Tables,
        moment: &Moment,
        gap: Path,
        jump: &JumpHandling,
    ) -> Result<(), CouplingError> {
        let finite = [gap.position, gap.slope, gap.curvature]
            .iter()
            .all(|value| value.is_finite());
        if !finite {
            return Err(CouplingError::NotFinite);
        }
        match *jump {
            JumpHandling::Allow => Ok(()),
            JumpHandling::Refuse => {
                let allowed = self.parameters.jump_limit;
                let rounding = 1e-12 * self.position_at(tables, moment)?.abs();
                let distance = -gap.position;
                if distance.abs() <= allowed + rounding {
                    Ok(())
                } else {
                    Err(CouplingError::Jump { distance, allowed })
                }
            }
            JumpHandling::RampIn { master_length } => {
                let moving = self.slave.velocity;
                if !self.is_coupled() && self.master.velocity == 0.0 && moving != 0.0 {
                    return Err(CouplingError::SlaveMoving { velocity: moving });
                }
                let gap = gap + self.ramp_at(moment);
                self.ramp = Some(Ramp::new(moment.master, master_length, gap));
                Ok(())
            }
        }
    }

    /// What the plate in a place gives, or has to give so that the slave does not jump.
    pub(super) fn reference(
        &self,
        tables: &Tables,
        index: usize,
        moment: &Moment,
    ) -> Result<Path, CouplingError> {
        match &self.layers[index] {
            Some(layer) => layer.path_at(tables, moment.master),
            None if self.is_coupled() => Ok(Path::default()),
            None => Ok(self.uncoupled_path()),
        }
    }

    /// The course of a slave that is not coupled yet, as far as the master's motion can tell.
    fn uncoupled_path(&self) -> Path {
        let (slave, master) = (&self.slave, &self.master);
        let mut path = Path {
            position: slave.position,
            ..Path::default()
        };
        if master.velocity != 0.0 {
            path.slope = slave.velocity / master.velocity;
            path.curvature = (slave.acceleration - path.slope * master.acceleration)
                / (master.velocity * master.velocity);
        }
        path
    }

    pub(super) fn position_at(
        &self,
        tables: &Tables,
        moment: &Moment,
    ) -> Result<f64, CouplingError> {
        if self.is_coupled() {
            Ok(self.path_at(tables, moment)?.position)
        } else {
            Ok(self.slave.position)
        }
    }

    /// The course of a coupled slave: all plates and the ramp.
    pub(super) fn path_at(&self, tables: &Tables, moment: &Moment) -> Result<Path, CouplingError> {
        let mut path = self.ramp_at(moment);
        for layer in self.layers.iter().flatten() {
            path += layer.path_at(tables, moment.master)?;
        }
        Ok(path)
    }

    fn ramp_at(&self, moment: &Moment) -> Path {
        self.ramp
            .and_then(|ramp| ramp.at(moment.master))
            .unwrap_or_default()
    }

    pub(super) fn is_last_plate(&self) -> bool {
        self.layers.iter().flatten().count() == 1
    }

    /// What the last plate leaves to the slave: position and velocity where it ends, so that a plate
    /// that ends at rest leaves it at rest.
    pub(super) fn leave_slave_at(
        &mut self,
        tables: &Tables,
        moment: &Moment,
    ) -> Result<(), CouplingError> {
        self.slave = self.path_at(tables, moment)?.slave_of(&self.master);
        Ok(())
    }
}
