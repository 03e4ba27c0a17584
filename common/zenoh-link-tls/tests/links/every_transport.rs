//! Links of every kind, read and written at both ends at once, for a run under a sanitizer or valgrind:
//! docs/UNSAFE.md has the commands and their results.

use std::time::Duration;

use super::authority::Authority;
use tokio::time::timeout;
use zenoh_link_commons::{LinkManagerUnicastTrait, LinkUnicast, NewLinkChannelSender};
use zenoh_protocol::core::EndPoint;

/// Under valgrind everything takes fifty times as long.
const LONG: Duration = Duration::from_secs(600);

/// Batches each way, of the length of a frame of some axes; a few thousand show a race that crashes a node in minutes.
const BATCHES: usize = 5_000;
const BATCH: usize = 1_200;

type Manager = Box<dyn LinkManagerUnicastTrait>;

/// Opens a link and hands over both ends.
async fn both_ends(
    make: impl Fn(NewLinkChannelSender) -> Manager,
    listen: EndPoint,
    dial: impl FnOnce(&str) -> EndPoint,
) -> (LinkUnicast, LinkUnicast) {
    let (sender, links) = flume::unbounded();
    let listener = make(sender);
    let locator = listener.new_listener(listen).await.expect("it listens");
    let (unused, _) = flume::unbounded();
    let dialled = make(unused)
        .new_link(dial(locator.address().as_str()))
        .await;
    let dialled = dialled.expect("a link");
    // A datagram link is there for the other end when the first datagram is.
    dialled.write_all(&[0; BATCH], None).await.expect("written");
    let taken = timeout(LONG, links.recv_async())
        .await
        .expect("in time")
        .expect("a link");
    // The listener lives as long as the process: some links share its socket.
    std::mem::forget(listener);
    (dialled, taken)
}

async fn send(link: LinkUnicast) {
    for n in 0..BATCHES {
        link.write_all(&[n as u8; BATCH], None)
            .await
            .expect("written");
    }
}

async fn receive(link: LinkUnicast, batches: usize) {
    let mut batch = [0; BATCH];
    for _ in 0..batches {
        if link.is_streamed() {
            link.read_exact(&mut batch, None).await.expect("read");
            assert!(batch.iter().all(|byte| *byte == batch[0]), "a torn batch");
        } else if timeout(Duration::from_secs(1), link.read(&mut batch, None))
            .await
            .is_err()
        {
            // Datagrams may be lost.
            break;
        }
    }
}

/// Reads and writes both ends at once, then closes one of them while the other one still writes.
async fn load((dialled, taken): (LinkUnicast, LinkUnicast)) {
    let tasks = [
        tokio::spawn(send(dialled.clone())),
        tokio::spawn(send(taken.clone())),
        tokio::spawn(receive(dialled.clone(), BATCHES)),
        tokio::spawn(receive(taken.clone(), BATCHES + 1)),
    ];
    for task in tasks {
        timeout(LONG, task)
            .await
            .expect("in time")
            .expect("it ends well");
    }
    let writer =
        tokio::spawn(async move { while taken.write_all(&[1; BATCH], None).await.is_ok() {} });
    dialled.close().await.expect("closed");
    drop(dialled);
    // A datagram link does not detect the loss of its peer.
    tokio::time::sleep(Duration::from_millis(50)).await;
    writer.abort();
    let _ = writer.await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn tls() {
    let authority = Authority::new();
    let (line, saw) = (authority.issue("line"), authority.issue("saw"));
    let make = |links| -> Manager { Box::new(zenoh_link_tls::LinkManagerUnicastTls::new(links)) };
    let listen = line.endpoint("127.0.0.1:0", "");
    load(both_ends(make, listen, |address| saw.endpoint(address, "")).await).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn quic() {
    let authority = Authority::new();
    let (line, saw) = (authority.issue("line"), authority.issue("saw"));
    let make = |links| -> Manager { Box::new(zenoh_link_quic::LinkManagerUnicastQuic::new(links)) };
    let over_quic = |endpoint: EndPoint| -> EndPoint {
        let text = endpoint.to_string().replacen("tls/", "quic/", 1);
        text.parse().expect("an endpoint")
    };
    let listen = over_quic(line.endpoint("127.0.0.1:0", ""));
    load(both_ends(make, listen, |address| over_quic(saw.endpoint(address, ""))).await).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn tcp() {
    let make = |links| -> Manager { Box::new(zenoh_link_tcp::LinkManagerUnicastTcp::new(links)) };
    let dial = |address: &str| format!("tcp/{address}").parse().expect("an endpoint");
    load(both_ends(make, dial("127.0.0.1:0"), dial).await).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn udp() {
    let make = |links| -> Manager { Box::new(zenoh_link_udp::LinkManagerUnicastUdp::new(links)) };
    let dial = |address: &str| format!("udp/{address}").parse().expect("an endpoint");
    load(both_ends(make, dial("127.0.0.1:0"), dial).await).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn unix_socket() {
    let folder = tempfile::tempdir().expect("a folder");
    let socket = folder.path().join("a.sock").display().to_string();
    let make = |links| -> Manager {
        Box::new(zenoh_link_unixsock_stream::LinkManagerUnicastUnixSocketStream::new(links))
    };
    let dial = |address: &str| {
        format!("unixsock-stream/{address}")
            .parse()
            .expect("an endpoint")
    };
    load(both_ends(make, dial(&socket), dial).await).await;
}
