//! A synchronisation that can be carried out.

use coaxle_axis::SyncPositions;
use coaxle_clock::Seconds;

use coaxle_curve::law::{Knot, LawError, Motion, Segment};
use coaxle_curve::profile::{Kinematics, Profile};

use super::path_piece::PathPiece;
use super::slave_path::SlavePath;
use super::task::SyncTask;

/// A planned synchronisation: the slave's path from the coupling moment to the synchronous phase. Plain
/// data of a fixed size.
///
/// All times and velocities assume that the master keeps its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawPlan {
    form: SawForm,
    profile: SawProfile,
    master_start: f64,
    master_velocity: f64,
    slave_start: Kinematics,
    line: SyncLine,
}

/// Form of a plan, in the manual's notation: Pn is a polynomial of degree n.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum SawForm {
    /// P5.
    Quintic,
    /// P1+P5: the start velocity, then a ramp.
    LineQuintic,
    /// P5+P1: a ramp, then the synchronous velocity.
    QuinticLine,
    /// P5+P1+P5: a ramp, constant velocity, a ramp.
    QuinticLineQuintic,
    /// The shortest ramp to the synchronous velocity.
    Ramp,
    /// Phases of constant jerk, over time or, as the master runs at its velocity, over its position.
    JerkPhases,
    /// No motion: the slave is synchronous already.
    Synchronous,
}

/// Path of the slave, by the variable it depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SawProfile {
    Nothing,
    OverMaster(SlavePath),
    OverTime(Profile),
}

/// The synchronous phase: slave = `slave` + `ratio`·(master − `master`).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SyncLine {
    /// Slave units per master unit.
    pub ratio: f64,
    /// Position of the master at the end of the synchronisation phase, u.
    pub master: f64,
    /// Position of the slave then, u.
    pub slave: f64,
}

impl SyncLine {
    /// Returns the positions of master and slave at the end of the synchronisation phase.
    #[must_use]
    pub const fn sync_positions(&self) -> SyncPositions {
        SyncPositions {
            master: self.master,
            slave: self.slave,
        }
    }

    /// Returns the set values of the synchronous slave.
    #[inline]
    #[must_use]
    pub fn slave_of(&self, master: &Kinematics) -> Kinematics {
        Kinematics {
            // From the synchronisation positions, so that small
            // differences are multiplied, not large positions.
            position: self.slave + self.ratio * (master.position - self.master),
            velocity: self.ratio * master.velocity,
            acceleration: self.ratio * master.acceleration,
        }
    }
}

impl SawPlan {
    pub(super) fn over_master(
        task: &SyncTask,
        form: SawForm,
        path: SlavePath,
        line: SyncLine,
    ) -> Self {
        Self::new(task, form, SawProfile::OverMaster(path), line)
    }

    #[inline]
    pub(super) fn over_time(task: &SyncTask, profile: Profile, line: SyncLine) -> Self {
        Self::new(
            task,
            SawForm::JerkPhases,
            SawProfile::OverTime(profile),
            line,
        )
    }

    /// Makes the plan of a slave that already has the gear's velocity.
    pub(super) fn synchronous(task: &SyncTask) -> Self {
        let line = SyncLine {
            ratio: task.ratio,
            master: task.master_position,
            slave: task.slave_position,
        };
        Self::new(task, SawForm::Synchronous, SawProfile::Nothing, line)
    }

    #[inline]
    fn new(task: &SyncTask, form: SawForm, profile: SawProfile, line: SyncLine) -> Self {
        Self {
            form,
            profile,
            master_start: task.master_position,
            master_velocity: task.master_velocity,
            slave_start: Kinematics {
                position: task.slave_position,
                velocity: task.slave_velocity,
                acceleration: task.slave_acceleration,
            },
            line,
        }
    }

    /// Returns the form of the plan.
    #[must_use]
    pub const fn form(&self) -> SawForm {
        self.form
    }

    /// Returns the synchronous phase that it leads to.
    #[must_use]
    pub const fn line(&self) -> &SyncLine {
        &self.line
    }

    /// Returns the master's position at the coupling moment, u.
    #[doc(alias = "fMasterPosStart")]
    #[must_use]
    pub const fn master_start(&self) -> f64 {
        self.master_start
    }

    /// Returns the master's position at the end of the synchronisation phase, u.
    #[doc(alias = "fMasterPosEnd")]
    #[must_use]
    pub const fn master_end(&self) -> f64 {
        self.line.master
    }

    /// Returns the master's velocity at the coupling moment, u/s.
    #[doc(alias = "fMasterVeloNom")]
    #[must_use]
    pub const fn master_velocity(&self) -> f64 {
        self.master_velocity
    }

    /// Returns the slave's start values in the plan: ignored accelerations are 0.
    #[must_use]
    pub const fn slave_start(&self) -> &Kinematics {
        &self.slave_start
    }

    /// Returns the duration of the synchronisation phase: infinite while the master stands still.
    #[must_use]
    pub fn duration(&self) -> Seconds {
        match &self.profile {
            SawProfile::Nothing => Seconds(0.0),
            SawProfile::OverMaster(_) => {
                Seconds((self.line.master - self.master_start) / self.master_velocity)
            }
            SawProfile::OverTime(profile) => profile.duration(),
        }
    }

    /// Returns the master position at which the slave joins the synchronous line: before the end of the
    /// phase if the last piece is part of that line already.
    pub(super) fn joins_line_at(&self) -> f64 {
        match &self.profile {
            // In sync depends on the axis: on the line it is in sync, whatever is left of the plan.
            SawProfile::OverMaster(path) if self.ends_on_line(path) => path.last().begin,
            _ => self.line.master,
        }
    }

    fn ends_on_line(&self, path: &SlavePath) -> bool {
        let by_form = self.form == SawForm::QuinticLine;
        by_form || self.form == SawForm::JerkPhases && path.last().is_line()
    }

    /// Returns the slave and its derivatives with respect to a master position: along the profile within
    /// the synchronisation phase, along the synchronous line beyond it. None if the profile depends on
    /// time.
    #[must_use]
    pub fn over_master_at(&self, master: f64) -> Option<Motion> {
        // The direction of the plan, not of the master now, which may run back.
        let towards = self.line.master - self.master_start;
        let on_line = Motion {
            position: self.line.slave + self.line.ratio * (master - self.line.master),
            velocity: self.line.ratio,
            ..Motion::default()
        };
        match &self.profile {
            SawProfile::Nothing => Some(on_line),
            SawProfile::OverMaster(_) if (master - self.line.master) * towards >= 0.0 => {
                Some(on_line)
            }
            SawProfile::OverMaster(path) => Some(path.at(master)),
            SawProfile::OverTime(_) => None,
        }
    }

    /// Returns the set values of the slave for those of its master, if the profile depends on the
    /// master's position.
    pub(super) fn slave_of(&self, master: &Kinematics) -> Kinematics {
        let Some(motion) = self.over_master_at(master.position) else {
            return self.line.slave_of(master);
        };
        let (velocity, acceleration) = (master.velocity, master.acceleration);
        Kinematics {
            position: motion.position,
            velocity: motion.velocity * velocity,
            // Chain rule with the master's actual motion: a = s''·V² + s'·A.
            acceleration: motion.acceleration * velocity * velocity
                + motion.velocity * acceleration,
        }
    }

    /// True if there is nothing to synchronise.
    pub(super) fn is_synchronous(&self) -> bool {
        self.form == SawForm::Synchronous
    }

    /// Returns the slave at a time after the coupling moment, if the master keeps its velocity.
    #[must_use]
    pub fn at(&self, since_start: Seconds) -> Kinematics {
        let velocity = self.master_velocity;
        if let SawProfile::OverTime(profile) = &self.profile {
            return profile.at(since_start);
        }
        self.slave_of(&Kinematics {
            position: self.master_start + velocity * since_start.0,
            velocity,
            acceleration: 0.0,
        })
    }

    /// Returns the profile over time of a time-based plan.
    #[must_use]
    pub const fn time_profile(&self) -> Option<&Profile> {
        match &self.profile {
            SawProfile::OverTime(profile) => Some(profile),
            SawProfile::Nothing | SawProfile::OverMaster(_) => None,
        }
    }

    /// Returns the path, and the velocity of the variable it depends on: of the master, or of time.
    pub(super) fn path(&self) -> Option<(SlavePath, f64)> {
        match &self.profile {
            SawProfile::Nothing => None,
            SawProfile::OverMaster(path) => Some((*path, self.master_velocity)),
            SawProfile::OverTime(profile) => Some((over_time(profile)?, 1.0)),
        }
    }

    /// Returns the profile as segments of a cam, in ascending order of the master. A time-based plan has
    /// none.
    ///
    /// # Errors
    /// [`LawError`] if the master's path is so short that it vanishes in the last digit of its position.
    pub fn segments(&self) -> impl Iterator<Item = Result<Segment, LawError>> + '_ {
        let path = match &self.profile {
            SawProfile::OverMaster(path) => Some(path),
            SawProfile::Nothing | SawProfile::OverTime(_) => None,
        };
        let count = path.map_or(0, |path| path.pieces().count());
        // Segments ascend in the master, pieces follow its motion.
        let backward = self.line.master < self.master_start;
        (0..count).filter_map(move |i| {
            let nth = if backward { count - 1 - i } else { i };
            path?.pieces().nth(nth).map(segment)
        })
    }
}

fn segment(piece: &PathPiece) -> Result<Segment, LawError> {
    let knot = |master| Knot {
        master,
        motion: piece.at(master),
    };
    let law = piece.law();
    let (begin, end) = (knot(piece.begin), knot(piece.end()));
    if piece.length > 0.0 {
        Segment::new(law, &begin, &end)
    } else {
        Segment::new(law, &end, &begin)
    }
}

/// Returns the phases of a profile as pieces over time; none if its duration is zero.
pub(super) fn over_time(profile: &Profile) -> Option<SlavePath> {
    // Each phase ends where the next begins, the last one at the end of the profile.
    let ends = profile.phase_begins().skip(1).chain([profile.duration()]);
    let pieces = profile.phase_begins().zip(ends).map(|(begin, end)| {
        let state = profile.at(begin);
        let constants = (state.velocity, state.acceleration, profile.jerk_at(begin));
        PathPiece::phase(begin.0, end.0 - begin.0, state.position, constants)
    });
    pieces
        .map(SlavePath::of)
        .reduce(|path, next| path.then(*next.first()))
}
