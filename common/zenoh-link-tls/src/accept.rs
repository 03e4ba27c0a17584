//! Accepting links.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream};
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::Instant;
use tokio_rustls::{TlsAcceptor, TlsStream};
use tokio_util::sync::CancellationToken;
use zenoh_link_commons::{LinkUnicast, NewLinkChannelSender};
use zenoh_result::ZResult;

use crate::config::{self, Common};
use crate::link::{LinkAddresses, TlsLink};
use crate::refusals::Refusals;

/// Greatest number of handshakes in progress. One takes a few milliseconds; a client slower than this
/// number of later ones makes room for the next one. So a client that connects and sends nothing keeps
/// nobody out: that would take this many connects within the time of one honest handshake, some 50 000 a
/// second. It also limits descriptors and memory.
const MOST_HANDSHAKES: usize = 128;

/// The wait when the system gives no descriptor: it will not have one at once.
const WITHOUT_DESCRIPTORS: Duration = Duration::from_millis(100);

/// A listening socket and the destination of its links.
pub(crate) struct TlsListener {
    pub(crate) socket: TcpListener,
    pub(crate) acceptor: TlsAcceptor,
    pub(crate) common: Arc<Common>,
    pub(crate) links: NewLinkChannelSender,
}

/// A handshake that ended: the client's address, and the error if it failed.
type Ended = (SocketAddr, Result<(), String>);

impl TlsListener {
    /// Runs until the token is cancelled.
    pub(crate) async fn run(self, token: CancellationToken) -> ZResult<()> {
        let mut under_way = Handshakes::default();
        let mut refusals = Refusals::default();
        loop {
            tokio::select! {
                () = token.cancelled() => return Ok(()),
                // Handshakes run beside the loop: one that waits for its client delays no other.
                Some((from, result)) = under_way.next() => {
                    if let Err(reason) = result {
                        refusals.add(from, reason);
                    }
                }
                accepted = self.socket.accept() => match accepted {
                    Ok((socket, from)) => {
                        // The oldest makes room, not the newest: an honest handshake is over in milliseconds, a
                        // silent client never.
                        if let Some(evicted) = under_way.make_room() {
                            refusals.add(evicted, "slower than those that came later".to_owned());
                        }
                        under_way.start(from, self.handshake(socket, from));
                    }
                    // The listener stays: descriptors come back when links end.
                    Err(error) => self.cannot_accept(&error).await,
                },
                // Refusals during the quiet time of the log are reported after it even if no further one comes.
                () = wait_until(refusals.due()) => {}
            }
            if let Some(line) = refusals.line(Instant::now()) {
                tracing::warn!(target: config::LOG, "{line}");
            }
        }
    }

    /// Makes the handshake of one connection, and hands over its link.
    fn handshake(
        &self,
        socket: TcpStream,
        from: SocketAddr,
    ) -> impl Future<Output = Result<(), String>> + Send + 'static {
        let (acceptor, common, links) = (
            self.acceptor.clone(),
            self.common.clone(),
            self.links.clone(),
        );
        async move {
            // A client in good health that is merely cut off would hold a place until the TCP timeout, which is
            // minutes.
            let link = tokio::time::timeout(common.handshake_timeout, async {
                let stream = acceptor.accept(socket).await?;
                let here = stream.get_ref().0.local_addr()?;
                io::Result::Ok((TlsStream::Server(stream), here))
            });
            let (stream, here) = link
                .await
                .map_err(|_| "no handshake within its time".to_owned())?
                .map_err(|error| error.to_string())?;
            let ends = LinkAddresses { here, there: from };
            // Only now: the session exists, and the certificates of the peer are checked.
            let link = TlsLink::open(stream, ends, &common);
            let link: LinkUnicast = link.map_err(|error| error.to_string())?;
            let handed_over = links.send_async(link).await;
            handed_over.map_err(|_| "the session is being closed".to_owned())
        }
    }

    async fn cannot_accept(&self, error: &io::Error) {
        tracing::error!(
            target: config::LOG,
            "no connection can be taken: {error} (each open link takes a descriptor: ulimit -n)"
        );
        tokio::time::sleep(WITHOUT_DESCRIPTORS).await;
    }
}

/// The handshakes in progress, the oldest one first.
#[derive(Default)]
struct Handshakes {
    tasks: JoinSet<Ended>,
    order: VecDeque<(SocketAddr, AbortHandle)>,
}

impl Handshakes {
    fn start(
        &mut self,
        from: SocketAddr,
        handshake: impl Future<Output = Result<(), String>> + Send + 'static,
    ) {
        let task = async move { (from, handshake.await) };
        let handle = self.tasks.spawn(task);
        self.order.push_back((from, handle));
    }

    /// Ends the oldest handshake if the limit is reached; returns the client's address.
    fn make_room(&mut self) -> Option<SocketAddr> {
        if self.order.len() < MOST_HANDSHAKES {
            return None;
        }
        // Finished ones are removed only when room is needed, so that the usual start costs nothing.
        self.order.retain(|(_, handle)| !handle.is_finished());
        if self.order.len() < MOST_HANDSHAKES {
            return None;
        }
        let (from, handle) = self.order.pop_front()?;
        // Its task ends at the next await, which drops the socket.
        handle.abort();
        Some(from)
    }

    /// Waits for the next one that ends by itself. None without any: a branch of `select!` that is off.
    async fn next(&mut self) -> Option<Ended> {
        loop {
            match self.tasks.join_next().await? {
                Ok(ended) => return Some(ended),
                // A handshake that was ended to make room.
                Err(ended) if ended.is_cancelled() => {}
                Err(panicked) => {
                    tracing::error!(target: config::LOG, "a handshake panicked: {panicked}");
                }
            }
        }
    }
}

/// Waits for ever without a time.
async fn wait_until(time: Option<Instant>) {
    match time {
        Some(time) => tokio::time::sleep_until(time).await,
        None => std::future::pending().await,
    }
}
