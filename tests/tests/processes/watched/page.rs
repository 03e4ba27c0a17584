//! The page of `coaxle scope`, in a real browser.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use coaxle_os::machine;
use coaxle_test_process::{Process, until};

use crate::watched::browser::Browser;
use crate::watched::line::{Line, log_text};

/// The tool that serves the page of a line.
struct Scope {
    _tool: Process,
    address: String,
}

impl Scope {
    fn of(line: &Line, options: &[&str]) -> Self {
        let log = line.log("scope");
        let out = std::fs::File::create(&log).expect("a log");
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command
            .args(["scope", "--page", "127.0.0.1:0"])
            .args(options);
        for endpoint in &line.endpoints {
            command.args(["--connect", endpoint]);
        }
        command.stdin(Stdio::null()).stdout(out);
        let errors = log.with_extension("errors");
        let mut scope = Self {
            _tool: Process::start("the scope", &mut command, &errors),
            address: String::new(),
        };
        until("it says where the page is", || {
            let text = log_text(&log);
            let address = text.strip_prefix("the page is at ");
            scope.address = address.unwrap_or_default().trim().to_owned();
            text.ends_with('\n')
        });
        scope
    }
}

#[test]
fn a_beat_is_found_by_the_trigger_and_measured() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let mut line = Line::moving(50.0, -500.0);
    line.receive(
        "saw",
        "{ node = 'belt', axis = 3 }\n[[slave]]\nname = 'gear'",
    );
    let scope = Scope::of(&line, &[]);
    // The rates of change of positions: the velocity that arrives, and the corrected one.
    let signals = "saw:belt.3.received_position',saw:belt.3.corrected_position',saw:gear.state,saw:belt.drift_ppm";
    browser.open(&format!("{}/#signals={signals}&span=0.4", scope.address));
    let number = |script: &str| browser.run(script).as_f64().unwrap_or_default();
    let text = |id: &str| {
        let script = format!("return document.querySelector('{id}').textContent");
        browser.run(&script).as_str().unwrap_or_default().to_owned()
    };
    until("rows come", || {
        // Two seconds of a cycle of 2 ms.
        number("return Number(document.body.dataset.rows)") > 1000.0
    });
    // One for each unit, and one with a lane for the state.
    assert_eq!(
        number("return document.querySelectorAll('canvas').length"),
        3.0
    );
    until("the state is told", || {
        text("#figures").contains("synchronized-motion")
    });
    until("the nodes are told", || text("#nodes").contains("saw: ok"));

    browser.click("canvas", (-50, 0), false);
    browser.click("canvas", (50, 0), true);
    until("the cursors are apart", || {
        text("#cursors").contains(" ms, ")
    });

    browser.run(
        "const settings = { 'trigger-signal': \"saw:belt.3.received_position'\", 'trigger-edge': 'falling', \
                            'trigger-level': 10, 'trigger-mode': 'single' }; \
         for (const [id, value] of Object.entries(settings)) { \
           document.getElementById(id).value = value; \
           document.getElementById(id).dispatchEvent(new Event('change')); \
         }",
    );
    until("the shot is taken", || text("#trigger-state") == "taken");
    assert_eq!(text("#pause"), "Go on");
    // A quarter of the window is before it. The same frame was read twice: nothing moved.
    assert_eq!(
        number("return state.trigger.at - view().from")
            .mul_add(1e3, 0.5)
            .floor(),
        100.0
    );
    let rate = |at: &str| {
        number(&format!(
            "return state.sources.get('saw').rows.at(\"belt.3.received_position'\", state.trigger.at{at})"
        ))
    };
    // Below the level of the trigger at its instant, and above it a cycle and a half before.
    assert!(rate("").abs() < 10.0 && rate(" - 0.003").abs() > 10.0);
    assert_eq!(number("return Number(document.body.dataset.missing)"), 0.0);
    keep(&browser, "scope.png");
    check_saved(&browser);
    check_kinds(&browser);
}

/// A slope with a sine of 20 Hz and an amplitude of 0.25: the greatest amplitude of its spectrum, and the frequency of that.
const PEAK: &str = "
const rows = new Rows(['sine'], 4096);
const times = Float64Array.from({ length: 1024 }, (_, n) => 1e9 + n / 512);
rows.push(times, [times.map((time, n) => 3 * n + 0.25 * Math.sin(2 * Math.PI * 20 * time))]);
const { step, amplitudes } = spectrumOf(rows, 'sine', 0, Infinity);
const most = amplitudes.reduce((a, b) => Math.max(a, b), 0);
return [amplitudes.indexOf(most) * step, most]";

/// Checks plots over the first signal, and of frequencies.
fn check_kinds(browser: &Browser) {
    let peak = browser.run(PEAK);
    let [frequency, amplitude] = [0, 1].map(|n| peak[n].as_f64().unwrap_or_default());
    assert!(
        (frequency - 20.0).abs() < 1e-3 && (amplitude - 0.25).abs() < 1e-4,
        "{peak}"
    );
    for kind in ["against", "spectrum"] {
        browser.run(&format!(
            "$('kind').value = '{kind}'; $('kind').dispatchEvent(new Event('change')); \
             document.body.dataset.frames = 0"
        ));
        until("it is drawn", || {
            browser.run("return Number(document.body.dataset.frames) > 0") == true
        });
        let is_drawn = "return panes.every(({ shown }) => shown.every(Number.isFinite)) && location.hash.includes('kind=')";
        assert_eq!(browser.run(is_drawn), true, "{kind}");
        keep(browser, &format!("scope-{kind}.png"));
    }
}

/// Checks the files that the buttons of the page save: each cycle of the window with its signals, and the plots.
fn check_saved(browser: &Browser) {
    let text = |script: &str| browser.run(script).as_str().unwrap_or_default().to_owned();
    let csv = text("return shownAsCsv()");
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some(
            "time_s,utc,saw:belt.3.received_position',saw:belt.3.corrected_position',saw:gear.state,saw:belt.drift_ppm"
        )
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    // All that the page has of them: of 0.4 s with a cycle of 2 ms a busy machine skips some.
    let known = "const { rows } = state.sources.get('saw'); const { from, to } = view(); return rows.find(to) - rows.find(from)";
    let known = browser.run(known).as_u64().unwrap_or_default();
    assert!((100..=201).contains(&known), "{known} cycles");
    let saved = rows.len() as u64;
    // With the one at the right edge.
    assert!(saved == known || saved == known + 1, "{saved} of {known}");
    let times: Vec<f64> = rows.iter().map(|row| row[0].parse().expect("s")).collect();
    assert!(times.is_sorted() && rows.iter().all(|row| row.len() == 6));
    assert!(
        rows.iter()
            .all(|row| row[1].ends_with('Z') && row[4] == "synchronized-motion")
    );
    let picture = text("return pictureOf(panes, colour)");
    assert!(picture.starts_with("data:image/png;base64,") && picture.len() > 10_000);
}

/// Compares the two summaries of a hundred signals at 1 kHz: by blocks, and row by row.
const SAME_AS_ROW_BY_ROW: &str = "
const { rows } = state.sources.get('saw');
const wrong = [];
for (const [name, column] of rows.columns) {
  for (const [from, to] of [[0, rows.length], [3, rows.length - 5], [rows.length >> 1, (rows.length >> 1) + 70]]) {
    let [least, most, sum] = [Infinity, -Infinity, 0];
    for (let row = from; row < to; row++) {
      if (column[row] < least) least = column[row];
      if (column[row] > most) most = column[row];
      if (!Number.isNaN(column[row])) sum += column[row];
    }
    const pyramid = rows.pyramids.get(name);
    pyramid.range(from, to);
    const [total] = pyramid.summed(from, to);
    const isClose = Math.abs(total - sum) <= 1e-9 * Math.abs(sum) + 1e-9;
    if (pyramid.least !== least || pyramid.most !== most || !isClose) wrong.push(name);
  }
}
return wrong.join(' ')";

#[test]
fn a_hundred_signals_at_a_kilohertz_are_all_there_and_drawn_several_times_a_second() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let mut line = Line::moving(50.0, 120.0);
    line.start(
        "receiver",
        "saw",
        "cycle-time-us = 1000\nmaster = { node = 'belt', axis = 3 }\n[[slave]]\nname = 'gear'\n",
    );
    let scope = Scope::of(&line, &[]);
    browser.open(&scope.address);
    until("the signals are known", || {
        let known = browser.run("return state.sources.get('saw')?.signals.length ?? 0");
        known.as_u64() >= Some(100)
    });
    browser.run(
        "state.span = 10; \
         for (const { name } of state.sources.get('saw').signals.slice(0, 100)) state.chosen.push(`saw:${name}`); \
         listen('saw'); arrange()",
    );
    let number = |script: &str| browser.run(script).as_f64().unwrap_or_default();
    let rows = "return state.sources.get('saw').rows?.length ?? 0";
    until("ten seconds have come", || number(rows) > 10_000.0);
    let chosen = "return state.sources.get('saw').rows.columns.size";
    assert_eq!(number(chosen), 100.0);

    let drawn = "return Number(document.body.dataset.frames)";
    let (begin, before) = (machine::now(), number(drawn));
    std::thread::park_timeout(Duration::from_secs(5));
    let frames = number(drawn) - before;
    let rate = frames / (machine::now() - begin).as_secs_f64();
    // Refresh rate on a busy machine of two cores, without a graphics processor; nine on an idle one.
    assert!(rate > 1.0, "{rate} times a second");
    assert_eq!(browser.run(SAME_AS_ROW_BY_ROW), "");
    assert_eq!(number("return Number(document.body.dataset.missing)"), 0.0);
    keep(&browser, "scope-100.png");
}

#[test]
fn a_slave_is_told_only_what_it_would_take() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let mut line = Line::new();
    line.receive(
        "saw",
        "{ node = 'belt', axis = 3 }\n[[slave]]\nname = 'gear'",
    );
    let scope = Scope::of(&line, &["--commands"]);
    // The address has the token of the commands in its query.
    browser.open(&format!("{}#tab=slaves", scope.address));
    let buttons = || {
        let script = "return [...document.querySelectorAll('#slaves button')].map((b) => b.textContent).join(' ')";
        browser.run(script).as_str().unwrap_or_default().to_owned()
    };
    let press = |label: &str| {
        let script = format!(
            "const b = [...document.querySelectorAll('#slaves button')].find((b) => b.textContent === '{label}'); \
             b?.click(); return b !== undefined"
        );
        until(label, || browser.run(&script) == true);
    };
    let shows = |what: &str| {
        until(what, || {
            let shown = browser.run("return document.querySelector('#slaves').innerText");
            shown.as_str().unwrap_or_default().contains(what)
        });
    };
    shows("in-sync");
    until("it may be uncoupled", || buttons().contains("Gear out"));
    press("Gear out");
    shows("standstill");
    press("Gear in 1:1");
    shows("synchronized-motion");
    press("Power off");
    shows("disabled");
    until("it may be switched on, and not coupled", || {
        buttons().contains("Power on") && !buttons().contains("Gear in")
    });
    keep(&browser, "slaves.png");
}

#[test]
fn a_node_gives_out_a_page_of_itself() {
    let mut line = Line::new();
    let config = "cycle-time-us = 2000\nmaster = { node = 'belt', axis = 3 }\n";
    line.start_with("receiver", "saw", config, &["--page", "127.0.0.1:0"]);
    let log = line.log("saw");
    until("it says where", || {
        log_text(&log).contains("the page is at http://")
    });
    let text = log_text(&log);
    let address = text
        .split("http://")
        .nth(1)
        .and_then(|rest| rest.split_whitespace().next());
    let address = address.expect("an address");
    let shown = |path: &str| {
        use std::io::{Read, Write};
        let mut stream = std::net::TcpStream::connect(address).expect("the page");
        let request =
            format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("a request");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        answer
    };
    until("it knows itself and its neighbour", || {
        let nodes = shown("/nodes");
        nodes.contains("\"name\":\"saw\"") && nodes.contains("\"name\":\"belt\"")
    });
    until("its own signals are there", || {
        shown("/signals/saw").contains("belt.3.corrected_position")
    });
    assert!(shown("/metrics").contains("coaxle_up{node=\"saw\"} 1"));
}

/// Keeps a picture in `target/tmp`, for examination.
pub(crate) fn keep(browser: &Browser, name: &str) {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    browser.screenshot(&file);
    let bytes = std::fs::read(&file).expect("a screenshot");
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 10_000);
}
