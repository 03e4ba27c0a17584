//! `MC_ReadCamTableMasterPosition`: the master positions for a slave position.
//!
//! A master position has one slave position, but a slave position may have many masters. Each segment
//! finds all of its own exactly; here they are put in order, over the turns of a cyclic plate.

use super::error::CamError;
use super::kind::Course;
use super::plate::Plate;
use coaxle_curve::law::MinMax;

/// Inputs of `MC_ReadCamTableMasterPosition`, TF5050 chapter 7.5: axis positions of a coupling with its
/// offsets and scalings.
#[doc(alias = "MC_ReadCamTableMasterPosition")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MasterQuery {
    /// Position of the slave axis, u.
    pub slave_position: f64,
    /// Offset added to the position of the master axis, x.
    pub master_offset: f64,
    /// Offset added to the position of the slave in the plate, u.
    pub slave_offset: f64,
    /// Scaling of the plate for the master axis.
    pub master_scaling: f64,
    /// Scaling of the plate for the slave axis.
    pub slave_scaling: f64,
    /// Position of the master axis at which the search starts, x.
    pub master_start: f64,
    /// Masters no farther than this from the start count as on both sides of it, x. Places are found to
    /// full precision for any accuracy.
    pub accuracy: f64,
}

impl Default for MasterQuery {
    fn default() -> Self {
        Self {
            slave_position: 0.0,
            master_offset: 0.0,
            slave_offset: 0.0,
            master_scaling: 1.0,
            slave_scaling: 1.0,
            master_start: 0.0,
            accuracy: 0.0,
        }
    }
}

/// `CamMasterData`, TF5050 chapter 8.17; none where `Valid` is false.
#[doc(alias = "CamMasterData")]
#[doc(alias = "ST_CamMasterData")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MasterPosition {
    /// Position of the master axis, x.
    #[doc(alias = "MasterAxisPosition")]
    pub axis: f64,
    /// Position of the master in the base cycle of the plate, x.
    #[doc(alias = "MasterCamPosition")]
    pub cam: f64,
    /// The slave offset with which a coupling there, which begins in the base cycle, leaves the slave in
    /// its position: the one of the query and the lifts up to there, u.
    #[doc(alias = "SlaveOffset")]
    pub slave_offset: f64,
}

impl Plate {
    /// `MC_ReadCamTableMasterPosition`: the nearest masters below and above the start at which the slave
    /// axis has the position of the query. Either is none if there is no such master.
    ///
    /// # Errors
    /// 0x4A1C for a number that is not finite, a scaling of 0 or an accuracy below 0.
    #[doc(alias = "MC_ReadCamTableMasterPosition")]
    pub fn master_positions(
        &self,
        query: &MasterQuery,
    ) -> Result<[Option<MasterPosition>; 2], CamError> {
        query.check()?;
        // Inverse of the coupling: slave = cam·scaling + offset, master on the plate = (master + offset)/scaling.
        let slave = (query.slave_position - query.slave_offset) / query.slave_scaling;
        let start = (query.master_start + query.master_offset) / query.master_scaling;
        let accuracy = query.accuracy / query.master_scaling.abs();
        let mut found = [
            self.master_below(slave, start, accuracy),
            self.master_above(slave, start, accuracy),
        ];
        // A negative scaling mirrors the master: below on the plate is above on the axis.
        if query.master_scaling < 0.0 {
            found.reverse();
        }
        Ok(found.map(|master| master.map(|master| self.located(master, query))))
    }

    /// Returns the greatest master not above `start` at which the slave is at `slave`; one up to
    /// `accuracy` above counts too. In x and u, raw.
    #[must_use]
    pub fn master_below(&self, slave: f64, start: f64, accuracy: f64) -> Option<f64> {
        self.neighbour(slave, start, accuracy, SearchDirection::Below)
    }

    /// Returns the least master not below `start` at which the slave is at `slave`; one up to `accuracy`
    /// below counts too. In x and u, raw.
    #[must_use]
    pub fn master_above(&self, slave: f64, start: f64, accuracy: f64) -> Option<f64> {
        self.neighbour(slave, start, accuracy, SearchDirection::Above)
    }

    /// Returns the masters of the base cycle at which the slave is at `slave`, ascending, in x and u,
    /// raw.
    ///
    /// Of a rest of the slave, only its begin is returned. The end of a cyclic plate is the begin of the
    /// next cycle and so does not count.
    pub fn masters_at(&self, slave: f64) -> impl Iterator<Item = f64> + '_ {
        let (start, end) = self.master_range();
        let excluded = match self.course() {
            Course::Linear => f64::INFINITY,
            // The end may be found a few bits early, and would be reported a second time by the next turn's start.
            Course::Cyclic => end - rounding(start, end),
        };
        self.crossings(slave).take_while(move |&m| m < excluded)
    }

    /// Returns these masters, the end of a cyclic plate included.
    fn crossings(&self, slave: f64) -> impl Iterator<Item = f64> + '_ {
        let (start, end) = self.master_range();
        let mut last = f64::NEG_INFINITY;
        self.curve()
            .segments()
            .iter()
            .flat_map(move |segment| {
                let roots = segment.masters_at(slave);
                (0..roots.len()).map(move |i| roots[i])
            })
            .filter(move |&master| {
                // Two segments both name the point between them.
                // Sorted already, since segments and the roots within each ascend: comparing with the last one
                // is enough.
                let new = master > last + rounding(start, end);
                if new {
                    last = master;
                }
                new
            })
    }

    fn located(&self, master: f64, query: &MasterQuery) -> MasterPosition {
        let turn = self.turn(master);
        MasterPosition {
            axis: master * query.master_scaling - query.master_offset,
            // A single turn gives place and lift, so both agree even at the edge of a turn.
            cam: master - turn * self.period(),
            slave_offset: query.slave_offset + turn * self.lift() * query.slave_scaling,
        }
    }

    fn neighbour(
        &self,
        slave: f64,
        start: f64,
        accuracy: f64,
        side: SearchDirection,
    ) -> Option<f64> {
        if self.rests_at(slave, start) {
            return Some(start);
        }
        let range = self.slave_range();
        self.turns_to_search(slave, start, range, side)
            .into_iter()
            .find_map(|turn| {
                let mut masters = self
                    .crossings(self.base_slave(slave, turn, range))
                    .map(|master| master + turn * self.period());
                match side {
                    SearchDirection::Below => masters
                        // `max(0.0)` since callers of `master_below` and `master_above` may pass a negative accuracy.
                        .take_while(|&m| m <= start + accuracy.max(0.0))
                        .last(),
                    SearchDirection::Above => masters.find(|&m| m >= start - accuracy.max(0.0)),
                }
            })
    }

    /// True if the slave stands still in its place at the start: there is no nearer master.
    fn rests_at(&self, slave: f64, start: f64) -> bool {
        let (first, last) = self.master_range();
        // Outside its range a linear plate holds the slave, but the plate names no master there.
        let on_plate = self.course() == Course::Cyclic || (first..=last).contains(&start);
        let here = self.at(start);
        on_plate
            && here.velocity == 0.0
            // Equal up to rounding: the position is a sum of the law's value and of the lift's product.
            && (here.position - slave).abs()
                <= 4.0 * f64::EPSILON * here.position.abs().max(slave.abs())
    }

    /// Returns the position of the slave in the base cycle. After many lifts it may miss the range by
    /// rounding.
    fn base_slave(&self, slave: f64, turn: f64, range: MinMax) -> f64 {
        let lifted = turn * self.lift();
        let base = slave - lifted;
        // A plate of huge numbers may have an empty range, at which a clamp would panic.
        let nearest = base.max(range.minimum.value).min(range.maximum.value);
        let rounding = 4.0 * f64::EPSILON * slave.abs().max(lifted.abs());
        if (base - nearest).abs() <= rounding {
            nearest
        } else {
            base
        }
    }

    /// Returns the turns in which the nearest master can be, the nearest first.
    ///
    /// The slave is continuous, so each turn whose range contains it well inside has a master. Hence,
    /// beginning at the turn of the start or at the nearest in range, the next few are enough; the one
    /// nearer still is for an accuracy across the edge.
    fn turns_to_search(
        &self,
        slave: f64,
        start: f64,
        range: MinMax,
        side: SearchDirection,
    ) -> impl Iterator<Item = f64> {
        let here = self.turn(start);
        let (first, step) = match side {
            // Without a lift every turn is alike and the reach infinite, so the turn of the start is the first.
            SearchDirection::Below => (here.min(self.turns_reaching(slave, range).1), -1.0),
            SearchDirection::Above => (here.max(self.turns_reaching(slave, range).0), 1.0),
        };
        let all = match self.course() {
            Course::Linear => 0..1,
            Course::Cyclic => -1..4,
        };
        all.map(move |i| first + f64::from(i) * step)
    }

    /// Returns the first and the last turn in which the slave can reach the position.
    fn turns_reaching(&self, slave: f64, range: MinMax) -> (f64, f64) {
        if self.course() == Course::Linear {
            return (0.0, 0.0);
        }
        if self.lift() == 0.0 {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        let a = (slave - range.minimum.value) / self.lift();
        let b = (slave - range.maximum.value) / self.lift();
        // A negative lift swaps both. Rounded outwards, since a turn too many is searched in vain but harmless.
        (libm::floor(a.min(b)), libm::ceil(a.max(b)))
    }
}

impl MasterQuery {
    fn check(&self) -> Result<(), CamError> {
        let refused = |name, received, expected| CamError::Parameter {
            name,
            received,
            expected,
        };
        for (name, received) in [
            ("slave position", self.slave_position),
            ("master offset", self.master_offset),
            ("slave offset", self.slave_offset),
            ("master start position", self.master_start),
        ] {
            if !received.is_finite() {
                return Err(refused(name, received, "a finite number"));
            }
        }
        for (name, received) in [
            ("master scaling", self.master_scaling),
            ("slave scaling", self.slave_scaling),
        ] {
            if !received.is_finite() || received == 0.0 {
                return Err(refused(name, received, "a finite number other than 0"));
            }
        }
        if !(self.accuracy.is_finite() && self.accuracy >= 0.0) {
            return Err(refused(
                "master accuracy",
                self.accuracy,
                "a finite number from 0",
            ));
        }
        Ok(())
    }
}

#[derive(Clone, Copy)]
enum SearchDirection {
    Below,
    Above,
}

/// Returns the greatest difference between two ways of computing one master.
fn rounding(start: f64, end: f64) -> f64 {
    16.0 * f64::EPSILON * start.abs().max(end.abs())
}
