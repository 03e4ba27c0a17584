//! `coaxle cam export`.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use coaxle_files::point_table::{Format, PointTable};
use coaxle_plate::{Plate, ValueSelect};

use super::format::FormatArg;
use super::text::parse_finite;
use super::{load, new_file};

/// Arguments of `coaxle cam export`.
#[derive(Debug, Args)]
pub struct CamExportArgs {
    /// Cam file, TOML
    file: PathBuf,
    /// Format [default: by the ending of the output's name: .st, .exp, .scl, .il, .TcGVL and .TcPOU are a PLC's, others CSV]
    #[arg(long, value_enum)]
    format: Option<FormatArg>,
    /// The name of the array in structured text
    #[arg(long, value_name = "NAME", default_value = "CamTable", value_parser = identifier)]
    array: String,
    /// Positions at this distance in master units, for any plate, instead of its own points
    #[arg(long, value_parser = parse_finite, allow_negative_numbers = true)]
    increment: Option<f64>,
    /// The table to write; it must not be there yet [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl CamExportArgs {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<()> {
        let (cam, plate) = load(&self.file)?;
        let table = match self.increment {
            None => PointTable::from(&cam.source()),
            Some(increment) => positions(&plate, increment)?,
        };
        let by_name = || self.output.as_deref().map(FormatArg::of);
        // The option wins over the ending: `table.txt` may be structured text.
        let format = self.format.or_else(by_name).unwrap_or(FormatArg::Csv);
        let text = match format.format() {
            Format::Csv => table.to_csv(),
            Format::StructuredText => table.to_structured_text(&self.array),
        };
        new_file::write(self.output.as_deref(), &text, out)
    }
}

/// From the first master position to the last, which is always there.
fn positions(plate: &Plate, increment: f64) -> anyhow::Result<PointTable> {
    let (start, end) = plate.master_range();
    let rows = plate.values(start, end, increment, ValueSelect::POSITION)?;
    let mut rows: Vec<_> = rows.map(|row| (row[0], row[1])).collect();
    // An increment that does not divide the range leaves a rest; without the end the table would be a shorter plate.
    if rows.last().is_none_or(|(master, _)| *master < end) {
        rows.push((end, plate.at(end).position));
    }
    Ok(PointTable::Positions(rows))
}

fn identifier(text: &str) -> Result<String, String> {
    let mut letters = text.chars();
    let is_name = letters
        .next()
        // Identifiers of IEC 61131-3; the text is pasted into a program.
        .is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && letters.all(|c| c.is_ascii_alphanumeric() || c == '_');
    if is_name {
        Ok(text.to_owned())
    } else {
        Err("expected the name of a variable: letters, digits and _".to_owned())
    }
}
