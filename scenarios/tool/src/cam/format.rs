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
        let is_plc = |ending: &str| {
            let of_plc = ["st", "exp", "tcgvl", "tcpou", "il", "scl"];
            of_plc
                .iter()
                // Programs on Windows write `.TcGVL` as well as `.tcgvl`.
                .any(|known| known.eq_ignore_ascii_case(ending))
        };
        if ending.is_some_and(is_plc) {
            Self::Plc
        } else {
            Self::Csv
        }
    }
}
