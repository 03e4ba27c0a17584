//! The course after a change, checked ahead of the master: whether the slave can follow it.

use super::coupling::{CamCoupling, MOST_PLATES};
use super::course_bound::CourseBound;
use super::error::CouplingError;
use super::layer::Layer;
use super::limits::CamLimits;
use super::placement::{Path, PlacedPlate};
use super::ramp::GapRamp;
use super::tables::Tables;
use coaxle_curve::law::Quantity;
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{Course, PeakDemands, Plate};

/// Places of a cycle, and of a ramp, at which the course is checked, beside the peaks of a plate.
// A quintic's curvature exceeds that at the nearer of 128 places by up to |f''''|/2·(1/256)², 0.03 % of its peak.
const PLACES: u32 = 128;

/// Greatest number of cycles of a plate in which its peaks are checked: of more, evenly spread ones are.
// A cycle shorter than that is as narrow as a place. Without a bound a plate with a short cycle, beside a
// long one, would cost any number of checks in one cycle.
const CYCLES: f64 = 128.0;

/// Greatest number of segments of a plate that are searched in as many cycles; of more, in fewer cycles.
// Bounds the places, at 30 to 170 ns each (docs/SPEED.md), of a plate that is repeated along a ramp or beside others.
const SEGMENTS_IN_CYCLES: f64 = 256.0;

/// Slack for rounding, relative to the limit.
const ROUNDING: f64 = 1e-6;

/// Course of the slave once a change is in force: all plates, one of them new, and a ramp.
pub(super) struct CourseAhead<'a> {
    pub(super) coupling: &'a CamCoupling,
    pub(super) tables: &'a Tables,
    /// Index of the place that changes, and the plate in it; none if it is removed.
    pub(super) index: usize,
    pub(super) next: Option<PlacedPlate<'a>>,
    pub(super) ramp: Option<GapRamp>,
}

impl CourseAhead<'_> {
    /// Checks whether the slave can follow the course ahead of a master that keeps its velocity: over a
    /// cycle of the new plate, and over the ramp, whose own jerk counts too.
    ///
    /// The demands of a plate are greatest at its [peaks](coaxle_plate::Plate::peaks), however narrow
    /// they are. With one plate, nothing exceeds its demands there. Of several plates, and of a ramp, the
    /// sum is checked at the peaks of each, and at [`PLACES`] in between. Segments that cannot exceed the
    /// limits, with all that is beside them, are left out.
    pub(super) fn check(
        &self,
        master: &Kinematics,
        limits: &CamLimits,
    ) -> Result<(), CouplingError> {
        let (from, velocity) = (master.position, master.velocity);
        // A master at standstill demands nothing, and gives no direction to look in.
        if velocity == 0.0 {
            return Ok(());
        }
        for distance in [
            self.distance_on_plate(master),
            self.distance_on_ramp(master),
        ] {
            for place in 0..=PLACES {
                let master = from + distance * f64::from(place) / f64::from(PLACES);
                self.check_at(master, velocity, limits)?;
            }
        }
        self.check_peaks(master, limits)?;
        self.check_ramp(master, limits.jerk)
    }

    /// Checks the peaks of each plate, as far as they lie ahead.
    fn check_peaks(&self, master: &Kinematics, limits: &CamLimits) -> Result<(), CouplingError> {
        let distance = [
            self.distance_on_plate(master),
            self.distance_on_ramp(master),
        ]
        .into_iter()
        // The longer of both: a ramp may last for several cycles of the plate.
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(0.0);
        let ahead = (master.position, master.position + distance);
        let plates = self.plates()?;
        let others = (0..MOST_PLATES).filter(|place| *place != self.index);
        // The new plate first: mostly it is the one that is too fast.
        for place in [self.index].into_iter().chain(others) {
            let Some(placed) = plates[place] else {
                continue;
            };
            let bound = CourseBound {
                placed,
                beside: self.bound_beside(place, &plates),
                velocity: master.velocity,
                limits,
            };
            self.check_peaks_of(&bound, ahead)?;
        }
        Ok(())
    }

    /// Returns the plates of the course in their places.
    fn plates(&self) -> Result<[Option<PlacedPlate<'_>>; MOST_PLATES], CouplingError> {
        let mut plates = [None; MOST_PLATES];
        for (placed, layer) in plates.iter_mut().zip(&self.coupling.layers) {
            *placed = match layer {
                Some(layer) => Some(layer.placed(self.tables)?),
                None => None,
            };
        }
        plates[self.index] = self.next;
        Ok(plates)
    }

    /// Returns the magnitudes that all but one of the plates, and the ramp, do not exceed in sum.
    fn bound_beside(&self, place: usize, plates: &[Option<PlacedPlate<'_>>; MOST_PLATES]) -> Path {
        let mut bound = self.ramp.map_or(Path::default(), |ramp| ramp.bound());
        let others = (0..MOST_PLATES).filter(|other| *other != place);
        for placed in others.filter_map(|other| plates[other]) {
            bound += placed.placement.bound(placed.plate.greatest_demands());
        }
        bound
    }

    fn check_peaks_of(
        &self,
        bound: &CourseBound<'_>,
        (from, to): (f64, f64),
    ) -> Result<(), CouplingError> {
        let PlacedPlate { placement, plate } = bound.placed;
        let can_be_exceeded = |demands: &PeakDemands| bound.can_be_exceeded(demands);
        // Mostly nothing is to be searched, however long the plate is.
        if !can_be_exceeded(plate.greatest_demands()) {
            return Ok(());
        }
        let (one, other) = (placement.on_plate(from), placement.on_plate(to));
        // A negative scaling of the master reverses the order on the plate.
        let (least, most) = (one.min(other), one.max(other));
        let period = plate.period();
        let searched = plate.peaks(can_be_exceeded).count() / Plate::PEAKS_OF_A_SEGMENT;
        let cycles = (CYCLES * SEGMENTS_IN_CYCLES / searched as f64).clamp(1.0, CYCLES);
        // Whole cycles, so that each place is a peak.
        let step = period * libm::ceil((most - least) / cycles / period).max(1.0);
        for peak in plate.peaks(can_be_exceeded) {
            // The first time at or after the least place, and each cycle from there.
            let (mut place, cycle) = match plate.course() {
                // Passed once: the infinite step ends the loop after the only place.
                Course::Linear => (peak, f64::INFINITY),
                Course::Cyclic => {
                    let turns = libm::ceil((least - peak) / period);
                    (peak + turns * period, step)
                }
            };
            while place <= most {
                // A peak of a linear plate may lie behind the master already.
                if place >= least {
                    self.check_at(placement.on_axis(place), bound.velocity, bound.limits)?;
                }
                place += cycle;
            }
        }
        Ok(())
    }

    /// Checks the ramp's jerk, by the differences of its curvature.
    fn check_ramp(&self, master: &Kinematics, limit: f64) -> Result<(), CouplingError> {
        let Some(ramp) = &self.ramp else {
            return Ok(());
        };
        // Mean jerk of a 128th: at the start, where a quintic's jerk peaks, 2.3 % below the peak (58.6 of 60).
        let step = self.distance_on_ramp(master) / f64::from(PLACES);
        let curvature = |place: u32| {
            let path = ramp.at(master.position + step * f64::from(place));
            path.unwrap_or_default().curvature
        };
        let speed = master.velocity.abs();
        let steepest = (0..PLACES)
            .map(|place| (curvature(place + 1) - curvature(place)).abs())
            .fold(0.0, f64::max);
        // j = dc/dx·V³ at a constant master velocity.
        let received = steepest / step.abs() * speed * speed * speed;
        if received <= limit * (1.0 + ROUNDING) {
            return Ok(());
        }
        Err(CouplingError::BeyondLimits {
            quantity: Quantity::Jerk,
            received,
            limit,
            speed,
            // Jerk grows with V³, so the speed at which it just fits is a cube root.
            fastest: speed * libm::cbrt(limit / received),
        })
    }

    fn check_at(
        &self,
        master: f64,
        master_velocity: f64,
        limits: &CamLimits,
    ) -> Result<(), CouplingError> {
        let path = self.at(master)?;
        let velocity = path.slope * master_velocity;
        let acceleration = path.curvature * master_velocity * master_velocity;
        // Opposite signs brake the slave.
        let push = if velocity * acceleration < 0.0 {
            limits.deceleration
        } else {
            limits.acceleration
        };
        let speed = master_velocity.abs();
        for (quantity, received, limit, part) in [
            (
                Quantity::Velocity,
                velocity.abs(),
                limits.velocity,
                // Velocity grows with V, acceleration with V²: so the speed that just fits is a quotient, or a
                // square root.
                limits.velocity / velocity.abs(),
            ),
            (
                Quantity::Acceleration,
                acceleration.abs(),
                push,
                libm::sqrt(push / acceleration.abs()),
            ),
        ] {
            // A plate planned exactly for the slave's limits must pass.
            if received > limit * (1.0 + ROUNDING) {
                return Err(CouplingError::BeyondLimits {
                    quantity,
                    received,
                    limit,
                    speed,
                    fastest: speed * part,
                });
            }
        }
        Ok(())
    }

    fn at(&self, master: f64) -> Result<Path, CouplingError> {
        let mut path = match &self.next {
            Some(placed) => placed.placement.at(placed.plate, master),
            None => Path::default(),
        };
        for layer in self.others() {
            path += layer.path_at(self.tables, master)?;
        }
        if let Some(ramp) = &self.ramp {
            // Beyond its end a ramp adds nothing.
            path += ramp.at(master).unwrap_or_default();
        }
        Ok(path)
    }

    /// Returns the plates in the other places.
    fn others(&self) -> impl Iterator<Item = &Layer> {
        let layers = self.coupling.layers.iter().enumerate();
        let others = layers.filter(|(index, _)| *index != self.index);
        others.filter_map(|(_, layer)| layer.as_ref())
    }

    /// Returns the distance of the master ahead on the new plate: a cycle, or the rest of a linear one.
    fn distance_on_plate(&self, master: &Kinematics) -> f64 {
        let Some(PlacedPlate { placement, plate }) = &self.next else {
            return 0.0;
        };
        let (start, end) = plate.master_range();
        let ahead = |distance: f64| distance * master.velocity > 0.0;
        if plate.course() == Course::Cyclic {
            // Scaled by the master's scaling, which may be negative.
            let period = placement.on_axis(end) - placement.on_axis(start);
            return period.abs().copysign(master.velocity);
        }
        // Only edges ahead count: behind both, the slave stands at the edge.
        let distances = [start, end].map(|edge| placement.on_axis(edge) - master.position);
        distances
            .into_iter()
            .filter(|distance| ahead(*distance))
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
            .unwrap_or(0.0)
    }

    fn distance_on_ramp(&self, master: &Kinematics) -> f64 {
        self.ramp
            .map_or(0.0, |ramp| ramp.length().copysign(master.velocity))
    }
}
