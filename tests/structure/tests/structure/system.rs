//! Places in the source that name an operating system.

use std::path::Path;

/// Names that a portable program does not use.
const NAMES: [&str; 7] = [
    "rustix::",
    "nix::",
    "sd_notify::",
    "std::os::",
    "target_os",
    "\"/proc/",
    "\"/sys/",
];

/// The lines under a folder with such names, except in tests and in the folder that ends with `but`.
pub(crate) fn lines_naming_a_system(folder: &Path, but: &str) -> Vec<String> {
    let mut found = Vec::new();
    if folder.ends_with(but) {
        return found;
    }
    let Ok(entries) = std::fs::read_dir(folder) else {
        return found;
    };
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        let name = path.file_stem().unwrap_or_default();
        if name == "tests" {
            continue;
        }
        if path.is_dir() {
            found.extend(lines_naming_a_system(&path, but));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).expect("readable source");
            let code = text.split("#[cfg(test)]\nmod tests {").next();
            let lines = code.unwrap_or_default().lines().enumerate();
            let naming = lines.filter(|(_, line)| NAMES.iter().any(|name| line.contains(name)));
            found.extend(naming.map(|(k, line)| format!("{}:{}: {line}", path.display(), k + 1)));
        }
    }
    found
}
