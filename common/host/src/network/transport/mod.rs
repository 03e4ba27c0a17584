//! The network as a node needs it: frames under keys, presence, requests and their replies.
//!
//! A [`Transport`] moves bytes without knowing their meaning. [`OverZenoh`] is the one for
//! machines; [`InProcess`] joins nodes of one process without any network.
//!
//! Handlers are called on threads of the transport, or on the very thread that publishes: they must
//! not wait.

mod in_process;
mod over_zenoh;

use std::borrow::Cow;
use std::time::Duration;

use coaxle_clock::Instant;

use coaxle_os::machine::Machine;
pub use in_process::InProcess;
pub use over_zenoh::{
    Exposure, OverZenoh, RefusedConnections, ZENOH_RUNTIME, endpoint, host_and_port, is_local,
    is_over_udp, start_accept_thread, zenoh_config,
};

/// A way to other nodes.
pub trait Transport: Send + Sync {
    /// Declares that bytes will be published under `key`.
    ///
    /// # Errors
    /// The transport refuses.
    fn publisher(&self, key: &str, urgency: Urgency) -> anyhow::Result<Box<dyn Publisher>>;

    /// Hands all data published under `key` to `on_bytes`, until the result is dropped. A part `*`
    /// of the key matches any part.
    ///
    /// # Errors
    /// The transport refuses.
    fn subscribe(&self, key: &str, on_bytes: BytesHandler) -> anyhow::Result<Declared>;

    /// Subscribes as [`Self::subscribe`] does, with the delivery options of each sample, where the
    /// transport reports them.
    ///
    /// # Errors
    /// The transport refuses.
    fn observe(&self, key: &str, mut on_sample: SampleHandler) -> anyhow::Result<Declared> {
        self.subscribe(key, Box::new(move |at, bytes| on_sample(at, bytes, None)))
    }

    /// Announces `key` until the result is dropped, or this process dies.
    ///
    /// # Errors
    /// The transport refuses.
    fn announce(&self, key: &str) -> anyhow::Result<Declared>;

    /// Calls `on_change` whenever the announcement of `key` appears or ends, until the result is
    /// dropped. A part `*` of the key matches any part.
    ///
    /// # Errors
    /// The transport refuses.
    fn watch(&self, key: &str, on_change: PresenceHandler) -> anyhow::Result<Declared>;

    /// Hands requests under `key` to `on_request`, until the result is dropped. A key that ends in
    /// `/*` matches all keys with one part in its place.
    ///
    /// # Errors
    /// The transport refuses.
    fn serve(&self, key: &str, on_request: RequestHandler) -> anyhow::Result<Declared>;

    /// Creates a client that sends requests under `key` and waits for replies up to `patience`.
    ///
    /// # Errors
    /// The transport refuses.
    fn client(&self, key: &str, patience: Duration) -> anyhow::Result<Box<dyn Client>>;

    /// Finds out why a node is not visible, by trying to reach it. Takes some seconds.
    fn invisibility_reason(&self, node: &str) -> Option<InvisibilityReason> {
        // Only a transport with endpoints can dial: the others have no reason to give.
        let _ = node;
        None
    }

    /// Connections that were refused; none if the transport checks none.
    fn refused_connections(&self) -> Option<RefusedConnections> {
        // Only certificates decide about a connection.
        None
    }

    /// Endpoints of the transport, for messages: those listened on and those connected to.
    fn whereabouts(&self) -> &str;

    /// Session id in the network, in hexadecimal digits; none if the transport has no ids.
    fn session_id(&self) -> Option<String> {
        None
    }

    /// Leaves the network. Takes a few seconds at most.
    fn close(&self);
}

/// Takes published data with the instant of their arrival.
pub type BytesHandler = Box<dyn FnMut(Instant<Machine>, &[u8]) + Send>;

/// Takes published data with the instant of their arrival and, if known, the delivery options.
pub type SampleHandler = Box<dyn FnMut(Instant<Machine>, &[u8], Option<Delivery>) + Send>;

/// Delivery options requested by the publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delivery {
    /// Priority, 1 (real-time) to 7 (background).
    pub priority: u8,
    /// True if it is dropped under congestion; otherwise the publisher waits.
    pub is_dropped: bool,
    /// True if it is sent at once instead of in a batch with other messages.
    pub is_express: bool,
}

/// Takes the key of an announcement, and true if it is present.
pub type PresenceHandler = Box<dyn Fn(&str, bool) + Send + Sync>;

/// Takes a request, with the instant of its arrival.
pub type RequestHandler = Box<dyn Fn(Instant<Machine>, Box<dyn Request>) + Send + Sync>;

/// A declaration that holds until it is dropped.
pub type Declared = Box<dyn Send + Sync>;

/// Reasons why a node is not visible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InvisibilityReason {
    /// No response from its possible endpoints, or one from another node.
    Unreachable(String),
    /// Refusal by the node, or of the node by this one.
    Refused(String),
}

impl InvisibilityReason {
    /// The reason in words.
    #[must_use]
    pub fn reason(&self) -> &str {
        match self {
            Self::Unreachable(reason) | Self::Refused(reason) => reason,
        }
    }
}

/// Importance of a timely arrival. Sending never waits: data that the network cannot take are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Urgency {
    /// Frames, before all else.
    RealTime,
    /// Data for people.
    Ordinary,
    /// Large data for live viewers: after all else.
    Bulk,
}

/// Publisher for one key.
pub trait Publisher: Send + Sync {
    /// Publishes bytes. May allocate, and take some ten microseconds.
    ///
    /// # Errors
    /// The transport refuses.
    fn publish(&self, bytes: Vec<u8>) -> anyhow::Result<()>;

    /// Publishes bytes with an attachment, which none of our nodes reads; the attachment is left
    /// out where the transport has none.
    ///
    /// # Errors
    /// The transport refuses.
    fn publish_with(&self, bytes: Vec<u8>, attachment: Vec<u8>) -> anyhow::Result<()> {
        drop(attachment);
        self.publish(bytes)
    }

    /// True if the key has a subscriber.
    fn has_subscriber(&self) -> bool;
}

/// A request that waits for its reply.
pub trait Request: Send {
    /// The key it was sent to, which may be a pattern of many.
    fn key(&self) -> &str;

    /// Contents of the request.
    fn payload(&self) -> Cow<'_, [u8]>;

    /// Replies in JSON: as a result if `taken`, otherwise as an error.
    fn reply(&self, json: String, taken: bool);
}

/// Client for one key.
pub trait Client {
    /// True if the key has a server.
    fn has_server(&self) -> bool;

    /// Sends a request in JSON and waits for the reply, a result or an error; none on a timeout.
    ///
    /// # Errors
    /// The transport refuses.
    fn request(&self, json: String) -> anyhow::Result<Option<Vec<u8>>>;
}
