//! `coaxle cam inverse`.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use coaxle_report::inspect::shown;

use super::load;
use super::text::parse_finite;

/// Arguments of `coaxle cam inverse`.
#[derive(Debug, Args)]
pub struct InverseArgs {
    /// Cam file, TOML
    file: PathBuf,
    /// Slave position
    #[arg(long, value_parser = parse_finite, allow_negative_numbers = true)]
    slave: f64,
    /// Master position to look from, downwards and upwards
    #[arg(long, value_parser = parse_finite, allow_negative_numbers = true)]
    start: f64,
}

impl InverseArgs {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<()> {
        let (cam, plate) = load(&self.file)?;
        // A tolerance of 0: only places on the named side of the start.
        let below = plate.master_below(self.slave, self.start, 0.0);
        let above = plate.master_above(self.slave, self.start, 0.0);
        // Besides, since a plate that is not monotonous passes a position several times.
        let crossings: Vec<_> = plate.masters_at(self.slave).collect();

        let (start, end) = plate.master_range();
        writeln!(
            out,
            "master positions in {} at which the slave is at {} {}",
            cam.master_unit,
            shown(self.slave),
            cam.slave_unit
        )?;
        writeln!(out, "below {}: {}", shown(self.start), listed(below))?;
        writeln!(out, "above {}: {}", shown(self.start), listed(above))?;
        writeln!(
            out,
            "all from {} to {}: {}",
            shown(start),
            shown(end),
            listed(crossings)
        )?;
        Ok(())
    }
}

fn listed(masters: impl IntoIterator<Item = f64>) -> String {
    let masters: Vec<_> = masters.into_iter().map(shown).collect();
    if masters.is_empty() {
        "none".to_owned()
    } else {
        masters.join(", ")
    }
}
