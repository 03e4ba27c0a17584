//! The Zenoh link: the session, the keys a node declares on it, and the way in for frames.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Thread;
use std::time::Duration;

use anyhow::Context;
use coaxle_clock::{Instant, Span};
use coaxle_node::command::BadOrder;
use coaxle_node::config::TransportConfig;
use coaxle_node::frame::KeySeal;
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, Message, Reader};
use zenoh::Wait;
use zenoh::bytes::{Encoding, ZBytes};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{Query, Queryable};
use zenoh::sample::SampleKind;

use crate::channels::{Publication, Subscription};
use crate::commands::{Asker, Counter, Incoming};
use crate::counters::{Counters, count};
use crate::faults::Faults;
use crate::machine::{self, Machine};
use crate::mailbox::{Inbox, Letter};
use crate::publisher::PublishedChannel;
use crate::transport::{zenoh_config, zenoh_error};

/// How long leaving the network may take.
const CLOSING: Duration = Duration::from_secs(3);

/// An open session with everything the node declares on it.
pub(crate) struct Link {
    session: zenoh::Session,
    /// The publishers of axes: whoever subscribes to them follows the node.
    axes: Vec<Arc<Publisher<'static>>>,
    status: Publisher<'static>,
    _alive: LivelinessToken,
    subscribers: Vec<Subscriber<()>>,
    commands: Option<Queryable<()>>,
    contact: Arc<Contact>,
}

/// What is known of the source, written by Zenoh's threads.
pub(crate) struct Contact {
    alive: AtomicBool,
    /// Machine time of the last accepted frame; `i64::MIN` before the first.
    last_frame: AtomicI64,
}

impl Link {
    /// Opens the session and declares the node alive on it.
    ///
    /// # Errors
    /// A wrong transport section, or a session that cannot be opened, with the endpoints.
    pub(crate) async fn open(transport: &TransportConfig, name: &NodeName) -> anyhow::Result<Self> {
        let config = zenoh_config(transport)?;
        let session = zenoh::open(config)
            .await
            .map_err(zenoh_error)
            .with_context(|| format!("cannot open the Zenoh session, {}", described(transport)))?;
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
            axes: Vec::new(),
            status,
            _alive: alive,
            subscribers: Vec::new(),
            commands: None,
            contact: Arc::new(Contact {
                alive: AtomicBool::new(false),
                last_frame: AtomicI64::new(i64::MIN),
            }),
        })
    }

    /// Declares the channels that the node publishes.
    pub(crate) async fn publish(
        &mut self,
        publications: &[Publication],
        seed: u64,
    ) -> anyhow::Result<Vec<PublishedChannel>> {
        let mut channels = Vec::new();
        for publication in publications {
            let channel = declare_channel(&self.session, publication, seed).await?;
            if publication.channel.carries_axes() {
                self.axes.push(Arc::clone(&channel.publisher));
            }
            channels.push(channel);
        }
        Ok(channels)
    }

    /// Subscribes to a channel: its frames go to `inbox`. Of a source of axes the liveliness shows in
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
            reader: subscription.reader.clone(),
            faults: Faults::new(&subscription.faults, seed, subscription.channel),
            inbox,
            contact: Arc::clone(&self.contact),
            counters,
        });
        let key = subscription.node.channel_key(subscription.channel);
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
        self.subscribers.push(frames);
        if subscription.channel.carries_axes() {
            self.watch(&subscription.node).await?;
        }
        Ok(())
    }

    /// Takes orders: they are handed in at `counter`, and `clerk` is woken.
    pub(crate) async fn take_commands(
        &mut self,
        name: &NodeName,
        counter: Counter<Query>,
        clerk: Thread,
    ) -> anyhow::Result<()> {
        let key = name.command_key();
        let own = key.clone();
        let queryable = self
            .session
            .declare_queryable(&key)
            // An order is for one node, not for all that might have its name.
            .complete(true)
            .callback(move |query| {
                let arrival = machine::now();
                if query.key_expr().as_str() == own {
                    counter.hand_in(Incoming {
                        arrival,
                        asker: query,
                    });
                    clerk.unpark();
                } else {
                    let received = query.key_expr().to_string();
                    let many = BadOrder::ManyNodes { received };
                    query.answer(&CommandAnswer::malformed(&many));
                }
            })
            .await
            .map_err(zenoh_error)
            .with_context(|| format!("cannot take orders under {key}"))?;
        self.commands = Some(queryable);
        Ok(())
    }

    async fn watch(&mut self, source: &NodeName) -> anyhow::Result<()> {
        let contact = Arc::clone(&self.contact);
        let life = self
            .session
            .liveliness()
            .declare_subscriber(source.alive_key())
            .history(true)
            .callback(move |sample| {
                let alive = sample.kind() == SampleKind::Put;
                contact.alive.store(alive, Ordering::Relaxed);
            })
            .await
            .map_err(zenoh_error)?;
        self.subscribers.push(life);
        Ok(())
    }

    /// Whether somebody subscribes to the axes of this node.
    pub(crate) fn has_follower(&self) -> bool {
        self.axes.iter().any(|publisher| {
            let status = publisher.matching_status().wait();
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

impl Asker for Query {
    fn order(&self) -> Cow<'_, [u8]> {
        self.payload().map_or(Cow::Borrowed(&[]), ZBytes::to_bytes)
    }

    /// As an error where no slave got the order.
    fn answer(&self, answer: &CommandAnswer) {
        let json = answer.to_json();
        let sent = if answer.is_taken() {
            self.reply(self.key_expr().clone(), json)
                .encoding(Encoding::APPLICATION_JSON)
                .wait()
        } else {
            self.reply_err(json)
                .encoding(Encoding::APPLICATION_JSON)
                .wait()
        };
        if let Err(error) = sent {
            tracing::debug!(%error, "Zenoh refused the answer to an order");
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
    publication: &Publication,
    seed: u64,
) -> anyhow::Result<PublishedChannel> {
    let channel = publication.channel;
    let key = publication.node.channel_key(channel);
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
        publisher: Arc::new(publisher),
        faults: Faults::new(&publication.faults, seed, channel),
    })
}

/// The way in for the frames of one key: checked, put through the faults, into the mailbox.
struct Reception {
    reader: Reader,
    faults: Faults,
    inbox: Inbox,
    contact: Arc<Contact>,
    counters: Arc<Counters>,
}

impl Reception {
    /// A delayed message is delivered at once, with a stamp in the future: the node holds it.
    fn take(&mut self, arrival: Instant<Machine>, payload: &[u8]) {
        let Self {
            reader,
            faults,
            inbox,
            contact,
            counters,
        } = self;
        for delay in faults.of(arrival) {
            let arrival = arrival + delay;
            reader.read(payload, |message| {
                match message {
                    Message::Sample(_) => {
                        let nanos = arrival.as_nanos();
                        contact.last_frame.store(nanos, Ordering::Relaxed);
                        count(&counters.received);
                    }
                    Message::Rejected(_) => count(&counters.refused),
                    Message::Question(_) | Message::Answer(_) => {}
                }
                inbox.push(Letter { arrival, message });
            });
        }
    }
}
