//! The structure of the code itself: no circle between the modules of a crate, one place for the operating system, and no Zenoh
//! where a change is to be tried in seconds; and of its pages: no link that leads nowhere, no translation that is behind.
//!
//! Between crates, the compiler excludes circles. Within a crate, sibling modules, each
//! with all that is below it, use one another in one direction only; a module and its own parent may
//! use each other.

mod circles;
mod file_sizes;
mod language;
mod links;
mod locks;
mod modules;
mod pages;
mod system;
mod translations;
mod transport;

use std::path::{Path, PathBuf};

use language::{Figures, Source};
use modules::Crate;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The folders of the workspace's members, as the manifest has them.
fn members() -> Vec<String> {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).expect("the manifest");
    let manifest: toml::Table = manifest.parse().expect("the manifest is TOML");
    let members = manifest["workspace"]["members"].as_array().expect("a list");
    members
        .iter()
        .map(|member| member.as_str().expect("a folder").to_owned())
        .collect()
}

#[test]
fn no_crate_has_a_circle_between_its_modules() {
    let mut found = Vec::new();
    for member in members() {
        let library = root().join(&member).join("src/lib.rs");
        if !library.exists() {
            continue;
        }
        let circles = circles::of(&Crate::read(&library));
        found.extend(circles.iter().map(|circle| format!("{member}: {circle}")));
    }
    assert!(found.is_empty(), "circles:\n{}", found.join("\n"));
}

/// The sources of the members that are no tests, below this folder of each.
fn sources_of_members(below: &str) -> Vec<Source> {
    let mut sources = Vec::new();
    for member in members()
        .iter()
        .filter(|member| !member.starts_with("tests"))
    {
        let folder = root().join(member).join(below);
        if folder.exists() {
            language::sources_below(&folder, &root(), &mut sources);
        }
    }
    // A folder that was not found would pass every bound.
    assert!(sources.len() > 500, "{}", sources.len());
    sources
}

#[test]
fn one_module_alone_knows_the_operating_system() {
    let found = system::lines_naming_a_system(&sources_of_members("src"), "common/os/src/system");
    assert!(found.is_empty(), "outside of it:\n{}", found.join("\n"));
}

/// A figure of the code, and the least and the most that it may be.
struct Bound<'a> {
    what: &'static str,
    figure: f64,
    least: f64,
    most: f64,
    places: &'a [String],
}

impl Bound<'_> {
    /// The figure, and the last places of those that it counts: new ones are mostly among them.
    fn report(&self) -> String {
        let last = &self.places[self.places.len().saturating_sub(20)..];
        let Self {
            what,
            figure,
            least,
            most,
            ..
        } = self;
        format!(
            "{what}: {figure:.2}, expected {least} to {most}; among them\n{}",
            last.join("\n")
        )
    }

    fn is_kept(&self) -> bool {
        (self.least..=self.most).contains(&self.figure)
    }
}

#[test]
fn the_language_is_plain() {
    let figures = Figures::of(&sources_of_members("."));
    let bounds = bounds(&figures);
    println!(
        "{} files, {} lines of code, {} doc comments",
        figures.files, figures.code_lines, figures.doc_comments
    );
    for bound in &bounds {
        println!(
            "{:>8.2} of {:>4.1} to {:>6.1}  {}",
            bound.figure, bound.least, bound.most, bound.what
        );
    }
    let beyond = bounds.iter().filter(|bound| !bound.is_kept());
    let beyond: Vec<_> = beyond.map(Bound::report).collect();
    assert!(beyond.is_empty(), "{}", beyond.join("\n"));
}

/// The bounds of comparable projects, which `docs/CONTRIBUTING.md` names; of shared names the present number, which may only fall.
fn bounds(figures: &Figures) -> [Bound<'_>; 9] {
    let bound = |what, figure, most, places| Bound {
        what,
        figure,
        least: 0.0,
        most,
        places,
    };
    let percent = |places| figures.percent(places);
    let number = |places: &[String]| places.len() as f64;
    [
        bound(
            "% of doc comments open with a clause (\"What …\", \"Whether …\")",
            percent(&figures.clauses),
            6.0,
            &figures.clauses,
        ),
        bound(
            "% of doc comments open with a pronoun (\"It …\", \"One …\")",
            percent(&figures.pronouns),
            // Worst of the seven projects, so that no bound asks for more than good code has.
            0.3,
            &figures.pronouns,
        ),
        bound(
            "doc comments open with \"The same\"",
            number(&figures.repetitions),
            1.0,
            &figures.repetitions,
        ),
        bound(
            "comments have a word that the glossary replaces",
            number(&figures.replaced),
            0.0,
            &figures.replaced,
        ),
        bound(
            "names in 10 000 lines are bound twice to hand an error on",
            figures.per_ten_thousand(figures.rebound.len()),
            12.0,
            &figures.rebound,
        ),
        bound(
            "% of files have more than 400 lines",
            100.0 * figures.long.len() as f64 / figures.files as f64,
            13.0,
            &figures.long,
        ),
        bound(
            "type names stand for several types",
            number(&figures.shared_names),
            110.0,
            &figures.shared_names,
        ),
        bound(
            "type names in 10 000 lines stand for several types",
            figures.per_ten_thousand(figures.shared_names.len()),
            11.7,
            &figures.shared_names,
        ),
        Bound {
            what: "comments beside 100 lines of code",
            figure: 100.0 * figures.reasons as f64 / figures.code_lines as f64,
            least: 3.0,
            most: 10.7,
            places: &[],
        },
    ]
}

/// Names that a generator puts together: `GearInPosAtdouble` is no word of a reader.
#[test]
fn pages_have_no_generated_names() {
    let docs = std::fs::read_dir(root().join("docs")).expect("the docs");
    let mut paths: Vec<_> = docs.map(|entry| entry.expect("a file").path()).collect();
    paths.push(root().join("README.md"));
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    // An empty folder has no generated names either.
    assert!(paths.len() > 10, "{}", paths.len());
    for path in paths {
        let text = std::fs::read_to_string(&path).expect("a page");
        let found: Vec<_> = text
            .lines()
            .filter(|line| language::has_generated_name(line))
            .collect();
        assert!(found.is_empty(), "{}: {found:#?}", path.display());
    }
}
