//! Comparison of the laws that can lead from one point to the next.

use alloc::vec::Vec;

use super::compile::{next_of, segment};
use super::error::CamError;
use super::kind::TableType;
use super::neighbours::{NeighbourMotion, Neighbours, ROUNDING, over_rounding};
use super::point::{MotionPoint, PointType};
use super::source::{PlateSource, SourceRows};
use coaxle_curve::law::{Motion, MotionLaw, Segment};

/// Quantity by which laws are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Demand {
    /// The greatest |v|, u/s.
    Velocity,
    /// The greatest |a|, u/s²: the force on the moved mass.
    #[default]
    Acceleration,
    /// The greatest |j|, u/s³: the excitation of vibrations.
    Jerk,
    /// The greatest |v·a|, u²/s³: the power per mass, which the drive's torque at its speed has to
    /// supply.
    Torque,
}

impl Demand {
    /// Complete list.
    pub const ALL: [Self; 4] = [Self::Velocity, Self::Acceleration, Self::Jerk, Self::Torque];
}

/// Limits of the slave; omitted ones do not apply.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LawLimits {
    /// Greatest |v|, u/s.
    pub velocity: Option<f64>,
    /// Greatest |a|, u/s².
    pub acceleration: Option<f64>,
    /// Greatest |j|, u/s³.
    pub jerk: Option<f64>,
    /// Greatest |v·a|, u²/s³.
    pub torque: Option<f64>,
}

/// Criteria of the comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawCriteria {
    /// The constant velocity of the master, x/s.
    pub master_velocity: f64,
    /// Limits of the slave.
    pub limits: LawLimits,
    /// Quantity to minimise.
    pub least: Demand,
}

/// Demands of a law on the slave between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawAdvice {
    /// The law.
    pub law: MotionLaw,
    /// Greatest velocity, u/s, acceleration, u/s², jerk, u/s³, and |v·a|, u²/s³, within the segment.
    demands: [f64; 4],
    /// Difference of its velocity from that of the points at its ends, the larger one, u/s; 0 within
    /// rounding.
    pub velocity_step: f64,
    /// Difference of its acceleration from that of the segments before and after, the larger one, u/s².
    pub acceleration_step: f64,
    /// True if it joins without a step of the velocity and keeps the limits.
    pub passes: bool,
}

impl LawAdvice {
    /// Returns the value of a demand. The jerk of a law whose acceleration steps at an end is infinite.
    #[must_use]
    pub const fn demand(&self, demand: Demand) -> f64 {
        match demand {
            // A step of the acceleration is an impulse of jerk, which no limit of jerk admits.
            Demand::Jerk if self.acceleration_step > 0.0 => f64::INFINITY,
            demand => self.demands[demand as usize],
        }
    }

    /// Returns the greatest jerk between the ends, u/s³, without steps at the ends.
    #[must_use]
    pub const fn inner_jerk(&self) -> f64 {
        self.demands[Demand::Jerk as usize]
    }

    /// Returns the limits that it exceeds.
    pub fn broken(&self, limits: &LawLimits) -> impl Iterator<Item = Demand> + use<> {
        let (advice, limits) = (*self, *limits);
        let exceeds = move |demand: &Demand| {
            let limit = limits.of(*demand);
            // A limit equal to a law's own peak must admit that law, computed in another way too.
            limit.is_some_and(|limit| advice.demand(*demand) > limit * (1.0 + ROUNDING))
        };
        Demand::ALL.into_iter().filter(exceeds)
    }
}

impl LawLimits {
    /// Returns the limit of a quantity.
    #[must_use]
    pub const fn of(&self, demand: Demand) -> Option<f64> {
        match demand {
            Demand::Velocity => self.velocity,
            Demand::Acceleration => self.acceleration,
            Demand::Jerk => self.jerk,
            Demand::Torque => self.torque,
        }
    }
}

impl PlateSource {
    /// Returns the laws that the points at both ends allow from a point of this number to the next one,
    /// the best first: those that join their points without a step of the velocity and keep the limits,
    /// and of them those with a continuous acceleration, by the quantity to minimise; then the others.
    ///
    /// The points themselves stay, and so does the rest of the plate, which need not be valid.
    ///
    /// # Errors
    /// 0x4262 for a position table, 0x4B33 for a point that does not exist, 0x4A1C for one from which no
    /// segment begins or within a spline, whose pieces have no laws of their own, and for an invalid
    /// velocity of the master or limit.
    pub fn law_advice(
        &self,
        point: u32,
        criteria: &LawCriteria,
    ) -> Result<Vec<LawAdvice>, CamError> {
        criteria.check()?;
        let context = SegmentContext::of(self, point)?;
        let laws = MotionLaw::ALL.iter().filter(|law| !law.is_spline());
        let mut advice: Vec<_> = laws
            .filter_map(|law| context.advice(*law, criteria))
            .collect();
        // False sorts before true.
        let late = |advice: &LawAdvice| (!advice.passes, advice.acceleration_step > 0.0);
        let much = |advice: &LawAdvice| advice.demand(criteria.least);
        advice.sort_by(|one, other| {
            // Infinite jerks are equal here, and the stable sort keeps them in the order of the list.
            let by_much = much(one).total_cmp(&much(other));
            late(one).cmp(&late(other)).then(by_much)
        });
        Ok(advice)
    }
}

impl LawCriteria {
    fn check(&self) -> Result<(), CamError> {
        let velocity = self.master_velocity;
        if !velocity.is_finite() || velocity == 0.0 {
            return Err(CamError::Parameter {
                name: "master velocity",
                received: velocity,
                expected: "a finite number other than 0",
            });
        }
        for (demand, name) in Demand::ALL.into_iter().zip([
            "limit of velocity",
            "limit of acceleration",
            "limit of jerk",
            "limit of torque",
        ]) {
            // An infinite limit is allowed and never broken. NaN would never be broken either, as it compares false.
            if let Some(received) = self.limits.of(demand)
                && (received.is_nan() || received <= 0.0)
            {
                let expected = "a number above 0";
                return Err(CamError::Parameter {
                    name,
                    received,
                    expected,
                });
            }
        }
        Ok(())
    }
}

/// Two points, and the motion of the slave before and after.
struct SegmentContext {
    point: MotionPoint,
    next: MotionPoint,
    /// Motion on arrival and after departure.
    before: NeighbourMotion,
    after: NeighbourMotion,
}

impl SegmentContext {
    fn of(source: &PlateSource, index: u32) -> Result<Self, CamError> {
        let points = match &source.rows {
            SourceRows::Points(points) => points,
            SourceRows::Positions { equidistant, .. } => {
                let received = if *equidistant {
                    TableType::Equidistant
                } else {
                    TableType::NonEquidistant
                };
                return Err(CamError::NotAMotionFunction { received });
            }
        };
        let last = points.len();
        let row = (index as usize).wrapping_sub(1);
        let point = points.get(row).ok_or(CamError::UnknownPoint {
            received: index,
            last: last as u32,
        })?;
        let refused = |expected| CamError::Parameter {
            name: "point",
            received: f64::from(index),
            expected,
        };
        if row + 1 == last || point.point_type == PointType::Ignore {
            return Err(refused("a point that a segment begins at"));
        }
        // A piece of a spline depends on all of its points, so no law can replace it alone.
        if point.function.is_spline() {
            return Err(refused(
                "a point outside of splines: their pieces have no laws of their own",
            ));
        }
        let next_row = next_of(points, row)?;
        let neighbours = Neighbours::of(source, points);
        Ok(Self {
            point: *point,
            next: points[next_row],
            before: neighbours.before(row),
            after: neighbours.after(row, next_row),
        })
    }

    /// Returns the demands of a law; none if the points do not allow it.
    fn advice(&self, law: MotionLaw, criteria: &LawCriteria) -> Option<LawAdvice> {
        let point = MotionPoint {
            function: law,
            ..self.point
        };
        let segment = segment(&point, &self.next).ok()?;
        let (first, last) = (segment.at(segment.start()), segment.at(segment.end()));
        // Magnitudes only: backwards the same plate makes the same peaks.
        let v = criteria.master_velocity.abs();
        let extremes = segment.extremes();
        let demands = [
            extremes.velocity.magnitude() * v,
            extremes.acceleration.magnitude() * v * v,
            extremes.jerk.magnitude() * v * v * v,
            // Velocity times acceleration has v·v².
            segment.momentum().magnitude() * v * v * v,
        ];
        let size = size_of(&segment, &first, &last);
        let velocity_step = (first.velocity - self.point.velocity)
            .abs()
            .max((last.velocity - self.next.velocity).abs());
        let (start, end) = (first.acceleration, last.acceleration);
        let before = self.before.step(start, end, size.acceleration);
        let after = self.after.step(end, start, size.acceleration);
        let mut advice = LawAdvice {
            law,
            demands,
            velocity_step: over_rounding(velocity_step, size.velocity) * v,
            acceleration_step: before.max(after) * v * v,
            passes: false,
        };
        advice.passes =
            advice.velocity_step == 0.0 && advice.broken(&criteria.limits).next().is_none();
        Some(advice)
    }
}

/// Returns the reference magnitudes for steps: those involved, and those of the stroke over a segment of
/// that length.
fn size_of(segment: &Segment, first: &Motion, last: &Motion) -> Motion {
    let length = segment.end() - segment.start();
    let mean = (last.position - first.position).abs() / length;
    let extremes = segment.extremes();
    Motion {
        velocity: extremes.velocity.magnitude().max(mean),
        acceleration: extremes.acceleration.magnitude().max(mean / length),
        ..Motion::default()
    }
}
