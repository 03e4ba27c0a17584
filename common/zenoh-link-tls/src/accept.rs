//! Accepting links.

use std::collections::BTreeMap;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use rustls::ServerConfig;
use rustls::server::Accepted;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::{AbortHandle, JoinError, JoinSet};
use tokio::time::{Instant, sleep_until, timeout_at};
use tokio_rustls::server::StartHandshake;
use tokio_rustls::{LazyConfigAcceptor, TlsStream};
use tokio_util::sync::CancellationToken;
use zenoh_link_commons::{LinkUnicast, NewLinkChannelSender};
use zenoh_result::ZResult;
use zenoh_runtime::ZRuntime;

use crate::admission::{AdmissionControl, ConnectionId, MOST_GREETED, MOST_SILENT};
use crate::config::Common;
use crate::events;
use crate::link::{LinkAddresses, TlsLink};
use crate::refusals::Refusals;
use crate::source_prefix::SourcePrefix;

/// Greatest duration of a handshake, whatever the config permits: two round trips, and a second for each of two lost
/// packets (RFC 6298). A new member must not wait longer for a place that a silent client holds.
pub(crate) const LONGEST_HANDSHAKE: Duration = Duration::from_secs(3);

/// The pause of accepting when the system gives no descriptor and no connection can make room: it will not have one at once.
const WITHOUT_DESCRIPTORS: Duration = Duration::from_millis(100);

/// Least time between two lines about that.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

/// Greatest number of descriptors of connections without a complete handshake, including displaced ones whose task has
/// not ended yet: a quarter of the 1024 that a process usually has.
pub(crate) const MOST_DESCRIPTORS: usize = 256;
// Otherwise no connection would be accepted, and none displaced, while all places are taken.
const _: () = assert!(MOST_DESCRIPTORS > MOST_SILENT + MOST_GREETED);

/// The handshakes of a listening socket, and the destination of its links.
pub(crate) struct TlsListener {
    pub(crate) server: Arc<ServerConfig>,
    pub(crate) common: Arc<Common>,
    pub(crate) links: NewLinkChannelSender,
}

impl TlsListener {
    /// Accepts connections until the token is cancelled.
    pub(crate) async fn run(
        self,
        socket: std::net::TcpListener,
        token: CancellationToken,
    ) -> ZResult<()> {
        // Of no runtime before: here it is registered with the one that accepts.
        let socket = TcpListener::from_std(socket)?;
        let mut open = PendingConnections::default();
        let mut refusals = Refusals::default();
        let mut pause = Pause::default();
        loop {
            let now = Instant::now();
            while let Some(id) = open.admission.start(now) {
                open.start(id, |greeted, held| self.handshake(greeted, held));
            }
            if let Some(line) = refusals.line(now) {
                tracing::warn!(target: events::LOG, "{line}");
            }
            let wake = [
                // The pace of an origin may hold a handshake up.
                open.admission.next_start(now),
                // Refusals during the quiet time of the log are reported after it even if no further one comes.
                refusals.due(now),
                pause.until(now),
            ];
            tokio::select! {
                () = token.cancelled() => return Ok(()),
                // PendingConnections are served beside the loop: one that waits for its client delays no other.
                refused = open.next() => if let Some((from, reason)) = refused {
                    refusals.add(Instant::now(), from, reason);
                },
                accepted = socket.accept(), if open.has_room() && pause.until(now).is_none() => match accepted {
                    Ok((socket, from)) => {
                        let ends = Instant::now() + LONGEST_HANDSHAKE.min(self.common.handshake_timeout);
                        if let Some(displaced) = open.admit(socket, from, ends) {
                            refusals.add(Instant::now(), displaced, DISPLACED.to_owned());
                        }
                    }
                    // The listener stays: descriptors come back when connections end.
                    Err(error) => {
                        let now = Instant::now();
                        pause.log(now, &error);
                        match open.displace() {
                            Some(displaced) => refusals.add(now, displaced, DISPLACED.to_owned()),
                            None => pause.begin(now),
                        }
                    }
                },
                () = wait_until(wake.into_iter().flatten().min()) => {}
            }
        }
    }

    /// Makes the handshake of a connection with a complete ClientHello, and hands over its link.
    fn handshake(
        &self,
        greeted: Greeted,
        held: &HeldConnection,
    ) -> impl Future<Output = Result<(), String>> + Send + use<> {
        let (server, common, links) = (
            Arc::clone(&self.server),
            Arc::clone(&self.common),
            self.links.clone(),
        );
        let (from, ends) = (held.from, held.ends);
        async move {
            let link = timeout_at(ends, async {
                // Here, not earlier: a socket is woken by the runtime that made it, and the link belongs to this one.
                let socket = TcpStream::from_std(greeted.socket)?;
                let stream = StartHandshake::from_parts(greeted.accepted, socket);
                let stream = stream.into_stream(server).await?;
                let here = stream.get_ref().0.local_addr()?;
                io::Result::Ok((TlsStream::Server(stream), here))
            });
            let (stream, here) = within_time(link.await)?;
            let ends = LinkAddresses { here, there: from };
            // Only now: the session exists, and the certificates of the peer are checked.
            let link = TlsLink::open(stream, ends, &common);
            let link: LinkUnicast = link.map_err(|error| error.to_string())?;
            let handed_over = links.send_async(link).await;
            handed_over.map_err(|_| "the session is being closed".to_owned())
        }
    }
}

/// Reason for the end of a connection that made room.
const DISPLACED: &str = "it was slower than later ones";

/// A connection whose ClientHello is complete.
struct Greeted {
    accepted: Accepted,
    /// Of no runtime: it changes to that of the links.
    socket: std::net::TcpStream,
}

/// Reads the ClientHello of a connection. Costs next to nothing: no key is used before it is complete.
async fn greet(socket: TcpStream, ends: Instant) -> Result<Greeted, String> {
    let greeting = LazyConfigAcceptor::new(rustls::server::Acceptor::default(), socket);
    let StartHandshake { accepted, io, .. } = within_time(timeout_at(ends, greeting).await)?;
    let socket = io.into_std().map_err(|error| error.to_string())?;
    Ok(Greeted { accepted, socket })
}

/// The result of a handshake or a part of it, or the reason for which it failed.
fn within_time<T>(result: Result<io::Result<T>, impl std::error::Error>) -> Result<T, String> {
    result
        // A client in good health that is merely cut off would hold a place until the TCP timeout, which is minutes.
        .map_err(|_| "no handshake within its time".to_owned())?
        .map_err(|error| error.to_string())
}

/// The end of a task.
enum Ended {
    Greeted(Result<Box<Greeted>, String>),
    Linked(Result<(), String>),
}

/// A connection without a complete handshake.
struct HeldConnection {
    from: SocketAddr,
    /// The latest end of its handshake.
    ends: Instant,
    state: PendingStep,
}

/// The thing that a connection waits for.
enum PendingStep {
    Task(AbortHandle),
    /// The start of its handshake.
    Start(Box<Greeted>),
    /// Nothing any more: its handshake is just being started.
    Over,
}

impl HeldConnection {
    fn abort(self) {
        // A task ends at its next await, which drops the socket.
        if let PendingStep::Task(task) = self.state {
            task.abort();
        }
    }
}

/// PendingConnections without a complete handshake, and the tasks that serve them.
#[derive(Default)]
struct PendingConnections {
    admission: AdmissionControl,
    held: BTreeMap<ConnectionId, HeldConnection>,
    tasks: JoinSet<(ConnectionId, Ended)>,
    /// The next connection is accepted after a task has ended.
    awaits_end: bool,
}

impl PendingConnections {
    /// Takes a connection. Returns the address of the one that it displaces.
    fn admit(&mut self, socket: TcpStream, from: SocketAddr, ends: Instant) -> Option<SocketAddr> {
        let (id, displaced) = self.admission.admit(SourcePrefix::of(from));
        let task = async move { (id, Ended::Greeted(greet(socket, ends).await.map(Box::new))) };
        let state = PendingStep::Task(self.tasks.spawn(task));
        self.held.insert(id, HeldConnection { from, ends, state });
        self.end(displaced)
    }

    /// True if one more descriptor may be held.
    fn has_room(&self) -> bool {
        let without_task = |held: &&HeldConnection| matches!(held.state, PendingStep::Start(_));
        let waiting = self.held.values().filter(without_task).count();
        // Without tasks nothing is to be awaited.
        let awaits_end = self.awaits_end && !self.tasks.is_empty();
        !awaits_end && self.tasks.len() + waiting < MOST_DESCRIPTORS
    }

    /// Ends one connection, for want of a descriptor. Returns its address.
    fn displace(&mut self) -> Option<SocketAddr> {
        let displaced = self.admission.displace();
        // Its descriptor is back when its task has ended; a further attempt would fail before.
        self.awaits_end = true;
        self.end(displaced)
    }

    /// Starts the handshake of a connection that waits for it.
    fn start<F>(&mut self, id: ConnectionId, handshake: impl FnOnce(Greeted, &HeldConnection) -> F)
    where
        F: Future<Output = Result<(), String>> + Send + 'static,
    {
        let Some(held) = self.held.get_mut(&id) else {
            return;
        };
        let PendingStep::Start(greeted) = std::mem::replace(&mut held.state, PendingStep::Over)
        else {
            return;
        };
        let handshake = handshake(*greeted, held);
        let task = async move { (id, Ended::Linked(handshake.await)) };
        // On the runtime of the links: the socket is registered there, and takes no way through this thread later.
        let task = self.tasks.spawn_on(task, &ZRuntime::Acceptor);
        held.state = PendingStep::Task(task);
    }

    /// Waits for the next task to end. Returns the address of a connection that is refused, and the reason.
    async fn next(&mut self) -> Option<(SocketAddr, String)> {
        let Some(ended) = self.tasks.join_next().await else {
            // The other branches of the loop go on.
            return std::future::pending().await;
        };
        self.awaits_end = false;
        let (id, ended) = match ended {
            Ok(ended) => ended,
            Err(error) => {
                self.forget(&error);
                return None;
            }
        };
        let result = match ended {
            Ended::Greeted(Ok(greeted)) => {
                // The loop starts its handshake, at the pace of its origin.
                if let Some(held) = self.held.get_mut(&id) {
                    held.state = PendingStep::Start(greeted);
                }
                let displaced = self.admission.greeted(id);
                return Some((self.end(displaced)?, DISPLACED.to_owned()));
            }
            Ended::Greeted(Err(reason)) => Err(reason),
            Ended::Linked(result) => result,
        };
        // One that was displaced meanwhile is counted already.
        let from = self.end(Some(id))?;
        Some((from, result.err()?))
    }

    /// Ends a connection. Returns its address.
    fn end(&mut self, id: Option<ConnectionId>) -> Option<SocketAddr> {
        let id = id?;
        self.admission.end(id);
        let held = self.held.remove(&id)?;
        let from = held.from;
        held.abort();
        Some(from)
    }

    /// Removes the connection of a task that gave no result, if it was not displaced.
    fn forget(&mut self, error: &JoinError) {
        let is_it = |held: &HeldConnection| matches!(&held.state, PendingStep::Task(task) if task.id() == error.id());
        let id = self.held.iter().find(|(_, held)| is_it(held));
        let id = id.map(|(id, _)| *id);
        self.end(id);
        if error.is_panic() {
            tracing::error!(target: events::LOG, "a handshake panicked: {error}");
        }
    }
}

/// The pause of accepting for want of descriptors. Everything else goes on meanwhile.
#[derive(Default)]
struct Pause {
    until: Option<Instant>,
    logged: Option<Instant>,
}

impl Pause {
    fn begin(&mut self, now: Instant) {
        self.until = Some(now + WITHOUT_DESCRIPTORS);
    }

    fn log(&mut self, now: Instant, error: &io::Error) {
        if self
            .logged
            .is_none_or(|logged| now >= logged + BETWEEN_LINES)
        {
            self.logged = Some(now);
            tracing::error!(
                target: events::LOG,
                "no connection can be taken: {error} (each open link takes a descriptor: ulimit -n)"
            );
        }
    }

    fn until(&self, now: Instant) -> Option<Instant> {
        self.until.filter(|until| *until > now)
    }
}

/// Waits for ever without a time.
async fn wait_until(time: Option<Instant>) {
    match time {
        Some(time) => sleep_until(time).await,
        None => std::future::pending().await,
    }
}
