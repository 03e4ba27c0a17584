//! Connections that hold a page up.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use futures_util::stream::repeat;
use hyper::body::Bytes;

use super::connections::MOST_CONNECTIONS;
use super::*;

/// A page with a text, and a stream without an end.
struct Page;

impl Routes for Page {
    async fn respond(&self, request: WebRequest) -> Response {
        match request.path().as_slice() {
            ["endless"] => streamed(repeat(Bytes::from_static(&[0; 4096]))),
            _ => whole("text/plain", "here"),
        }
    }
}

fn page() -> PageServer {
    PageServer::open("127.0.0.1:0".parse().unwrap(), None, Page).unwrap()
}

/// A connection that has sent this.
fn connection(at: SocketAddr, sent: &str) -> TcpStream {
    let mut stream = TcpStream::connect(at).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    stream.write_all(sent.as_bytes()).unwrap();
    stream
}

/// Everything that comes back, until the other end closes.
fn rest(mut stream: TcpStream) -> String {
    let mut text = Vec::new();
    // A reset is an end as well.
    let _ = stream.read_to_end(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

const WHOLE: &str = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n";
const HALF: &str = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-a: ";

#[test]
fn a_newcomer_is_served_however_many_send_their_requests_slowly() {
    let page = page();
    // Three times as many as there may be, which send a byte now and then.
    let mut slow: Vec<_> = (0..3 * MOST_CONNECTIONS)
        .map(|_| connection(page.address(), HALF))
        .collect();
    for _ in 0..3 {
        assert!(rest(connection(page.address(), WHOLE)).ends_with("here"));
        for stream in &mut slow {
            // Those that were closed refuse it.
            let _ = stream.write_all(b"b");
        }
    }
    // The first ones had to go for those that came later.
    let first = slow.remove(0);
    assert_eq!(rest(first), "");
}

#[test]
fn a_request_that_does_not_end_is_given_up() {
    let page = page();
    // The header does not end.
    assert_eq!(rest(connection(page.address(), HALF)), "");
    // Nor does the body, of which there are two bytes.
    let post =
        "POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nx-coaxle-page: 1\r\nContent-Length: 9\r\n\r\n{}";
    let refused = rest(connection(page.address(), post));
    assert!(refused.contains(" 408 "), "{refused}");
    assert!(
        refused.contains("expected the body within 10s"),
        "{refused}"
    );
}

#[test]
fn beyond_the_last_connection_a_newcomer_is_told_so() {
    let page = page();
    let endless = "GET /endless HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    let open: Vec<_> = (0..MOST_CONNECTIONS)
        .map(|_| {
            let mut stream = connection(page.address(), endless);
            // Its response is under way.
            stream.read_exact(&mut [0; 12]).unwrap();
            stream
        })
        .collect();
    let refused = rest(connection(page.address(), WHOLE));
    assert!(refused.starts_with("HTTP/1.1 503 "), "{refused:?}");
    drop(open);
    // The server learns of it with the next write.
    let end = coaxle_os::machine::now() + coaxle_clock::Span::from_secs(60);
    while !rest(connection(page.address(), WHOLE)).ends_with("here") {
        assert!(coaxle_os::machine::now() < end);
    }
}
