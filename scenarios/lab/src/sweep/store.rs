//! The runs of a sweep in its folder, so that an interrupted one continues where it was.
//!
//! `sweep.toml` identifies the sweep. `runs/PROGRAM/KEY.toml` has the record of a run. The key is of the scenario at its point
//! with its seed, as TOML, so that any change of it makes another run; the program is the very file that runs.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use anyhow::Context;
use coaxle_os::exit::wrong_argument;
use coaxle_os::{Os, System};
use serde::{Deserialize, Serialize};

use super::record::RunRecord;
use crate::results_folder::ResultsFolder;
use crate::scenario::Scenario;

/// Identity of a sweep, whose points share one folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct SweepIdentity {
    /// The scenario's name.
    pub(super) scenario: String,
    /// The fields of the axes.
    pub(super) fields: Vec<String>,
    /// Fields set at all points.
    pub(super) set: Vec<String>,
    /// The only receivers; all if empty.
    pub(super) receivers: Vec<String>,
    /// The scenario's text without its grid.
    pub(super) text: String,
}

/// The folder of a sweep.
#[derive(Debug)]
pub(super) struct Store {
    runs: PathBuf,
}

const IDENTITY: &str = "sweep.toml";
const RUNS: &str = "runs";

impl Store {
    /// Opens the folder of this sweep; of a new one where it is empty, or if `is_fresh`.
    ///
    /// # Errors
    /// The folder of another sweep, and files that cannot be read or written.
    pub(super) fn open(
        folder: &ResultsFolder,
        identity: &SweepIdentity,
        is_fresh: bool,
    ) -> anyhow::Result<Self> {
        let (all, path) = (folder.file(RUNS), folder.file(IDENTITY));
        let before = read(&path)?;
        if let (Some(before), false) = (&before, is_fresh) {
            identity.check_same(before).or_else(|what| wrong_argument(format!(
                "{}: received the folder of a sweep {what}; expected the same sweep, another folder (--out DIR), or --fresh to \
                 begin this one anew",
                path.display()
            )))?;
        }
        let text = toml::to_string(identity).context("cannot write the sweep as TOML")?;
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        let runs = all.join(program().context("cannot read the program itself")?);
        // Files in the folder of no sweep belong to others.
        if before.is_some() {
            remove_old(&all, &runs, is_fresh)?;
        }
        make(&runs)?;
        Ok(Self { runs })
    }

    /// Path of the record of a run, present or not.
    ///
    /// # Errors
    /// A scenario that TOML cannot express.
    pub(super) fn place(&self, scenario: &Scenario) -> anyhow::Result<PathBuf> {
        let mut scenario = scenario.clone();
        // A point is equal in another grid.
        scenario.grid.clear();
        let text = toml::to_string(&scenario).context("cannot write the scenario as TOML")?;
        // Its algorithm may change with the compiler, but then the program is another one and has another folder.
        // 64 bits: among 10 000 runs two share a key with a probability of 3e-12.
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        Ok(self.runs.join(format!("{:016x}.toml", hasher.finish())))
    }
}

/// Loads the record of a run; none where it is missing, or incomplete.
pub(super) fn load(place: &Path) -> Option<RunRecord> {
    toml::from_str(&fs::read_to_string(place).ok()?).ok()
}

/// Writes the record of a run, as a whole or not at all, however the program ends.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn keep(place: &Path, record: &RunRecord) -> anyhow::Result<()> {
    let cannot = || format!("cannot write {}", place.display());
    let text = toml::to_string(record).with_context(cannot)?;
    let unfinished = place.with_extension("new");
    fs::write(&unfinished, text).with_context(cannot)?;
    // A rename replaces a file at once or not at all, so that a crash leaves no half a record under this name.
    fs::rename(&unfinished, place).with_context(cannot)
}

impl SweepIdentity {
    /// Compares two identities. The error names the difference.
    fn check_same(&self, other: &Self) -> Result<(), String> {
        let list = |items: &[String]| match items {
            [] => "none".to_owned(),
            items => items.join(", "),
        };
        if other.scenario != self.scenario {
            return Err(format!("of the scenario {}", other.scenario));
        }
        for (what, theirs, own) in [
            ("over the fields", &other.fields, &self.fields),
            ("with --set", &other.set, &self.set),
            ("with --receivers", &other.receivers, &self.receivers),
        ] {
            if theirs != own {
                let (theirs, own) = (list(theirs), list(own));
                return Err(format!("{what} {theirs} (this one: {own})"));
            }
        }
        if other.text != self.text {
            return Err("of another text of the scenario".to_owned());
        }
        Ok(())
    }
}

fn read(path: &Path) -> anyhow::Result<Option<SweepIdentity>> {
    let text = match fs::read_to_string(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        text => text.with_context(|| format!("cannot read {}", path.display()))?,
    };
    let Ok(identity) = toml::from_str(&text) else {
        return wrong_argument(format!(
            "{}: received another file, expected that of a sweep, or another folder (--out DIR)",
            path.display()
        ));
    };
    Ok(Some(identity))
}

/// Hash of the running file: its behaviour may change without its version.
fn program() -> io::Result<String> {
    let mut file = Os::own_program()?;
    // A megabyte at a time: a hash needs no more of the program in memory.
    let (mut hasher, mut piece) = (DefaultHasher::new(), vec![0; 1 << 20]);
    loop {
        match file.read(&mut piece)? {
            0 => break,
            length => hasher.write(&piece[..length]),
        }
    }
    Ok(format!("{:016x}", hasher.finish()))
}

/// Removes the runs of other programs, and of this one, too, if `is_fresh`.
fn remove_old(all: &Path, own: &Path, is_fresh: bool) -> anyhow::Result<()> {
    // A folder may lack it, as its user may have deleted the runs.
    make(all)?;
    let cannot = || format!("cannot read {}", all.display());
    for entry in fs::read_dir(all).with_context(cannot)? {
        let path = entry.with_context(cannot)?.path();
        if path == own && !is_fresh {
            continue;
        }
        if path != own && !is_fresh {
            tracing::warn!(
                "{}: of another program; its runs are run again",
                path.display()
            );
        }
        fs::remove_dir_all(&path).with_context(|| format!("cannot remove {}", path.display()))?;
    }
    Ok(())
}

fn make(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog;

    fn identity() -> SweepIdentity {
        SweepIdentity {
            scenario: "beat".to_owned(),
            fields: vec!["network.loss".to_owned()],
            set: Vec::new(),
            receivers: Vec::new(),
            text: "title = \"x\"\n".to_owned(),
        }
    }

    fn record() -> RunRecord {
        RunRecord {
            judged: 1,
            failures: vec!["a \"quoted\"\nline".to_owned()],
            rows: Vec::new(),
        }
    }

    #[test]
    fn what_is_kept_is_there_when_the_folder_is_opened_again() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = ResultsFolder::hold(scratch.path()).unwrap();
        let scenario = |set: &str| {
            let source = catalog::find("observer-sweep").unwrap();
            source.read(&[set.to_owned()]).unwrap()
        };
        let store = Store::open(&folder, &identity(), false).unwrap();
        let place = store.place(&scenario("seed=1")).unwrap();
        assert_eq!(load(&place), None);
        keep(&place, &record()).unwrap();
        let store = Store::open(&folder, &identity(), false).unwrap();
        assert_eq!(
            load(&store.place(&scenario("seed=1")).unwrap()),
            Some(record())
        );
        // The key of a point does not depend on the grid.
        assert_eq!(store.place(&scenario("sweep=[]")).unwrap(), place);
        assert_eq!(load(&store.place(&scenario("seed=2")).unwrap()), None);
        Store::open(&folder, &identity(), true).unwrap();
        assert_eq!(load(&place), None);
    }

    #[test]
    fn what_is_not_whole_is_not_there_and_other_programs_have_left_nothing() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = ResultsFolder::hold(scratch.path()).unwrap();
        let theirs = folder.file(RUNS).join("another");
        fs::create_dir_all(&theirs).unwrap();
        Store::open(&folder, &identity(), false).unwrap();
        assert!(theirs.exists(), "it was in the folder of no sweep");
        let store = Store::open(&folder, &identity(), false).unwrap();
        assert!(!theirs.exists());
        let place = store.runs.join("x.toml");
        keep(&place, &record()).unwrap();
        let text = fs::read_to_string(&place).unwrap();
        fs::write(&place, &text[..text.len() / 2]).unwrap();
        assert_eq!(load(&place), None);
    }

    #[test]
    fn the_folder_of_another_sweep_is_refused_and_left_alone() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = ResultsFolder::hold(scratch.path()).unwrap();
        Store::open(&folder, &identity(), false).unwrap();
        let other = |change: fn(&mut SweepIdentity)| {
            let mut other = identity();
            change(&mut other);
            other
        };
        for (other, part) in [
            (
                other(|it| it.scenario = "jitter".to_owned()),
                "of the scenario beat",
            ),
            (
                other(|it| it.fields.clear()),
                "over the fields network.loss (this one: none)",
            ),
            (
                other(|it| it.set.push("a=1".to_owned())),
                "with --set none (this one: a=1)",
            ),
            (other(|it| it.text.clear()), "of another text"),
        ] {
            let error = Store::open(&folder, &other, false).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains("--fresh"), "{error}");
        }
        assert_eq!(read(&folder.file(IDENTITY)).unwrap(), Some(identity()));
        fs::write(folder.file(IDENTITY), "else").unwrap();
        for is_fresh in [false, true] {
            let error = Store::open(&folder, &identity(), is_fresh).unwrap_err();
            assert!(error.to_string().contains("another file"), "{error}");
        }
    }
}
