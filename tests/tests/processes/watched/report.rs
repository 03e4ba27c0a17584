//! The report of a run, in a real browser, from a file.

use std::process::{Command, Stdio};

use coaxle_test_process::until;
use serde_json::Value;

use crate::watched::browser::Browser;

#[test]
fn a_report_is_zoomed_to_single_cycles_and_measured() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let scratch = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command.args(["run", "observer", "--no-trace", "--set", "duration-s=20"]);
    command
        .arg("--out")
        .arg(scratch.path())
        .stdout(Stdio::null());
    assert!(command.status().is_ok(), "it runs");
    let page = scratch.path().join("report.html");
    browser.open(&format!("file://{}", page.display()));
    let number = |script: &str| browser.run(script).as_f64().unwrap_or_default();
    let text = |script: &str| {
        let told = browser.run(script);
        told.as_str().unwrap_or_default().to_owned()
    };
    // Figures are drawn when they come near.
    browser.run("document.querySelector('.plot').scrollIntoView()");
    until("the first figure is drawn", || {
        number("return Number(document.querySelector('.plot').dataset.to)") > 19.9
    });
    let range = "const { shown } = figures[0].panels[0]; return shown[1] - shown[0]";
    let of_all = number(range);

    // A place where every cycle is kept: there, a value is one, not a least and a most.
    browser.run(
        "document.querySelector('.places').open = true; \
         [...document.querySelectorAll('.places button')].find((one) => one.textContent.includes('beat')).click()",
    );
    let span = "const { from, to } = views.get('s'); return to - from";
    until("it is zoomed", || number(span) < 5.0);
    let apart = "const { from, to } = views.get('s'); const { levels } = figures[0].curves[0]; \
                 const at = levels.at((from + to) / 2); return levels.windows.length && at[1] - at[0]";
    assert_eq!(browser.run(apart), 0);
    let before = number(span);
    wheel(&browser, -100);
    until("the wheel zooms", || number(span) < before);

    browser.run("document.querySelector('#correction').scrollIntoView()");
    browser.click("#correction canvas", (-100, 0), false);
    browser.click("#correction canvas", (100, 0), true);
    let measured = "return document.querySelector('#correction .measured').textContent";
    until("the cursors are told", || {
        let told = text(measured);
        told.contains("Δ: 0.") && told.contains("observer") && told.contains("µs")
    });
    let tip = "return document.querySelector('#correction .tip').textContent";
    until("the curves at the pointer are named", || {
        text(tip).contains("observer: ") && text(tip).contains(" µs")
    });

    browser.run("document.querySelector('.plot').scrollIntoView(); views.get('s').showAll()");
    until("all is seen again", || {
        number(range).to_bits() == of_all.to_bits()
    });
}

fn wheel(browser: &Browser, by: i32) {
    let script = format!(
        "const canvas = document.querySelector('#velocity canvas'); const {{ left, top }} = canvas.getBoundingClientRect(); \
         canvas.dispatchEvent(new WheelEvent('wheel', {{ deltaY: {by}, clientX: left + 400, clientY: top + 40 }}))"
    );
    let _: Value = browser.run(&script);
}
