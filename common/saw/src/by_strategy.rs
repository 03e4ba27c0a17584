//! Planning `MC_GearInPos` with a strategy: phases of constant jerk within the limits in force.

use core::convert::Infallible;

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Profile, ProfileExtremes, bracket, to_velocity};

use super::SyncStrategy;
use super::checks::SyncEnds;
use super::command::GearInPos;
use super::coupling_moment::CouplingMoment;
use super::demands::SlaveDemands;
use super::path_limits::PathLimits;
use super::path_piece::PathPiece;
use super::plan::{SawForm, SawPlan, SyncLine, over_time};
use super::refusal::{SawRefusal, Violation};
use super::slave_path::SlavePath;
use super::sync_span::{SyncSpan, check_positions};
use super::task::SyncTask;

/// Greatest part of acceleration, deceleration and jerk that a synchronisation as late as possible needs
/// when it begins, so that the ripple of a master does not make the last moment too late.
const LATEST_SHARE: f64 = 0.99;
/// Least part of them to which a synchronisation is stretched.
// Ramps last longer by the square or the cube root of 1/share: 1000 times at least.
const MIN_SHARE: f64 = 1e-9;
/// Relative margin of the share over the least one, so that a path keeps off a limit of position.
// Far above the rounding of a check (1e-12), far below a reserve of 1 %.
const SHARE_MARGIN: f64 = 1e-6;
/// Relative length below which a phase is none.
// Shorter ones are left over by rounding. Over such a length derivatives would be divisions by noise.
const MIN_PHASE: f64 = 1e-12;

impl GearInPos {
    /// Plans the synchronisation by a strategy, from this moment on. The wait of [`SyncStrategy::Late`]
    /// and that for the start distance are left to [`super::SawCoupling`].
    pub(super) fn plan_by(
        &self,
        strategy: SyncStrategy,
        moment: &CouplingMoment,
    ) -> Result<SawPlan, SawRefusal> {
        let task = self.limited_task(moment)?;
        match strategy {
            SyncStrategy::Early => self.plan_early(&task),
            SyncStrategy::Slow | SyncStrategy::Late => {
                SyncPathPlanner::new(&task, self)?.stretched().map(|path| {
                    let line = SyncLine {
                        ratio: task.ratio,
                        master: self.master_sync_position,
                        slave: self.slave_sync_position,
                    };
                    SawPlan::over_master(&task, SawForm::JerkPhases, path, line)
                })
            }
        }
    }

    /// Returns the task of a command whose velocity limit is kept, in sync too.
    fn limited_task(&self, moment: &CouplingMoment) -> Result<SyncTask, SawRefusal> {
        let task = SyncTask::new(&self.ratio, &self.sync_mode, &self.limits, moment)?;
        match self.limits.velocity {
            // Without a strategy the limit is a matter of the sync mode. A
            // strategy keeps it on the line as well, since the slave stays there.
            Some(limit) => task.check_sync_velocity(limit).map(|()| task),
            None => Ok(task),
        }
    }

    fn plan_early(&self, task: &SyncTask) -> Result<SawPlan, SawRefusal> {
        check_positions(self)?;
        let line = Kinematics {
            // The line where it is now. Its synchronisation position may lie ahead or behind.
            position: self.slave_sync_position
                + task.ratio * (task.master_position - self.master_sync_position),
            velocity: task.sync_velocity(),
            acceleration: 0.0,
        };
        let start = Kinematics {
            position: task.slave_position,
            velocity: task.slave_velocity,
            acceleration: task.slave_acceleration,
        };
        let check = |profile: &Profile| check_over_time(task, profile);
        let profile = chase(task)
            .fastest((&start, &line), 1.0, check)
            .ok_or(nothing_left(task))??;
        let duration = profile.duration().0;
        // A path of no time has no pieces to divide by.
        if duration == 0.0 {
            return Ok(SawPlan::synchronous(task));
        }
        let line = SyncLine {
            ratio: task.ratio,
            master: task.master_position + task.master_velocity * duration,
            slave: profile.end().position,
        };
        Ok(SawPlan::over_time(task, profile, line))
    }

    /// Returns the moment at which the slave has to be synchronised at the latest, if it keeps its motion
    /// until then.
    ///
    /// # Errors
    /// [`SawRefusal`] if it cannot be synchronised at all.
    pub(super) fn latest(&self, moment: &CouplingMoment) -> Result<CouplingMoment, SawRefusal> {
        let available = self.time_left(moment)?;
        let at = |wait: f64| advanced(moment, wait);
        // Time needed after the wait, less the time left.
        let late_by = |wait: f64| match self.arrival(&at(wait)) {
            Ok(Some(takes)) => wait + takes - available,
            // A slave that could not stop within its software limits has waited too long as well.
            _ => f64::INFINITY,
        };
        let now = late_by(0.0);
        // Too late already for the share in reserve: the plan decides with all of the dynamics.
        if now >= 0.0 {
            return Ok(*moment);
        }
        // With no time left every path is late, so the change of sign lies between.
        let latest = bracket((0.0, now), (available, late_by(available)), late_by);
        // The lower end is in time, the upper one no longer.
        Ok(at(latest.below))
    }

    /// True if the slave can keep its motion for `elapsed` more, and be synchronised then.
    ///
    /// # Errors
    /// [`SawRefusal`] if it cannot be synchronised at all.
    pub(super) fn can_wait(
        &self,
        moment: &CouplingMoment,
        elapsed: Seconds,
    ) -> Result<bool, SawRefusal> {
        let next = advanced(moment, elapsed.0);
        let available = self.time_left(moment)? - elapsed.0;
        // After the next cycle the master would be past its position, so this cycle is the last.
        let takes = if available > 0.0 {
            self.arrival(&next)?
        } else {
            None
        };
        Ok(takes.is_some_and(|takes| takes <= available))
    }

    /// Returns the time of the master to its synchronisation position, s.
    fn time_left(&self, moment: &CouplingMoment) -> Result<f64, SawRefusal> {
        let task = self.limited_task(moment)?;
        Ok(SyncPathPlanner::new(&task, self)?.available())
    }

    /// Returns the time of the slave to the line of its gear, s, with nearly all of its dynamics; none if
    /// it could no longer stop within its software limits.
    fn arrival(&self, moment: &CouplingMoment) -> Result<Option<f64>, SawRefusal> {
        let task = self.limited_task(moment)?;
        // If the master is at its synchronisation position already, there is no time left.
        let Ok(planner) = SyncPathPlanner::new(&task, self) else {
            return Ok(None);
        };
        if !planner.can_stop(moment) {
            return Ok(None);
        }
        Ok(planner
            .fastest(LATEST_SHARE)
            .map(|profile| profile.duration().0))
    }
}

/// Returns the axes `wait` seconds later, if the slave keeps its velocity, and so does the master.
fn advanced(moment: &CouplingMoment, wait: f64) -> CouplingMoment {
    let dynamics = &moment.axis.dynamics;
    let keeping = to_velocity(&moment.slave, moment.slave.velocity, dynamics);
    let master = Kinematics {
        acceleration: 0.0,
        ..moment.master
    };
    CouplingMoment {
        // Without a wait, the plan considers the acceleration that the master has now.
        master: if wait == 0.0 {
            moment.master
        } else {
            master.after(wait, 0.0)
        },
        slave: keeping.at(Seconds(wait)),
        ..*moment
    }
}

fn chase(task: &SyncTask) -> PathLimits {
    PathLimits {
        limits: task.limits_in_force(),
        // It has been checked already.
        fastest_line: task.sync_velocity().abs(),
        mask: task.checklist.mask,
    }
}

fn nothing_left(task: &SyncTask) -> SawRefusal {
    SawRefusal::NothingLeft {
        velocity: task.sync_velocity(),
        limit: task.checklist.velocity,
    }
}

fn check_over_time(task: &SyncTask, profile: &Profile) -> Result<(), Violation> {
    let Some(path) = over_time(profile) else {
        return Ok(());
    };
    let places = |time| task.master_position + task.master_velocity * time;
    let demands = path.demands(1.0).with_places(places);
    check(task, demands, profile.end().position)
}

fn check(task: &SyncTask, demands: SlaveDemands, sync_position: f64) -> Result<(), Violation> {
    task.check(
        &demands,
        &SyncEnds {
            start: (task.slave_position, task.slave_velocity),
            sync: (sync_position, task.sync_velocity()),
        },
    )
}

/// Path to the synchronisation positions: over time, with the master at its present velocity.
struct SyncPathPlanner<'a> {
    span: SyncSpan<'a>,
    chase: PathLimits,
}

impl<'a> SyncPathPlanner<'a> {
    fn new(task: &'a SyncTask, command: &GearInPos) -> Result<Self, SawRefusal> {
        if task.master_velocity == 0.0 {
            return Err(SawRefusal::MasterStands);
        }
        Ok(Self {
            span: SyncSpan::of_master(task, command)?,
            chase: chase(task),
        })
    }

    /// Returns the time of the master to its synchronisation position, s.
    fn available(&self) -> f64 {
        self.span.master / self.span.task.master_velocity
    }

    fn can_stop(&self, moment: &CouplingMoment) -> bool {
        let CouplingMoment { slave, axis, .. } = moment;
        // The slave moves on while it waits, and has to stay
        // able to stop if the synchronisation is refused later.
        let stop = self.chase.stop(slave, LATEST_SHARE);
        let (low, high) = (stop.min(slave.position), stop.max(slave.position));
        axis.min_position.is_none_or(|min| low >= min)
            && axis.max_position.is_none_or(|max| high <= max)
    }

    fn ends(&self) -> (Kinematics, Kinematics) {
        let span = &self.span;
        let velocity = span.task.master_velocity;
        let start = Kinematics {
            position: span.task.slave_position,
            velocity: span.task.slave_velocity,
            // The slave's acceleration less the part that comes from the master's own.
            acceleration: span.curvature * velocity * velocity,
        };
        let line = Kinematics {
            // Backwards from the synchronisation positions to the present place of the master.
            position: span.sync.1 - span.task.ratio * span.master,
            velocity: span.task.sync_velocity(),
            acceleration: 0.0,
        };
        (start, line)
    }

    fn fastest(&self, share: f64) -> Option<Profile> {
        let unchecked = |_: &Profile| Ok::<(), Infallible>(());
        let (start, line) = self.ends();
        let path = self.chase.fastest((&start, &line), share, unchecked)?;
        path.ok()
    }

    fn fastest_checked(&self, share: f64) -> Option<Result<Profile, Violation>> {
        let (start, line) = self.ends();
        let check = |profile: &Profile| self.check(&self.path_over_master(profile));
        self.chase.fastest((&start, &line), share, check)
    }

    /// Plans the path with the least part of acceleration, deceleration and jerk that arrives in time.
    fn stretched(&self) -> Result<SlavePath, SawRefusal> {
        // Unchecked first: a check costs the extremes of a path in every step of the search.
        let path = self.path_over_master(&self.gentlest(|share| self.fastest(share))?);
        match self.check(&path) {
            Ok(()) => Ok(path),
            // Another path may pass, say one that does not reverse.
            Err(violation) => self
                .gentlest(|share| self.fastest_checked(share)?.ok())
                .map(|profile| self.path_over_master(&profile))
                .map_err(|_| violation.into()),
        }
    }

    fn gentlest(&self, fastest: impl Fn(f64) -> Option<Profile>) -> Result<Profile, SawRefusal> {
        let available = self.available();
        // With everything allowed: a path that is late now is late with any share.
        let fast = fastest(1.0).ok_or(nothing_left(self.span.task))?;
        let needed = fast.duration().0;
        if needed > available {
            return Err(SawRefusal::TooShort { needed, available });
        }
        // With less jerk, the present acceleration would add more to the velocity.
        let speed = |profile: &Profile| ProfileExtremes::of(profile).speed;
        let most = speed(&fast).max(self.chase.limits.velocity());
        // Durations vary with powers of the share.
        let late_by = |gentle: f64| match fastest(libm::exp(-gentle)) {
            Some(profile) if speed(&profile) <= most => profile.duration().0 - available,
            _ => f64::INFINITY,
        };
        // The share as e^−gentle, so that the search divides decades evenly.
        let gentlest = -libm::log(MIN_SHARE);
        let at_least = late_by(gentlest);
        let gentle = if at_least <= 0.0 {
            gentlest
        } else {
            let from = (0.0, needed - available);
            // The lower end arrives in time.
            let found = bracket(from, (gentlest, at_least), late_by).below;
            // If a check ends the search, keep a small margin to its limit.
            // Early, although the slowest was looked for: the next
            // gentler path does not exist, or breaks a check.
            if late_by(found) < -MIN_PHASE * available {
                (found - SHARE_MARGIN).max(0.0)
            } else {
                found
            }
        };
        Ok(fastest(libm::exp(-gentle)).unwrap_or(fast))
    }

    /// Returns the path of a profile over the master's position. On the rest of the path the slave is
    /// synchronous.
    fn path_over_master(&self, profile: &Profile) -> SlavePath {
        let span = &self.span;
        let (start, end) = (span.task.master_position, span.sync.0);
        let (duration, available) = (profile.duration().0, self.available());
        // A path that takes all the time ends where the master is
        // synchronous, to the last bit: no piece of 1e-13 is left over.
        let is_exact = available - duration <= MIN_PHASE * available;
        let whole = if is_exact { duration } else { available };
        let place = |time: f64| {
            if time == whole {
                end
            } else {
                start + span.master * (time / whole)
            }
        };
        let least = MIN_PHASE * whole;
        let begins = profile.phase_begins().map(|begin| begin.0);
        let ends = profile.phase_begins().skip(1).map(|begin| begin.0);
        let phases = begins
            .zip(ends.chain([duration]))
            .filter(|(begin, end)| end - begin > least);
        let pieces = phases.map(|(begin, end)| {
            let state = profile.at(Seconds(begin));
            let constants = (
                state.velocity,
                state.acceleration,
                profile.jerk_at(Seconds(begin)),
            );
            let piece = PathPiece::phase(begin, end - begin, state.position, constants);
            // The length of a short phase is not taken as the difference of two places, which have few
            // digits left for it.
            piece.over_range(place(begin), span.master * ((end - begin) / whole))
        });
        let rest = (!is_exact || duration == 0.0).then(|| {
            let begin = if is_exact { start } else { place(duration) };
            let left = end - begin;
            let position = span.sync.1 - span.task.ratio * left;
            PathPiece::line(begin, left, position, span.task.ratio)
        });
        pieces
            .chain(rest)
            .map(SlavePath::of)
            .reduce(|path, next| path.then(*next.first()))
            .unwrap_or_else(|| {
                SlavePath::of(PathPiece::line(
                    start,
                    span.master,
                    span.task.slave_position,
                    span.task.ratio,
                ))
            })
    }

    fn check(&self, path: &SlavePath) -> Result<(), Violation> {
        let task = self.span.task;
        check(task, path.demands(task.master_velocity), self.span.sync.1)
    }
}
