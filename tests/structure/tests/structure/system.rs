//! Places in the source that name an operating system.

use super::language::Source;

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

/// The lines of the sources with such names, except in tests and below the folder `but`.
pub(crate) fn lines_naming_a_system(sources: &[Source], but: &str) -> Vec<String> {
    let mut found = Vec::new();
    for Source { path, text } in sources.iter().filter(|source| !source.path.contains(but)) {
        // A test may read the machine as it likes.
        let code = text.split("#[cfg(test)]\nmod tests {").next();
        let lines = code.unwrap_or_default().lines().enumerate();
        let naming = lines.filter(|(_, line)| NAMES.iter().any(|name| line.contains(name)));
        found.extend(naming.map(|(k, line)| format!("{path}:{}: {line}", k + 1)));
    }
    found
}
