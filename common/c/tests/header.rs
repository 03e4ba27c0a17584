//! The header is what cbindgen makes of the sources.

use std::path::Path;

#[test]
fn the_header_is_what_the_sources_say() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml")).expect("its config");
    let made = cbindgen::Builder::new()
        .with_config(config)
        .with_crate(package)
        .generate()
        .expect("the sources can be read");
    let mut expected = Vec::new();
    made.write(&mut expected);
    let expected = without_rust(&String::from_utf8(expected).expect("UTF-8"));
    let path = package.join("include/coaxle.h");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::create_dir_all(package.join("include")).expect("its folder");
        std::fs::write(&path, &expected).expect("the header can be written");
    }
    let written = std::fs::read_to_string(&path).expect("include/coaxle.h");
    assert!(
        written == expected,
        "include/coaxle.h is not what the sources say: UPDATE_DOCS=1 writes it"
    );
}

/// Leaves out what is for readers of the Rust alone.
fn without_rust(header: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    for line in header.lines() {
        let is_rule = ["// # Safety", "// The rules of the header."];
        if is_rule.contains(&line.trim()) {
            // Its empty line too.
            if lines.last().is_some_and(|last| last.trim() == "//") {
                lines.pop();
            }
            continue;
        }
        lines.push(line);
    }
    lines.join("\n") + "\n"
}
