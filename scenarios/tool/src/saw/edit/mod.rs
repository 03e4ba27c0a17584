//! `coaxle saw edit`: distances, speeds and limits of a flying saw, moved on a page.

mod fields;
#[cfg(test)]
mod tests;
mod view;

use std::path::PathBuf;

use clap::Args;
use coaxle_files::saw::SawFile;
use coaxle_node::text_file::MOST_CONFIG_BYTES;
use coaxle_os::exit::Exit;
use coaxle_saw::SyncMask;
use serde::Deserialize;
use serde_json::Value;
use toml_edit::Array;

use super::refusal::flags_with;
use super::text::{command_name, sync_mode};
use crate::edit::toml_text::{document, put_at, value_of};
use crate::edit::{Design, EditArgs, PageParts, edit};
use crate::sync_flags::flag_name;

/// Arguments of `coaxle saw edit`.
#[derive(Debug, Args)]
pub struct SawEditArgs {
    #[command(flatten)]
    edit: EditArgs,
}

const PARTS: PageParts = PageParts {
    html: include_str!("page.html"),
    js: include_str!("page.js"),
};

/// Serves the page until Ctrl-C.
///
/// # Errors
/// A file that cannot be read, or an address that is not available.
pub(crate) fn run(args: &SawEditArgs) -> anyhow::Result<Exit> {
    let design = SawDesign {
        path: args.edit.file.clone(),
        last: None,
    };
    edit(&args.edit, design, PARTS)
}

/// A saw on a page.
struct SawDesign {
    /// Name of the file in errors.
    path: PathBuf,
    /// The last text that could be planned: it is drawn faint while another one is refused.
    last: Option<String>,
}

/// A belt, a saw that waits, and room for both.
const TEMPLATE: &str = "title = \"\"\nmaster-unit = \"mm\"\nslave-unit = \"mm\"\n\n\
    [master]\nposition = 0\nvelocity = 500\n\n[slave]\nposition = 0\nvelocity = 0\n\n\
    [axis]\nvelocity = 1500\nacceleration = 4000\njerk = 40000\nmin-position = -10\nmax-position = 1500\n\n\
    [gear-in-pos]\nratio = { numerator = 1 }\nmaster-sync-position = 500\nslave-sync-position = 250\n\
    sync-mode.mask = [\"min-pos\", \"max-pos\", \"max-velo\", \"max-acc\", \"max-dec\", \"max-jerk\"]\n";

/// A change from the page.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum SawPageChange {
    /// Fields by their paths; null takes one out.
    Set(Vec<(String, Value)>),
    /// A flag of the sync mode.
    Flag { flag: String, on: bool },
}

impl SawDesign {
    fn saw(&self, text: &str) -> Result<SawFile, String> {
        let saw = SawFile::parse(&self.path.display().to_string(), text);
        saw.map_err(|error| error.to_string())
    }

    /// The flag in the mask of the command, or not.
    fn with_flag(&self, text: &str, flag: &str, on: bool) -> Result<(String, Value), String> {
        let saw = self.saw(text)?;
        let known = SyncMask::all()
            .iter()
            .find(|known| flag_name(*known) == flag);
        let known = known
            .ok_or_else(|| format!("received flag {flag:?}, expected one of the sync mode"))?;
        let mut mask = sync_mode(&saw.command).mask;
        mask.set(known, on);
        let field = format!("{}.sync-mode.mask", command_name(&saw.command));
        Ok((field, flags_with(mask)))
    }
}

impl Design for SawDesign {
    const MOST_BYTES: u64 = MOST_CONFIG_BYTES;

    fn template(&self) -> String {
        TEMPLATE.to_owned()
    }

    fn view(&mut self, text: &str, _: &Value) -> Value {
        view::view(self, text)
    }

    fn changed(&mut self, text: &str, change: &Value, _: &Value) -> Result<String, String> {
        let fields = match SawPageChange::deserialize(change).map_err(|error| error.to_string())? {
            SawPageChange::Set(fields) => fields,
            SawPageChange::Flag { flag, on } => vec![self.with_flag(text, &flag, on)?],
        };
        let mut document = document(text)?;
        for (path, value) in fields {
            // Paths come from the page: any other one could write a field that no saw file has.
            if !fields::is_known(&path) {
                return Err(format!(
                    "received field {path:?}, expected one of a saw file"
                ));
            }
            put_at(&mut document, &path, written(&value)?)?;
        }
        Ok(document.to_string())
    }

    fn check(&self, text: &str) -> Result<(), String> {
        // A refused synchronisation can be saved: its file is in order.
        self.saw(text).map(drop)
    }

    fn act(&mut self, _: &str, wanted: &Value) -> Result<String, String> {
        Err(format!("received {wanted}, which a saw does not do"))
    }
}

/// Returns a value as the file has it; flags are a list.
fn written(value: &Value) -> Result<Option<toml_edit::Value>, String> {
    match value {
        // Null takes the field out.
        Value::Null => Ok(None),
        Value::Array(flags) => {
            let flags = flags.iter().map(value_of).collect::<Result<Vec<_>, _>>()?;
            Ok(Some(toml_edit::Value::from(
                flags.into_iter().collect::<Array>(),
            )))
        }
        value => value_of(value).map(Some),
    }
}
