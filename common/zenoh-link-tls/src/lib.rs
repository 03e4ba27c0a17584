//! TLS for Zenoh's links, in safe Rust.
//!
//! Takes the place of `zenoh-link-tls` of the same version, by `[patch.crates-io]` of the workspace. That crate reads and
//! writes one TLS stream from two tasks at once, through an `UnsafeCell`, which rustls does not allow: nodes crashed, now
//! and then, in the middle of a run ([zenoh#2557](https://github.com/eclipse-zenoh/zenoh/issues/2557),
//! [rustls#288](https://github.com/rustls/rustls/issues/288)). Here the stream is behind a lock that is held for one poll
//! (`stream.rs`). The protocol is the same, so both are compatible.
//!
//! Stricter for secure networks:
//!
//! * TLS 1.3 alone, and no authority but the one that the config names.
//! * Connections are accepted by a thread of their own (`accept_thread.rs`), and handshakes run in parallel: a
//!   failed one delays nobody. A client that connects and sends nothing makes room for later ones, and each address has
//!   its share of places and its pace of handshakes (`admission.rs`).
//! * Refused connections are counted ([`refused_connections`]), and a flood of them is one line a minute.
//! * IPv6 addresses are compared with certificates.
//! * A certificate that the authority has revoked is refused, and its links end within a second or two, without a
//!   restart ([`RevocationWatch`]).
//! * What was refused and what was ended is reported to the program around it ([`on_link_event`]).
//! * A link whose certificates have expired is closed at both ends, if the config says so.
//!
//! The settings are Zenoh's own, below `transport/link/tls`. Zenoh's links are internal to it, so this
//! crate fits exactly one version.

mod accept;
mod accept_thread;
mod admission;
#[cfg(test)]
mod bounds;
mod certificate;
mod config;
mod events;
mod flood;
mod link;
mod manager;
mod refusals;
mod revocation;
mod source_prefix;
mod stream;

pub use accept_thread::start_accept_thread;
pub use config::TlsConfigurator;
pub use events::{LinkEvent, LinkEventKind, on_link_event};
pub use manager::LinkManagerUnicastTls;
pub use refusals::{RefusedConnections, refused_connections};
pub use revocation::{
    InvalidRevocations, MOST_LIST_BYTES, REVOKED_FILE, RevocationList, RevocationWatch,
};

use async_trait::async_trait;
use zenoh_link_commons::LocatorInspector;
use zenoh_protocol::core::{Locator, Metadata};
use zenoh_result::ZResult;

/// The protocol in a locator: `tls/<host>:<port>`.
pub const TLS_LOCATOR_PREFIX: &str = "tls";

/// The properties of a locator that Zenoh inspects before there is a link.
#[derive(Clone, Copy, Debug, Default)]
pub struct TlsLocatorInspector;

#[async_trait]
impl LocatorInspector for TlsLocatorInspector {
    fn protocol(&self) -> &str {
        TLS_LOCATOR_PREFIX
    }

    async fn is_multicast(&self, _locator: &Locator) -> ZResult<bool> {
        Ok(false)
    }

    fn is_reliable(&self, locator: &Locator) -> ZResult<bool> {
        use zenoh_protocol::core::Reliability;
        match locator.metadata().get(Metadata::RELIABILITY) {
            Some(named) => Ok(named.parse::<Reliability>()? == Reliability::Reliable),
            // TCP below is reliable, unless the locator states otherwise.
            None => Ok(true),
        }
    }
}
