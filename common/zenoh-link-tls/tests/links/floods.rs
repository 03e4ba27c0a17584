//! Floods of connections at a listener: the number that it holds, and members that get in meanwhile.

use std::io::{BufRead as _, BufReader, ErrorKind, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use super::authority::{Authority, Files, endpoint_of};
use super::tls::{LONG, Listening, dial};
use rustix::process::{Resource, Rlimit, setrlimit};
use rustls::pki_types::{CertificateDer, ServerName, pem::PemObject};
use rustls::{ClientConfig, ClientConnection, RootCertStore};
use tokio::time::{Duration, timeout};
use zenoh_link_commons::LinkManagerUnicastTrait as _;
use zenoh_link_tls::{LinkManagerUnicastTls, refused_connections};

/// Most connections without a complete ClientHello, and with one: `src/admission.rs`.
const MOST_SILENT: usize = 128;
const MOST_GREETED: usize = 64;

/// Connects that stay open, and send these bytes.
fn flood(address: &str, count: usize, bytes: &[u8]) -> Vec<TcpStream> {
    let connect = |_| {
        let mut socket = TcpStream::connect(address).expect("a connection");
        // The listener may have closed it already.
        let _ = socket.write_all(bytes);
        socket.set_nonblocking(true).expect("a socket");
        socket
    };
    (0..count).map(connect).collect()
}

/// True if the listener has not closed the connection.
fn is_open(socket: &TcpStream) -> bool {
    let mut socket = socket;
    // Several: its own part of a handshake may come before the end.
    loop {
        match socket.read(&mut [0; 4096]) {
            Ok(0) => return false,
            Ok(_) => {}
            Err(error) => return error.kind() == ErrorKind::WouldBlock,
        }
    }
}

fn count_open(sockets: &[TcpStream]) -> usize {
    sockets.iter().filter(|socket| is_open(socket)).count()
}

/// Waits until the listener holds no more of these than `most`.
async fn until_open(sockets: &[TcpStream], most: usize) {
    let closed = async {
        while count_open(sockets) > most {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    timeout(LONG, closed).await.expect("in time");
}

async fn member_gets_in(listening: &Listening, saw: &Files) {
    let link = timeout(LONG, listening.dialled(saw)).await;
    link.expect("in time").expect("a member gets in");
    listening.taken().await;
}

/// Returns the first bytes of a member, which anybody can send.
fn client_hello(authority: &Files) -> Vec<u8> {
    let mut roots = RootCertStore::empty();
    let pem = authority.authority();
    let certificate = CertificateDer::from_pem_slice(pem.as_bytes()).expect("a certificate");
    roots.add(certificate).expect("an authority");
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&rustls::version::TLS13])
        .expect("TLS 1.3")
        .with_root_certificates(roots)
        .with_no_client_auth();
    let name = ServerName::try_from("127.0.0.1").expect("a name");
    let mut client = ClientConnection::new(Arc::new(config), name).expect("a client");
    let mut hello = Vec::new();
    client.write_tls(&mut hello).expect("a ClientHello");
    hello
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn silent_and_slow_connects_are_held_up_to_a_limit_and_a_member_gets_in() {
    let authority = Authority::new();
    let (line, saw) = (authority.issue("line"), authority.issue("saw"));
    // Longer than the test: connections are closed by the limit, or after the 3 s of the listener.
    let patient = "tls_handshake_timeout_ms=600000";
    // The head of a record of 512 bytes with a ClientHello, and no more of it.
    for bytes in [&b""[..], &[0x16, 3, 1, 2, 0, 1]] {
        let listening = Listening::with(&line, "127.0.0.1", patient).await;
        let held = flood(&listening.address(), 600, bytes);
        member_gets_in(&listening, &saw).await;
        until_open(&held, MOST_SILENT).await;
        // Nobody else comes: the time of each is over.
        until_open(&held, 0).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn handshakes_that_stall_are_held_up_to_a_limit_and_a_member_gets_in() {
    let authority = Authority::new();
    let (line, saw) = (authority.issue("line"), authority.issue("saw"));
    let patient = "tls_handshake_timeout_ms=600000";
    let listening = Listening::with(&line, "127.0.0.1", patient).await;
    let held = flood(&listening.address(), 300, &client_hello(&line));
    // At the pace of its address, behind those that wait already.
    member_gets_in(&listening, &saw).await;
    until_open(&held, MOST_SILENT + MOST_GREETED).await;
    until_open(&held, 0).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_flood_is_counted_and_its_address_named_and_no_link_ends() {
    let authority = Authority::new();
    let (line, saw) = (authority.issue("line"), authority.issue("saw"));
    let listening = Listening::with(&line, "127.0.0.1", "").await;
    let dialled = listening.dialled(&saw).await.expect("a link");
    let established = listening.taken().await;
    let before = refused_connections().count;
    for _ in 0..1_500 {
        let mut socket = TcpStream::connect(listening.address()).expect("a connection");
        let _ = socket.write_all(&[0x16; 5]);
    }
    member_gets_in(&listening, &saw).await;
    let counted = async {
        while refused_connections().count < before + 1_500 {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    timeout(LONG, counted).await.expect("in time");
    established.write_all(b"on", None).await.expect("written");
    let mut on = [0; 2];
    let read = timeout(LONG, dialled.read_exact(&mut on, None)).await;
    read.expect("in time").expect("the link works on");
}

/// Descriptors of a process that has a dozen of its own: far fewer than connections may hold.
const FEW_DESCRIPTORS: u64 = 48;
/// Environment of the process that listens: the folder of its certificates.
const FOLDER: &str = "COAXLE_TEST_FOLDER";

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "the other process of the test below"]
async fn listener_with_few_descriptors() {
    let Ok(folder) = std::env::var(FOLDER) else {
        return;
    };
    let few = Some(FEW_DESCRIPTORS);
    let limit = Rlimit {
        current: few,
        maximum: few,
    };
    setrlimit(Resource::Nofile, limit).expect("fewer are always permitted");
    let (sender, links) = flume::unbounded();
    let manager = LinkManagerUnicastTls::new(sender);
    let endpoint = endpoint_of(Path::new(&folder), "127.0.0.1:0", "");
    let locator = manager.new_listener(endpoint).await.expect("it listens");
    println!("\nlistens on {}", locator.address());
    let _link = links.recv_async().await.expect("a link");
    println!("\nlinked");
    // The parent ends this process.
    std::future::pending::<()>().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn without_descriptors_silent_connects_make_room_for_a_member() {
    let authority = Authority::new();
    let (line, saw) = (authority.issue("line"), authority.issue("saw"));
    let mut listener = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", "--ignored", "--nocapture"])
        .arg("floods::listener_with_few_descriptors")
        .env(FOLDER, line.folder())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut said = BufReader::new(listener.stdout.take().expect("a pipe")).lines();
    let mut next = |what: &str| {
        let found = said.find_map(|line| line.ok()?.strip_prefix(what).map(str::to_owned));
        found.unwrap_or_else(|| panic!("it ended before it said {what:?}"))
    };
    let address = next("listens on ");
    // More than its descriptors, and fewer than the kernel holds for it.
    let held = flood(&address, 400, b"");
    let link = timeout(LONG, dial(saw.endpoint(&address, ""))).await;
    let link = link.expect("in time").expect("a member gets in");
    next("linked");
    assert!(count_open(&held) <= FEW_DESCRIPTORS as usize);
    drop(link);
    listener.kill().expect("it runs");
    listener.wait().expect("it ended");
}
