//! Points and positions in the structured text of a PLC.
//!
//! From a program, the arrays that can hold a plate are read, from their declarations and the
//! assignments to their elements; the rest is skipped. Bounds and values are literals: an
//! expression is refused.

mod arrays;
mod parser;
mod token;
mod write;

use coaxle_node::config::{ConfigError, Wrong};
use parser::Parser;

use super::PointTable;
pub(super) use write::write;

pub(super) fn read(
    file: &str,
    text: &str,
    wanted: Option<&str>,
) -> Result<PointTable, ConfigError> {
    let mut arrays = Parser::new(text)
        .arrays(wanted)
        .map_err(|wrong| wrong.in_file(file))?;
    // Named: any array of the file. Not named: the only one that has values.
    let found = match wanted {
        Some(name) => arrays.take(name),
        None if arrays.names().count() == 1 => arrays.take_first(),
        None => None,
    };
    match found {
        Some(array) => array.table(file),
        None => {
            let names: Vec<_> = arrays.names().collect();
            let received = wanted.map_or("no name".to_owned(), |name| format!("{name:?}"));
            let expected = match &names[..] {
                [] => "one of MC_MotionFunctionPoint or of pairs of LREAL with values: the file has no array of them".to_owned(),
                // Names of others help a person who misspelt one.
                names => format!("one of: {}", names.join(", ")),
            };
            Err(Wrong::of("array", received, expected).in_file(file))
        }
    }
}
