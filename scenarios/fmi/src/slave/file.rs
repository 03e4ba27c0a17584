//! The file of a slave: a saw, gear or cam file, by what is in it.

use std::path::Path;

use coaxle_cam::CamIn;
use coaxle_curve::profile::Limits;
use coaxle_files::cam::CamFile;
use coaxle_files::gear::GearFile;
use coaxle_files::saw::SawFile;
use coaxle_gear::FlyingGearParameters;
use coaxle_node::config::{Unit, Wrong, parse_table};
use coaxle_plate::Plate;
use coaxle_saw::SawCommand;
use coaxle_slave::SlaveParameters;

/// Content of a slave's file.
#[derive(Clone, Debug)]
pub(super) struct SlaveFile {
    pub(super) title: String,
    pub(super) master_unit: Unit,
    pub(super) unit: Unit,
    pub(super) limits: SlaveParameters,
    /// Position and velocity at which it waits for its first command, u and u/s.
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) coupling: SlaveCoupling,
}

/// The coupling in a file.
#[derive(Clone, Debug)]
pub(super) enum SlaveCoupling {
    Saw(SawCommand),
    Gear(FlyingGearParameters),
    Cam(CamIn, Box<Plate>),
}

/// Limits of a slave on a cam plate, whose file has none: those of no axis, to be replaced by parameters. u/s, u/s², u/s³.
const WIDE_LIMITS: [f64; 3] = [1e5, 1e7, 1e15];

impl SlaveFile {
    /// Reads a file; files that it names are searched for in its folder.
    ///
    /// # Errors
    /// Names the file, the field, the value received and the one expected.
    pub(super) fn parse(file: &Path, text: &str) -> anyhow::Result<Self> {
        let name = file.display().to_string();
        let table = parse_table(&name, text)?;
        let has = |keys: &[&str]| keys.iter().any(|key| table.contains_key(*key));
        if has(&["gear-in-pos", "gear-in-velo"]) {
            return Ok(of_saw(SawFile::parse(&name, text)?));
        }
        if has(&["flying-gear"]) {
            return Ok(of_gear(GearFile::parse(&name, text)?));
        }
        if has(&["point", "points", "table"]) {
            return of_cam(&CamFile::parse(file, text)?);
        }
        let expected = "gear-in-pos or gear-in-velo of a saw file, flying-gear of a gear file, or the points or table of a cam file";
        Err(Wrong::value("a file without a coupling", expected)
            .in_file(&name)
            .into())
    }
}

fn of_saw(file: SawFile) -> SlaveFile {
    let axis = file.moment.axis;
    SlaveFile {
        title: file.title,
        master_unit: unit(file.master_unit),
        unit: unit(file.slave_unit),
        limits: SlaveParameters {
            min_position: axis.min_position,
            max_position: axis.max_position,
            master_increment: file.moment.encoder.map(|encoder| encoder.scaling),
            ..within(&axis.dynamics)
        },
        position: file.moment.slave.position,
        velocity: file.moment.slave.velocity,
        coupling: SlaveCoupling::Saw(file.command),
    }
}

fn of_gear(file: GearFile) -> SlaveFile {
    SlaveFile {
        title: file.title,
        master_unit: unit(file.master_unit),
        unit: unit(file.slave_unit),
        limits: within(&file.limits),
        position: file.slave_position,
        velocity: 0.0,
        coupling: SlaveCoupling::Gear(file.parameters),
    }
}

fn of_cam(file: &CamFile) -> anyhow::Result<SlaveFile> {
    let plate = file.plate()?;
    let [velocity, acceleration, jerk] = WIDE_LIMITS;
    let table = file.table_id.map_or(1, |id| id.get().into());
    Ok(SlaveFile {
        title: file.title.clone(),
        master_unit: unit(file.master_unit.clone()),
        unit: unit(file.slave_unit.clone()),
        limits: SlaveParameters::new(velocity, acceleration, jerk),
        position: plate.at(0.0).position,
        velocity: 0.0,
        coupling: SlaveCoupling::Cam(
            CamIn {
                table,
                ..CamIn::default()
            },
            Box::new(plate),
        ),
    })
}

fn within(limits: &Limits) -> SlaveParameters {
    SlaveParameters {
        deceleration: Some(limits.deceleration()),
        ..SlaveParameters::new(limits.velocity(), limits.acceleration(), limits.jerk())
    }
}

/// A unit of a file; one that is a text for people only is any unit.
fn unit(text: String) -> Unit {
    Unit::new(text).unwrap_or_default()
}
