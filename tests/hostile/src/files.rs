//! Input from files, as `--check` and the tool read it, and up to the first cycles.

use std::path::{Path, PathBuf};

use coaxle_clock::{Instant, Span};
use coaxle_files::cam::CamFile;
use coaxle_files::gear::GearFile;
use coaxle_files::point_table::PointTable;
use coaxle_files::saw::SawFile;
use coaxle_lab::catalog::Source;
use coaxle_node::config::parse;
use coaxle_node::lab::{NodeFile, WithLab};
use coaxle_node::one_line;
use coaxle_plate::{
    Course, Demand, LawCriteria, LawLimits, PlateSource, SourceRows, ValueSelect, WrittenPoint,
};
use coaxle_receiver::{Drives, Receiver, ReceiverConfig};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;
use coaxle_source::config::ReplayConfig;
use coaxle_source::{AxisSource as _, Replay};

use crate::Outcome;
use crate::node::scan;
use crate::seeds::root;

/// Cycles that a node is run for.
const CYCLES: usize = 10;

/// A sender's config.
pub(crate) fn sender_config(data: &[u8]) -> Outcome {
    let mut config: SenderConfig = node_config("sender.toml", text(data)?)?;
    config.relative_to(&root().join("sender/configs"));
    config.check_files().map_err(error_text)?;
    let mut sender = Sender::new(&config, Instant::EPOCH, 1).map_err(error_text)?;
    // Derived texts are read by operators and must not panic either.
    let _ = config.columns();
    scan(&mut sender, &config.name, CYCLES);
    Ok(())
}

/// A receiver's config.
pub(crate) fn receiver_config(data: &[u8]) -> Outcome {
    let mut config: ReceiverConfig = node_config("receiver.toml", text(data)?)?;
    config.relative_to(&root().join("receiver/configs"));
    config.check_files().map_err(error_text)?;
    let notes = config.notes();
    // Each note becomes one line of the log.
    assert!(
        notes.iter().all(|note| note.lines().count() == 1),
        "{notes:?}"
    );
    let built = Receiver::with_drives(&config, Drives::simulated(), Instant::EPOCH, 1);
    let mut receiver = built.map_err(|error| one_line(&error.to_string()))?;
    let _ = (config.columns(), config.wiring());
    scan(&mut receiver, &config.name, CYCLES);
    Ok(())
}

/// The config of a node, as its own file has it or as a scenario does.
fn node_config<C: WithLab>(file: &str, text: &str) -> Result<C, String> {
    // Scenarios hold configs without the lab table around them, and both ways must withstand all input.
    match NodeFile::parse(file, text).map_err(error_text) {
        Ok(NodeFile { config, .. }) => Ok(config),
        Err(_) => parse(file, text).map_err(error_text),
    }
}

/// A scenario, as `coaxle check` reads it.
pub(crate) fn scenario(data: &[u8]) -> Outcome {
    let source = Source {
        name: "scenario".to_owned(),
        file: root()
            // Relative paths in the input resolve as in a shipped scenario, whose files exist.
            .join("scenarios/catalog/t.toml")
            .display()
            .to_string(),
        text: text(data)?.to_owned(),
    };
    let prepared = coaxle_lab::sweep::prepare(&source, &coaxle_lab::sweep::Setup::default());
    // As the tool prints it.
    let prepared = prepared.map_err(|error| one_line(&format!("{error:#}")))?;
    let notes = prepared.notes();
    assert!(
        notes.iter().all(|note| note.lines().count() == 1),
        "{notes:?}"
    );
    Ok(())
}

/// A cam file, and everything that the tool prints about it.
pub(crate) fn cam_file(data: &[u8]) -> Outcome {
    let path = root().join("scenarios/cams/t.toml");
    examine_cam(CamFile::parse(&path, text(data)?).map_err(error_text)?)
}

/// The CSV file of a cam file.
pub(crate) fn cam_table(data: &[u8]) -> Outcome {
    let file = Scratch::holding(data);
    let mut outcome = Ok(());
    // Each kind of interpolation calculates in other code.
    for (interpolation, course) in [
        ("linear", "linear"),
        ("spline", "cyclic"),
        ("sliding-spline", "linear"),
    ] {
        let path = file.path().display();
        let cam = format!(
            "course = '{course}'\n[table]\ninterpolation = '{interpolation}'\ncsv = '{path}'"
        );
        let cam = CamFile::parse(Path::new("t.toml"), &cam).map_err(error_text)?;
        outcome = examine_cam(cam);
    }
    outcome
}

fn examine_cam(cam: CamFile) -> Outcome {
    let plate = cam.plate().map_err(error_text)?;
    let (start, end) = plate.master_range();
    // Both ends, the last position inside, and values that overflow when differences are squared.
    for master in [start, end, end.next_down(), 0.0, -1e300, 1e300, f64::NAN] {
        let _ = plate.at(master);
    }
    let rows = plate.values(start, end, (end - start) / 10.0, ValueSelect::all());
    // Bounded: a range of a huge plate has any number of values.
    let _ = rows.map(|rows| rows.take(20).count());
    let _ = plate.characteristics(1.0);
    let middle = plate.at(start + 0.5 * (end - start)).position;
    let _ = (
        plate.master_below(middle, start, 0.0),
        plate.master_above(middle, start, 0.0),
    );
    let _ = plate.masters_at(middle).take(1_000).count();
    Ok(())
}

/// A point table as CSV, written again where it makes a plate.
pub(crate) fn point_table(data: &[u8]) -> Outcome {
    examine_points(PointTable::from_csv("t.csv", text(data)?).map_err(error_text)?)
}

/// An array in structured text.
pub(crate) fn plc_array(data: &[u8]) -> Outcome {
    let table = PointTable::from_structured_text("t.st", text(data)?, None);
    examine_points(table.map_err(error_text)?)
}

fn examine_points(table: PointTable) -> Outcome {
    let csv = PointTable::from_csv("t.csv", &table.to_csv());
    let array = PointTable::from_structured_text("t.st", &table.to_structured_text("Cam"), None);
    // NaN has no notation in a program: the array may be refused.
    let PointTable::Points(points) = table else {
        return Ok(());
    };
    // A table that was read can be written and read again.
    assert!(csv.is_ok(), "{csv:?}");
    drop(array);
    let laws = WrittenPoint::to_points(&points);
    let points = laws.map_err(|row| format!("point {}: no law", row + 1))?;
    let source = PlateSource {
        course: Course::Cyclic,
        rows: SourceRows::Points(points),
    };
    source.check_size().map_err(error_text)?;
    let criteria = LawCriteria {
        master_velocity: 1.0,
        limits: LawLimits::default(),
        least: Demand::Torque,
    };
    let _ = source.law_advice(1, &criteria);
    source.plate().map(drop).map_err(error_text)
}

/// A saw file, planned, with remedies where it is refused.
pub(crate) fn saw_file(data: &[u8]) -> Outcome {
    let saw = SawFile::parse("saw.toml", text(data)?).map_err(error_text)?;
    match saw.plan() {
        Ok(plan) => {
            let _ = plan.characteristics(saw.table_id);
            let _ = plan.motion_function();
            Ok(())
        }
        Err(refusal) => {
            // Searches for parameters that would work, from the values that did not.
            let _ = saw.remedy();
            Err(refusal.to_string())
        }
    }
}

/// A gear file, planned and driven through.
pub(crate) fn gear_file(data: &[u8]) -> Outcome {
    let file = GearFile::parse("gear.toml", text(data)?).map_err(error_text)?;
    let mut gear = file.gear().map_err(error_text)?;
    let _ = gear.fastest(&file.limits, file.cycle.0);
    let at = |position: f64| {
        let mut master = file.master;
        master.position = position;
        master
    };
    for stretch in gear.ranges(file.master.velocity, file.cycle.0) {
        for position in [stretch.master_free, stretch.master_coupled] {
            let _ = gear.update(&at(position));
        }
    }
    Ok(())
}

/// A recorded motion, replayed.
pub(crate) fn recording(data: &[u8]) -> Outcome {
    let file = Scratch::holding(data);
    for repeat in [false, true] {
        let config = ReplayConfig {
            file: file.path().to_owned(),
            axis: None,
            repeat,
            interpolation: Default::default(),
        };
        let mut replay = Replay::open(&config).map_err(error_text)?;
        // Between rows, on a row, beyond the end, and as late as time can be.
        for nanos in [0, 1, 1_000_000, 1_500_000_000, i64::MAX] {
            let _ = replay.sample(Span::from_nanos(nanos));
        }
    }
    Ok(())
}

fn text(data: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(data).map_err(|_| "no UTF-8 text".to_owned())
}

fn error_text(error: impl std::error::Error) -> String {
    error.to_string()
}

/// A file that is read by its path, in memory where there is such a file system.
struct Scratch(PathBuf);

impl Scratch {
    fn holding(data: &[u8]) -> Self {
        use std::sync::atomic::{AtomicU64, Ordering};
        static COUNT: AtomicU64 = AtomicU64::new(0);
        // Thousands of files in a run, which a disk would slow down.
        let shm = Path::new("/dev/shm");
        let folder = if shm.is_dir() {
            shm.to_owned()
        } else {
            std::env::temp_dir()
        };
        // Tests of one process run at the same time.
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("coaxle-hostile-{}-{count}.csv", std::process::id()));
        std::fs::write(&path, data).expect("a scratch file");
        Self(path)
    }

    fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}
