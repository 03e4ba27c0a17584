//! Resources of a unit: what it is made of.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Component, Path};
use std::rc::Rc;

use coaxle_clock::{CycleTime, Span};
use coaxle_node::config::{CycleMicros, Wrong, parse};
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use schemars::JsonSchema;
use serde::Deserialize;
use sha2::{Digest, Sha256};

use crate::link::LinkUnitModel;
use crate::model::Model;
use crate::slave::SlaveUnitModel;

/// Name of the file that lists the others.
const MANIFEST: &str = "unit.toml";
/// Greatest size of a file beside the main one, bytes: that of the largest tables of points.
pub const MOST_FILE_BYTES: u64 = 64 << 20;

/// Kind of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UnitKind {
    /// A sender, a network and a receiver.
    Link,
    /// A slave axis.
    Slave,
}

impl UnitKind {
    /// Name of its library, without the ending.
    #[must_use]
    pub const fn identifier(self) -> &'static str {
        match self {
            Self::Link => "coaxle_link",
            Self::Slave => "coaxle_slave",
        }
    }
}

impl fmt::Display for UnitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Link => "link",
            Self::Slave => "slave",
        })
    }
}

/// The files of a unit, as texts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resources {
    kind: UnitKind,
    /// Cycle time of a slave; a link has that of its sender.
    cycle: Option<CycleTime>,
    /// Name of the main one.
    main: String,
    files: BTreeMap<String, String>,
}

/// The file that lists the others.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Manifest {
    kind: UnitKind,
    cycle_time_us: Option<CycleMicros>,
    main: String,
    files: Vec<String>,
}

impl Resources {
    /// Resources of a link, with the text of a scenario.
    #[must_use]
    pub fn of_link(name: &str, text: &str) -> Self {
        Self::of(UnitKind::Link, name, text, None)
    }

    /// Resources of a slave, with the text of a saw, gear or cam file, and its cycle time.
    ///
    /// # Errors
    /// [`Wrong`]: a cycle time out of range.
    pub fn of_slave(name: &str, text: &str, cycle_us: u32) -> Result<Self, Wrong> {
        let cycle = CycleTime::new(Span::from_micros(i64::from(cycle_us)));
        let cycle = cycle.map_err(|error| Wrong::with_reason("cycle-time-us", error))?;
        Ok(Self::of(UnitKind::Slave, name, text, Some(cycle)))
    }

    fn of(kind: UnitKind, name: &str, text: &str, cycle: Option<CycleTime>) -> Self {
        Self {
            kind,
            cycle,
            main: name.to_owned(),
            files: BTreeMap::from([(name.to_owned(), text.to_owned())]),
        }
    }

    /// Adds a file that the main one names, by its path from there.
    ///
    /// # Errors
    /// [`Wrong`]: a path that leads elsewhere, or one that is taken.
    pub fn add(&mut self, name: &str, text: String) -> Result<(), Wrong> {
        check_path(name)?;
        if name == MANIFEST || self.files.insert(name.to_owned(), text).is_some() {
            return Err(Wrong::of(
                "file",
                format!("{name:?} twice"),
                "each file once",
            ));
        }
        Ok(())
    }

    /// Reads those of a unit from their folder.
    ///
    /// # Errors
    /// Names the file that cannot be read, or the field that is wrong.
    pub fn load(folder: &Path) -> anyhow::Result<Self> {
        let path = folder.join(MANIFEST);
        let text = text_file::read(&path, MOST_CONFIG_BYTES)?;
        let manifest: Manifest = parse(&path.display().to_string(), &text)?;
        let mut files = BTreeMap::new();
        for name in manifest.files {
            check_path(&name)?;
            let text = text_file::read(&folder.join(&name), MOST_FILE_BYTES)?;
            files.insert(name, text);
        }
        if !files.contains_key(&manifest.main) {
            return Err(
                Wrong::of("main", format!("{:?}", manifest.main), "one of the files").into(),
            );
        }
        Ok(Self {
            kind: manifest.kind,
            cycle: manifest.cycle_time_us.map(|cycle| cycle.0),
            main: manifest.main,
            files,
        })
    }

    /// Kind of the unit.
    #[must_use]
    pub const fn kind(&self) -> UnitKind {
        self.kind
    }

    /// The unit; files that its main one names are searched for in `folder`.
    ///
    /// # Errors
    /// Names the file, the field, the value received and the one expected.
    pub fn model(&self, folder: &Path) -> anyhow::Result<Rc<dyn Model>> {
        let (file, text) = (folder.join(&self.main), &self.files[&self.main]);
        Ok(match self.kind {
            UnitKind::Link => Rc::new(LinkUnitModel::new(&file, text)?),
            UnitKind::Slave => {
                let missing = || Wrong::of("cycle-time-us", "none", "that of the slave");
                let cycle = self.cycle.ok_or_else(missing)?;
                Rc::new(SlaveUnitModel::new(&file, text, cycle)?)
            }
        })
    }

    /// Token that distinguishes the unit from all others: another file, or another version of the library, is another unit.
    #[must_use]
    pub fn token(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(env!("CARGO_PKG_VERSION"));
        for (name, text) in self.all() {
            // With their lengths, or two files could be the same as one.
            hash.update((name.len() as u64).to_le_bytes());
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(name);
            hash.update(text);
        }
        let digest = hash.finalize();
        let hex: String = digest[..16]
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        format!("coaxle-{}-{hex}", self.kind)
    }

    /// Files with their names: the list of them, and the others in the order of their names.
    pub fn all(&self) -> impl Iterator<Item = (String, String)> {
        let listed = (MANIFEST.to_owned(), self.manifest());
        let files = self.files.iter();
        std::iter::once(listed).chain(files.map(|(name, text)| (name.clone(), text.clone())))
    }

    fn manifest(&self) -> String {
        let names: Vec<_> = self.files.keys().map(|name| quoted(name)).collect();
        let cycle = self.cycle.map_or_else(String::new, |cycle| {
            format!("cycle-time-us = {}\n", cycle.span().as_micros_f64())
        });
        let (kind, main, names) = (self.kind, quoted(&self.main), names.join(", "));
        format!("kind = \"{kind}\"\n{cycle}main = {main}\nfiles = [{names}]\n")
    }
}

/// A text in TOML: JSON's escapes are among TOML's.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Refuses paths that lead out of the folder of resources.
fn check_path(name: &str) -> Result<(), Wrong> {
    let path = Path::new(name);
    let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_));
    if !name.is_empty() && !name.contains('\\') && path.components().all(is_plain) {
        return Ok(());
    }
    let expected = "a path in the folder of the unit's main file, without \"..\"";
    Err(Wrong::of("file", format!("{name:?}"), expected))
}
