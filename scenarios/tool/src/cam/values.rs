//! `coaxle cam values`.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use coaxle_files::cam::CamFile;
use coaxle_plate::{Plate, ValueSelect};
use coaxle_report::inspect::{QUANTITIES, shown};

use super::load;
use super::text::{heading, master_heading, parse_finite};

/// Arguments of `coaxle cam values`.
#[derive(Debug, Args)]
pub struct ValuesArgs {
    /// Cam file, TOML
    file: PathBuf,
    /// First master position [default: where the plate begins]
    #[arg(long, value_parser = parse_finite, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Last master position; may lie beyond the plate [default: where the plate ends]
    #[arg(long, value_parser = parse_finite, allow_negative_numbers = true)]
    to: Option<f64>,
    /// Step of the master, negative to go backwards [default: a hundredth of the way]
    #[arg(long, value_parser = parse_finite, allow_negative_numbers = true)]
    increment: Option<f64>,
    /// As comma-separated values with all digits
    #[arg(long)]
    csv: bool,
}

impl ValuesArgs {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<()> {
        let (cam, plate) = load(&self.file)?;
        if self.csv {
            self.write_csv(&plate, out)
        } else {
            self.write_table(&cam, &plate, out)
        }
    }

    fn rows(&self, plate: &Plate) -> anyhow::Result<impl Iterator<Item = Vec<f64>>> {
        let (start, end) = plate.master_range();
        let (from, to) = (self.from.unwrap_or(start), self.to.unwrap_or(end));
        // One place is one row, with any increment.
        let usual = if to == from { 1.0 } else { (to - from) / 100.0 };
        let increment = self.increment.unwrap_or(usual);
        let rows = plate.values(from, to, increment, ValueSelect::all())?;
        Ok(rows.map(|row| row.to_vec()))
    }

    fn write_csv(&self, plate: &Plate, out: &mut dyn Write) -> anyhow::Result<()> {
        let rows = self.rows(plate)?;
        writeln!(out, "master,{}", QUANTITIES.join(","))?;
        for row in rows {
            // The shortest digits that read back as the same bits.
            let cells: Vec<_> = row.iter().map(f64::to_string).collect();
            writeln!(out, "{}", cells.join(","))?;
        }
        Ok(())
    }

    fn write_table(&self, cam: &CamFile, plate: &Plate, out: &mut dyn Write) -> anyhow::Result<()> {
        let rows = self.rows(plate)?;
        let mut headings = vec![master_heading(cam)];
        headings.extend((0..QUANTITIES.len()).map(|quantity| heading(cam, quantity)));
        write_line(&headings, out)?;
        for row in rows {
            let cells: Vec<_> = row.iter().copied().map(shown).collect();
            write_line(&cells, out)?;
        }
        Ok(())
    }
}

/// Columns of one width, so that rows can be printed as they come.
fn write_line(cells: &[String], out: &mut dyn Write) -> anyhow::Result<()> {
    // Wide enough for the headings with usual units.
    let cells: Vec<_> = cells.iter().map(|cell| format!("{cell:>20}")).collect();
    writeln!(out, "{}", cells.join(" "))?;
    Ok(())
}
