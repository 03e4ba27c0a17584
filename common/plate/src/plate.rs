//! A cam plate: a motion function or a position table, passed once or repeated.

use core::ops::Range;

use super::curve_peaks::CurvePeaks;
use super::error::CamError;
use super::function::MotionFunction;
use super::kind::{Course, TableType};
use super::point::MotionPoint;
use super::table::{Interpolation, PositionTable};
use coaxle_curve::curve::Curve;
use coaxle_curve::law::Motion;
use coaxle_curve::profile::Kinematics;

/// A cam plate, ready to be evaluated: loaded by `MC_CamTableSelect`.
///
/// Masters are in master units (x), slaves in slave units (u), both raw: without a coupling's
/// offsets and scalings.
#[doc(alias = "MC_CAM_REF")]
#[derive(Clone, Debug)]
pub struct Plate {
    source: PlateForm,
    course: Course,
    lift: f64,
}

#[derive(Clone, Debug)]
enum PlateForm {
    Function(MotionFunction),
    Table(PositionTable),
}

/// Place of the last evaluation of a plate, so that the next one near by is quick. Any cursor is valid
/// for any plate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cursor {
    segment: usize,
    turn: f64,
}

impl Cursor {
    /// Returns the number of cycles of the plate: 0 in the base cycle, negative below it. Always 0 on a
    /// linear plate.
    #[must_use]
    pub const fn turn(&self) -> f64 {
        self.turn
    }
}

impl Plate {
    /// Makes a plate from a motion function.
    #[must_use]
    pub fn from_function(function: MotionFunction, course: Course) -> Self {
        Self {
            // First and last point are never ignored ones, so they are the ends of the course.
            lift: lift_of_points(function.points()),
            source: PlateForm::Function(function),
            course,
        }
    }

    /// Makes a plate from a position table, with the table's course.
    #[must_use]
    pub fn from_table(table: PositionTable) -> Self {
        Self {
            lift: lift_of_rows(table.rows()),
            course: table.course(),
            source: PlateForm::Table(table),
        }
    }

    /// Returns the type of the plate.
    #[must_use]
    pub const fn table_type(&self) -> TableType {
        match &self.source {
            PlateForm::Function(_) => TableType::MotionFunction,
            PlateForm::Table(table) => table.table_type(),
        }
    }

    /// Returns the course: passed once or repeated.
    #[must_use]
    pub const fn course(&self) -> Course {
        self.course
    }

    /// Returns the motion function it is made from, if any.
    #[must_use]
    pub const fn function(&self) -> Option<&MotionFunction> {
        match &self.source {
            PlateForm::Function(function) => Some(function),
            PlateForm::Table(_) => None,
        }
    }

    /// Returns the position table it is made from, if any.
    #[must_use]
    pub const fn table(&self) -> Option<&PositionTable> {
        match &self.source {
            PlateForm::Function(_) => None,
            PlateForm::Table(table) => Some(table),
        }
    }

    /// Returns the interpolation of a position table, the PLC's default for a motion function.
    #[must_use]
    pub fn interpolation(&self) -> Interpolation {
        self.table()
            .map_or_else(Interpolation::default, PositionTable::interpolation)
    }

    /// Returns the number of its rows or points, ignored ones included.
    #[must_use]
    pub fn rows(&self) -> usize {
        match &self.source {
            PlateForm::Function(function) => function.points().len(),
            PlateForm::Table(table) => table.rows().len(),
        }
    }

    /// Returns the number of its columns: 1 for a motion function, 2 for a position table.
    #[must_use]
    pub const fn columns(&self) -> usize {
        match self.source {
            PlateForm::Function(_) => 1,
            PlateForm::Table(_) => 2,
        }
    }

    /// Returns the first and the last master position of the base cycle, x.
    #[must_use]
    pub fn master_range(&self) -> (f64, f64) {
        (self.curve().start(), self.curve().end())
    }

    /// Returns the master's distance from the first to the last position, x.
    #[must_use]
    pub fn period(&self) -> f64 {
        let (start, end) = self.master_range();
        end - start
    }

    /// Returns the slave's distance from the first to the last position, u; 0 if it is within rounding.
    #[must_use]
    pub const fn lift(&self) -> f64 {
        self.lift
    }

    /// Returns the motion at any master position, x.
    #[must_use]
    pub fn at(&self, master: f64) -> Motion {
        match self.course {
            // Outside its range the law must not be asked: a polynomial continued beyond its ends runs away.
            Course::Linear => self.held(master).unwrap_or_else(|| self.curve().at(master)),
            Course::Cyclic => {
                let turn = self.turn_of(master);
                self.lifted(self.curve().at(self.base_master(turn, master)), turn)
            }
        }
    }

    /// Returns exactly the result of [`Self::at`], quicker the nearer it is to the last place.
    #[must_use]
    pub fn along(&self, cursor: &mut Cursor, master: f64) -> Motion {
        match self.course {
            // A cursor may come from a cyclic plate, and its turn would add a lift here.
            Course::Linear => {
                cursor.turn = 0.0;
                self.held(master)
                    .unwrap_or_else(|| self.curve().along(&mut cursor.segment, master))
            }
            Course::Cyclic => {
                // Mostly the turn of the last cycle is right, and saves a division.
                if !self.is_in_turn(cursor.turn, master) {
                    cursor.turn = self.turn_of(master);
                }
                let base = self.base_master(cursor.turn, master);
                let motion = self.curve().along(&mut cursor.segment, base);
                self.lifted(motion, cursor.turn)
            }
        }
    }

    /// `MC_ReadCamTableSlaveDynamics`: the slave's set values for those of the master.
    ///
    /// For a master velocity of 1 and no acceleration these are the plate's own derivatives. Unlike the
    /// original, position tables give velocity and acceleration too.
    #[doc(alias = "MC_ReadCamTableSlaveDynamics")]
    #[must_use]
    pub fn slave_dynamics(&self, master: &Kinematics) -> Kinematics {
        slave_of(&self.at(master.position), master)
    }

    /// Returns the number of whole cycles between the base cycle and a master position: 0 on a linear
    /// plate.
    #[must_use]
    pub fn turn(&self, master: f64) -> f64 {
        match self.course {
            Course::Linear => 0.0,
            Course::Cyclic => self.turn_of(master),
        }
    }

    /// Copies another plate. Nothing is allocated if both are motion functions with equal numbers of
    /// points.
    pub fn copy_from(&mut self, other: &Self) {
        match (&mut self.source, &other.source) {
            (PlateForm::Function(function), PlateForm::Function(other)) => {
                function.copy_from(other)
            }
            // Tables have any number of rows, so only motion functions can be copied into the present memory.
            (source, other) => *source = other.clone(),
        }
        self.course = other.course;
        self.lift = other.lift;
    }

    /// Runs [`MotionFunction::change`] in the plate; then period and lift are those of the new points.
    ///
    /// # Errors
    /// As there, and 0x4262 for a position table.
    pub fn change(&mut self, points: &[MotionPoint]) -> Result<(), CamError> {
        // Lift after the change: a refused change leaves the lift as it was.
        let function = self.function_mut()?;
        function.change(points)?;
        self.lift = lift_of_points(function.points());
        Ok(())
    }

    /// Runs [`MotionFunction::check_change`] in the plate.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn check_change(&self, points: &[MotionPoint]) -> Result<(), CamError> {
        let received = self.table_type();
        let function = self
            .function()
            .ok_or(CamError::NotAMotionFunction { received })?;
        function.check_change(points)
    }

    /// Runs [`MotionFunction::segments_changed`] in the plate, in masters of the base cycle. A cyclic
    /// plate changes as a whole if its period or lift would, since every turn but the first moves.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn segments_changed(&mut self, points: &[MotionPoint]) -> Result<Range<f64>, CamError> {
        let (course, lift) = (self.course, self.lift);
        let function = self.function_mut()?;
        let changed = function.segments_changed(points)?;
        let same_lift = lift == lift_of_points(function.staged_points());
        let range = |curve: &Curve| (curve.start(), curve.end());
        let (old, new) = (range(function.curve()), range(function.staged_curve()));
        // A period or lift that differs moves all turns but the first, however small the edited segment.
        if course == Course::Linear || old == new && same_lift {
            Ok(changed)
        } else {
            // The union of both ranges: a slave may be on the old plate beyond the end of the new one.
            Ok(old.0.min(new.0)..old.1.max(new.1))
        }
    }

    pub(super) fn curve(&self) -> &Curve {
        match &self.source {
            PlateForm::Function(function) => function.curve(),
            PlateForm::Table(table) => table.curve(),
        }
    }

    pub(super) const fn curve_peaks(&self) -> &CurvePeaks {
        match &self.source {
            PlateForm::Function(function) => function.peaks(),
            PlateForm::Table(table) => table.peaks(),
        }
    }

    /// Adds the lift of a turn to the position.
    fn lifted(&self, motion: Motion, turn: f64) -> Motion {
        Motion {
            // A product instead of a sum over the turns: rounding does not grow with the turns passed.
            position: motion.position + turn * self.lift,
            ..motion
        }
    }

    fn function_mut(&mut self) -> Result<&mut MotionFunction, CamError> {
        match &mut self.source {
            PlateForm::Function(function) => Ok(function),
            PlateForm::Table(table) => Err(CamError::NotAMotionFunction {
                received: table.table_type(),
            }),
        }
    }

    /// Returns the motion outside the range of a linear plate: the slave stands at the edge.
    fn held(&self, master: f64) -> Option<Motion> {
        let (start, end) = self.master_range();
        // NaN is neither below nor above, so it reaches the curve and comes out as NaN.
        let edge = if master < start {
            start
        } else if master > end {
            end
        } else {
            return None;
        };
        Some(Motion {
            // The law's own value, not the point's: entering the range must not step by a rounding of the law.
            position: self.curve().at(edge).position,
            ..Motion::default()
        })
    }

    /// Returns the turn of a master position. One correction compensates rounding, so that
    /// [`Self::is_in_turn`] agrees.
    fn turn_of(&self, master: f64) -> f64 {
        let (start, end) = self.master_range();
        // The quotient is rounded, and start + turn·period is rounded otherwise.
        // At the edge of a turn both may disagree by one turn, though never by more.
        let guess = libm::floor((master - start) / (end - start));
        if master < self.turn_start(guess) {
            guess - 1.0
        } else if master >= self.turn_start(guess + 1.0) {
            guess + 1.0
        } else {
            guess
        }
    }

    fn is_in_turn(&self, turn: f64, master: f64) -> bool {
        // Half open: the end of a turn is the start of the next one, as in the curve's own segments.
        self.turn_start(turn) <= master && master < self.turn_start(turn + 1.0)
    }

    fn turn_start(&self, turn: f64) -> f64 {
        let (start, end) = self.master_range();
        // A single expression gives the end of a turn and the start of the next: no master lies between two turns.
        start + turn * (end - start)
    }

    /// Returns the corresponding place in the base cycle. Far out a master has few digits left, so it may
    /// miss the range by its rounding.
    fn base_master(&self, turn: f64, master: f64) -> f64 {
        let (start, end) = self.master_range();
        // No remainder function: fmod takes the sign of the master, and turns below 0 would need a second case.
        // Start is below end for each compiled plate, so the clamp cannot panic.
        (master - turn * (end - start)).clamp(start, end)
    }
}

/// Returns the set values of the slave for a moving master, by the chain rule: v = f'·V, a = f''·V² +
/// f'·A.
#[must_use]
pub fn slave_of(cam: &Motion, master: &Kinematics) -> Kinematics {
    Kinematics {
        position: cam.position,
        velocity: cam.velocity * master.velocity,
        // Derivative of f'(x)·V over time: f''·V·V and, by the product rule, f'·A.
        acceleration: cam.acceleration * master.velocity * master.velocity
            + cam.velocity * master.acceleration,
    }
}

/// Returns the lift from the positions of the ends themselves: a segment meets its end only to the last
/// few bits, which would add up over the turns.
fn lift_of(first: f64, last: f64) -> f64 {
    let lift = last - first;
    // Start and end of a plate without lift may be written differently, as 0.3 and 0.1 + 0.2 are.
    let rounding = 8.0 * f64::EPSILON * first.abs().max(last.abs());
    if lift.abs() <= rounding { 0.0 } else { lift }
}

fn lift_of_points(points: &[MotionPoint]) -> f64 {
    let slave = |row: usize| points[row].slave;
    lift_of(slave(0), slave(points.len() - 1))
}

fn lift_of_rows(rows: &[(f64, f64)]) -> f64 {
    let slave = |row: usize| rows[row].1;
    lift_of(slave(0), slave(rows.len() - 1))
}
