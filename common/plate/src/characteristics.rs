//! `MC_ReadCamTableCharacteristics`: what a plate demands of the slave.

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
    /// Where the plate starts.
    pub start: PlateEnd,
    /// Where it ends.
    pub end: PlateEnd,
    /// The least and the most of position, velocity, acceleration and jerk, and where.
    pub extremes: Extremes,
    /// The velocity where the acceleration is least.
    #[doc(alias = "fSVeloAtSAccMin")]
    pub velocity_at_minimum_acceleration: f64,
    /// The velocity where the acceleration is highest.
    #[doc(alias = "fSVeloAtSAccMax")]
    pub velocity_at_maximum_acceleration: f64,
    /// The least and the highest product of velocity and acceleration, u²/s³: what a drive must
    /// brake and what it must give, up to the mass. The original leaves it out.
    #[doc(alias = "fSlaveDynMomMin")]
    #[doc(alias = "fSlaveDynMomMax")]
    pub dynamic_momentum: MinMax,
    /// The mean of the velocity's magnitude. The original leaves it out.
    #[doc(alias = "fSlaveVeloMean")]
    pub mean_velocity: f64,
    /// The root of the mean square of the acceleration. The original leaves it out.
    #[doc(alias = "fSlaveAccEff")]
    pub effective_acceleration: f64,
    /// At how many places inside the plate, and at the seam of a cyclic one, the velocity steps:
    /// [`Plate::velocity_steps`]. The original says nothing of them.
    pub velocity_steps: usize,
    /// The largest of these steps, over time.
    pub largest_velocity_step: Option<VelocityStep>,
    /// How many rows or points the plate has.
    #[doc(alias = "NumberOfRows")]
    pub rows: usize,
    /// How many columns.
    #[doc(alias = "NumberOfColumns")]
    pub columns: usize,
    /// What it is made from.
    pub table_type: TableType,
    /// Whether it is repeated.
    pub course: Course,
}

/// An end of a plate, with the slave as it moves there.
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
                acceleration: scaled(extremes.acceleration, v * v),
                jerk: scaled(extremes.jerk, v * v * v),
            },
            velocity_at_minimum_acceleration: v * demands.velocity_at_minimum_acceleration,
            velocity_at_maximum_acceleration: v * demands.velocity_at_maximum_acceleration,
            dynamic_momentum: scaled(demands.momentum, v * v * v),
            mean_velocity: v.abs() * demands.path / self.period(),
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

    /// The least and the highest position of the slave in the base cycle, u, and where.
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

    fn demands(&self) -> Demands {
        let (first, _) = self.ends();
        self.curve().segments()[1..]
            .iter()
            .map(Demands::of)
            .fold(Demands::of(first), Demands::joined)
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

/// What a part of the plate demands at a master velocity of 1.
struct Demands {
    extremes: Extremes,
    velocity_at_minimum_acceleration: f64,
    velocity_at_maximum_acceleration: f64,
    momentum: MinMax,
    /// The slave's whole way, forwards and backwards: the integral of |v|.
    path: f64,
    /// The integral of a².
    square: f64,
}

impl Demands {
    fn of(segment: &Segment) -> Self {
        let extremes = segment.extremes();
        let velocity_at = |extreme: Extreme| segment.at(extreme.master).velocity;
        Self {
            extremes,
            velocity_at_minimum_acceleration: velocity_at(extremes.acceleration.minimum),
            velocity_at_maximum_acceleration: velocity_at(extremes.acceleration.maximum),
            momentum: segment.momentum(),
            path: segment.way(),
            square: segment.squared_acceleration(),
        }
    }

    fn joined(self, next: Self) -> Self {
        let (before, after) = (self.extremes.acceleration, next.extremes.acceleration);
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
