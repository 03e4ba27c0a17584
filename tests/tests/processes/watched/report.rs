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
        // Nearly the whole run of 20 s.
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
        // To the bit: the same view, not one nearly like it.
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

#[test]
fn a_page_of_a_saw_is_zoomed_names_its_phases_and_is_saved() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let scratch = tempfile::tempdir().expect("a folder");
    let page = scratch.path().join("saw.html");
    let saw = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenarios/saws/saw-position-1-checked.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command.args(["saw", "plot"]).arg(saw).arg("-o").arg(&page);
    let status = command.stdout(Stdio::null()).status();
    assert!(status.is_ok_and(|status| status.success()));
    browser.open(&format!("file://{}", page.display()));
    let text = |script: &str| browser.run(script).as_str().unwrap_or_default().to_owned();
    let number = |script: &str| browser.run(script).as_f64().unwrap_or_default();
    until("the figure is drawn", || {
        number("return Number(document.querySelector('.plot').dataset.to)") > 1000.0
    });
    // On the mark of the second phase.
    browser.run(
        "const { canvas } = figures[0].panels[3]; const { left, top } = canvas.getBoundingClientRect(); \
         const { from, to } = figures[0].view; const place = area(canvas); \
         const clientX = left + place.left + ((500 - from) / (to - from)) * place.width; \
         canvas.dispatchEvent(new PointerEvent('pointermove', { clientX, clientY: top + 40 }))",
    );
    let tip = text("return document.querySelector('.tip').textContent");
    for told in ["500", "polynom1", "limit of jerk: 5000 mm/s³"] {
        assert!(tip.contains(told), "{told}: {tip}");
    }
    let span = "const { from, to } = figures[0].view; return to - from";
    let before = number(span);
    browser.run(
        "const { canvas } = figures[0].panels[0]; const { left, top } = canvas.getBoundingClientRect(); \
         canvas.dispatchEvent(new WheelEvent('wheel', { deltaY: -100, clientX: left + 400, clientY: top + 40 }))",
    );
    until("all charts are zoomed", || number(span) < before);
    let saved = "let kept; HTMLAnchorElement.prototype.click = function () { kept = [this.download, this.href.length]; }; \
                 document.querySelector('.keep').click(); return kept";
    let saved = browser.run(saved);
    assert_eq!(saved[0], "saw.png");
    assert!(saved[1].as_u64() > Some(10_000), "{saved}");
}
