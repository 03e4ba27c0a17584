//! Planning `MC_GearInPos`: the optimisation steps of TS5055 7, in their order.

use super::checks::SyncEnds;
use super::command::GearInPos;
use super::coupling_moment::CouplingMoment;
use super::demands::SlaveDemands;
use super::path_piece::PathPiece;
use super::plan::{SawForm, SawPlan, SyncLine};
use super::plateau::Plateau;
use super::refusal::{SawRefusal, Violation};
use super::slave_path::SlavePath;
use super::sync_span::SyncSpan;
use super::task::{NEGLIGIBLE, SyncTask};
use super::{GearInSyncMode, SyncMask};

impl GearInPos {
    /// Plans the synchronisation of this command from this coupling moment: a dry run, as it moves
    /// nothing. `MasterStartDistance` is left to [`super::SawCoupling`].
    ///
    /// With a [strategy](super::SyncStrategy) it is made of phases of constant jerk. Otherwise the first
    /// of these that passes all checks is taken:
    /// 1. P1+P5 or P5+P1, free of velocity over- and undershoot, if either is checked;
    /// 2. P5+P1+P5 at the limits of acceleration, if constant velocity is preferred or the slave
    ///    already has the synchronous velocity but is not in place;
    /// 3. P5+P1+P5 at the limit of velocity, if that is checked and P5 breaks it;
    /// 4. P5.
    ///
    /// 1 to 3 need both axes free of acceleration.
    ///
    /// # Errors
    /// [`SawRefusal`]; of a profile, the violation of the P5.
    pub fn plan(&self, moment: &CouplingMoment) -> Result<SawPlan, SawRefusal> {
        if self.sync_mode.base == GearInSyncMode::TimeBased {
            return Err(SawRefusal::TimeBasedPosition);
        }
        let ahead = self.master_sync_position - moment.master.position;
        // Before the branch, so that an invalid velocity is refused with a strategy, too.
        let moving = moment.with_expected_velocity(self.limits.master_velocity, ahead)?;
        if let Some(strategy) = self.strategy {
            return self.plan_by(strategy, moment);
        }
        let task = SyncTask::new(&self.ratio, &self.sync_mode, &self.limits, &moving)?;
        task.check_master()?;
        let span = SyncSpan::new(&task, self)?;
        let (form, path) = span.best_path()?;
        let line = SyncLine {
            ratio: task.ratio,
            master: self.master_sync_position,
            slave: self.slave_sync_position,
        };
        Ok(SawPlan::over_master(&task, form, path, line))
    }
}

impl SyncSpan<'_> {
    fn best_path(&self) -> Result<(SawForm, SlavePath), SawRefusal> {
        let checklist = &self.task.checklist;
        let quintic = self.quintic();
        // Finite inputs of extreme sizes may overflow in powers of the distance.
        if !quintic.is_finite() {
            return Err(SawRefusal::NotFinite {
                field: "profile",
                received: f64::NAN,
            });
        }
        let free = self.task.is_free_of_acceleration(self.master);
        // Nothing can refuse it, so its extremes need not be known.
        if self.task.checks_nothing() && !(free && self.wants_plateau()) {
            return Ok((SawForm::Quintic, quintic));
        }
        if free {
            let preferred = || self.passing(self.with_preferred_plateau());
            // In the order of TS5055 chapter 7: step 1 before a plateau.
            if let Some(path) = self.passing(self.without_shoot()).or_else(preferred) {
                return Ok(path);
            }
        }
        let demands = self.demands(&quintic);
        if free
            && checklist.speed(&demands).is_err()
            && let Some(path) = self.passing(self.at_highest_velocity(&demands))
        {
            return Ok(path);
        }
        // The refusal is that of P5, the path that any command may take.
        self.check(demands)?;
        Ok((SawForm::Quintic, quintic))
    }

    /// Makes P5.
    fn quintic(&self) -> SlavePath {
        SlavePath::of(PathPiece::quintic(
            self.task.master_position,
            self.master,
            (self.task.slave_position, self.from, self.curvature),
            (self.slave, self.task.ratio),
        ))
    }

    /// Makes P1+P5 or P5+P1: one ramp, and for the rest of the distance the start or the synchronous
    /// slope, so that the velocity has no overshoot or undershoot by construction.
    fn without_shoot(&self) -> Option<(SawForm, SlavePath)> {
        let shoots = SyncMask::OVERSHOOT_VELO.union(SyncMask::UNDERSHOOT_VELO);
        if !self.task.checklist.mask.intersects(shoots) || self.has_sync_slope() {
            return None;
        }
        // τ, the mean velocity as a part of the change: 0 is the start velocity, 1 the synchronous one.
        let share = (self.slave / self.master - self.from) / (self.task.ratio - self.from);
        // Outside, the mean lies beyond both velocities, so
        // one of them has to be passed. NaN is refused, too.
        if !(share > 0.0 && share < 1.0) {
            return None;
        }
        let (start, position) = (self.task.master_position, self.task.slave_position);
        let gear = self.task.ratio;
        if share <= 0.5 {
            // The line at the start slope over M − L, the ramp at
            // the mean of both over L: L = 2τM. Otherwise 2(1 − τ)M.
            let ramp = 2.0 * share * self.master;
            let rest = self.master - ramp;
            let line = PathPiece::line(start, rest, position, self.from);
            let path = SlavePath::of(line).then(PathPiece::ramp(
                // From the end backwards, so that the last piece
                // ends exactly at the synchronisation position.
                self.sync.0 - ramp,
                ramp,
                position + line.distance(),
                self.from,
                gear,
            ));
            Some((SawForm::LineQuintic, path))
        } else {
            let ramp = PathPiece::ramp(
                start,
                2.0 * (1.0 - share) * self.master,
                position,
                self.from,
                gear,
            );
            let path = SlavePath::of(ramp).then(PathPiece::line(
                ramp.end(),
                self.sync.0 - ramp.end(),
                position + ramp.distance(),
                gear,
            ));
            Some((SawForm::QuinticLine, path))
        }
    }

    /// Makes P5+P1+P5 with the peak velocity at the limit that P5 breaks, both ramps with the same peak
    /// of acceleration.
    fn at_highest_velocity(&self, quintic: &SlaveDemands) -> Option<(SawForm, SlavePath)> {
        let limit = self.task.checklist.velocity;
        let velocity = &quintic.course.velocity;
        // P5 may be too fast either way; the plateau lies on that side.
        let too_fast = velocity.maximum.value > limit;
        let peak = if too_fast { limit } else { -limit };
        let slope = peak / self.task.master_velocity;

        let (rise, fall) = (slope - self.from, slope - self.task.ratio);
        let to_make_up = slope * self.master - self.slave;
        // Ramps of one steepness κ have lengths |w − u|/κ and
        // lose (w − u)/2 each: Σ(w − u)·|w − u|/2κ = wM − Δs.
        let steepness = (rise * rise.abs() + fall * fall.abs()) / (2.0 * to_make_up);
        let ramps = Plateau {
            slope,
            first: rise.abs() / steepness,
            last: fall.abs() / steepness,
        };
        // A ramp of the wrong sign would run against the master.
        (steepness * self.master > 0.0)
            .then(|| self.plateau(&ramps))
            .flatten()
    }

    fn with_preferred_plateau(&self) -> Option<(SawForm, SlavePath)> {
        if !self.wants_plateau() {
            return None;
        }
        self.plateau(&Plateau::with_shortest_ramps(self)?)
    }

    fn wants_plateau(&self) -> bool {
        let preferred = self
            .task
            .checklist
            .mask
            .contains(SyncMask::PREFER_CONST_VELO);
        let difference = self.slave - self.task.ratio * self.master;
        let out_of_place = difference.abs() > NEGLIGIBLE * self.slave.abs();
        // A slave that is on the line already needs no ramps, and they would have no length.
        let wanted = if self.has_sync_slope() {
            out_of_place
        } else {
            preferred
        };
        self.task.master_velocity != 0.0 && wanted
    }

    fn has_sync_slope(&self) -> bool {
        let gear = self.task.ratio;
        // Ramps between velocities that differ by rounding would be divisions by it.
        (gear - self.from).abs() <= NEGLIGIBLE * gear.abs().max(self.from.abs())
    }

    /// Makes P5+P1+P5.
    fn plateau(&self, ramps: &Plateau) -> Option<(SawForm, SlavePath)> {
        let between = self.master - ramps.first - ramps.last;
        // Rounding remainder between two ramps that touch.
        let none_left = between.abs() <= f64::EPSILON * 4.0 * self.master.abs();
        // Ramps longer than the distance leave a line of the wrong sign.
        if !(between * self.master >= 0.0 || none_left) {
            return None;
        }
        let (start, position) = (self.task.master_position, self.task.slave_position);
        let first = PathPiece::ramp(start, ramps.first, position, self.from, ramps.slope);
        let position = position + first.distance();
        let line = PathPiece::line(first.end(), between, position, ramps.slope);
        let position = position + line.distance();
        let last = PathPiece::ramp(
            self.sync.0 - ramps.last,
            ramps.last,
            position,
            ramps.slope,
            self.task.ratio,
        );
        let path = SlavePath::of(first).then(line).then(last);
        Some((SawForm::QuinticLineQuintic, path))
    }

    /// Returns the path if it passes all checks.
    fn passing(&self, path: Option<(SawForm, SlavePath)>) -> Option<(SawForm, SlavePath)> {
        path.filter(|(_, path)| self.check(self.demands(path)).is_ok())
    }

    fn demands(&self, path: &SlavePath) -> SlaveDemands {
        path.demands(self.task.master_velocity)
    }

    fn check(&self, demands: SlaveDemands) -> Result<(), Violation> {
        let task = self.task;
        task.check(
            &demands,
            &SyncEnds {
                start: (task.slave_position, self.from * task.master_velocity),
                sync: (self.sync.1, task.sync_velocity()),
            },
        )
    }
}
