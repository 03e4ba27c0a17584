//! A real browser, driven by the WebDriver standard: Chromium and its driver, where they are installed.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use coaxle_test_process::{Process, until};
use coaxle_tests::ports::free_port;
use serde_json::{Value, json};

/// Options without which it sends requests of its own.
const QUIET: [&str; 8] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
];

/// Lock for one browser at a time: two of them leave the nodes of a test too little of a small machine.
static TURN: Mutex<()> = Mutex::new(());

pub(crate) struct Browser {
    port: u16,
    session: String,
    _driver: Process,
    // Released last, when the driver is gone.
    _turn: MutexGuard<'static, ()>,
}

impl Browser {
    /// Starts it; none, with a note on the output, where it is not installed.
    #[expect(clippy::print_stdout, reason = "so a test says that it tested nothing")]
    pub(crate) fn start() -> Option<Self> {
        let port = free_port();
        let mut driver = Command::new("chromedriver");
        driver
            .arg(format!("--port={port}"))
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        let driver = Process::start_without_log("chromedriver", &mut driver);
        let Ok(driver) = driver else {
            println!("not tested: chromedriver is not installed");
            return None;
        };
        let mut browser = Self {
            port,
            session: String::new(),
            _driver: driver,
            _turn: TURN.lock().unwrap_or_else(PoisonError::into_inner),
        };
        until("the driver listens", || {
            TcpStream::connect(("127.0.0.1", port)).is_ok()
        });
        let options = json!({ "goog:chromeOptions": { "args": QUIET } });
        let wanted = json!({ "capabilities": { "alwaysMatch": options } });
        let opened = browser.send("POST", "/session", &wanted);
        let session = opened["sessionId"].as_str();
        browser.session = format!("/session/{}", session.unwrap_or_else(|| panic!("{opened}")));
        // A fixed size, since tests click at places of the page.
        let size = json!({ "width": 1400, "height": 900 });
        browser.send_command("/window/rect", &size);
        Some(browser)
    }

    pub(crate) fn open(&self, address: &str) {
        self.send_command("/url", &json!({ "url": address }));
    }

    /// Runs a script in the page, and returns its result.
    pub(crate) fn run(&self, script: &str) -> Value {
        self.send_command("/execute/sync", &json!({ "script": script, "args": [] }))
    }

    /// Clicks into an element, at this offset to the right and below its middle.
    pub(crate) fn click(&self, selector: &str, (right, below): (i64, i64), shift: bool) {
        let found = self.send_command(
            "/element",
            &json!({ "using": "css selector", "value": selector }),
        );
        let place = json!({ "type": "pointerMove", "origin": found, "x": right, "y": below });
        let mouse = json!({ "type": "pointer", "id": "mouse", "actions": [
            place, { "type": "pointerDown", "button": 0 }, { "type": "pointerUp", "button": 0 }] });
        let key = |what: &str| json!({ "type": what, "value": "\u{e008}" });
        let pause = json!({ "type": "pause" });
        let held = match shift {
            // The key is released after the button.
            true => json!([key("keyDown"), pause, pause, pause, key("keyUp")]),
            false => json!([pause, pause, pause]),
        };
        let mut mouse = mouse;
        if shift {
            // The key goes down first.
            mouse["actions"] = json!([pause, place, { "type": "pointerDown", "button": 0 },
                { "type": "pointerUp", "button": 0 }]);
        }
        let keys = json!({ "type": "key", "id": "keys", "actions": held });
        self.send_command("/actions", &json!({ "actions": [keys, mouse] }));
    }

    /// Clicks twice into an element, at this offset to the right and below its middle.
    pub(crate) fn double_click(&self, selector: &str, at: (i64, i64)) {
        let place = self.place_in(selector, at);
        let (down, up) = (button("pointerDown"), button("pointerUp"));
        self.mouse(&json!([place, down, up, down, up]));
    }

    /// Drags within an element, between two offsets to the right and below its middle.
    pub(crate) fn drag(&self, selector: &str, from: (i64, i64), to: (i64, i64)) {
        // A drag without a move in between is a click to some pages.
        let between = ((from.0 + to.0) / 2, (from.1 + to.1) / 2);
        let [from, between, to] = [from, between, to].map(|at| self.place_in(selector, at));
        self.mouse(&json!([
            from,
            button("pointerDown"),
            between,
            to,
            button("pointerUp")
        ]));
    }

    fn place_in(&self, selector: &str, (right, below): (i64, i64)) -> Value {
        let found = self.send_command(
            "/element",
            &json!({ "using": "css selector", "value": selector }),
        );
        json!({ "type": "pointerMove", "origin": found, "x": right, "y": below })
    }

    fn mouse(&self, actions: &Value) {
        let mouse = json!({ "type": "pointer", "id": "mouse", "actions": actions });
        self.send_command("/actions", &json!({ "actions": [mouse] }));
    }

    pub(crate) fn screenshot(&self, file: &Path) {
        let shot = self.send("GET", &format!("{}/screenshot", self.session), &Value::Null);
        let bytes = decoded(shot.as_str().unwrap_or_default());
        let written = File::create(file).and_then(|mut out| out.write_all(&bytes));
        written.expect("a screenshot");
    }

    fn send_command(&self, what: &str, body: &Value) -> Value {
        self.send("POST", &format!("{}{what}", self.session), body)
    }

    fn send(&self, method: &str, path: &str, body: &Value) -> Value {
        let body = match body {
            Value::Null => String::new(),
            body => body.to_string(),
        };
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("the driver is there");
        let patience = Some(Duration::from_secs(120));
        stream.set_read_timeout(patience).expect("a time limit");
        let (port, length) = (self.port, body.len());
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\
             Content-Type: application/json\r\nContent-Length: {length}\r\n\r\n{body}"
        );
        stream.write_all(request.as_bytes()).expect("a request");
        let answer: Value = serde_json::from_slice(&body_of(stream)).expect("JSON");
        let value = answer["value"].clone();
        assert!(value.get("error").is_none(), "{path}: {value}");
        value
    }
}

fn button(what: &str) -> Value {
    json!({ "type": what, "button": 0 })
}

impl Drop for Browser {
    fn drop(&mut self) {
        if !self.session.is_empty() {
            // Else the browser outlives its driver.
            let request = format!(
                "DELETE {} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n",
                self.session
            );
            if let Ok(mut stream) = TcpStream::connect(("127.0.0.1", self.port)) {
                let _ = stream.write_all(request.as_bytes());
                let _ = stream.set_read_timeout(Some(Duration::from_secs(5)));
                let _ = stream.read(&mut [0; 1024]);
            }
        }
    }
}

/// The body of a response. The driver keeps the connection open.
fn body_of(stream: TcpStream) -> Vec<u8> {
    let mut reader = BufReader::new(stream);
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).expect("an answer");
        if line.trim().is_empty() {
            break;
        }
        let (name, value) = line.split_once(':').unwrap_or_default();
        if name.eq_ignore_ascii_case("content-length") {
            length = value.trim().parse().expect("a length");
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).expect("an answer");
    body
}

/// Decodes Base64, the format of a screenshot.
fn decoded(text: &str) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |c: u8| DIGITS.iter().position(|known| *known == c);
    let bits: Vec<_> = text.bytes().filter_map(digit).collect();
    let bytes = bits.chunks(4).flat_map(|four| {
        // Four digits of six bits are three bytes; a shorter last group has fewer.
        let all = four.iter().fold(0, |all, digit| all << 6 | digit) << (6 * (4 - four.len()));
        let bytes = [all >> 16, all >> 8, all].map(|byte| (byte & 0xff) as u8);
        bytes.into_iter().take(four.len().saturating_sub(1))
    });
    bytes.collect()
}
