//! Seeds on the command line.

use clap::builder::RangedU64ValueParser;

/// Takes a seed that a scenario file can hold.
pub(crate) fn parser() -> RangedU64ValueParser {
    // TOML has signed 64-bit integers only.
    clap::value_parser!(u64).range(..=i64::MAX as u64)
}
