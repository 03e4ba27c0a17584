//! The scenarios that come with the tool, built into it.

use std::path::Path;

use anyhow::Context;
use coaxle_node::config::{ConfigError, did_you_mean, parse_table};
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_os::exit::wrong_argument;

use crate::scenario::Scenario;
use crate::{overrides, read};

macro_rules! catalogue {
    ($($name:literal,)*) => {
        &[$(($name, include_str!(concat!("../../catalog/", $name, ".toml"))),)*]
    };
}

/// Name and text of every scenario, in the order in which a newcomer might look at them.
pub const CATALOG: &[(&str, &str)] = catalogue![
    "cut-to-length",
    "beat",
    "beat-sender-slow",
    "beat-sender-fast",
    "cycle-ratio",
    "dead-time",
    "encoder-master",
    "measuring-wheel",
    "jitter",
    "locked-cycle",
    "loss",
    "master-in-motion",
    "presented",
    "presented-auto",
    "presented-chain",
    "presented-plant",
    "coupled-stop",
    "planned-partition",
    "drift-change",
    "sender-restart",
    "twin-sender",
    "chain",
    "many-axes",
    "three-senders",
    "plant",
    "knife-by-turns",
    "line-shaft",
    "observer",
    "observer-sweep",
    "zero-lag",
    "timing-channel",
    "common-time",
    "orders",
    "delay-step",
    "delay-step-large",
    "drift-step",
    "sender-stop-resume",
    "hot-standby",
    "cam-tables",
    "product-change",
    "start-modes",
    "rotary-knife",
    "saw-recovery",
    "flying-gear-1",
    "flying-gear-2",
    "flying-gear-3",
    "saw-velocity-1",
    "saw-velocity-2",
    "saw-velocity-3",
    "saw-position-1",
    "saw-position-2",
    "rollback-1",
    "rollback-2",
    "rollback-3",
    "rollback-4",
    "rollback-5",
    "rollback-6",
    "rollback-7",
    "rollback-8",
    "diagonal-saw",
    "hour",
];

/// Scenarios of faults, one for each: in the order of the table in `docs/FAULTS.md`.
pub const FAULTS: &[(&str, &str)] = catalogue![
    "faults/drift",
    "faults/wander",
    "faults/terms",
    "faults/clock-back",
    "faults/clock-leap",
    "faults/jitter",
    "faults/corruption",
    "faults/repetition",
    "faults/order",
    "faults/loss",
    "faults/loss-beyond-age-limit",
    "faults/delay-steps",
    "faults/stale-burst",
    "faults/insertion",
    "faults/twin",
    "faults/masquerade",
    "faults/addressing",
    "faults/restart",
    "faults/freeze",
    "faults/receiver-overrun",
    "faults/frozen-receiver",
    "faults/stalled-viewer",
    "faults/receiver-restart",
    "faults/sender-error",
    "faults/beyond-limits",
    "faults/version",
    "faults/flood",
    "faults/index-wrap",
    "faults/counter-wraps",
];

/// Name and text of every scenario that comes with the tool.
pub fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
    CATALOG.iter().chain(FAULTS).copied()
}

/// A scenario's text, and its name in errors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The scenario's name: of the catalogue, or the file's without its ending.
    pub name: String,
    /// Name in errors.
    pub file: String,
    /// The TOML.
    pub text: String,
}

/// Finds a scenario: by its name in the catalogue, or by its path.
///
/// # Errors
/// Names the scenario that was not found, and those that exist.
pub fn find(name_or_path: &str) -> anyhow::Result<Source> {
    if let Some((name, text)) = all().find(|(name, _)| *name == name_or_path) {
        return Ok(Source {
            name: name.to_owned(),
            file: format!("{name}.toml"),
            text: text.to_owned(),
        });
    }
    let path = Path::new(name_or_path);
    let looks_like_path = path.extension().is_some() || path.components().count() > 1;
    // A bare word is a misspelt name: that no file has it would lead astray.
    if !looks_like_path {
        let known: Vec<_> = all().map(|(name, _)| name).collect();
        return wrong_argument(format!(
            "received scenario {name_or_path:?}, expected a path ending in .toml or one of: {}{}",
            known.join(", "),
            did_you_mean(name_or_path, known)
        ));
    }
    let text = text_file::read(path, MOST_CONFIG_BYTES)?;
    let name = path.file_stem().map_or(name_or_path.into(), |stem| {
        stem.to_string_lossy().into_owned()
    });
    Ok(Source {
        name,
        file: name_or_path.to_owned(),
        text,
    })
}

impl Source {
    /// The scenario with some of its fields set to other values, each `path.to.field=value`.
    ///
    /// # Errors
    /// Names the file, the field, what was received and what is expected.
    pub fn read(&self, sets: &[String]) -> anyhow::Result<Scenario> {
        let own = parse_table(&self.file, &self.text)?;
        let in_text = |error: ConfigError| error.in_text(&self.file, &self.text);
        if sets.is_empty() {
            return Ok(read::scenario(&self.file, own).map_err(in_text)?);
        }
        let mut table = own.clone();
        for text in sets {
            overrides::apply(&mut table, text).with_context(|| self.file.clone())?;
        }
        // An error without the overrides has a line; an error with them has none.
        let read = read::scenario(&self.file, table.clone());
        read.map_err(|error| match read::scenario(&self.file, own) {
            Err(own) => in_text(own).into(),
            Ok(_) => error.in_table(&self.file, &table).into(),
        })
    }
}
