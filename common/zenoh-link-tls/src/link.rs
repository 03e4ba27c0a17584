//! A link: one TLS connection, with the interface of Zenoh.

use std::fmt;
use std::net::SocketAddr;
use std::sync::{Arc, Weak};
use std::time::Duration;

use async_trait::async_trait;
use time::OffsetDateTime;
use tokio::net::TcpStream;
use tokio::task::AbortHandle;
use tokio_rustls::TlsStream;
use zenoh_link_commons::{LinkAuthId, LinkUnicast, LinkUnicastTrait, get_ip_interface_names};
use zenoh_protocol::core::{Locator, Priority};
use zenoh_protocol::transport::BatchSize;
use zenoh_result::{ZResult, zerror};

use crate::TLS_LOCATOR_PREFIX;
use crate::certificate::CertifiedPeer;
use crate::config::Common;
use crate::events::{self, LinkEventKind, report};
use crate::revocation::RevocationWatch;
use crate::stream::SharedStream;

/// The longest sleep until a certificate expires: the machine's clock may be set meanwhile.
const LONGEST_SLEEP: Duration = Duration::from_secs(600);

/// Interval between two looks at the list of revoked certificates, which itself looks at its file as often.
const LOOK: Duration = Duration::from_secs(1);

/// A TLS connection to a peer whose certificate was checked.
pub(crate) struct TlsLink {
    stream: SharedStream,
    ends: LinkAddresses,
    source: Locator,
    destination: Locator,
    authenticated: LinkAuthId,
    watch: Option<AbortHandle>,
}

/// The addresses of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LinkAddresses {
    pub(crate) here: SocketAddr,
    pub(crate) there: SocketAddr,
}

impl TlsLink {
    /// Takes a connection whose handshake is done. It ends when the certificate of the peer is revoked, and with
    /// `closes_on_expiry` when a certificate of its chain expires.
    ///
    /// # Errors
    /// A certificate of the peer that cannot be read or is revoked; an invalid address.
    pub(crate) fn open(
        stream: TlsStream<TcpStream>,
        ends: LinkAddresses,
        common: &Common,
    ) -> ZResult<LinkUnicast> {
        let (socket, session) = stream.get_ref();
        // A batch is sent when it is complete; Nagle's algorithm would hold it back for the acknowledgement of the last one.
        socket.set_nodelay(true)?;
        let peer = CertifiedPeer::of(session.peer_certificates())?;
        let locator =
            |address: SocketAddr| Locator::new(TLS_LOCATOR_PREFIX, address.to_string(), "");
        let (source, destination) = (locator(ends.here)?, locator(ends.there)?);
        let revocation = |watch: &Arc<RevocationWatch>| watch.list().revocation(&peer);
        if let Some(reason) = common.revoked.as_ref().and_then(revocation) {
            return Err(zerror!("{reason}").into());
        }
        let end = LinkEnd {
            expires: peer.expires.filter(|_| common.closes_on_expiry),
            // A peer without a certificate has none that could be revoked.
            revoked: common.revoked.clone().filter(|_| peer.name.is_some()),
            peer: peer.clone(),
        };
        // The task that ends it needs the link, but must not keep it alive: a weak reference made before the link
        // is.
        let link = Arc::new_cyclic(|link: &Weak<Self>| Self {
            stream: SharedStream::new(stream),
            ends,
            source,
            destination,
            authenticated: LinkAuthId::Tls(peer.name),
            watch: end.is_possible().then(|| end.watch(link.clone())),
        });
        Ok(LinkUnicast::from(link as Arc<dyn LinkUnicastTrait>))
    }

    fn failed(&self, doing: &str, error: &std::io::Error) -> zenoh_result::Error {
        tracing::trace!("{doing} on {self}: {error}");
        zerror!("{doing} on TLS link {self}: {error}").into()
    }
}

/// What ends a link that still exists.
struct LinkEnd {
    peer: CertifiedPeer,
    expires: Option<OffsetDateTime>,
    revoked: Option<Arc<RevocationWatch>>,
}

impl LinkEnd {
    const fn is_possible(&self) -> bool {
        self.expires.is_some() || self.revoked.is_some()
    }

    /// Ends the link when its time has come.
    fn watch(self, link: Weak<TlsLink>) -> AbortHandle {
        let wait = async move {
            let reason = loop {
                if let Some(reason) = self.reason() {
                    break reason;
                }
                // Sleeps measure monotonic time, certificates the time of day: asked again after each piece.
                let left = self.expires.and_then(remaining).unwrap_or(LONGEST_SLEEP);
                let longest = if self.revoked.is_some() {
                    LOOK
                } else {
                    LONGEST_SLEEP
                };
                tokio::time::sleep(left.min(longest)).await;
            };
            if let Some(link) = link.upgrade() {
                tracing::warn!(target: events::LOG, "{link}: {reason}: link closed");
                let client = self
                    .peer
                    .name
                    .unwrap_or_else(|| link.ends.there.to_string());
                report(&client, LinkEventKind::Ended, &reason);
                link.stream.abort();
            }
        };
        zenoh_runtime::ZRuntime::Acceptor.spawn(wait).abort_handle()
    }

    fn reason(&self) -> Option<String> {
        let list = self.revoked.as_ref().map(|watch| watch.list());
        let revocation = list.and_then(|list| list.revocation(&self.peer));
        let is_over = |until: &OffsetDateTime| remaining(*until).is_none();
        let expiry = self.expires.filter(is_over);
        let expiry = expiry.map(|_| "the certificate of the other end has expired".to_owned());
        revocation.or(expiry)
    }
}

/// Returns the remaining time; none when it is over.
fn remaining(until: OffsetDateTime) -> Option<Duration> {
    let left = until - OffsetDateTime::now_utc();
    // A negative rest is no `Duration`, and over.
    Duration::try_from(left).ok().filter(|left| !left.is_zero())
}

#[async_trait]
impl LinkUnicastTrait for TlsLink {
    async fn write(&self, buffer: &[u8], _priority: Option<Priority>) -> ZResult<usize> {
        let written = self.stream.write(buffer).await;
        written.map_err(|error| self.failed("writing", &error))
    }

    async fn write_all(&self, buffer: &[u8], _priority: Option<Priority>) -> ZResult<()> {
        let written = self.stream.write_all(buffer).await;
        written.map_err(|error| self.failed("writing", &error))
    }

    async fn read(&self, buffer: &mut [u8], _priority: Option<Priority>) -> ZResult<usize> {
        let read = self.stream.read(buffer).await;
        read.map_err(|error| self.failed("reading", &error))
    }

    async fn read_exact(&self, buffer: &mut [u8], _priority: Option<Priority>) -> ZResult<()> {
        let read = self.stream.read_exact(buffer).await;
        read.map_err(|error| self.failed("reading", &error))
    }

    async fn close(&self) -> ZResult<()> {
        self.stream.close().await;
        Ok(())
    }

    fn get_mtu(&self) -> BatchSize {
        // A stream of bytes: the batch is bounded by its length field alone.
        BatchSize::MAX
    }

    fn get_src(&self) -> &Locator {
        &self.source
    }

    fn get_dst(&self) -> &Locator {
        &self.destination
    }

    fn is_reliable(&self) -> bool {
        true
    }

    fn is_streamed(&self) -> bool {
        true
    }

    fn get_interface_names(&self) -> Vec<String> {
        get_ip_interface_names(&self.ends.here)
    }

    fn get_auth_id(&self) -> &LinkAuthId {
        &self.authenticated
    }
}

impl Drop for TlsLink {
    fn drop(&mut self) {
        if let Some(watch) = &self.watch {
            // Otherwise a task per closed link would sleep until its certificate expires.
            watch.abort();
        }
    }
}

impl fmt::Display for TlsLink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} => {}", self.ends.here, self.ends.there)
    }
}
