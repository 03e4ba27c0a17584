//! Crates that are built without Zenoh.

use std::process::Command;

/// Crates to check, with all their dependencies, tests included.
const WITHOUT: [&str; 6] = [
    "coaxle-os",
    "coaxle-lab",
    "coaxle-report",
    "coaxle-fmi",
    "coaxle-fmu",
    "coaxle-virtual-tests",
];

/// First words of crates of a server or a transport.
const NOT_THERE: [&str; 2] = ["zenoh", "hyper"];

/// Finds crates with such a dependency, by the tree of cargo.
#[test]
fn the_lab_the_report_the_units_and_the_tests_of_virtual_time_need_no_zenoh() {
    let mut found = Vec::new();
    for package in WITHOUT {
        let mut tree = Command::new(env!("CARGO"));
        tree.current_dir(super::root());
        // Offline: the lock file decides, and a test needs no network. `-e all` has build and test dependencies.
        tree.args(["tree", "--offline", "--prefix", "none", "-e", "all"]);
        let tree = tree.args(["-p", package]).output().expect("cargo");
        let (text, error) = (
            String::from_utf8_lossy(&tree.stdout),
            String::from_utf8_lossy(&tree.stderr),
        );
        // An error prints nothing, which would pass.
        assert!(text.starts_with(package), "{package}: {error}");
        let needed = text.lines().filter(|line| {
            // `zenoh-link-tcp v1.10.2` has `zenoh` as its first word.
            let name = line.split([' ', '-']).next().unwrap_or_default();
            NOT_THERE.contains(&name)
        });
        found.extend(needed.map(|line| format!("{package}: {line}")));
    }
    assert!(found.is_empty(), "needed:\n{}", found.join("\n"));
}
