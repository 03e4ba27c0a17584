//! The transport over Zenoh: the only code that uses it.

mod config;
mod dial;
mod endpoint;
mod error;
mod exposure;
mod listening;
mod secure;
mod settings;
mod unseen;

use std::borrow::Cow;
use std::sync::mpsc::channel;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context, anyhow};
use coaxle_node::config::TransportConfig;
use zenoh::Wait;
use zenoh::bytes::{Encoding, ZBytes};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{Querier, Query};
use zenoh::sample::{Sample, SampleKind};

use coaxle_os::machine;
use config::described;
pub use config::{ZENOH_RUNTIME, zenoh_config};
pub use endpoint::{endpoint, host_and_port, is_local, is_over_udp};
pub use exposure::Exposure;
pub use zenoh_link_tls::{RefusedConnections, start_accept_thread};

use self::error::zenoh_error;
use self::unseen::SessionEndpoints;
use super::{
    BytesHandler, Client, Declared, Delivery, InvisibilityReason, PresenceHandler, Publisher,
    Request, RequestHandler, SampleHandler, Transport, Urgency,
};

/// Timeout for leaving the network.
const CLOSING: Duration = Duration::from_secs(3);

/// A Zenoh session.
pub struct OverZenoh {
    session: zenoh::Session,
    whereabouts: String,
    session_endpoints: SessionEndpoints,
}

impl OverZenoh {
    /// Joins the network. With a client's config this waits for its router.
    ///
    /// # Errors
    /// A wrong transport section, or a session that cannot be opened, with the endpoints.
    pub async fn open(transport: &TransportConfig) -> anyhow::Result<Self> {
        let config = zenoh_config(transport)?;
        let session_endpoints = SessionEndpoints::of(&config, transport);
        let session = zenoh::open(config).await;
        Self::opened(session, transport, session_endpoints)
    }

    /// Joins the network from a thread that may wait.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_and_wait(transport: &TransportConfig) -> anyhow::Result<Self> {
        let config = zenoh_config(transport)?;
        let session_endpoints = SessionEndpoints::of(&config, transport);
        Self::opened(zenoh::open(config).wait(), transport, session_endpoints)
    }

    fn opened(
        session: zenoh::Result<zenoh::Session>,
        transport: &TransportConfig,
        session_endpoints: SessionEndpoints,
    ) -> anyhow::Result<Self> {
        let whereabouts = described(transport);
        let session = session
            .map_err(|error| {
                let remedy = listening::remedy(&transport.listen);
                anyhow!("{}{remedy}", zenoh_error(error))
            })
            .with_context(|| format!("cannot open the Zenoh session, {whereabouts}"))?;
        Ok(Self {
            session,
            whereabouts,
            session_endpoints,
        })
    }
}

impl Transport for OverZenoh {
    fn publisher(&self, key: &str, urgency: Urgency) -> anyhow::Result<Box<dyn Publisher>> {
        let priority = match urgency {
            Urgency::RealTime => Priority::RealTime,
            Urgency::Ordinary => Priority::DEFAULT,
            Urgency::Bulk => Priority::DataLow,
        };
        // Drop: the newest frame is worth more than a guarantee, and Block would hold the publisher.
        // Not express: each express message takes a whole batch, and most of them would be lost.
        let publisher = self
            .session
            .declare_publisher(key.to_owned())
            .congestion_control(CongestionControl::Drop)
            .priority(priority)
            .express(false)
            .wait()
            .map_err(zenoh_error)
            .with_context(|| format!("cannot publish on {key}"))?;
        Ok(Box::new(publisher))
    }

    fn subscribe(&self, key: &str, mut on_bytes: BytesHandler) -> anyhow::Result<Declared> {
        self.observe(key, Box::new(move |at, bytes, _| on_bytes(at, bytes)))
    }

    fn observe(&self, key: &str, on_sample: SampleHandler) -> anyhow::Result<Declared> {
        // Zenoh calls back from one thread per link, so no caller ever waits for this lock.
        let on_sample = Mutex::new(on_sample);
        let subscriber = self
            .session
            .declare_subscriber(key)
            .callback(move |sample| {
                let arrival = machine::now();
                let bytes = sample.payload().to_bytes();
                let mut on_sample = on_sample.lock().unwrap_or_else(PoisonError::into_inner);
                on_sample(arrival, &bytes, Some(delivery(&sample)));
            })
            .wait()
            .map_err(zenoh_error)
            .with_context(|| format!("cannot subscribe to {key}"))?;
        Ok(Box::new(subscriber))
    }

    fn announce(&self, key: &str) -> anyhow::Result<Declared> {
        let token = self
            .session
            .liveliness()
            .declare_token(key)
            .wait()
            .map_err(zenoh_error)
            .with_context(|| format!("cannot announce {key}"))?;
        Ok(Box::new(token))
    }

    fn watch(&self, key: &str, on_change: PresenceHandler) -> anyhow::Result<Declared> {
        let subscriber = self
            .session
            .liveliness()
            .declare_subscriber(key)
            .history(true)
            .callback(move |sample| {
                let is_there = sample.kind() == SampleKind::Put;
                on_change(sample.key_expr().as_str(), is_there);
            })
            .wait()
            .map_err(zenoh_error)
            .with_context(|| format!("cannot watch {key}"))?;
        Ok(Box::new(subscriber))
    }

    fn serve(&self, key: &str, on_request: RequestHandler) -> anyhow::Result<Declared> {
        let queryable = self
            .session
            .declare_queryable(key)
            // A request is for one node, not for all that might have its name.
            .complete(true)
            .callback(move |query| on_request(machine::now(), Box::new(query)))
            .wait()
            .map_err(zenoh_error)
            .with_context(|| format!("cannot take requests under {key}"))?;
        Ok(Box::new(queryable))
    }

    fn client(&self, key: &str, patience: Duration) -> anyhow::Result<Box<dyn Client>> {
        let querier = self
            .session
            .declare_querier(key.to_owned())
            .timeout(patience)
            .wait()
            .map_err(zenoh_error)
            .with_context(|| format!("cannot send requests under {key}"))?;
        Ok(Box::new(OfKey { querier, patience }))
    }

    fn invisibility_reason(&self, node: &str) -> Option<InvisibilityReason> {
        self.session_endpoints.invisibility_reason(node)
    }

    fn refused_connections(&self) -> Option<RefusedConnections> {
        let is_secure = self.session_endpoints.is_secure();
        is_secure.then(zenoh_link_tls::refused_connections)
    }

    fn whereabouts(&self) -> &str {
        &self.whereabouts
    }

    fn session_id(&self) -> Option<String> {
        Some(self.session.zid().to_string())
    }

    fn close(&self) {
        let session = self.session.clone();
        let (done, closed) = channel();
        // Zenoh itself has no time limit for this.
        let closing = std::thread::Builder::new().name("closing".to_owned());
        let closing = closing.spawn(move || done.send(session.close().wait()));
        match closing.ok().and_then(|_| closed.recv_timeout(CLOSING).ok()) {
            Some(Ok(())) => {}
            Some(Err(error)) => tracing::debug!(%error, "the Zenoh session did not close cleanly"),
            None => tracing::debug!("the Zenoh session did not close in time"),
        }
    }
}

fn delivery(sample: &Sample) -> Delivery {
    Delivery {
        priority: sample.priority() as u8,
        is_dropped: sample.congestion_control() == CongestionControl::Drop,
        is_express: sample.express(),
    }
}

impl Publisher for zenoh::pubsub::Publisher<'static> {
    fn publish(&self, bytes: Vec<u8>) -> anyhow::Result<()> {
        self.put(bytes).wait().map_err(zenoh_error)
    }

    fn publish_with(&self, bytes: Vec<u8>, attachment: Vec<u8>) -> anyhow::Result<()> {
        let put = self.put(bytes).attachment(attachment);
        put.wait().map_err(zenoh_error)
    }

    fn has_subscriber(&self) -> bool {
        let status = self.matching_status().wait();
        status.is_ok_and(|status| status.matching())
    }
}

/// Client for one key.
struct OfKey {
    querier: Querier<'static>,
    patience: Duration,
}

impl Client for OfKey {
    fn has_server(&self) -> bool {
        let status = self.querier.matching_status().wait();
        status.is_ok_and(|status| status.matching())
    }

    fn request(&self, json: String) -> anyhow::Result<Option<Vec<u8>>> {
        let replies = self
            .querier
            .get()
            .payload(json)
            .encoding(Encoding::APPLICATION_JSON)
            .wait()
            .map_err(zenoh_error)?;
        let Ok(Some(reply)) = replies.recv_timeout(self.patience) else {
            return Ok(None);
        };
        let payload = match reply.result() {
            Ok(sample) => sample.payload().to_bytes(),
            Err(error) => error.payload().to_bytes(),
        };
        Ok(Some(payload.into_owned()))
    }
}

impl Request for Query {
    fn key(&self) -> &str {
        self.key_expr().as_str()
    }

    fn payload(&self) -> Cow<'_, [u8]> {
        Self::payload(self).map_or(Cow::Borrowed(&[]), ZBytes::to_bytes)
    }

    fn reply(&self, json: String, taken: bool) {
        let sent = if taken {
            Self::reply(self, self.key_expr().clone(), json)
                .encoding(Encoding::APPLICATION_JSON)
                .wait()
        } else {
            self.reply_err(json)
                .encoding(Encoding::APPLICATION_JSON)
                .wait()
        };
        if let Err(error) = sent {
            tracing::debug!(%error, "Zenoh refused the reply to a request");
        }
    }
}
