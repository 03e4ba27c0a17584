//! Lengths of the source files, tests and benches included.

use std::path::{Path, PathBuf};

/// Most lines of a file: a longer one is a sign that two ideas share a room.
const MOST: usize = 500;

#[test]
fn no_file_is_longer_than_a_room_of_one_idea() {
    let mut files = files_below(&super::root());
    files.retain(|file| file.extension().is_some_and(|ending| ending == "rs"));
    // A folder that was not found would pass.
    assert!(files.len() > 1_000, "{}", files.len());
    let long: Vec<_> = files.iter().filter_map(|file| beyond(file)).collect();
    assert!(
        long.is_empty(),
        "more than {MOST} lines: split each where two ideas meet\n{}",
        long.join("\n")
    );
}

/// The file with its number of lines, if that is too large.
fn beyond(file: &Path) -> Option<String> {
    let text = std::fs::read_to_string(file).expect("readable source");
    let lines = text.lines().count();
    (lines > MOST).then(|| format!("{}: {lines}", file.display()))
}

/// Every file below a folder, except what is built and what is hidden.
pub(crate) fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        let name = path.file_name().and_then(|name| name.to_str());
        if path.is_dir() {
            // A clone may keep what it builds under any name that begins so, and its versions in a hidden folder.
            if !name.is_some_and(|name| name.starts_with("target") || name.starts_with('.')) {
                found.extend(files_below(&path));
            }
        } else {
            found.push(path);
        }
    }
    found
}
