//! `MC_ReadMotionFunctionValues`: a plate as a table of interpolated values.

use bitflags::bitflags;

use super::error::CamError;
use super::plate::{Cursor, Plate};
use coaxle_curve::law::Motion;

bitflags! {
    /// `MC_ValueSelectType`, TF5050 chapter 8.14: the columns of a table of values beside the master.
    #[doc(alias = "MC_ValueSelectType")]
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct ValueSelect: u16 {
        /// The slave's position, u.
        #[doc(alias = "MC_VALUETYPE_POSITION")]
        const POSITION = 1;
        /// The slave's velocity, u/x.
        #[doc(alias = "MC_VALUETYPE_VELOCITY")]
        const VELOCITY = 2;
        /// The slave's acceleration, u/x².
        #[doc(alias = "MC_VALUETYPE_ACCELERATION")]
        const ACCELERATION = 4;
        /// The slave's jerk, u/x³.
        #[doc(alias = "MC_VALUETYPE_JERK")]
        const JERK = 8;
    }
}

/// A row of such a table: the master, then the selected values in the order of their bits. Dereferences
/// to a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueRow {
    columns: [f64; 5],
    len: usize,
}

impl core::ops::Deref for ValueRow {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.columns[..self.len]
    }
}

/// Least distance from the end, in increments, within which a grid point is at the end.
// 0.3 / 0.1 is 2.9999999999999996, so without a tolerance the last row would be missing.
const END_TOLERANCE: f64 = 1e-9;

/// Greatest such distance: beyond it the next grid point is nearer.
const NEAREST: f64 = 0.5;

/// Greatest number of rows: more than can be read are a mistyped increment.
// Ten million rows with all five columns are 400 MB.
const MOST_ROWS: f64 = 1e7;

impl Plate {
    /// `MC_ReadMotionFunctionValues`: the values at `from`, and each `increment` further up to `to`, all
    /// in x. The increment has the sign of the direction. If `to` is not a whole number of increments
    /// away, the last row is the one before it.
    ///
    /// The masters may lie anywhere, over several cycles too, and the plate may be of any type.
    ///
    /// # Errors
    /// 0x4B37 if no column is selected, 0x4B38 for an increment that is 0 or leads away from `to`, 0x4A1C
    /// for an end that is not finite.
    #[doc(alias = "MC_ReadMotionFunctionValues")]
    pub fn values(
        &self,
        from: f64,
        to: f64,
        increment: f64,
        select: ValueSelect,
    ) -> Result<impl Iterator<Item = ValueRow> + '_, CamError> {
        check_select(select)?;
        let tolerance = end_tolerance(from, to, increment);
        let rows = count_rows(from, to, increment)?;
        let mut cursor = Cursor::default();
        Ok((0..rows).map(move |row| {
            // Product instead of a running sum, whose rounding would grow with the rows.
            let along = row as f64 * increment;
            let at_end =
                row + 1 == rows && (to - from - along).abs() <= tolerance * increment.abs();
            // Exactly `to`, since a linear plate holds the slave at standstill one bit beyond its edge.
            let master = if at_end { to } else { from + along };
            row_of(master, &self.along(&mut cursor, master), select)
        }))
    }
}

fn check_select(select: ValueSelect) -> Result<(), CamError> {
    // An unknown bit is a column that the client expects and would not get.
    if select.is_empty() || !ValueSelect::all().contains(select) {
        return Err(CamError::NoColumns {
            received: select.bits(),
        });
    }
    Ok(())
}

fn count_rows(from: f64, to: f64, increment: f64) -> Result<u64, CamError> {
    for (name, received) in [("start position", from), ("end position", to)] {
        if !received.is_finite() {
            return Err(CamError::Parameter {
                name,
                received,
                expected: "a finite number",
            });
        }
    }
    let distance = to - from;
    let increments = distance / increment;
    // NaN if the increment is, or if both are 0; infinite if only the increment is 0.
    // A quotient below 0 is an increment in the wrong direction.
    // -0.0, of equal ends, is in the range and gives one row.
    if !(increment.is_finite() && (0.0..MOST_ROWS).contains(&increments)) {
        return Err(CamError::Increment {
            received: increment,
            distance,
        });
    }
    // Fence posts: n increments have n + 1 rows.
    Ok(libm::floor(increments + end_tolerance(from, to, increment)) as u64 + 1)
}

/// Returns the distance from the end, in increments, within which a grid point is at the end.
fn end_tolerance(from: f64, to: f64, increment: f64) -> f64 {
    // Each is rounded by half an epsilon: both ends as written, and of the distance between them the
    // subtraction, the increment and the quotient. The distance is at most |from| + |to|, so 2 epsilons cover all.
    let rounding = 2.0 * f64::EPSILON * (from.abs() + to.abs()) / increment.abs();
    rounding.clamp(END_TOLERANCE, NEAREST)
}

fn row_of(master: f64, motion: &Motion, select: ValueSelect) -> ValueRow {
    let mut row = ValueRow {
        columns: [master, 0.0, 0.0, 0.0, 0.0],
        len: 1,
    };
    let values = [
        (ValueSelect::POSITION, motion.position),
        (ValueSelect::VELOCITY, motion.velocity),
        (ValueSelect::ACCELERATION, motion.acceleration),
        (ValueSelect::JERK, motion.jerk),
    ];
    for (column, value) in values {
        if select.contains(column) {
            row.columns[row.len] = value;
            row.len += 1;
        }
    }
    row
}
