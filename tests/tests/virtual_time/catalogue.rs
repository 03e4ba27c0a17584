//! Every scenario that comes with the tool keeps its promises in virtual time.

use coaxle::catalog::CATALOG;

#[test]
fn every_scenario_meets_its_expectations() {
    let mut failures = Vec::new();
    for (name, _) in CATALOG {
        let summary = crate::common::run(name, &[]);
        assert!(!summary.expectations.is_empty(), "{name} expects nothing");
        failures.extend(summary.failed().map(|verdict| format!("{name}: {verdict}")));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn the_shipped_files_and_the_catalogue_are_the_same() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/catalog");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the catalogue's folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    files.sort();
    let mut names: Vec<String> = CATALOG.iter().map(|(name, _)| (*name).to_owned()).collect();
    names.sort();
    assert_eq!(files, names);
}
