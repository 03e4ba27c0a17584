//! The pages of `coaxle cam edit` and `coaxle saw edit`, in a real browser.

use std::path::Path;
use std::process::{Command, Stdio};

use coaxle_test_process::{Process, until};
use serde_json::{Value, json};

use crate::watched::browser::Browser;
use crate::watched::line::{Line, log_text, printed};
use crate::watched::page::keep;

/// The tool that serves the page of a file.
struct Editor {
    _tool: Process,
    address: String,
}

impl Editor {
    fn of(folder: &Path, what: &str, file: &Path, options: &[&str]) -> Self {
        let log = folder.join(format!("{what}-edit.log"));
        let out = std::fs::File::create(&log).expect("a log");
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.args([what, "edit"]).arg(file);
        command.args(["--page", "127.0.0.1:0"]).args(options);
        command.stdin(Stdio::null()).stdout(out);
        let errors = log.with_extension("errors");
        let mut editor = Self {
            _tool: Process::start("the editor", &mut command, &errors),
            address: String::new(),
        };
        until("it says where the page is", || {
            let text = log_text(&log);
            let address = text.strip_prefix("the page is at ");
            editor.address = address.unwrap_or_default().trim().to_owned();
            text.ends_with('\n')
        });
        editor
    }
}

const CHART: &str = ".chart[data-quantity='0']";

/// State of the page, polled until a condition holds.
struct Page<'a>(&'a Browser);

impl Page<'_> {
    fn until(&self, script: &str) {
        until(script, || {
            self.0.run(&format!("return Boolean({script})")) == Value::Bool(true)
        });
    }

    /// Waits until no request is under way.
    fn rest(&self) {
        self.until("page.answer && !page.isBusy && page.queue.length === 0 && !charts.drag");
    }

    /// The place of a chart's values on the screen, from the middle of the chart.
    fn place(&self, quantity: u32, along: f64, value: f64) -> (i64, i64) {
        self.rest();
        let script = format!(
            "const c = charts.canvases[{quantity}], p = charts.place({quantity}); \
             return [Math.round(p.x({along}) - c.clientWidth / 2), Math.round(p.y({value}) - c.clientHeight / 2)]"
        );
        let place = self.0.run(&script);
        let number = |n: usize| place[n].as_i64().expect("a number");
        (number(0), number(1))
    }

    /// Enters a value into a field as a user does, and leaves the field.
    fn fill(&self, label: &str, value: &str) {
        self.rest();
        let (label, value) = (json!(label), json!(value));
        self.0.run(&format!(
            "const f = document.querySelector(`[aria-label='${{{label}}}']`); f.value = {value}; \
             f.dispatchEvent(new Event('change', {{ bubbles: true }}))"
        ));
        self.rest();
    }

    fn press(&self, selector: &str) {
        self.rest();
        self.0.run(&format!(
            "document.querySelector({}).click()",
            json!(selector)
        ));
        self.rest();
    }

    fn told(&self) -> String {
        let told = self
            .0
            .run("return document.getElementById('told').textContent");
        told.as_str().unwrap_or_default().to_owned()
    }
}

const CUTTER: &str = "cycle-time-us = 2000\n\
    [[virtual-axis]]\nid = 1\nname = 'shaft'\nunit = '°'\n\
    [virtual-axis.program]\nlimits = { velocity = 720, acceleration = 7200, jerk = 72000 }\n\
    steps = [{ enable = true }, { velocity = { value = 360 } }]\n\
    [[slave]]\nname = 'knife'\ncouple = 'off'\nlimits = { velocity = 2000, acceleration = 40000, jerk = 2e6 }\n";

/// Designed in the browser from scratch, saved, loaded into a running receiver, coupled, and changed while it runs.
#[test]
fn a_plate_is_designed_from_scratch_and_run() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let mut line = Line::new();
    line.start("receiver", "cutter", CUTTER);
    let file = line.folder.path().join("press.toml");
    let mut options = vec!["--node", "cutter", "--slave", "knife", "--table", "3"];
    for endpoint in &line.endpoints {
        options.extend(["--connect", endpoint]);
    }
    let editor = Editor::of(line.folder.path(), "cam", &file, &options);
    browser.open(&format!("{}#acceleration=20000", editor.address));
    let page = Page(&browser);
    page.until("page.answer && page.answer.is_new");
    page.fill("Title", "Press");
    browser.double_click(CHART, page.place(0, 180.0, 0.8));
    page.until("page.answer.view.points.length === 3");
    // Dragged up; of a drag one step is undone.
    browser.drag(CHART, page.place(0, 180.0, 0.8), page.place(0, 180.0, 0.99));
    page.rest();
    page.fill("point 2 slave", "60");
    page.fill("point 2 master", "180");
    browser.drag(
        CHART,
        page.place(0, 180.0, 60.0),
        page.place(0, 120.0, 40.0),
    );
    page.rest();
    let moved = browser.run("return page.answer.view.points[1]");
    let (master, slave) = (moved["master"].as_f64(), moved["slave"].as_f64());
    // A pixel of the chart is some tenths of a degree, and places are rounded.
    assert!((master.expect("a number") - 120.0).abs() < 2.0, "{moved}");
    assert!((slave.expect("a number") - 40.0).abs() < 1.0, "{moved}");
    page.press("#undo");
    assert_eq!(browser.run("return page.answer.view.points[1].slave"), 60);
    page.press("#redo");
    page.press("#undo");
    // Advised laws, one of which is taken.
    page.until("document.querySelectorAll('#advice tbody tr').length > 10");
    page.press("#advice tbody tr:first-child button");
    page.until("document.querySelectorAll('#points .mark').length === 9");
    let law = browser.run("return page.answer.view.points[1].law");
    page.press("#save");
    let text = std::fs::read_to_string(&file).expect("the file");
    let law = law.as_str().expect("a law");
    assert!(
        text.contains("title = \"Press\"") && text.contains(law),
        "{text}"
    );
    keep(&browser, "designer.png");

    for (button, expected) in [
        ("load", "accepted"),
        ("power", "accepted"),
        ("couple", "accepted"),
    ] {
        page.press(&format!("[data-do='{button}']"));
        let told = page.told();
        assert!(told.contains(expected), "{button}: {told}");
    }
    let info = |line: &Line| {
        let asked = line.run_tool(&[
            "command", "cutter", "knife", "cam-info", "--table", "3", "--json",
        ]);
        serde_json::from_str::<Value>(&printed(&asked)).unwrap_or_default()
    };
    until("it is coupled", || {
        info(&line)["axis"]["coupling"] == "in-sync"
    });
    // Changed while it runs.
    page.fill("point 2 slave", "45");
    page.press("[data-do='load']");
    assert!(page.told().contains("accepted"), "{}", page.told());
    let top = || {
        let asked = line.run_tool(&[
            "command",
            "cutter",
            "knife",
            "read-motion-function-point",
            "--table=3",
            "--point=2",
            "--json",
        ]);
        let read: Value = serde_json::from_str(&printed(&asked)).unwrap_or_default();
        read["cam"]["points"]["points"][0]["slave"].clone()
    };
    until("the new plate is in force", || top() == 45.0);
    assert_eq!(info(&line)["axis"]["coupling"], "in-sync");
    page.press("[data-do='uncouple']");
    assert!(page.told().contains("accepted"), "{}", page.told());
}

/// A refused saw is shown with its remedies, and passes with one of them.
#[test]
fn a_saw_is_moved_until_it_passes() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a scratch folder");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/saws/too-close.toml");
    let file = folder.path().join("saw.toml");
    std::fs::copy(shipped, &file).expect("a copy");
    let editor = Editor::of(folder.path(), "saw", &file, &[]);
    browser.open(&editor.address);
    let page = Page(&browser);
    page.until("page.answer && page.answer.view.refusal");
    page.press("#remedies button");
    page.until("page.answer.view.plan");
    // The slider is moved until it is refused again: the limit is at the stated place.
    let slider = "[aria-label='gear-in-pos.master-sync-position slider']";
    browser.run(&format!(
        "const s = document.querySelector(\"{slider}\"); s.value = 150; s.dispatchEvent(new Event('input')); \
         s.dispatchEvent(new Event('change'))"
    ));
    page.until("page.answer.view.refusal && page.answer.view.curves[0].is_faint");
    page.press("#undo");
    page.until("page.answer.view.plan");
    keep(&browser, "saw-editor.png");
    page.press("#save");
    let text = std::fs::read_to_string(&file).expect("the file");
    assert!(text.contains("# The belt is measured."), "{text}");
    assert!(!text.contains("master-sync-position = 200"), "{text}");
}
