//! Points and positions in the structured text of a PLC.
//!
//! From a program, the arrays that can hold a plate are read, from their declarations and the
//! assignments to their elements; the rest is skipped. Bounds and values are literals: an
//! expression is refused.

mod arrays;
mod parser;
mod token;
mod write;

use coaxle_node::config::ConfigError;
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
        .map_err(|wrong| ConfigError::field(file, format!("line {}", wrong.line), wrong.reason))?;
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
            let (field, received) = match wanted {
                Some(name) => ("array", format!("received {name:?}")),
                None => ("array", "received no name".to_owned()),
            };
            let expected = match &names[..] {
                // Names of others help a person who misspelt one.
                [] => "the file has no array of MC_MotionFunctionPoint or of pairs of LREAL with values".to_owned(),
                names => format!("expected one of: {}", names.join(", ")),
            };
            Err(ConfigError::field(
                file,
                field,
                format!("{received}, {expected}"),
            ))
        }
    }
}
