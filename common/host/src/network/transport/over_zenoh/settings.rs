//! Reading and setting what a Zenoh config holds, with errors for people.

use std::path::Path;

use anyhow::{Context, anyhow};
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use zenoh::Config;

use super::error::{insertion_reason, zenoh_error};

pub(super) fn from_file(file: &Path) -> anyhow::Result<Config> {
    // Checked first because Zenoh itself would read any file, even one without an end.
    text_file::open(file, MOST_CONFIG_BYTES)
        .map_err(anyhow::Error::from)
        .and_then(|_| Config::from_file(file).map_err(zenoh_error))
        .with_context(|| format!("the Zenoh config file {}", file.display()))
}

/// Inserts where the config still holds Zenoh's own default.
pub(super) fn unless_set(config: &mut Config, path: &str, json: &str) -> anyhow::Result<()> {
    // Zenoh's config does not say what was set: a value other than the default must have been.
    let untouched = Config::default().get_json(path).ok();
    if config.get_json(path).ok() == untouched {
        insert(config, path, json)?;
    }
    Ok(())
}

pub(super) fn insert(config: &mut Config, path: &str, json: &str) -> anyhow::Result<()> {
    config.insert_json5(path, json).map_err(|error| {
        let reason = insertion_reason(&error.to_string());
        anyhow!("the Zenoh setting \"{path}\" = {json} is refused: {reason}")
    })
}
