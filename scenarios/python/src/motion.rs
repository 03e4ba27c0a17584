//! Laws, cam plates and saws, calculated.

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use coaxle_clock::Seconds;
use coaxle_curve::law::{Knot, Motion, MotionLaw, Segment};
use coaxle_files::cam::CamFile;
use coaxle_files::saw::SawFile;
use coaxle_plate::Cursor;
use coaxle_wire::command::CharacteristicFigures;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::columns::{f64s, numbers};
use crate::error::{told, wrong};

/// Position, velocity, acceleration, jerk: a column each.
type Columns<'py> = [Bound<'py, PyBytes>; 4];

fn columns<'py>(py: Python<'py>, motions: &[Motion]) -> Columns<'py> {
    let column = |of: fn(&Motion) -> f64| {
        let all: Vec<f64> = motions.iter().map(of).collect();
        f64s(py, &all)
    };
    [
        column(|motion| motion.position),
        column(|motion| motion.velocity),
        column(|motion| motion.acceleration),
        column(|motion| motion.jerk),
    ]
}

/// The names of the motion laws, each with its number in TF5050.
#[pyfunction]
pub(crate) fn laws() -> PyResult<Vec<(String, u16)>> {
    let named = |law: &MotionLaw| {
        // The name as in files, which serde alone knows.
        let name = serde_json::to_value(law)?;
        Ok((name.as_str().unwrap_or_default().to_owned(), law.code()))
    };
    let all = MotionLaw::ALL.iter().map(named);
    all.collect::<serde_json::Result<_>>().map_err(told)
}

/// A motion law between two points, each with master, position, velocity, acceleration.
#[pyclass(module = "coaxle")]
pub(crate) struct Law(Segment);

#[pymethods]
impl Law {
    #[new]
    fn new(name: &str, start: [f64; 4], end: [f64; 4]) -> PyResult<Self> {
        let law: MotionLaw = serde_json::from_value(name.into()).map_err(|_| {
            let known = laws().unwrap_or_default();
            let known: Vec<_> = known.iter().map(|(name, _)| name.as_str()).collect();
            let hint = coaxle_node::config::did_you_mean(name, known.iter().copied());
            wrong(format!(
                "law: received {name:?}, expected one of {}{hint}",
                known.join(", ")
            ))
        })?;
        Segment::new(law, &knot(start), &knot(end))
            .map(Self)
            .map_err(wrong)
    }

    /// Motion at each of these masters; beyond its ends the formula continues.
    fn at<'py>(&self, py: Python<'py>, masters: &[u8]) -> PyResult<Columns<'py>> {
        let masters = numbers(masters)?;
        let motions: Vec<_> = masters.iter().map(|master| self.0.at(*master)).collect();
        Ok(columns(py, &motions))
    }

    /// The smallest and the largest value of position, velocity, acceleration, jerk, each with its master position.
    fn extremes(&self) -> [[(f64, f64); 2]; 4] {
        let all = self.0.extremes();
        [all.position, all.velocity, all.acceleration, all.jerk].map(|of| {
            [
                (of.minimum.value, of.minimum.master),
                (of.maximum.value, of.maximum.master),
            ]
        })
    }
}

fn knot([master, position, velocity, acceleration]: [f64; 4]) -> Knot {
    Knot {
        master,
        motion: Motion {
            position,
            velocity,
            acceleration,
            jerk: 0.0,
        },
    }
}

/// A cam plate: `coaxle_plate::Plate` of a cam file.
#[pyclass(module = "coaxle")]
pub(crate) struct Plate {
    file: CamFile,
    /// Locked for one thread at a time.
    plate: Mutex<coaxle_plate::Plate>,
}

#[pymethods]
impl Plate {
    /// The plate of a cam file's text; `path` is its name in errors, and a CSV file is read from its folder.
    #[new]
    fn new(path: &str, text: &str) -> PyResult<Self> {
        let file = CamFile::parse(Path::new(path), text).map_err(told)?;
        let plate = file.plate().map_err(told)?;
        Ok(Self {
            file,
            plate: Mutex::new(plate),
        })
    }

    /// Title, unit of the master, unit of the slave.
    fn facts(&self) -> (&str, &str, &str) {
        (
            &self.file.title,
            &self.file.master_unit,
            &self.file.slave_unit,
        )
    }

    /// First and last master position.
    fn master_range(&self) -> (f64, f64) {
        self.plate().master_range()
    }

    /// Motion at each of these masters.
    fn at<'py>(&self, py: Python<'py>, masters: &[u8]) -> PyResult<Columns<'py>> {
        let masters = numbers(masters)?;
        // A cursor remembers the segment: masters in order need no search.
        let (plate, mut cursor) = (self.plate(), Cursor::default());
        let motions = masters
            .iter()
            .map(|master| plate.along(&mut cursor, *master));
        let motions: Vec<_> = motions.collect();
        Ok(columns(py, &motions))
    }

    /// The masters at which the slave is at a position, over one turn.
    fn masters_at(&self, position: f64) -> Vec<f64> {
        self.plate().masters_at(position).collect()
    }

    /// Characteristic values at a velocity of the master, x/s: JSON, as in the response to an order.
    fn characteristics(&self, master_velocity: f64) -> PyResult<String> {
        let plate = self.plate();
        let found = plate.characteristics(master_velocity).map_err(wrong)?;
        // 0 is no table: a file need not name one.
        let table = self.file.table_id.map_or(0, |id| id.get().into());
        let figures = CharacteristicFigures::of(table, &plate, &found);
        serde_json::to_string(&figures).map_err(told)
    }
}

impl Plate {
    fn plate(&self) -> MutexGuard<'_, coaxle_plate::Plate> {
        self.plate.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The plan of a saw file.
#[pyclass(module = "coaxle")]
pub(crate) struct SawPlan {
    file: SawFile,
    plan: coaxle_saw::SawPlan,
}

#[pymethods]
impl SawPlan {
    /// The plan of a saw file's text; `file` is its name in errors. A refusal of the command is an error.
    #[new]
    fn new(file: &str, text: &str) -> PyResult<Self> {
        let saw = SawFile::parse(file, text).map_err(told)?;
        let plan = saw.plan().map_err(|refusal| {
            let code = refusal.code();
            wrong(format!("{file}: refused, 0x{code:04X}: {refusal}"))
        })?;
        Ok(Self { file: saw, plan })
    }

    /// Title, unit of the master, unit of the slave.
    fn facts(&self) -> (&str, &str, &str) {
        (
            &self.file.title,
            &self.file.master_unit,
            &self.file.slave_unit,
        )
    }

    /// Properties of the whole plan.
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let outline = PyDict::new(py);
        let plan = &self.plan;
        outline.set_item("form", format!("{:?}", plan.form()))?;
        outline.set_item("duration_s", plan.duration().0)?;
        outline.set_item("master_start", plan.master_start())?;
        outline.set_item("master_end", plan.master_end())?;
        outline.set_item("master_velocity", plan.master_velocity())?;
        Ok(outline)
    }

    /// The slave at each of these times since the coupling moment, s: position, velocity, acceleration.
    fn at<'py>(&self, py: Python<'py>, times_s: &[u8]) -> PyResult<[Bound<'py, PyBytes>; 3]> {
        let times = numbers(times_s)?;
        let slaves: Vec<_> = times
            .iter()
            .map(|time| self.plan.at(Seconds(*time)))
            .collect();
        let column = |of: fn(&coaxle_curve::profile::Kinematics) -> f64| {
            let all: Vec<f64> = slaves.iter().map(of).collect();
            f64s(py, &all)
        };
        Ok([
            column(|slave| slave.position),
            column(|slave| slave.velocity),
            column(|slave| slave.acceleration),
        ])
    }
}
