//! Planning `MC_GearInVelo`.

use coaxle_curve::profile::{Kinematics, to_velocity};

use super::GearInSyncMode;
use super::checks::SyncEnds;
use super::command::GearInVelo;
use super::coupling_moment::CouplingMoment;
use super::curved_ramp;
use super::demands::SlaveDemands;
use super::path_piece::PathPiece;
use super::plan::{SawForm, SawPlan, SyncLine, over_time};
use super::ramp::shortest_ramp;
use super::refusal::SawRefusal;
use super::slave_path::SlavePath;
use super::task::{NEGLIGIBLE, SyncTask};

impl GearInVelo {
    /// Plans the synchronisation of this command from this coupling moment: a dry run, as it moves
    /// nothing.
    ///
    /// Position-based it is the shortest symmetric ramp within acceleration, deceleration and jerk,
    /// time-based the fastest change of velocity.
    ///
    /// # Errors
    /// [`SawRefusal`].
    pub fn plan(&self, moment: &CouplingMoment) -> Result<SawPlan, SawRefusal> {
        // A slave that stands beside its master is synchronous at once, but has to reach its future
        // velocity.
        let moving = moment.with_expected_velocity(self.limits.master_velocity, 1.0)?;
        let task = |moment| SyncTask::new(&self.ratio, &self.sync_mode, &self.limits, moment);
        // Only for its refusals: the plan itself is made for the master as it is.
        task(&moving)?;
        let task = task(moment)?;
        task.check_master()?;
        match self.sync_mode.base {
            GearInSyncMode::PositionBased => over_master(&task),
            GearInSyncMode::TimeBased => over_time_of(&task),
        }
    }
}

fn over_master(task: &SyncTask) -> Result<SawPlan, SawRefusal> {
    let Some(ramp) = ramp(task)? else {
        return Ok(SawPlan::synchronous(task));
    };
    let path = SlavePath::of(ramp);
    let line = SyncLine {
        ratio: task.ratio,
        master: ramp.end(),
        slave: task.slave_position + ramp.distance(),
    };
    if !path.is_finite() {
        return Err(SawRefusal::NotFinite {
            field: "profile",
            received: f64::NAN,
        });
    }
    check(task, &line, || path.demands(task.master_velocity))?;
    Ok(SawPlan::over_master(task, SawForm::Ramp, path, line))
}

/// Returns the shortest ramp over the master's position; none if there is nothing to change.
fn ramp(task: &SyncTask) -> Result<Option<PathPiece>, SawRefusal> {
    if task.master_velocity == 0.0 {
        return Ok(None);
    }
    let (from, to) = (task.slope(), task.ratio);
    let direction = task.master_velocity.signum();
    // Over the master the length is signed like its motion; the ramp's own duration has no sign.
    let length = shortest_ramp(from, to, &task.ramp_bounds(task.checklist.jerk)) * direction;
    let bend = task.curvature() * length;
    // The symmetric ramp starts without acceleration. A present one would be dropped within a cycle.
    if task.curvature() != 0.0 && bend.abs() >= NEGLIGIBLE * (to - from).abs() {
        return curved_ramp::shortest(task).map(Some);
    }
    let (start, position) = (task.master_position, task.slave_position);
    Ok((length != 0.0).then(|| PathPiece::ramp(start, length, position, from, to)))
}

#[inline]
fn over_time_of(task: &SyncTask) -> Result<SawPlan, SawRefusal> {
    let start = Kinematics {
        position: task.slave_position,
        velocity: task.slave_velocity,
        acceleration: task.slave_acceleration,
    };
    let target = task.sync_velocity();
    // The velocity of the gear is already checked, up to rounding.
    let fastest = task.limits.velocity().max(target.abs());
    let limits = task.limits.with_velocity(fastest)?;
    let profile = to_velocity(&start, target, &limits);
    let duration = profile.duration().0;
    // The slave's position is free, so the line begins where the ramp happens to end.
    let line = SyncLine {
        ratio: task.ratio,
        master: task.master_position + task.master_velocity * duration,
        slave: profile.end().position,
    };
    if duration == 0.0 {
        return Ok(SawPlan::synchronous(task));
    }
    if !(line.master.is_finite() && line.slave.is_finite()) {
        return Err(SawRefusal::NotFinite {
            field: "profile",
            received: duration,
        });
    }
    if !task.checks_nothing()
        && let Some(path) = over_time(&profile)
    {
        // Time runs at 1 s/s.
        let demands = path.demands(1.0);
        let places = |time| task.master_position + task.master_velocity * time;
        check(task, &line, || demands.with_places(places))?;
    }
    Ok(SawPlan::over_time(task, profile, line))
}

/// Makes the checks, if there are any.
fn check(
    task: &SyncTask,
    line: &SyncLine,
    demands: impl FnOnce() -> SlaveDemands,
) -> Result<(), SawRefusal> {
    if task.checks_nothing() {
        return Ok(());
    }
    let ends = SyncEnds {
        start: (task.slave_position, task.slave_velocity),
        sync: (line.slave, task.sync_velocity()),
    };
    Ok(task.check(&demands(), &ends)?)
}
