//! Placement of a plate in the axes of master and slave.

use core::ops::{Add, AddAssign, Sub};

use super::change_moment::{ChangeMoment, Direction};
use super::command::{AxisScaling, ScalingData};
use super::modes::ScalingMode;
use coaxle_curve::law::Motion;
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{Course, PeakDemands, Plate};

/// A slave's course over the master axis: position and its first two derivatives, in u, u per u of the
/// master, and so on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Path {
    pub(super) position: f64,
    pub(super) slope: f64,
    pub(super) curvature: f64,
}

impl Path {
    /// Returns the slave's set values for those of the master.
    pub(super) fn slave_of(&self, master: &Kinematics) -> Kinematics {
        let velocity = master.velocity;
        Kinematics {
            position: self.position,
            velocity: self.slope * velocity,
            // Chain rule over time: a = c·V² + s·A.
            acceleration: self.curvature * velocity * velocity + self.slope * master.acceleration,
        }
    }
}

impl Add for Path {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            position: self.position + other.position,
            slope: self.slope + other.slope,
            curvature: self.curvature + other.curvature,
        }
    }
}

impl AddAssign for Path {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Path {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            position: self.position - other.position,
            slope: self.slope - other.slope,
            curvature: self.curvature - other.curvature,
        }
    }
}

/// Placement of a plate. TF5050 chapter 4.4:
/// master on the plate = (master + master offset) / master scaling,
/// slave = slave on the plate · slave scaling + slave offset.
///
/// A cyclic plate with lift continues from `base_turn`: that turn counts as the base cycle. The strokes
/// completed before are kept in slave units, so that a scaling does not change them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    pub(super) master_offset: f64,
    pub(super) master_scaling: f64,
    pub(super) slave_offset: f64,
    pub(super) slave_scaling: f64,
    base_turn: f64,
    strokes: f64,
    /// Sum of all additions to the scaled slave of the plate.
    shift: f64,
    /// Factors of the slopes and curvatures of the plate.
    slope_ratio: f64,
    curvature_ratio: f64,
}

/// A plate and its placement.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedPlate<'a> {
    pub(super) placement: &'a Placement,
    pub(super) plate: &'a Plate,
}

/// Inputs of a new placement.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacementContext<'a> {
    /// Moment of the placement.
    pub(super) moment: ChangeMoment,
    /// The plate that it replaces; the plate itself if it is only scaled.
    pub(super) before: Option<PlacedPlate<'a>>,
    /// Strokes completed so far, u; 0 for a plate that starts in its base cycle.
    pub(super) strokes: f64,
    /// Slave value of the plate for which the slave does not jump, u.
    pub(super) reference: f64,
}

impl Placement {
    /// Finds the placement for `scaling`, first of the master, then of the slave.
    pub(super) fn settle(scaling: &ScalingData, plate: &Plate, at: &PlacementContext<'_>) -> Self {
        let (master_offset, master_scaling) = master_place(&scaling.master, plate, at);
        let AxisScaling {
            relative, offset, ..
        } = scaling.slave;
        // The slave's value without a jump, not its position: of several plates each has only its part.
        let origin = if relative { at.reference } else { 0.0 };
        let before = at.before.map(|before| before.placement);
        let (slave_offset, slave_scaling) = match (scaling.slave.mode, before) {
            (ScalingMode::Off, Some(before)) => (before.slave_offset, before.slave_scaling),
            (ScalingMode::Off, None) => (0.0, 1.0),
            // With an automatic offset only the scaling of these counts: the offset is replaced below.
            _ => (origin + offset, scaling.slave.scaling),
        };
        let mut placed = Self {
            master_offset,
            master_scaling,
            slave_offset,
            slave_scaling,
            base_turn: 0.0,
            strokes: at.strokes,
            shift: 0.0,
            slope_ratio: slave_scaling / master_scaling,
            // Second derivative of scaling·f((x + o)/m). Divided twice, since m² could underflow to 0.
            curvature_ratio: slave_scaling / master_scaling / master_scaling,
        };
        // Needs the master's placement only, so it comes before any sum of the slave.
        placed.base_turn = placed.turns(plate, at.moment.master).0;
        // After the master: its offset decides where on the plate the slave is (TF5050 8.4).
        if scaling.slave.mode == ScalingMode::AutoOffset {
            placed.slave_offset = 0.0;
            placed.sum_up(plate);
            // Found with an offset of 0, then the sum is formed again with this one.
            placed.slave_offset = at.reference - placed.at(plate, at.moment.master).position;
        }
        placed.sum_up(plate);
        placed
    }

    /// Returns the placement with an offset of the slave that makes it pass through `reference`.
    pub(super) fn through(mut self, plate: &Plate, master: f64, reference: f64) -> Self {
        self.slave_offset += reference - self.at(plate, master).position;
        self.sum_up(plate);
        self
    }

    /// Returns the position of the master on the unscaled plate, x.
    pub(super) fn on_plate(&self, master: f64) -> f64 {
        (master + self.master_offset) / self.master_scaling
    }

    /// Returns the position of the master axis for one on the unscaled plate, u.
    pub(super) fn on_axis(&self, cam_master: f64) -> f64 {
        cam_master * self.master_scaling - self.master_offset
    }

    /// Returns the course of the slave at a position of the master axis.
    pub(super) fn at(&self, plate: &Plate, master: f64) -> Path {
        self.path(&plate.at(self.on_plate(master)))
    }

    /// Returns the course on the plate, in the axes.
    pub(super) fn path(&self, motion: &Motion) -> Path {
        Path {
            // All additions in one sum, formed once at the placement: one multiplication and addition in each cycle.
            position: motion.position * self.slave_scaling + self.shift,
            slope: motion.velocity * self.slope_ratio,
            curvature: motion.acceleration * self.curvature_ratio,
        }
    }

    /// Returns the magnitudes that slope and curvature in the axes do not exceed, for such demands of the
    /// plate.
    pub(super) fn bound(&self, demands: &PeakDemands) -> Path {
        Path {
            position: 0.0,
            slope: demands.slope * self.slope_ratio.abs(),
            curvature: demands.curvature() * self.curvature_ratio.abs(),
        }
    }

    /// Strokes completed from the base cycle to a position of the master axis, u.
    pub(super) fn strokes_at(&self, plate: &Plate, master: f64) -> f64 {
        let (turn, _) = self.turns(plate, master);
        // Earlier strokes as they were done, later ones by the present scaling.
        self.strokes + self.slave_scaling * plate.lift() * (turn - self.base_turn)
    }

    /// Returns the whole cycles completed at a position of the master axis, and the completed part of the
    /// present one.
    ///
    /// At the seam, rounding of the master must not decide which cycle it is: a scaling there would be
    /// off by a whole stroke.
    pub(super) fn turns(&self, plate: &Plate, master: f64) -> (f64, f64) {
        let (start, _) = plate.master_range();
        if plate.course() == Course::Linear {
            // Passed once: all of the master, even outside, belongs to one cycle.
            return (0.0, (self.on_plate(master) - start) / plate.period());
        }
        let turns = self.turns_from(start, plate, master);
        let whole = libm::floor(turns);
        (whole, turns - whole)
    }

    /// Returns the cycles from a position of the plate to the master. A number within rounding of a whole
    /// number becomes that number.
    pub(super) fn turns_from(&self, position: f64, plate: &Plate, master: f64) -> f64 {
        let period = plate.period();
        let turns = (self.on_plate(master) - position) / period;
        // Magnitudes before the sum: a large offset that cancels the master leaves its rounding behind.
        let largest = (master.abs() + self.master_offset.abs()) / self.master_scaling.abs();
        let rounding = 16.0 * f64::EPSILON * ((largest + position.abs()) / period + 1.0);
        let nearest = libm::round(turns);
        if (turns - nearest).abs() <= rounding {
            nearest
        } else {
            turns
        }
    }

    fn sum_up(&mut self, plate: &Plate) {
        self.shift =
            self.slave_offset + self.strokes - self.slave_scaling * plate.lift() * self.base_turn;
    }
}

/// Returns the offset and scaling of the master.
fn master_place(master: &AxisScaling, plate: &Plate, at: &PlacementContext<'_>) -> (f64, f64) {
    match (master.mode, at.before) {
        (ScalingMode::Off, Some(before)) => {
            let Placement {
                master_offset,
                master_scaling,
                ..
            } = *before.placement;
            (master_offset, master_scaling)
        }
        (ScalingMode::Off, None) => (0.0, 1.0),
        // Solved for the offset: on the plate = (master + offset)/scaling.
        (ScalingMode::AutoOffset, Some(before)) => {
            let (start, _) = plate.master_range();
            let fraction = fraction_kept(&before, plate, &at.moment);
            let on_plate = start + fraction * plate.period();
            (on_plate * master.scaling - at.moment.master, master.scaling)
        }
        _ => {
            let origin = if master.relative {
                // Offset that makes the master's position at the activation the plate's 0.
                -at.moment.master
            } else {
                0.0
            };
            (origin + master.offset, master.scaling)
        }
    }
}

/// Returns the position of the master in the cycle, as a part of it, equal in the new and the old plate.
fn fraction_kept(before: &PlacedPlate<'_>, plate: &Plate, moment: &ChangeMoment) -> f64 {
    let linear = |plate: &Plate| plate.course() == Course::Linear;
    // At an edge from one plate to the next: the end of one is the start of the other.
    if let Some(direction) = moment.edge
        && (linear(before.plate) || linear(plate))
    {
        return match direction {
            Direction::Forwards => 0.0,
            Direction::Backwards => 1.0,
        };
    }
    let (_, fraction) = before.placement.turns(before.plate, moment.master);
    // Beyond the edge of a linear plate the part exceeds a cycle, and would begin in another turn.
    if linear(before.plate) && !linear(plate) {
        fraction.clamp(0.0, 1.0)
    } else {
        fraction
    }
}
