//! Formats of point tables.

use std::path::Path;

use clap::ValueEnum;
use coaxle_files::point_table::Format;

/// The format of a point table, as the command line spells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FormatArg {
    /// Columns, with a header
    Csv,
    /// An array of structured text
    Plc,
}

/// Endings of files that PLC projects have.
pub(super) const OF_PLC: [&str; 6] = ["st", "exp", "scl", "il", "TcGVL", "TcPOU"];

impl FormatArg {
    pub(super) const fn format(self) -> Format {
        match self {
            Self::Csv => Format::Csv,
            Self::Plc => Format::StructuredText,
        }
    }

    /// Format of a file by its name: CSV unless the ending is one that PLC projects have.
    pub(super) fn of(path: &Path) -> Self {
        let ending = path.extension().and_then(|ending| ending.to_str());
        // Programs on Windows write `.TcGVL` as well as `.tcgvl`.
        let is_plc = |ending: &str| {
            let mut of_plc = OF_PLC.iter();
            of_plc.any(|known| known.eq_ignore_ascii_case(ending))
        };
        if ending.is_some_and(is_plc) {
            Self::Plc
        } else {
            Self::Csv
        }
    }
}
