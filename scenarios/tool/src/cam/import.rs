//! `coaxle cam import`.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use coaxle_files::cam::{CamFile, MOST_BYTES};
use coaxle_files::point_table::PointTable;
use coaxle_os::exit::wrong_argument;
use coaxle_plate::{Course, WrittenPoint};
use coaxle_report::inspect::name;

use super::format::FormatArg;
use super::{mistake, new_file};

/// The table to read, and the facts that it lacks.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// Point table: CSV, or structured text of a PLC
    table: PathBuf,
    /// Format of the table [default: by the ending of its name: .st, .exp, .scl, .il, .TcGVL and .TcPOU are a PLC's, others CSV]
    #[arg(long, value_enum)]
    format: Option<FormatArg>,
    /// Name of the array in the structured text, if there are several
    #[arg(long, value_name = "NAME")]
    array: Option<String>,
    /// The cam file to write; it must not be there yet [default: standard output]
    #[arg(short, long, value_name = "TOML")]
    output: Option<PathBuf>,
    /// Title of the plate
    #[arg(long, default_value = "")]
    title: String,
    /// Course of the plate: passed once, or repeated
    #[arg(long, value_enum, default_value = "linear")]
    course: CourseArg,
    /// The number of the plate
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..))]
    table_id: Option<u8>,
    /// Unit of the master
    #[arg(long, default_value = "x")]
    master_unit: String,
    /// Unit of the slave
    #[arg(long, default_value = "u")]
    slave_unit: String,
    /// Interpolation between the rows of a position table
    #[arg(long, value_enum, default_value = "linear")]
    interpolation: InterpolationArg,
    /// The steps of a position table are equal
    #[arg(long)]
    equidistant: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum CourseArg {
    Linear,
    Cyclic,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum InterpolationArg {
    Linear,
    Spline,
    SlidingSpline,
}

impl ImportArgs {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<()> {
        let format = self.format.unwrap_or_else(|| FormatArg::of(&self.table));
        let table = PointTable::load(&self.table, format.format(), self.array.as_deref())?;
        let text = self.text(&table, None);
        // Errors name the table, as the user has no other file yet.
        let (file, folder) = (self.table.display().to_string(), Path::new(""));
        let parsed = text.parse().context("the cam file cannot be written")?;
        let cam = CamFile::from_table(&file, folder, parsed);
        // Before anything is written: no file is left behind that is refused later.
        cam.and_then(|cam| cam.plate()).map_err(mistake)?;
        // A cam file of that size would be refused when it is read.
        if text.len() as u64 > MOST_BYTES {
            return self.write_beside(&table, text.len(), out);
        }
        new_file::write(self.output.as_deref(), &text, out)
    }

    /// Leaves more points than a cam file holds in a CSV file beside it.
    fn write_beside(
        &self,
        table: &PointTable,
        bytes: usize,
        out: &mut dyn Write,
    ) -> anyhow::Result<()> {
        let Some(output) = &self.output else {
            return wrong_argument(format!(
                "{}: received {bytes} bytes of TOML, expected at most {MOST_BYTES} on standard output; with --output the points \
                 are left in a CSV file beside it",
                self.table.display()
            ));
        };
        let beside = output.with_extension("csv");
        let Some(name) = beside.file_name().map(|name| name.to_string_lossy()) else {
            return wrong_argument(format!("{}: received no name of a file", output.display()));
        };
        // The table itself may have that name already, with the same points in it.
        if !is_same(&beside, &self.table) {
            new_file::write(Some(&beside), &table.to_csv(), out)?;
        }
        new_file::write(Some(output), &self.text(table, Some(&name)), out)?;
        // The written file may be larger than the table, and is read to the end.
        CamFile::load(output).map_err(mistake)?;
        Ok(())
    }

    /// The cam file, with its points in it or in a CSV file of that name.
    fn text(&self, table: &PointTable, csv: Option<&str>) -> String {
        let course = match self.course {
            CourseArg::Linear => Course::Linear,
            CourseArg::Cyclic => Course::Cyclic,
        };
        let mut text = String::new();
        // Titles may hold quotes and line breaks.
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let _ = writeln!(text, "title = {}", quoted(&self.title));
        if let Some(id) = self.table_id {
            let _ = writeln!(text, "table-id = {id}");
        }
        let _ = writeln!(text, "course = {}", quoted(&name(&course)));
        let _ = writeln!(text, "master-unit = {}", quoted(&self.master_unit));
        let _ = writeln!(text, "slave-unit = {}", quoted(&self.slave_unit));
        // A name without a folder: the cam file finds it beside itself, wherever both are copied to.
        let csv = csv.map(|csv| format!("csv = {}\n", quoted(csv)));
        match (table, csv) {
            (PointTable::Points(_), Some(csv)) => text += &format!("\n[points]\n{csv}"),
            (PointTable::Points(points), None) => {
                for (row, point) in points.iter().enumerate() {
                    push_point(&mut text, row, row + 1 == points.len(), point);
                }
            }
            (PointTable::Positions(rows), csv) => self.push_table(&mut text, rows, csv),
        }
        text
    }

    fn push_table(&self, text: &mut String, rows: &[(f64, f64)], csv: Option<String>) {
        text.push_str("\n[table]\n");
        if self.equidistant {
            text.push_str("equidistant = true\n");
        }
        let interpolation = match self.interpolation {
            InterpolationArg::Linear => "linear",
            InterpolationArg::Spline => "spline",
            InterpolationArg::SlidingSpline => "sliding-spline",
        };
        let _ = writeln!(text, "interpolation = \"{interpolation}\"");
        if let Some(csv) = csv {
            text.push_str(&csv);
            return;
        }
        text.push_str("rows = [\n");
        for (master, slave) in rows {
            let _ = writeln!(text, "    [{}, {}],", number(*master), number(*slave));
        }
        text.push_str("]\n");
    }
}

/// True if both names are of one existing file.
fn is_same(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => false,
    }
}

/// Appends a point, without the fields that can be left out.
fn push_point(text: &mut String, row: usize, is_last: bool, point: &WrittenPoint) {
    text.push_str("\n[[point]]\n");
    // The default of each field is left out, so that the file stays short.
    if let Some(index) = point.index.filter(|index| *index as usize != row + 1) {
        let _ = writeln!(text, "index = {index}");
    }
    if let Some(law) = point.law.filter(|law| !is_last || law.is_spline()) {
        let _ = writeln!(text, "law = \"{}\"", law.file_name());
    }
    if let Some(kind) = point
        .point_type
        // A type that follows from the derivatives would contradict them after a change by hand.
        .filter(|kind| *kind != point.implied_type())
    {
        let _ = writeln!(text, "type = \"{}\"", kind.file_name());
    }
    if point.relative_next != 1 && !is_last {
        let _ = writeln!(text, "relative-next = {}", point.relative_next);
    }
    let _ = writeln!(text, "master = {}", number(point.master));
    let _ = writeln!(text, "slave = {}", number(point.slave));
    for (field, value) in [
        ("velocity", point.velocity),
        ("acceleration", point.acceleration),
        ("jerk", point.jerk),
    ] {
        if value != 0.0 {
            let _ = writeln!(text, "{field} = {}", number(value));
        }
    }
}

/// Formats a number for TOML: whole numbers without a point, as people write them.
fn number(value: f64) -> String {
    // Below 2^53 ≈ 9e15 every whole number is exact.
    if value.fract() == 0.0 && value.abs() < 1e15 {
        format!("{value}")
    } else {
        // `{:?}` gives the shortest digits that read back as the same bits; TOML writes `nan` in small letters.
        format!("{value:?}").replace("NaN", "nan")
    }
}
