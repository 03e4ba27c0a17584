//! `MC_ReadCamTableCharacteristics`: the demands of a plate on the slave.

use super::error::CamError;
use super::kind::{Course, TableType};
use super::plate::Plate;
use super::steps::VelocityStep;
use coaxle_curve::law::{Extreme, Extremes, MinMax, Motion, Segment};

/// `MC_TableCharacValues`, TF5050 chapter 8.11, for one constant velocity of the master.
///
/// Masters are in x, slaves in u, u/s, u/s² and u/s³. Where a derivative jumps at a point, both of
/// its values count.
#[doc(alias = "MC_TableCharacValues")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Characteristics {
    /// The velocity of the master, x/s.
    #[doc(alias = "fMasterVeloNom")]
    pub master_velocity: f64,
    /// The start of the plate.
    pub start: PlateEnd,
    /// The end of the plate.
    pub end: PlateEnd,
    /// Minima and maxima of position, velocity, acceleration and jerk, with their places.
    pub extremes: Extremes,
    /// The velocity at the minimum acceleration.
    #[doc(alias = "fSVeloAtSAccMin")]
    pub velocity_at_minimum_acceleration: f64,
    /// The velocity at the maximum acceleration.
    #[doc(alias = "fSVeloAtSAccMax")]
    pub velocity_at_maximum_acceleration: f64,
    /// The minimum and maximum product of velocity and acceleration, u²/s³: the braking and the driving
    /// power, up to the mass. The original leaves it out.
    #[doc(alias = "fSlaveDynMomMin")]
    #[doc(alias = "fSlaveDynMomMax")]
    pub dynamic_momentum: MinMax,
    /// The mean of the velocity's magnitude. The original leaves it out.
    #[doc(alias = "fSlaveVeloMean")]
    pub mean_velocity: f64,
    /// The root of the mean square of the acceleration. The original leaves it out.
    #[doc(alias = "fSlaveAccEff")]
    pub effective_acceleration: f64,
    /// Number of places inside the plate, and at the seam of a cyclic one, at which the velocity steps:
    /// [`Plate::velocity_steps`]. The original does not report them.
    pub velocity_steps: usize,
    /// The largest of these steps, over time.
    pub largest_velocity_step: Option<VelocityStep>,
    /// Number of rows or points of the plate.
    #[doc(alias = "NumberOfRows")]
    pub rows: usize,
    /// Number of columns.
    #[doc(alias = "NumberOfColumns")]
    pub columns: usize,
    /// Type of the plate.
    pub table_type: TableType,
    /// Course: linear or cyclic.
    pub course: Course,
}

/// An end of a plate, with the slave's motion there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateEnd {
    /// Position of the master, x.
    pub master: f64,
    /// Position of the slave and its derivatives over time.
    pub slave: Motion,
}

impl Plate {
    /// `MC_ReadCamTableCharacteristics`: the extremes of one cycle, from the laws themselves, for a
    /// master velocity in x/s. The original's nominal velocity is 1.
    ///
    /// # Errors
    /// 0x4A1C unless the velocity is finite and not 0.
    #[doc(alias = "MC_ReadCamTableCharacteristics")]
    pub fn characteristics(&self, master_velocity: f64) -> Result<Characteristics, CamError> {
        // At standstill all demands would be 0, a result that looks like a harmless plate.
        if !master_velocity.is_finite() || master_velocity == 0.0 {
            return Err(CamError::Parameter {
                name: "master velocity",
                received: master_velocity,
                expected: "a finite number other than 0",
            });
        }
        let v = master_velocity;
        let demands = self.demands();
        let (first, last) = self.ends();
        let extremes = demands.extremes;
        Ok(Characteristics {
            master_velocity,
            start: moving_end(first.start(), first, v),
            end: moving_end(last.end(), last, v),
            extremes: Extremes {
                position: extremes.position,
                velocity: scaled(extremes.velocity, v),
                // Chain rule at a constant master velocity: each order of the derivative has one more factor v.
                acceleration: scaled(extremes.acceleration, v * v),
                jerk: scaled(extremes.jerk, v * v * v),
            },
            velocity_at_minimum_acceleration: v * demands.velocity_at_minimum_acceleration,
            velocity_at_maximum_acceleration: v * demands.velocity_at_maximum_acceleration,
            // (v·s')·(v²·s''): the product has the third power, and so its sign is that of v.
            dynamic_momentum: scaled(demands.momentum, v * v * v),
            // Path over time, as the cycle takes period/|v|.
            mean_velocity: v.abs() * demands.path / self.period(),
            // √(∫(v²s'')² dt / t) with dt = dx/v: the velocity leaves the integral as v².
            effective_acceleration: v * v * libm::sqrt(demands.square / self.period()),
            velocity_steps: self.velocity_steps().count(),
            largest_velocity_step: self.largest_velocity_step().map(|step| VelocityStep {
                master: step.master,
                before: step.before * v,
                after: step.after * v,
            }),
            rows: self.rows(),
            columns: self.columns(),
            table_type: self.table_type(),
            course: self.course(),
        })
    }

    /// Returns the minimum and maximum position of the slave in the base cycle, u, with their places.
    #[must_use]
    pub fn slave_range(&self) -> MinMax {
        let (first, _) = self.ends();
        self.curve()
            .segments()
            .iter()
            .map(|segment| segment.extremes().position)
            .fold(first.extremes().position, MinMax::joined)
    }

    fn ends(&self) -> (&Segment, &Segment) {
        let segments = self.curve().segments();
        (&segments[0], &segments[segments.len() - 1])
    }

    fn demands(&self) -> SegmentDemands {
        let (first, _) = self.ends();
        self.curve().segments()[1..]
            .iter()
            .map(SegmentDemands::of)
            // Folded from the first segment: a neutral start value has no place to name.
            .fold(SegmentDemands::of(first), SegmentDemands::joined)
    }
}

fn moving_end(master: f64, segment: &Segment, v: f64) -> PlateEnd {
    let motion = segment.at(master);
    PlateEnd {
        master,
        slave: Motion {
            position: motion.position,
            velocity: motion.velocity * v,
            acceleration: motion.acceleration * v * v,
            jerk: motion.jerk * v * v * v,
        },
    }
}

fn scaled(range: MinMax, factor: f64) -> MinMax {
    let scaled = |extreme: Extreme| Extreme {
        value: extreme.value * factor,
        ..extreme
    };
    // Backwards odd orders change their sign, so the greatest becomes the least.
    let (minimum, maximum) = if factor < 0.0 {
        (range.maximum, range.minimum)
    } else {
        (range.minimum, range.maximum)
    };
    MinMax {
        minimum: scaled(minimum),
        maximum: scaled(maximum),
    }
}

/// Demands of a part of the plate at a master velocity of 1.
struct SegmentDemands {
    extremes: Extremes,
    velocity_at_minimum_acceleration: f64,
    velocity_at_maximum_acceleration: f64,
    momentum: MinMax,
    /// The slave's whole path length, forwards and backwards: the integral of |v|.
    path: f64,
    /// The integral of a².
    square: f64,
}

impl SegmentDemands {
    fn of(segment: &Segment) -> Self {
        let extremes = segment.extremes();
        let velocity_at = |extreme: Extreme| segment.at(extreme.master).velocity;
        Self {
            extremes,
            velocity_at_minimum_acceleration: velocity_at(extremes.acceleration.minimum),
            velocity_at_maximum_acceleration: velocity_at(extremes.acceleration.maximum),
            momentum: segment.momentum(),
            path: segment.path_length(),
            square: segment.squared_acceleration(),
        }
    }

    fn joined(self, next: Self) -> Self {
        let (before, after) = (self.extremes.acceleration, next.extremes.acceleration);
        // Strict as in `MinMax::joined`, so that the velocity is that at the place which the extremes name.
        let lower = after.minimum.value < before.minimum.value;
        let higher = after.maximum.value > before.maximum.value;
        Self {
            extremes: self.extremes.joined(next.extremes),
            velocity_at_minimum_acceleration: if lower {
                next.velocity_at_minimum_acceleration
            } else {
                self.velocity_at_minimum_acceleration
            },
            velocity_at_maximum_acceleration: if higher {
                next.velocity_at_maximum_acceleration
            } else {
                self.velocity_at_maximum_acceleration
            },
            momentum: self.momentum.joined(next.momentum),
            path: self.path + next.path,
            square: self.square + next.square,
        }
    }
}
