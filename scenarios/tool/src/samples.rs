//! Samples and checks for the tests of commands.

use std::path::{Path, PathBuf};

use coaxle_report::figure::{Curve, Data, Panel};

/// A folder of the scenarios.
pub(crate) fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

/// The TOML files in it.
pub(crate) fn shipped(name: &str) -> Vec<PathBuf> {
    let files = std::fs::read_dir(folder(name)).expect("the folder is there");
    let mut files: Vec<_> = files
        .map(|file| file.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    files
}

/// The TOML blocks of a handbook.
pub(crate) fn examples_of(handbook: &str) -> Vec<String> {
    let path = folder("../docs").join(handbook);
    let text = std::fs::read_to_string(path).expect("the handbook is there");
    let blocks = text.split("```toml\n").skip(1);
    blocks
        .map(|block| block.split("```").next().unwrap_or_default().to_owned())
        .collect()
}

/// The points of each curve of a panel, by name.
pub(crate) fn curves_of(panel: &Panel) -> Vec<(&Curve, &[(f64, f64)])> {
    let points = panel.curves.iter().map(|curve| match &curve.data {
        Data::Points(points) | Data::Course(points) => points.as_slice(),
        Data::Levels { .. } => panic!("no points"),
    });
    panel.curves.iter().zip(points).collect()
}

/// A page is small, loads nothing from elsewhere, and runs only its own scripts.
pub(crate) fn stands_alone(page: &str) {
    // Its own scripts, and the figure.
    let own = coaxle_report::page::document("", "");
    let scripts = |page: &str| page.matches("</script>").count();
    assert_eq!(scripts(page), scripts(&own) + 1);
    for reference in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert!(page.len() < 200_000, "{} bytes", page.len());
}
