//! The structure of the code itself: no circle between the modules of a crate, one place for the operating system, and no Zenoh
//! where a change is to be tried in seconds.
//!
//! That crates have none, the compiler sees to. Within a crate, the modules beside each other, each
//! with all that is below it, use one another in one direction only; a module and its own parent may
//! use each other.

mod circles;
mod modules;
mod system;
mod transport;

use std::path::{Path, PathBuf};

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

#[test]
fn one_module_alone_knows_the_operating_system() {
    let mut found = Vec::new();
    for member in members()
        .iter()
        .filter(|member| !member.starts_with("tests"))
    {
        let source = root().join(member).join("src");
        found.extend(system::lines_that_name_it(&source, "common/os/src/system"));
    }
    assert!(found.is_empty(), "outside of it:\n{}", found.join("\n"));
}
