//! The network as a node needs it: frames under keys, who is there, requests and their replies.
//!
//! A [`Transport`] moves bytes and knows nothing of what they say. [`OverZenoh`] is the one that
//! machines use; [`InProcess`] joins nodes of one process without any network.
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
    Exposure, OverZenoh, ZENOH_RUNTIME, endpoint, host_and_port, is_local, is_over_udp,
    zenoh_config,
};

/// A way to other nodes.
pub trait Transport: Send + Sync {
    /// Declares that bytes will be published under `key`.
    ///
    /// # Errors
    /// The transport refuses.
    fn publisher(&self, key: &str, urgency: Urgency) -> anyhow::Result<Box<dyn Publisher>>;

    /// Has everything that is published under `key` handed to `on_bytes`, until the result is dropped. A part of the
    /// key that is `*` stands for any.
    ///
    /// # Errors
    /// The transport refuses.
    fn subscribe(&self, key: &str, on_bytes: BytesHandler) -> anyhow::Result<Declared>;

    /// The same, and how each was sent, where the transport tells.
    ///
    /// # Errors
    /// The transport refuses.
    fn observe(&self, key: &str, mut on_sample: SampleHandler) -> anyhow::Result<Declared> {
        self.subscribe(key, Box::new(move |at, bytes| on_sample(at, bytes, None)))
    }

    /// Shows everybody that `key` is there, until the result is dropped, or this process dies.
    ///
    /// # Errors
    /// The transport refuses.
    fn announce(&self, key: &str) -> anyhow::Result<Declared>;

    /// Tells `on_change` whenever the announcement of `key` comes or goes, until the result is dropped. A part
    /// of the key that is `*` stands for any.
    ///
    /// # Errors
    /// The transport refuses.
    fn watch(&self, key: &str, on_change: PresenceHandler) -> anyhow::Result<Declared>;

    /// Has requests under `key` handed to `on_request`, until the result is dropped. A key that ends in `/*`
    /// stands for all that have one part more in its place.
    ///
    /// # Errors
    /// The transport refuses.
    fn serve(&self, key: &str, on_request: RequestHandler) -> anyhow::Result<Declared>;

    /// Where requests under `key` are sent from, which wait so long for their replies.
    ///
    /// # Errors
    /// The transport refuses.
    fn client(&self, key: &str, patience: Duration) -> anyhow::Result<Box<dyn Client>>;

    /// Why a node is not to be seen, as far as trying to reach it tells. Takes some seconds.
    fn why_unseen(&self, node: &str) -> Option<Unseen> {
        let _ = node;
        None
    }

    /// How it reaches others, for messages: where it listens, where it connects to.
    fn whereabouts(&self) -> &str;

    /// What the network calls this one, in hexadecimal digits; none where nobody is called anything.
    fn session_id(&self) -> Option<String> {
        None
    }

    /// Leaves. Takes a few seconds at most.
    fn close(&self);
}

/// Takes what was published, with the instant of its arrival.
pub type BytesHandler = Box<dyn FnMut(Instant<Machine>, &[u8]) + Send>;

/// Takes what was published, with the instant of its arrival, and how it was sent, if that is known.
pub type SampleHandler = Box<dyn FnMut(Instant<Machine>, &[u8], Option<Delivery>) + Send>;

/// How something was sent: what whoever published it asked of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delivery {
    /// Its priority, 1 (real-time) to 7 (background).
    pub priority: u8,
    /// Whether it is dropped where the network cannot keep up; else whoever publishes waits.
    pub is_dropped: bool,
    /// Whether it waits for no other message to leave with.
    pub is_express: bool,
}

/// Takes the key of an announcement, and whether it is there.
pub type PresenceHandler = Box<dyn Fn(&str, bool) + Send + Sync>;

/// Takes a request, with the instant of its arrival.
pub type RequestHandler = Box<dyn Fn(Instant<Machine>, Box<dyn Request>) + Send + Sync>;

/// Something that holds until it is dropped.
pub type Declared = Box<dyn Send + Sync>;

/// Why a node is not to be seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unseen {
    /// Nobody answers where it may be, or somebody else does.
    Unreachable(String),
    /// Somebody answers, and refuses this one or is refused.
    Refused(String),
}

impl Unseen {
    /// The reason in words.
    #[must_use]
    pub fn reason(&self) -> &str {
        match self {
            Self::Unreachable(reason) | Self::Refused(reason) => reason,
        }
    }
}

/// How much it matters that something arrives soon. Nothing is ever waited for: what the network
/// cannot take is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Urgency {
    /// Frames, before all else.
    RealTime,
    /// What people read.
    Ordinary,
    /// Much at a time, for who looks on: after all else.
    Bulk,
}

/// Publishes under one key.
pub trait Publisher: Send + Sync {
    /// Publishes bytes. May allocate, and take some ten microseconds.
    ///
    /// # Errors
    /// The transport refuses.
    fn publish(&self, bytes: Vec<u8>) -> anyhow::Result<()>;

    /// The same with an attachment beside the bytes, which no node of ours reads; left out where the transport has none.
    ///
    /// # Errors
    /// The transport refuses.
    fn publish_with(&self, bytes: Vec<u8>, attachment: Vec<u8>) -> anyhow::Result<()> {
        drop(attachment);
        self.publish(bytes)
    }

    /// Whether anybody subscribes to the key.
    fn has_subscriber(&self) -> bool;
}

/// A request that waits for its reply.
pub trait Request: Send {
    /// The key it was sent to, which may be a pattern of many.
    fn key(&self) -> &str;

    /// What it says.
    fn payload(&self) -> Cow<'_, [u8]>;

    /// Replies in JSON; `taken`: as a result, otherwise as an error.
    fn reply(&self, json: String, taken: bool);
}

/// Sends requests under one key.
pub trait Client {
    /// Whether anybody serves the key.
    fn has_server(&self) -> bool;

    /// Sends a request in JSON and waits for the reply, be it a result or an error; none if it does
    /// not come in time.
    ///
    /// # Errors
    /// The transport refuses.
    fn request(&self, json: String) -> anyhow::Result<Option<Vec<u8>>>;
}
