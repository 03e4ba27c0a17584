//! Samples and checks for the tests of commands.

use std::path::{Path, PathBuf};

use serde_json::Value;

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

/// The figure of a page, as a browser would read it.
pub(crate) fn figure_of(page: &str, id: &str) -> Value {
    let (_, rest) = page
        .split_once(&format!("id=\"{id}-figure\">"))
        .expect("a figure");
    let (json, _) = rest.split_once("</script>").expect("an end");
    serde_json::from_str(json).expect("JSON")
}

/// A page loads nothing from elsewhere, and runs only the plotting library and its own script.
pub(crate) fn stands_alone(page: &str) {
    // The plotting library, the figure, and the page's own script.
    assert_eq!(page.matches("</script>").count(), 3);
    let own: String = page
        .split("<script")
        .filter(|part| !part.contains("plotly.js v"))
        .collect();
    for reference in ["http:", "https:", "src=", "href=", "@import"] {
        assert!(!own.contains(reference), "{reference}");
    }
}
