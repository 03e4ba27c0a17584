//! Responses to the page, as a browser gets them.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use coaxle_clock::Span;
use coaxle_host::client::{Commander, Watcher};
use coaxle_host::network::transport::{InProcess, Transport, Urgency};
use coaxle_node::signal::Instance;
use coaxle_recording::{Facts, Level, LogLine, Pieces, RowEncoder, Table};
use coaxle_sender::signals::AxisSignals;

use super::stream::{Blocks, signals_of};
use super::{PageArgs, Scope};

fn table() -> Table {
    Table {
        name: "conveyor".to_owned(),
        role: "sender".to_owned(),
        instances: vec![Instance::of::<AxisSignals>("belt.1")],
    }
}

/// A piece with rows `from` to `to` of an axis that moves by 1 from row to row.
fn piece(pieces: &mut Pieces, from: i64, to: i64) -> Vec<u8> {
    let mut encoder = RowEncoder::of(&table());
    for k in from..to {
        let row = AxisSignals {
            position: k as f64,
            ..AxisSignals::default()
        };
        let at = k * 1_000_000;
        pieces.row(&encoder.encode(at, at, &row).unwrap()).unwrap();
    }
    pieces.take().unwrap().unwrap()
}

fn pieces() -> Pieces {
    let facts = Facts::from([("epoch".to_owned(), "00f00d".to_owned())]);
    Pieces::of(table(), facts, 5_000_000_000)
}

/// Head and numbers of a block.
fn taken_apart(block: &[u8]) -> (serde_json::Value, Vec<f64>) {
    let length = u32::from_le_bytes(block[..4].try_into().unwrap()) as usize;
    let head = serde_json::from_slice(&block[4..4 + length]).unwrap();
    let numbers = block[(4 + length).next_multiple_of(8)..].chunks_exact(8);
    let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
    (head, numbers.map(number).collect())
}

#[test]
fn a_block_has_what_was_asked_for() {
    let mut pieces = pieces();
    let first = piece(&mut pieces, 0, 3);
    let names: Vec<_> = signals_of(&first).into_iter().map(|of| of.name).collect();
    assert!(names.contains(&"belt.1.position".to_owned()), "{names:?}");
    let wanted = ["belt.1.position", "belt.2.position"].map(str::to_owned);
    let mut blocks = Blocks::of(wanted.to_vec());
    let (head, numbers) = taken_apart(&blocks.block(&first).unwrap());
    assert_eq!(head["rows"], 3);
    assert_eq!(head["epoch"], "00f00d");
    assert_eq!(head["unknown"], serde_json::json!(["belt.2.position"]));
    assert_eq!(numbers[..6], [5.0, 5.001, 5.002, 0.0, 1.0, 2.0]);
    assert!(numbers[6..].iter().all(|number| number.is_nan()));
    assert_eq!(blocks.block(b"no piece"), None);
}

#[test]
fn a_log_line_comes_without_rows_too() {
    let mut pieces = pieces();
    let line = LogLine {
        at_ns: 1_000_000_000,
        level: Level::Warning,
        name: "conveyor".to_owned(),
        text: "late".to_owned(),
    };
    pieces.log(&line).unwrap();
    let piece = pieces.take().unwrap().unwrap();
    let block = Blocks::of(vec!["belt.1.position".to_owned()]).block(&piece);
    let (head, numbers) = taken_apart(&block.unwrap());
    let expected = serde_json::json!([{ "at": 6.0, "level": "warning", "text": "late" }]);
    assert_eq!(head["log"], expected);
    assert!(numbers.is_empty());
}

/// A page of a network in which a node shows itself all the time.
struct Shown {
    scope: Option<Scope>,
    is_over: Arc<AtomicBool>,
    node: Option<JoinHandle<()>>,
}

impl Shown {
    fn new(commands: bool) -> Self {
        let network = InProcess::default();
        let watcher = Watcher::over(Arc::new(network.clone()), &[]).unwrap();
        let page = PageArgs {
            page: "127.0.0.1:0".parse().unwrap(),
            commands,
        };
        let commander = commands.then(|| Commander::of_page(watcher.transport()).unwrap());
        let scope = Scope::open(watcher, commander, &page).unwrap();
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let node = std::thread::spawn(move || {
            let _alive = network.announce("coaxle/conveyor/alive").unwrap();
            let rows = network.publisher("coaxle/conveyor/rows", Urgency::Bulk);
            let status = network.publisher("coaxle/conveyor/status", Urgency::Ordinary);
            let (rows, status) = (rows.unwrap(), status.unwrap());
            let (mut pieces, mut k) = (pieces(), 0);
            while !over.load(Ordering::Relaxed) {
                let said = r#"{"node":"conveyor","health":"ok","cycles":7}"#;
                status.publish(said.into()).unwrap();
                rows.publish(piece(&mut pieces, k, k + 10)).unwrap();
                k += 10;
                std::thread::park_timeout(Duration::from_millis(5));
            }
        });
        Self {
            scope: Some(scope),
            is_over,
            node: Some(node),
        }
    }

    fn address(&self) -> SocketAddr {
        self.scope.as_ref().unwrap().address()
    }

    /// The response to a request, until it ends or is long enough: its head and its body.
    fn ask(&self, request: &str, headers: &str, body: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(self.address()).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(60)))
            .unwrap();
        let length = body.len();
        write!(
            stream,
            "{request} HTTP/1.1\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n{body}"
        )
        .unwrap();
        let mut reader = BufReader::new(stream);
        let mut head = String::new();
        while !head.ends_with("\r\n\r\n") && reader.read_line(&mut head).unwrap() > 0 {}
        let mut body = Vec::new();
        reader.take(4096).read_to_end(&mut body).unwrap();
        (head, body)
    }

    fn get(&self, path: &str) -> (String, String) {
        let host = format!("Host: {}\r\n", self.address());
        let (head, body) = self.ask(&format!("GET {path}"), &host, "");
        (head, String::from_utf8_lossy(&body).into_owned())
    }

    /// Repeats the request until the response contains this text.
    fn until(&self, path: &str, what: &str) -> String {
        let end = coaxle_os::machine::now() + Span::from_secs(60);
        loop {
            let (_, body) = self.get(path);
            if body.contains(what) {
                return body;
            }
            assert!(coaxle_os::machine::now() < end, "{path}: {body}");
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        drop(self.scope.take());
        let _ = self.node.take().map(JoinHandle::join);
    }
}

#[test]
fn the_page_its_nodes_their_signals_rows_and_metrics_are_given_out() {
    let shown = Shown::new(false);
    let (head, page) = shown.get("/");
    assert!(
        head.contains("200 OK") && page.contains("Coaxle scope"),
        "{head}{page}"
    );
    for file in [
        "/page.js",
        "/axes.js",
        "/pyramid.js",
        "/plot.js",
        "/kinds.js",
        "/save.js",
        "/base.css",
        "/page.css",
    ] {
        assert!(shown.get(file).0.contains("200 OK"), "{file}");
    }
    assert!(
        shown
            .until("/nodes", "conveyor")
            .contains("\"commands\":false")
    );
    assert!(
        shown
            .until("/metrics", "coaxle_up")
            .contains("{node=\"conveyor\"} 1")
    );
    let plant = shown.until("/plant.svg", "conveyor");
    assert!(plant.starts_with("<svg "), "{plant}");
    shown.until("/signals/conveyor", "\"belt.1.position\"");
    let host = format!("Host: {}\r\n", shown.address());
    let (head, rows) = shown.ask("GET /rows/conveyor?signals=belt.1.position", &host, "");
    assert!(head.contains("application/octet-stream"), "{head}");
    assert!(String::from_utf8_lossy(&rows).contains("\"epoch\":\"00f00d\""));
    assert!(shown.get("/rows/no+node?signals=a").0.contains("400"));
}

#[test]
fn other_pages_neither_look_nor_command() {
    let shown = Shown::new(true);
    let order = r#"{"version":1,"slave":"a","command":{"halt":{"dynamics":{}}},"dry-run":true}"#;
    let status = |request: &str, headers: &str, body: &str| {
        let (head, _) = shown.ask(request, headers, body);
        head.split(' ').nth(1).unwrap_or_default().to_owned()
    };
    let own = format!("Host: {}\r\n", shown.address());
    assert_eq!(status("GET /nodes", "Host: evil.example\r\n", ""), "403");
    // A form of another page can be sent, but not with a header of ours.
    assert_eq!(status("POST /orders/conveyor", &own, order), "403");
    // Nor by a program on this PC, which may send any header, but does not know the token.
    for unknown in ["1", "", "0123456789abcdef0123456789abcdef"] {
        let headers = format!("{own}x-coaxle-page: {unknown}\r\n");
        let (head, why) = shown.ask("POST /orders/conveyor", &headers, order);
        assert!(head.contains("403"), "{head}");
        let why = String::from_utf8_lossy(&why).into_owned();
        assert!(why.contains("at the address with ?token="), "{why}");
    }
    let url = shown.scope.as_ref().unwrap().url();
    let (_, token) = url.split_once("/?token=").unwrap();
    let ours = format!("{own}x-coaxle-page: {token}\r\n");
    assert_eq!(status("POST /orders/conveyor", &ours, "{}"), "400");
    // No response has the token in it: reading is open.
    for path in ["/", "/page.js", "/nodes", "/metrics"] {
        assert!(!shown.get(path).1.contains(token), "{path}");
    }
    assert_eq!(status("OPTIONS /orders/conveyor", &own, ""), "405");
}

#[test]
fn without_leave_nobody_commands() {
    let shown = Shown::new(false);
    let headers = format!("Host: {}\r\nx-coaxle-page: 1\r\n", shown.address());
    let (head, body) = shown.ask("POST /orders/conveyor", &headers, "{}");
    assert!(head.contains("403"), "{head}");
    assert!(String::from_utf8_lossy(&body).contains("--commands"));
}

#[test]
fn an_address_that_is_taken_is_named() {
    let shown = Shown::new(false);
    let watcher = Watcher::over(Arc::new(InProcess::default()), &[]).unwrap();
    let page = PageArgs {
        page: shown.address(),
        commands: false,
    };
    let error = Scope::open(watcher, None, &page).map(|_| ()).unwrap_err();
    let message = format!("{error:#}");
    assert!(message.contains(&shown.address().to_string()), "{message}");
    assert!(message.starts_with("--page: "), "{message}");
}
