//! The Zenoh link: the session, the keys a node declares on it, and the way in for frames.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::Context;
use coaxle_clock::{Instant, Span};
use coaxle_node::config::{LinkConfig, TransportConfig};
use coaxle_node::faults::{LinkModel, seed_of};
use coaxle_node::frame::KeySeal;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, Intake, Message};
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::SampleKind;

use crate::counters::{Counters, count};
use crate::machine::{self, Machine};
use crate::mailbox::{Inbox, Letter};
use crate::publisher::PublishedChannel;
use crate::run::Subscription;
use crate::transport::{zenoh_config, zenoh_error};

/// How long leaving the network may take.
const CLOSING: Duration = Duration::from_secs(3);

/// An open session with everything the node declares on it.
pub(crate) struct Link {
    session: zenoh::Session,
    channels: Vec<PublishedChannel>,
    status: Publisher<'static>,
    _alive: LivelinessToken,
    _subscribers: Vec<Subscriber<()>>,
    contact: Arc<Contact>,
}

/// What is known of the source, written by Zenoh's threads.
pub(crate) struct Contact {
    alive: AtomicBool,
    /// Machine time of the last accepted frame; `i64::MIN` before the first.
    last_frame: AtomicI64,
}

impl Link {
    /// Opens the session and declares the node on it.
    ///
    /// # Errors
    /// A wrong transport section, or a session that cannot be opened, with the endpoints.
    pub(crate) async fn open(
        transport: &TransportConfig,
        name: &NodeName,
        publishes: &[Channel],
    ) -> anyhow::Result<Self> {
        let config = zenoh_config(transport)?;
        let session = zenoh::open(config)
            .await
            .map_err(zenoh_error)
            .with_context(|| format!("cannot open the Zenoh session, {}", described(transport)))?;
        let mut channels = Vec::new();
        for &channel in publishes {
            channels.push(declare_channel(&session, name, channel).await?);
        }
        let status = session
            .declare_publisher(name.status_key())
            .congestion_control(CongestionControl::Drop)
            .await
            .map_err(zenoh_error)?;
        let alive = session
            .liveliness()
            .declare_token(name.alive_key())
            .await
            .map_err(zenoh_error)?;
        Ok(Self {
            session,
            channels,
            status,
            _alive: alive,
            _subscribers: Vec::new(),
            contact: Arc::new(Contact {
                alive: AtomicBool::new(false),
                last_frame: AtomicI64::new(i64::MIN),
            }),
        })
    }

    /// Subscribes to a source: its frames go to `inbox`, its liveliness shows in
    /// [`Self::source_alive`].
    pub(crate) async fn subscribe(
        &mut self,
        subscription: &Subscription,
        seed: u64,
        inbox: Inbox,
        counters: Arc<Counters>,
    ) -> anyhow::Result<()> {
        // Zenoh calls back from one thread per link, so nobody ever waits for this lock.
        let reception = Mutex::new(Reception {
            intake: subscription.intake.clone(),
            faults: Faults::new(&subscription.faults, seed),
            inbox,
            contact: Arc::clone(&self.contact),
            counters,
        });
        let key = subscription.source.channel_key(subscription.channel);
        let frames = self
            .session
            .declare_subscriber(&key)
            .callback(move |sample| {
                let arrival = machine::now();
                let payload = sample.payload().to_bytes();
                reception
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .take(arrival, &payload);
            })
            .await
            .map_err(zenoh_error)
            .with_context(|| format!("cannot subscribe to {key}"))?;

        let contact = Arc::clone(&self.contact);
        let life = self
            .session
            .liveliness()
            .declare_subscriber(subscription.source.alive_key())
            .history(true)
            .callback(move |sample| {
                let alive = sample.kind() == SampleKind::Put;
                contact.alive.store(alive, Ordering::Relaxed);
            })
            .await
            .map_err(zenoh_error)?;
        self._subscribers = vec![frames, life];
        Ok(())
    }

    /// The channels this node publishes.
    pub(crate) fn channels(&self) -> &[PublishedChannel] {
        &self.channels
    }

    /// Whether somebody subscribes to one of this node's channels.
    pub(crate) fn has_subscriber(&self) -> bool {
        self.channels.iter().any(|channel| {
            let status = channel.publisher.matching_status().wait();
            status.is_ok_and(|status| status.matching())
        })
    }

    /// Whether the source's liveliness token is there. For display: what counts is the age of its
    /// frames.
    pub(crate) fn source_alive(&self) -> bool {
        self.contact.alive.load(Ordering::Relaxed)
    }

    /// How long ago the source's last good frame came; none if none ever did.
    pub(crate) fn frame_age(&self, now: Instant<Machine>) -> Option<Span> {
        match self.contact.last_frame.load(Ordering::Relaxed) {
            i64::MIN => None,
            nanos => Some(now - Instant::from_nanos(nanos)),
        }
    }

    /// Publishes the status, as well as the network can take it.
    pub(crate) fn publish_status(&self, json: String) {
        if let Err(error) = self.status.put(json).wait() {
            tracing::debug!(%error, "Zenoh refused the status");
        }
    }

    /// Leaves the network.
    pub(crate) async fn close(&self) {
        let closing = async { self.session.close().await };
        match tokio::time::timeout(CLOSING, closing).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => tracing::debug!(%error, "the Zenoh session did not close cleanly"),
            Err(_) => tracing::debug!("the Zenoh session did not close in time"),
        }
    }
}

/// The endpoints of a transport section, for messages.
pub(crate) fn described(transport: &TransportConfig) -> String {
    let mut parts = Vec::new();
    if !transport.listen.is_empty() {
        parts.push(format!("listening on {}", transport.listen.join(", ")));
    }
    if !transport.connect.is_empty() {
        parts.push(format!("connecting to {}", transport.connect.join(", ")));
    }
    if transport.multicast {
        parts.push("looking for peers by multicast".to_owned());
    }
    if let Some(file) = &transport.file {
        parts.push(format!("with the Zenoh config file {}", file.display()));
    }
    if parts.is_empty() {
        parts.push("without any endpoint to listen on or to connect to".to_owned());
    }
    parts.join(", ")
}

async fn declare_channel(
    session: &zenoh::Session,
    name: &NodeName,
    channel: Channel,
) -> anyhow::Result<PublishedChannel> {
    let key = name.channel_key(channel);
    // Drop: the newest frame is worth more than a guarantee, and Block would hold the publisher.
    // Not express: each express message takes a whole batch, and most of them would be lost.
    let publisher = session
        .declare_publisher(key.clone())
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::RealTime)
        .express(false)
        .await
        .map_err(zenoh_error)
        .with_context(|| format!("cannot publish on {key}"))?;
    Ok(PublishedChannel {
        channel,
        seal: KeySeal::new(&key),
        publisher,
    })
}

/// The way in for frames: checked, put through the faults, into the mailbox.
struct Reception {
    intake: Intake,
    faults: Option<Faults>,
    inbox: Inbox,
    contact: Arc<Contact>,
    counters: Arc<Counters>,
}

impl Reception {
    fn take(&mut self, arrival: Instant<Machine>, payload: &[u8]) {
        let message = self.intake.message(payload);
        match &mut self.faults {
            None => self.deliver(arrival, message),
            Some(faults) => {
                for delay in faults.link.offer(arrival - faults.start) {
                    self.deliver(arrival + delay, message);
                }
            }
        }
    }

    /// A delayed message is delivered at once, with a stamp in the future: the node holds it.
    fn deliver(&mut self, arrival: Instant<Machine>, message: Message) {
        match message {
            Message::Sample(_) => {
                let nanos = arrival.as_nanos();
                self.contact.last_frame.store(nanos, Ordering::Relaxed);
                count(&self.counters.received);
            }
            Message::Rejected(_) => count(&self.counters.refused),
        }
        self.inbox.push(Letter { arrival, message });
    }
}

/// Faults laid over the real link.
struct Faults {
    link: LinkModel,
    start: Instant<Machine>,
}

impl Faults {
    fn new(config: &LinkConfig, seed: u64) -> Option<Self> {
        (*config != LinkConfig::default()).then(|| Self {
            link: LinkModel::new(config, seed_of(seed, "link")),
            start: machine::now(),
        })
    }
}
