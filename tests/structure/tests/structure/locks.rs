//! Lock files of the workspaces beside this one: a dependency that a crate has gained is missing in them until cargo writes them
//! again, and `--locked` then ends their builds.

use std::collections::BTreeMap;

use toml::{Table, Value};

/// Folders with a workspace of their own.
const BESIDE: [&str; 2] = ["tests/fuzz", "tests/no-std"];

#[test]
fn lock_files_of_other_workspaces_have_the_dependencies_of_our_crates() {
    let manifests = manifests();
    let mut missing = Vec::new();
    for folder in BESIDE {
        let lock = table(&format!("{folder}/Cargo.lock"));
        let packages = lock["package"].as_array().expect("a list").iter();
        for package in packages.filter_map(Value::as_table) {
            let name = package["name"].as_str().expect("a name");
            let Some(manifest) = manifests.get(name) else {
                continue;
            };
            let locked = list(package.get("dependencies"));
            let wanted = own_dependencies(manifest, &manifests);
            let wanted = wanted.filter(|wanted| !locked.iter().any(|other| other == wanted));
            missing.extend(wanted.map(|wanted| format!("{folder}/Cargo.lock: {name} -> {wanted}")));
        }
    }
    assert!(
        missing.is_empty(),
        "missing, cargo metadata --manifest-path FOLDER/Cargo.toml adds them:\n{}",
        missing.join("\n")
    );
}

fn table(path: &str) -> Table {
    let text = std::fs::read_to_string(super::root().join(path)).expect(path);
    text.parse().expect(path)
}

/// The manifests of all members by the names of their packages.
fn manifests() -> BTreeMap<String, Table> {
    let manifest = |member: String| {
        let manifest = table(&format!("{member}/Cargo.toml"));
        let name = manifest["package"]["name"].as_str().expect("a name");
        (name.to_owned(), manifest)
    };
    super::members().into_iter().map(manifest).collect()
}

fn list(value: Option<&Value>) -> Vec<&str> {
    let values = value.and_then(Value::as_array).into_iter().flatten();
    values.filter_map(Value::as_str).collect()
}

/// Members that a crate needs whatever its features are.
fn own_dependencies<'a>(
    manifest: &'a Table,
    members: &'a BTreeMap<String, Table>,
) -> impl Iterator<Item = &'a str> {
    let dependencies = manifest.get("dependencies").and_then(Value::as_table);
    let dependencies = dependencies.into_iter().flatten();
    dependencies
        .filter(|(_, value)| value.get("optional").and_then(Value::as_bool) != Some(true))
        .map(|(name, _)| name.as_str())
        .filter(|name| members.contains_key(*name))
}
