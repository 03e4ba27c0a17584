//! The page of a node: who holds it up, and who commands by it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use coaxle_test_process::{Process, output, until};
use coaxle_tests::ports::free_port;

use crate::{AXIS, Bench, TOOL, shown};

/// Descriptors of the node under test: some times those of a page, and far fewer than its slow clients.
const FILES: usize = 128;
const SLOW: usize = 300;

/// A receiver with a slave and a page.
struct PagedNode {
    node: Process,
    /// Address of the page.
    host: String,
    /// Its token.
    token: String,
}

impl PagedNode {
    fn start(bench: &Bench, folder: &str, transport: &str) -> Self {
        let slave = "[[slave]]\nname = 'carriage'\ncouple = 'off'\n\
                     limits = { velocity = 500, acceleration = 2000, jerk = 1e5 }\n";
        let config = format!(
            "name = 'saw'\ncycle-time-us = 2000\nmaster = {{ node = 'line' }}\n{slave}[transport]\n{transport}"
        );
        let config = bench.file("saw.toml", config);
        if !folder.is_empty() {
            let line = format!("listen = ['tls/127.0.0.1:{}']", free_port());
            let line = format!("name = 'line'\ncycle-time-us = 2000\n{AXIS}[transport]\n{line}\n");
            let line = bench.file("line.toml", line);
            let words = [
                "secure",
                "init",
                &line,
                &config,
                "--out",
                folder,
                "--operator",
                "anna",
            ];
            let made = output(Command::new(TOOL).args(words));
            assert!(made.status.success(), "{made:?}");
        }
        let mut command = Command::new("sh");
        let script = format!("ulimit -n {FILES}; exec \"$0\" \"$@\"");
        command.args([
            "-c",
            &script,
            TOOL,
            "receiver",
            &config,
            "--page",
            "127.0.0.1:0",
            "--commands",
        ]);
        command.stdin(Stdio::null());
        let node = Process::start("saw", &mut command, &bench.path("saw.log"));
        until("it says where its page is", || node.logged("/?token="));
        let log = node.log();
        let url = log
            .split("the page is at http://")
            .nth(1)
            .and_then(|rest| rest.split_whitespace().next());
        let (host, token) = url
            .and_then(|url| url.split_once("/?token="))
            .expect("an address with a token");
        let (host, token) = (host.to_owned(), token.to_owned());
        Self { node, host, token }
    }

    /// The response to a request.
    fn ask(&self, request: &str, token: &str, body: &str) -> String {
        let mut stream = self.connect();
        let length = body.len();
        let text = format!(
            "{request} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nx-coaxle-page: {token}\r\nContent-Length: {length}\r\n\r\n{body}",
            self.host
        );
        stream.write_all(text.as_bytes()).expect("a request");
        let mut answer = Vec::new();
        // A reset is an end as well.
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).expect("the page");
        stream
            .set_read_timeout(Some(Duration::from_secs(60)))
            .expect("a timeout");
        stream
    }

    fn power(&self, token: &str) -> String {
        let order = r#"{"version":1,"slave":"carriage","command":{"power":true}}"#;
        self.ask("POST /orders/saw", token, order)
    }

    /// Descriptors that it has open; none where the system does not say.
    fn open_files(&self) -> Option<usize> {
        let folder = format!("/proc/{}/fd", self.node.id());
        Some(std::fs::read_dir(Path::new(&folder)).ok()?.count())
    }
}

fn slow_requests_take_no_descriptor_from_the_node(bench: &Bench) {
    let port = free_port();
    let endpoint = format!("tcp/127.0.0.1:{port}");
    let paged = PagedNode::start(bench, "", &format!("listen = ['{endpoint}']"));
    let before = paged.open_files();
    let mut slow: Vec<_> = (0..SLOW).map(|_| paged.connect()).collect();
    for stream in &mut slow {
        // Some are closed already, for those that came later.
        let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-a: ");
    }
    // The page itself, the status, a command: each needs descriptors of the node.
    assert!(paged.ask("GET /nodes", "", "").contains("\"name\":\"saw\""));
    for words in [
        &["status", "saw"][..],
        &["command", "saw", "carriage", "power", "on"],
    ] {
        let end = output(
            Command::new(TOOL)
                .args(words)
                .args(["--connect", &endpoint]),
        );
        assert!(end.status.success(), "{words:?}: {end:?}");
    }
    if let (Some(before), Some(now)) = (before, paged.open_files()) {
        // 32 connections, one that is just accepted, and the links of the tool, which may not be gone yet.
        assert!(now <= before + 32 + 1 + 4, "{before}, then {now}");
    }
    assert!(
        !paged.node.logged("accepts no connection"),
        "{}",
        paged.node.log()
    );
    for mut stream in slow {
        // All are closed within the time of a head, without a response.
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        assert!(answer.is_empty(), "{}", String::from_utf8_lossy(&answer));
    }
}

/// The probe of the page's limits.
pub(crate) fn is_probed() {
    slow_requests_take_no_descriptor_from_the_node(&Bench::new());
}

#[test]
fn only_who_has_the_token_commands_a_secure_node_by_its_page() {
    let bench = Bench::new();
    let port = free_port();
    let folder = shown(&bench.path("net"));
    let transport = format!("secure = '{folder}/saw'\nlisten = ['tls/127.0.0.1:{port}']");
    let paged = PagedNode::start(&bench, &folder, &transport);
    for unknown in ["", "1", "00000000000000000000000000000000"] {
        let refused = paged.power(unknown);
        assert!(
            refused.contains(" 403 ") && refused.contains("with ?token="),
            "{refused}"
        );
    }
    assert!(!paged.node.logged("order of"), "{}", paged.node.log());
    until("each refusal is on record", || {
        let refusals = paged.node.log();
        let refusals = refusals.lines().filter(|line| {
            line.contains("page of \"127.0.0.1:") && line.contains("POST /orders/saw: refused")
        });
        refusals.count() == 3
    });
    let taken = paged.power(&paged.token);
    assert!(
        taken.contains(" 200 ") && taken.contains("accepted"),
        "{taken}"
    );
    until("the order is on record", || {
        paged
            .node
            .logged("order of \"page\": MC_Power to \"carriage\": accepted")
    });
    assert_eq!(paged.node.log().matches(&paged.token).count(), 1);
}
