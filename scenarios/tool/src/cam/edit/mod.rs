//! `coaxle cam edit`: a plate designed on a page.

mod change;
mod curves;
mod points;
mod target;
#[cfg(test)]
mod tests;
mod view;
mod view_settings;

use std::path::{Path, PathBuf};

use clap::Args;
use coaxle_files::cam::{CamFile, MOST_BYTES};
use coaxle_os::exit::Exit;
use coaxle_plate::Plate;
use serde_json::Value;

use self::target::{CommandTarget, TargetArgs};
use self::view_settings::ViewSettings;
use super::load;
use crate::edit::{Design, EditArgs, PageParts, edit};

/// The plate, the file it is compared with, and the slave it is loaded into.
#[derive(Debug, Args)]
pub struct CamEditArgs {
    #[command(flatten)]
    edit: EditArgs,
    /// Another cam file to compare the plate with
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    #[command(flatten)]
    target: TargetArgs,
}

const PARTS: PageParts = PageParts {
    html: include_str!("page.html"),
    js: include_str!("page.js"),
};

/// Serves the page until Ctrl-C.
///
/// # Errors
/// A file that cannot be read, a network that cannot be joined, or an address that is not available.
pub(crate) fn run(args: &CamEditArgs) -> anyhow::Result<Exit> {
    let compared = args
        .compare
        .as_deref()
        .map(ComparedPlate::load)
        .transpose()?;
    let design = CamDesign {
        path: args.edit.file.clone(),
        compared,
        target: args.target.open()?,
        last: None,
    };
    edit(&args.edit, design, PARTS)
}

/// Another plate, drawn beside this one.
struct ComparedPlate {
    name: String,
    plate: Plate,
}

impl ComparedPlate {
    fn load(path: &Path) -> anyhow::Result<Self> {
        let (_, plate) = load(path)?;
        let name = path.display().to_string();
        Ok(Self { name, plate })
    }

    fn parse(name: &str, text: &str) -> Result<Self, String> {
        let cam = CamFile::parse(Path::new(name), text).map_err(|error| error.to_string())?;
        let plate = cam.plate().map_err(|error| error.to_string())?;
        let name = name.to_owned();
        Ok(Self { name, plate })
    }
}

/// A plate on a page.
struct CamDesign {
    /// Name of the file in errors. CSV files are read from its folder.
    path: PathBuf,
    compared: Option<ComparedPlate>,
    /// A running receiver, if there is one to load the plate into.
    target: Option<CommandTarget>,
    /// The last text that made a plate: it is drawn faint while another one makes none.
    last: Option<String>,
}

// A plate that is valid at once: two points, cyclic, at rest.
const TEMPLATE: &str = "title = \"\"\ncourse = \"cyclic\"\nmaster-unit = \"°\"\nslave-unit = \"mm\"\n\n\
    [[point]]\nlaw = \"polynom5\"\nmaster = 0\nslave = 0\n\n[[point]]\nmaster = 360\nslave = 0\n";

impl CamDesign {
    fn plate(&self, text: &str) -> Result<(CamFile, Plate), String> {
        let cam = CamFile::parse(&self.path, text).map_err(|error| error.to_string())?;
        let plate = cam.plate().map_err(|error| error.to_string())?;
        Ok((cam, plate))
    }
}

impl Design for CamDesign {
    const MOST_BYTES: u64 = MOST_BYTES;

    fn template(&self) -> String {
        TEMPLATE.to_owned()
    }

    fn view(&mut self, text: &str, settings: &Value) -> Value {
        let settings = match ViewSettings::of(settings) {
            Ok(settings) => settings,
            Err(error) => return serde_json::json!({ "error": error }),
        };
        // Kept as text: the view may be asked for with other settings later.
        if self.plate(text).is_ok() {
            self.last = Some(text.to_owned());
        }
        view::view(self, text, &settings)
    }

    fn changed(&mut self, text: &str, change: &Value, settings: &Value) -> Result<String, String> {
        let settings = ViewSettings::of(settings)?;
        change::changed(self, text, change, &settings)
    }

    fn check(&self, text: &str) -> Result<(), String> {
        // Stricter than reading the file: points that make no plate can be read.
        self.plate(text).map(drop)
    }

    fn act(&mut self, text: &str, wanted: &Value) -> Result<String, String> {
        // A file that the browser opens: its text comes from the page, not from a path on this PC.
        let name = wanted["compare"]["name"].as_str();
        if let (Some(name), Some(other)) = (name, wanted["compare"]["text"].as_str()) {
            self.compared = Some(ComparedPlate::parse(name, other)?);
            return Ok(format!("compared with {name}"));
        }
        match wanted["do"].as_str() {
            Some("compare-with-this") => {
                let (_, plate) = self.plate(text)?;
                let name = "as it was".to_owned();
                self.compared = Some(ComparedPlate { name, plate });
                Ok("compared with the plate as it is now".to_owned())
            }
            Some("compare-with-none") => {
                self.compared = None;
                Ok(String::new())
            }
            _ => {
                // Checked here, before a running receiver is asked at all.
                let (cam, _) = self.plate(text)?;
                let target = self.target.as_mut();
                let target = target
                    .ok_or("there is no receiver to load it into: --node and --slave name one")?;
                target.act(&cam, wanted)
            }
        }
    }
}
