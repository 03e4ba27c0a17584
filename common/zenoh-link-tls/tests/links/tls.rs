//! Links over TLS: transmission, admission, and the end of a link.

use std::io::Write as _;
use std::net::TcpStream as PlainStream;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::authority::{Authority, Files};
use tokio::time::timeout;
use zenoh_link_commons::{LinkAuthId, LinkManagerUnicastTrait, LinkUnicast};
use zenoh_link_tls::{LinkManagerUnicastTls, on_link_event};
use zenoh_protocol::core::{EndPoint, Locator};

/// Timeout on a busy machine for operations that take milliseconds.
pub(crate) const LONG: Duration = Duration::from_secs(60);

/// A listener and the links that it takes.
pub(crate) struct Listening {
    _manager: LinkManagerUnicastTls,
    pub(crate) links: flume::Receiver<LinkUnicast>,
    locator: Locator,
}

impl Listening {
    pub(crate) async fn with(files: &Files, host: &str, more: &str) -> Self {
        let (sender, links) = flume::unbounded();
        let manager = LinkManagerUnicastTls::new(sender);
        let endpoint = files.endpoint(&format!("{host}:0"), more);
        let locator = manager.new_listener(endpoint).await.expect("it listens");
        Self {
            _manager: manager,
            links,
            locator,
        }
    }

    pub(crate) fn address(&self) -> String {
        self.locator.address().as_str().to_owned()
    }

    pub(crate) async fn dialled(&self, files: &Files) -> zenoh_result::ZResult<LinkUnicast> {
        dial(files.endpoint(&self.address(), "")).await
    }

    pub(crate) async fn taken(&self) -> LinkUnicast {
        let taken = timeout(LONG, self.links.recv_async()).await;
        taken.expect("in time").expect("a link")
    }
}

/// Makes a listener of `line` and both ends of a link of `saw` to it: the end that dialled first.
async fn linked(authority: &Authority) -> (Listening, LinkUnicast, LinkUnicast) {
    let listening = Listening::with(&authority.issue("line"), "127.0.0.1", "").await;
    let dialled = listening.dialled(&authority.issue("saw")).await;
    let dialled = dialled.expect("a link");
    let taken = listening.taken().await;
    (listening, dialled, taken)
}

pub(crate) async fn dial(endpoint: EndPoint) -> zenoh_result::ZResult<LinkUnicast> {
    let (sender, _) = flume::unbounded();
    LinkManagerUnicastTls::new(sender).new_link(endpoint).await
}

fn name_of(link: &LinkUnicast) -> Option<&str> {
    match link.get_auth_id() {
        LinkAuthId::Tls(name) => name.as_deref(),
        other => panic!("received {other:?}, expected TLS"),
    }
}

/// Returns a byte that depends on its place, so that lost, doubled or mixed up bytes are detected.
fn pattern(n: usize, salt: u8) -> u8 {
    // 2⁶⁴ over the golden ratio: neighbouring numbers have unlike bytes.
    (n as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).to_le_bytes()[5] ^ salt
}

async fn send(link: &LinkUnicast, bytes: usize, salt: u8) {
    let mut sent = 0;
    while sent < bytes {
        // From a byte to several records of TLS, as batches are.
        let length = (1 + (sent * 7919) % 50_000).min(bytes - sent);
        let batch: Vec<_> = (sent..sent + length).map(|n| pattern(n, salt)).collect();
        link.write_all(&batch, None).await.expect("it is written");
        sent += length;
    }
}

async fn receive(link: &LinkUnicast, bytes: usize, salt: u8) {
    let mut received = 0;
    while received < bytes {
        let length = (1 + (received * 104_729) % 30_000).min(bytes - received);
        let mut batch = vec![0; length];
        link.read_exact(&mut batch, None).await.expect("it is read");
        for (n, byte) in batch.iter().enumerate() {
            assert_eq!(*byte, pattern(received + n, salt), "byte {}", received + n);
        }
        received += length;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn both_ends_read_and_write_at_once_and_every_byte_arrives() {
    // Enough for Zenoh's own link to fail within a second in 20 of 20 runs.
    const BYTES: usize = 24 << 20;
    let authority = Authority::new();
    let (_listening, dialled, taken) = linked(&authority).await;
    assert_eq!(name_of(&dialled), Some("line"));
    assert_eq!(name_of(&taken), Some("saw"));
    let (there, back) = (dialled.clone(), taken.clone());
    let tasks = [
        tokio::spawn(async move { send(&there, BYTES, 1).await }),
        tokio::spawn(async move { send(&back, BYTES, 2).await }),
        tokio::spawn(async move { receive(&dialled, BYTES, 2).await }),
        tokio::spawn(async move { receive(&taken, BYTES, 1).await }),
    ];
    for task in tasks {
        timeout(10 * LONG, task)
            .await
            .expect("in time")
            .expect("it ends well");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_writer_that_nobody_reads_does_not_keep_its_own_reader_waiting() {
    let authority = Authority::new();
    let (_listening, dialled, taken) = linked(&authority).await;
    let stuck = dialled.clone();
    // More than all buffers of a loopback connection hold.
    let stuck = tokio::spawn(async move { stuck.write_all(&vec![7; 64 << 20], None).await });
    taken.write_all(b"word", None).await.expect("it is written");
    let mut word = [0; 4];
    let read = timeout(LONG, dialled.read_exact(&mut word, None)).await;
    read.expect("in time").expect("it is read");
    assert_eq!(&word, b"word");
    assert!(!stuck.is_finished(), "nobody reads what it writes");
    // Closing waits for no writer that is stuck, and ends it.
    timeout(LONG, dialled.close())
        .await
        .expect("in time")
        .expect("closed");
    let ended = timeout(LONG, stuck)
        .await
        .expect("in time")
        .expect("no panic");
    assert!(ended.is_err(), "the link is closed");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_other_end_finds_the_end_of_a_link_that_is_closed() {
    let authority = Authority::new();
    let (_listening, dialled, taken) = linked(&authority).await;
    dialled.write_all(b"last", None).await.expect("written");
    dialled.close().await.expect("closed");
    dialled.close().await.expect("closed once more");
    let mut last = [0; 4];
    timeout(LONG, taken.read_exact(&mut last, None))
        .await
        .expect("in time")
        .expect("read");
    assert_eq!(&last, b"last");
    let end = timeout(LONG, taken.read_exact(&mut last, None)).await;
    assert!(end.expect("in time").is_err());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_is_not_of_the_network_does_not_get_in() {
    let authority = Authority::new();
    let listening = Listening::with(&authority.issue("line"), "127.0.0.1", "").await;
    let stranger = Authority::new().issue("saw").trusting(&authority);
    let refused_later = [
        ("another authority", stranger),
        ("expired", authority.issue_expired("saw")),
    ];
    for (why, files) in refused_later {
        // TLS 1.3 reports a refusal to a client only after the client's own handshake is done.
        if let Ok(link) = listening.dialled(&files).await {
            let read = timeout(LONG, link.read_exact(&mut [0; 1], None)).await;
            assert!(read.expect("in time").is_err(), "{why}");
        }
    }
    let anonymous = authority
        .issue("saw")
        .endpoint(&listening.address(), "enable_mtls=false");
    if let Ok(link) = dial(anonymous).await {
        let read = timeout(LONG, link.read_exact(&mut [0; 1], None)).await;
        assert!(read.expect("in time").is_err(), "no certificate");
    }
    let other = authority.issue("saw").trusting(&Authority::new());
    let error = listening
        .dialled(&other)
        .await
        .expect_err("an authority that it does not know");
    assert!(
        error.to_string().contains("invalid peer certificate"),
        "{error}"
    );
    assert!(listening.links.is_empty(), "nobody got in");
    listening
        .dialled(&authority.issue("saw"))
        .await
        .expect("a member gets in");
    assert_eq!(name_of(&listening.taken().await), Some("saw"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn addresses_are_compared_with_certificates_ipv6_too() {
    let authority = Authority::new();
    let six = Listening::with(&authority.issue("line"), "[::1]", "").await;
    six.dialled(&authority.issue("saw"))
        .await
        .expect("a link over IPv6");
    assert_eq!(name_of(&six.taken().await), Some("saw"));
    let elsewhere = authority.issue_for("line", &["10.0.0.1"]);
    let listening = Listening::with(&elsewhere, "127.0.0.1", "").await;
    let error = listening
        .dialled(&authority.issue("saw"))
        .await
        .expect_err("another address");
    assert!(error.to_string().contains("not valid for name"), "{error}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn connects_that_say_nothing_or_nonsense_keep_nobody_out() {
    let authority = Authority::new();
    let listening = Listening::with(&authority.issue("line"), "127.0.0.1", "").await;
    let before = listening
        .dialled(&authority.issue("saw"))
        .await
        .expect("a link");
    let established = listening.taken().await;
    // More than the limit stay open and silent, and as many close at once or send garbage.
    let mut silent = Vec::new();
    // 200 of each kind, of which 128 silent ones fill all places.
    for n in 0..600 {
        let mut socket = PlainStream::connect(listening.address()).expect("a connection");
        match n % 3 {
            0 => silent.push(socket),
            1 => drop(socket),
            _ => {
                let _ = socket.write_all(b"GET / HTTP/1.1\r\n\r\n");
            }
        }
    }
    let saw = authority.issue("saw");
    let member = timeout(LONG, listening.dialled(&saw)).await;
    member.expect("in time").expect("a member gets in");
    listening.taken().await;
    established.write_all(b"on", None).await.expect("written");
    let mut on = [0; 2];
    before
        .read_exact(&mut on, None)
        .await
        .expect("the link of before works on");
    assert!(silent.len() > 128);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_link_ends_when_the_certificate_of_the_other_end_expires() {
    let authority = Authority::new();
    // Long enough for a handshake on a busy machine.
    let soon = authority.issue_until("saw", Duration::from_secs(8));
    let expiring = "close_link_on_expiration=true";
    let listening = Listening::with(&authority.issue("line"), "127.0.0.1", expiring).await;
    let dialled = listening
        .dialled(&soon)
        .await
        .expect("a link while it is valid");
    let taken = listening.taken().await;
    let end = timeout(LONG, taken.read_exact(&mut [0; 1], None)).await;
    assert!(end.expect("it is ended").is_err());
    let end = timeout(LONG, dialled.read_exact(&mut [0; 1], None)).await;
    assert!(end.expect("at both ends").is_err());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_revoked_certificate_loses_its_links_and_gets_no_new_one() {
    let events: Arc<Mutex<Vec<String>>> = Arc::default();
    let noted = Arc::clone(&events);
    on_link_event(move |event| {
        let text = format!("{} {:?}: {}", event.client, event.kind, event.reason);
        noted.lock().expect("no panic").push(text);
    });
    let authority = Authority::new();
    let line = authority.issue("line");
    let listening = Listening::with(&line, "127.0.0.1", "").await;
    let (mill, press) = (authority.issue("mill"), authority.issue("press"));
    let dialled = listening.dialled(&mill).await.expect("a link");
    let taken = listening.taken().await;
    let good = listening.dialled(&press).await.expect("a link");
    let good_taken = listening.taken().await;

    // A list of somebody else changes nothing, for longer than the interval of the looks.
    Authority::new().revoke(9, &["mill", "press"], &line);
    tokio::time::sleep(Duration::from_secs(3)).await;
    send(&dialled, 10, 1).await;
    receive(&taken, 10, 1).await;

    // That of the authority, while the listener runs.
    authority.revoke(2, &["mill"], &line);
    let end = timeout(LONG, taken.read_exact(&mut [0; 1], None)).await;
    assert!(end.expect("it is ended").is_err());
    let end = timeout(LONG, dialled.read_exact(&mut [0; 1], None)).await;
    assert!(end.expect("at both ends").is_err());
    if let Ok(link) = listening.dialled(&mill).await {
        let read = timeout(LONG, link.read_exact(&mut [0; 1], None)).await;
        let error = read.expect("in time").expect_err("it is revoked");
        assert!(error.to_string().contains("CertificateRevoked"), "{error}");
    }
    send(&good, 1_000, 1).await;
    receive(&good_taken, 1_000, 1).await;
    let revoked = "the certificate of \"mill\" is revoked";
    for kind in ["Ended", "Refused"] {
        let event = format!("mill {kind}: {revoked}");
        let events = events.lock().expect("no panic");
        assert!(events.contains(&event), "{event}: {events:?}");
    }

    // An older list, or none, takes nothing back; a certificate from after that is good.
    authority.revoke(1, &[], &line);
    tokio::time::sleep(Duration::from_secs(2)).await;
    if let Ok(link) = listening.dialled(&mill).await {
        let read = timeout(LONG, link.read_exact(&mut [0; 1], None)).await;
        assert!(read.expect("in time").is_err());
    }
    let renewed = listening.dialled(&authority.renew("mill")).await;
    assert!(renewed.is_ok());
    assert_eq!(name_of(&listening.taken().await), Some("mill"));

    // The end that dials has a list of its own.
    authority.revoke(3, &["line"], &press);
    let error = listening.dialled(&press).await.expect_err("it is revoked");
    let expected = "the certificate of \"line\" is revoked";
    assert!(error.to_string().contains(expected), "{error}");
}

#[tokio::test]
async fn a_wrong_setting_is_named_with_what_is_expected() {
    let authority = Authority::new();
    let files = authority.issue("line");
    let (sender, _links) = flume::unbounded();
    let manager = LinkManagerUnicastTls::new(sender);
    for (endpoint, expected) in [
        (
            "tls/127.0.0.1:0".to_owned(),
            "listen_certificate: received none",
        ),
        (
            format!("{}", files.endpoint("127.0.0.1:0", "enable_mtls=perhaps")),
            "enable_mtls: received \"perhaps\", expected true or false",
        ),
        (
            format!(
                "{}",
                files.endpoint("127.0.0.1:0", "listen_private_key_file=nowhere")
            ),
            "listen_private_key: nowhere",
        ),
        (
            format!("{}", files.endpoint("127.0.0.1:0", "so_sndbuf=much")),
            "so_sndbuf: received \"much\", expected a number",
        ),
    ] {
        let endpoint: EndPoint = endpoint.parse().expect("an endpoint");
        let error = manager.new_listener(endpoint).await.expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
    }
    let error = dial("tls/127.0.0.1:7447".parse().expect("one"))
        .await
        .expect_err("no authority");
    assert!(
        error
            .to_string()
            .contains("root_ca_certificate: received none"),
        "{error}"
    );
}
