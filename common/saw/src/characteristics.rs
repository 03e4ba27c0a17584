//! `MC_ReadFlyingSawCharacteristics`: the demands of a synchronisation phase on the slave.

use alloc::vec::Vec;

use coaxle_curve::law::{Extreme, Extremes, MinMax, Motion, MotionLaw};
use coaxle_plate::{CamError, MotionFunction, MotionPoint, PointType, TableType};

use super::path_piece::PathPiece;
use super::plan::SawPlan;
use super::refusal::SawRefusal;
use super::slave_path::SlavePath;

/// `MC_FlyingSawCharacValues`, TS5055 12.3.2, TF5055 5.3: the synchronisation phase of a master
/// that keeps its velocity.
///
/// Positions are in u, the rest in u/s, u/s² and u/s³. Where a derivative jumps, its values on both sides
/// count; of equal extremes, the first place is reported. While the master stands still, all velocities
/// are 0.
#[doc(alias = "MC_FlyingSawCharacValues")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyingSawCharacteristics {
    /// The master's velocity at the coupling moment.
    #[doc(alias = "fMasterVeloNom")]
    pub master_velocity: f64,
    /// The start of the phase.
    pub start: SawEnd,
    /// The end of the phase.
    pub end: SawEnd,
    /// Minima and maxima of position, velocity, acceleration and jerk, with their places.
    pub extremes: Extremes,
    /// The slave's velocity at its minimum acceleration.
    #[doc(alias = "fSVeloAtSAccMin")]
    pub velocity_at_minimum_acceleration: f64,
    /// The slave's velocity at its maximum acceleration.
    #[doc(alias = "fSVeloAtSAccMax")]
    pub velocity_at_maximum_acceleration: f64,
    /// The minimum and maximum product of velocity and acceleration, u²/s³. The original leaves it out.
    #[doc(alias = "fSlaveDynMomMin")]
    #[doc(alias = "fSlaveDynMomMax")]
    pub dynamic_moment: MinMax,
    /// The mean of the velocity's magnitude. The original leaves it out.
    #[doc(alias = "fSlaveVeloMean")]
    pub mean_velocity: f64,
    /// The root of the mean square of the acceleration. The original leaves it out.
    #[doc(alias = "fSlaveAccEff")]
    pub effective_acceleration: f64,
    /// The header of the table that holds the profile.
    pub table: SawTable,
}

/// End or start of the synchronisation phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SawEnd {
    /// Position of the master.
    #[doc(alias = "fMasterPosStart")]
    #[doc(alias = "fMasterPosEnd")]
    pub master: f64,
    /// Position of the slave and its derivatives over time, on the phase's side.
    pub slave: Motion,
}

/// The table that holds the profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub struct SawTable {
    /// Id of the table.
    #[doc(alias = "CamTableID")]
    pub id: u32,
    /// Number of its points; none if there is nothing to synchronise.
    #[doc(alias = "NumberOfRows")]
    pub rows: usize,
    /// Number of its columns.
    #[doc(alias = "NumberOfColumns")]
    pub columns: usize,
    /// Motion function.
    #[doc(alias = "TableType")]
    pub table_type: TableType,
    /// False: never periodic.
    #[doc(alias = "Periodic")]
    pub periodic: bool,
}

/// Returns the id of the table that holds a slave's profile: 256 − axis id (TS5055 13).
///
/// # Errors
/// [`SawRefusal::NoTable`] (0x4A00) for an axis id that is not from 1 to 255, and
/// [`SawRefusal::TableInUse`] (0x4063) if `in_use` is true for the id.
pub fn saw_table_id(axis_id: u32, in_use: impl FnOnce(u32) -> bool) -> Result<u32, SawRefusal> {
    if !(1..=255).contains(&axis_id) {
        return Err(SawRefusal::NoTable { axis_id });
    }
    let table = 256 - axis_id;
    if in_use(table) {
        return Err(SawRefusal::TableInUse { table });
    }
    Ok(table)
}

impl FlyingSawCharacteristics {
    /// The names of the 31 values in the structure.
    pub const NAMES: [&str; 31] = [
        "fMasterVeloNom",
        "fMasterPosStart",
        "fSlavePosStart",
        "fSlaveVeloStart",
        "fSlaveAccStart",
        "fSlaveJerkStart",
        "fMasterPosEnd",
        "fSlavePosEnd",
        "fSlaveVeloEnd",
        "fSlaveAccEnd",
        "fSlaveJerkEnd",
        "fMPosAtSPosMin",
        "fSlavePosMin",
        "fMPosAtSVeloMin",
        "fSlaveVeloMin",
        "fMPosAtSAccMin",
        "fSlaveAccMin",
        "fSVeloAtSAccMin",
        "fSlaveJerkMin",
        "fSlaveDynMomMin",
        "fMPosAtSPosMax",
        "fSlavePosMax",
        "fMPosAtSVeloMax",
        "fSlaveVeloMax",
        "fMPosAtSAccMax",
        "fSlaveAccMax",
        "fSVeloAtSAccMax",
        "fSlaveJerkMax",
        "fSlaveDynMomMax",
        "fSlaveVeloMean",
        "fSlaveAccEff",
    ];

    /// Returns the 31 values in the order of the structure.
    #[must_use]
    pub fn values(&self) -> [f64; 31] {
        let Extremes {
            position,
            velocity,
            acceleration,
            jerk,
        } = self.extremes;
        let (start, end) = (self.start.slave, self.end.slave);
        let moment = self.dynamic_moment;
        [
            self.master_velocity,
            self.start.master,
            start.position,
            start.velocity,
            start.acceleration,
            start.jerk,
            self.end.master,
            end.position,
            end.velocity,
            end.acceleration,
            end.jerk,
            position.minimum.master,
            position.minimum.value,
            velocity.minimum.master,
            velocity.minimum.value,
            acceleration.minimum.master,
            acceleration.minimum.value,
            self.velocity_at_minimum_acceleration,
            jerk.minimum.value,
            moment.minimum.value,
            position.maximum.master,
            position.maximum.value,
            velocity.maximum.master,
            velocity.maximum.value,
            acceleration.maximum.master,
            acceleration.maximum.value,
            self.velocity_at_maximum_acceleration,
            jerk.maximum.value,
            moment.maximum.value,
            self.mean_velocity,
            self.effective_acceleration,
        ]
    }
}

impl SawPlan {
    /// Returns the characteristic values, for the table with this id.
    #[doc(alias = "MC_ReadFlyingSawCharacteristics")]
    #[must_use]
    pub fn characteristics(&self, table_id: u32) -> FlyingSawCharacteristics {
        match self.path() {
            Some((path, velocity)) => self.characteristics_of(&path, velocity, table_id),
            None => self.characteristics_of_nothing(table_id),
        }
    }

    /// Computes the characteristic values. `velocity` is the velocity of the variable that the path
    /// depends on: the master or the time.
    fn characteristics_of(
        &self,
        path: &SlavePath,
        velocity: f64,
        table_id: u32,
    ) -> FlyingSawCharacteristics {
        let demands = path.demands(velocity);
        let (first, last) = (path.first(), path.last());
        // Derivatives over the path times its velocity: 1 for a path over time.
        let velocity_at = |extreme: Extreme| path.at(extreme.master).velocity * velocity;
        let acceleration = demands.course.acceleration;
        let moment = path
            .pieces()
            .skip(1)
            .map(|piece| piece.dynamic_moment(velocity))
            .fold(first.dynamic_moment(velocity), MinMax::joined);
        let distance: f64 = path.pieces().map(PathPiece::path).sum();
        let squares = path
            .pieces()
            .map(|piece| piece.squared_acceleration(velocity));
        // Infinite for a standing master, so that both means below are 0.
        let duration = self.duration().0;

        let place = |at: f64| {
            // Extremes have the time as their place then. The structure has the master's position.
            if self.time_profile().is_some() {
                self.master_start() + self.master_velocity() * at
            } else {
                at
            }
        };
        let line = self.line();
        FlyingSawCharacteristics {
            master_velocity: self.master_velocity(),
            start: SawEnd {
                master: self.master_start(),
                slave: over_time(&first.at(first.begin), velocity),
            },
            end: SawEnd {
                master: line.master,
                slave: Motion {
                    position: line.slave,
                    velocity: line.ratio * self.master_velocity(),
                    acceleration: 0.0,
                    // On the side of the phase; on the line behind it the jerk is 0.
                    jerk: over_time(&last.at(last.end()), velocity).jerk,
                },
            },
            velocity_at_minimum_acceleration: velocity_at(acceleration.minimum),
            velocity_at_maximum_acceleration: velocity_at(acceleration.maximum),
            dynamic_moment: moment,
            mean_velocity: distance / duration,
            effective_acceleration: libm::sqrt(squares.sum::<f64>() / duration),
            extremes: demands.with_places(place).course,
            table: table(table_id, path.pieces().count() + 1),
        }
    }

    fn characteristics_of_nothing(&self, table_id: u32) -> FlyingSawCharacteristics {
        let line = self.line();
        let velocity = line.ratio * self.master_velocity();
        let end = SawEnd {
            master: line.master,
            slave: Motion {
                position: line.slave,
                velocity,
                ..Motion::default()
            },
        };
        let only = |value| MinMax::at(line.master, value);
        FlyingSawCharacteristics {
            master_velocity: self.master_velocity(),
            start: end,
            end,
            extremes: Extremes {
                position: only(line.slave),
                velocity: only(velocity),
                acceleration: only(0.0),
                jerk: only(0.0),
            },
            velocity_at_minimum_acceleration: velocity,
            velocity_at_maximum_acceleration: velocity,
            dynamic_moment: only(0.0),
            mean_velocity: velocity.abs(),
            effective_acceleration: 0.0,
            table: table(table_id, 0),
        }
    }

    /// Returns the profile as the points of a motion function, in ascending order of the master; none for
    /// a time-based plan, which does not depend on it.
    #[must_use]
    pub fn motion_points(&self) -> Vec<MotionPoint> {
        let Some((path, _)) = self.path().filter(|_| self.time_profile().is_none()) else {
            return Vec::new();
        };
        let begins = path.pieces().map(|piece| (piece.begin, piece));
        let end = (path.last().end(), path.last());
        let mut knots: Vec<(f64, &PathPiece)> = begins.chain([end]).collect();
        // A table ascends, whichever way the master runs.
        let backward = path.last().length < 0.0;
        if backward {
            knots.reverse();
        }
        let pieces: Vec<&PathPiece> = if backward {
            path.pieces().rev().collect()
        } else {
            path.pieces().collect()
        };
        let laws = pieces.iter().map(|piece| piece.law());
        // The last point's law leads nowhere.
        let laws = laws.chain([MotionLaw::Polynom1]);
        knots
            .iter()
            .zip(laws)
            .zip(1..)
            .map(|((&(master, piece), law), index)| point(index, law, master, &piece.at(master)))
            .collect()
    }

    /// Returns the profile as a motion function, as a cam coupling would run it.
    ///
    /// # Errors
    /// [`CamError`] if there are no points, or if the master's path is so short that it vanishes in the
    /// last digit of its position.
    pub fn motion_function(&self) -> Result<MotionFunction, CamError> {
        MotionFunction::new(self.motion_points())
    }
}

fn point(index: u32, law: MotionLaw, master: f64, motion: &Motion) -> MotionPoint {
    MotionPoint {
        index,
        function: law,
        point_type: PointType::Motion,
        // Each point leads to the next one; no point is skipped.
        relative_next: 1,
        master,
        slave: motion.position,
        velocity: motion.velocity,
        acceleration: motion.acceleration,
        jerk: motion.jerk,
    }
}

fn table(id: u32, rows: usize) -> SawTable {
    SawTable {
        id,
        rows,
        columns: 1,
        table_type: TableType::MotionFunction,
        periodic: false,
    }
}

fn over_time(motion: &Motion, velocity: f64) -> Motion {
    Motion {
        position: motion.position,
        velocity: motion.velocity * velocity,
        // Without s'·a_master, since the values assume a master that keeps its velocity.
        acceleration: motion.acceleration * velocity * velocity,
        jerk: motion.jerk * velocity * velocity * velocity,
    }
}
