//! The Python package: its tests and its examples, with the extension and the tool that were just built, where
//! Python has the modules they need.

use std::path::{Path, PathBuf};
use std::process::Command;

use coaxle_tests::python;

/// A folder from which Python imports the package.
struct Package {
    folder: tempfile::TempDir,
    python: PathBuf,
}

impl Package {
    /// Absent where no Python has `modules`.
    fn with(modules: &str) -> Option<Self> {
        let python = python::with(modules)?;
        let folder = tempfile::tempdir().expect("a scratch folder");
        let package = folder.path().join("coaxle");
        std::fs::create_dir(&package).expect("a folder");
        for file in std::fs::read_dir(own("python/coaxle")).expect("the package") {
            let file = file.expect("a file").path();
            if file.is_file() {
                let name = file.file_name().expect("it has a name");
                std::fs::copy(&file, package.join(name)).expect("a copy");
            }
        }
        // A link, so that the extension just built is tested and no copy of an older one.
        std::os::unix::fs::symlink(extension(), package.join("_coaxle.abi3.so")).expect("a link");
        Some(Self { folder, python })
    }

    fn run(&self, words: &[&str]) {
        let output = Command::new(&self.python)
            .args(["-B"])
            .args(words)
            .env("PYTHONPATH", self.folder.path())
            .env("COAXLE_TOOL", env!("CARGO_BIN_EXE_coaxle-under-test"))
            // Pictures without a screen.
            .env("MPLBACKEND", "agg")
            .current_dir(self.folder.path())
            .output();
        let output = output.expect("Python runs");
        let told = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
        assert!(output.status.success(), "{words:?}: {told:?}");
    }
}

/// The extension, which is built beside this test.
fn extension() -> PathBuf {
    let test = std::env::current_exe().expect("this test");
    let beside = test.parent().expect("it lies in a folder");
    let extension = beside.join("libcoaxle_python.so");
    assert!(extension.exists(), "{}", extension.display());
    extension
}

fn own(path: &str) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/python");
    package.join(path)
}

fn text(path: &str) -> String {
    own(path).display().to_string()
}

#[test]
fn the_package_does_what_it_says() {
    if let Some(package) = Package::with("pytest, numpy, pandas, polars") {
        package.run(&[
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:cacheprovider",
            &text("tests"),
        ]);
    }
}

#[test]
fn the_examples_run_and_leave_their_pictures() {
    let Some(package) = Package::with("matplotlib, numpy, pandas") else {
        return;
    };
    for example in ["beat", "sweep", "cam"] {
        let picture = package.folder.path().join(format!("{example}.png"));
        package.run(&[
            &text(&format!("examples/{example}.py")),
            &picture.display().to_string(),
        ]);
        let bytes = std::fs::read(&picture).expect("a picture");
        assert!(
            // Signature of PNG; an empty picture is smaller.
            bytes.starts_with(b"\x89PNG") && bytes.len() > 10_000,
            "{example}"
        );
    }
}

#[test]
fn its_types_are_right() {
    if let Some(package) = Package::with("mypy, numpy") {
        let config = text("pyproject.toml");
        package.run(&["-m", "mypy", "--config-file", &config, "-p", "coaxle"]);
    }
}
