//! Connecting and listening.

use std::sync::Arc;

use async_trait::async_trait;
use rustls::pki_types::ServerName;
use tokio_rustls::{TlsConnector, TlsStream};
use zenoh_link_commons::tcp::get_tcp_addrs;
use zenoh_link_commons::{
    LinkManagerUnicastTrait, LinkUnicast, ListenersUnicastIP, NewLinkChannelSender,
};
use zenoh_protocol::core::{EndPoint, Locator};
use zenoh_result::{ZResult, zerror};

use crate::accept::TlsListener;
use crate::accept_thread;
use crate::config::{self, Common};
use crate::events::{LinkEventKind, report};
use crate::link::{LinkAddresses, TlsLink};

/// Opens links and accepts those of others.
pub struct LinkManagerUnicastTls {
    links: NewLinkChannelSender,
    listeners: ListenersUnicastIP,
}

impl LinkManagerUnicastTls {
    /// Makes a manager that hands over accepted links to `links`.
    #[must_use]
    pub fn new(links: NewLinkChannelSender) -> Self {
        Self {
            links,
            listeners: ListenersUnicastIP::new(),
        }
    }
}

#[async_trait]
impl LinkManagerUnicastTrait for LinkManagerUnicastTls {
    async fn new_link(&self, endpoint: EndPoint) -> ZResult<LinkUnicast> {
        let settings = endpoint.config();
        let failed =
            |error: &dyn std::fmt::Display| zerror!("connecting to {endpoint} over TLS: {error}");
        // Every setting is checked before a connection is made: a mistake needs no peer to be found.
        let name = server_name(endpoint.address().as_str()).map_err(|error| failed(&error))?;
        let common = Common::of(&settings).map_err(|error| failed(&error))?;
        let client = config::client(&settings).await;
        let client = client.map_err(|error| failed(&error))?;
        let sockets = config::sockets(&settings).await;
        let sockets = sockets.map_err(|error| failed(&error))?;
        let addresses = get_tcp_addrs(endpoint.address()).await?;
        let connected = sockets.new_link_first_reachable(addresses).await;
        let (socket, here, there) = connected.map_err(|error| failed(&error))?;
        let handshake = TlsConnector::from(client).connect(name, socket);
        // A port on which something else listens may accept and never answer.
        let stream = tokio::time::timeout(common.handshake_timeout, handshake)
            .await
            .map_err(|_| failed(&"no handshake within its time"))?
            .map_err(|error| failed(&error))?;
        let ends = LinkAddresses { here, there };
        let link = TlsLink::open(TlsStream::Client(stream), ends, &common);
        link.inspect_err(|error| {
            report(
                &there.to_string(),
                LinkEventKind::Refused,
                &error.to_string(),
            )
        })
    }

    async fn new_listener(&self, endpoint: EndPoint) -> ZResult<Locator> {
        let settings = endpoint.config();
        let failed =
            |error: &dyn std::fmt::Display| zerror!("listening on {endpoint} over TLS: {error}");
        let common = Common::of(&settings).map_err(|error| failed(&error))?;
        let server = config::server(&settings, &common).await;
        let server = server.map_err(|error| failed(&error))?;
        let sockets = config::sockets(&settings).await;
        let sockets = sockets.map_err(|error| failed(&error))?;
        let address = config::resolve(endpoint.address().as_str()).await?;
        let (socket, address) = sockets.new_listener(&address)?;
        let (host, _) = host_and_port(endpoint.address().as_str())?;
        // The port of the socket: with 0 in the endpoint the system chose one.
        let host_and_port = format!("{host}:{}", address.port());
        let locator = Locator::new(endpoint.protocol(), host_and_port, endpoint.metadata())?;
        let listened = EndPoint::new(
            locator.protocol(),
            locator.address(),
            locator.metadata(),
            endpoint.config(),
        )?;
        // A child: closing all listeners ends this one, and not the other way round.
        let token = self.listeners.token.child_token();
        let listener = TlsListener {
            server,
            common: Arc::new(common),
            links: self.links.clone(),
        };
        let accepting = accept_thread::spawn(listener.run(socket.into_std()?, token.clone()))?;
        // Zenoh awaits the end of the listener through this one.
        let listening = async move { accepting.await? };
        self.listeners
            .add_listener(listened, address, listening, token)
            .await?;
        Ok(locator)
    }

    async fn del_listener(&self, endpoint: &EndPoint) -> ZResult<()> {
        let address = config::resolve(endpoint.address().as_str()).await?;
        self.listeners.del_listener(address).await
    }

    async fn get_listeners(&self) -> Vec<EndPoint> {
        self.listeners.get_endpoints()
    }

    async fn get_locators(&self) -> Vec<Locator> {
        self.listeners.get_locators()
    }

    async fn get_locators_noloopback(&self) -> Vec<Locator> {
        self.listeners.get_locators_noloopback()
    }
}

/// Returns the name that the certificate of the peer must be for.
fn server_name(address: &str) -> ZResult<ServerName<'static>> {
    let (host, _) = host_and_port(address)?;
    // An IPv6 address is in brackets, which are no part of it.
    let bare = host
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'))
        .unwrap_or(host);
    ServerName::try_from(bare.to_owned()).map_err(|error| {
        zerror!("{bare:?} is no name that a certificate may be for: {error}").into()
    })
}

fn host_and_port(address: &str) -> ZResult<(&str, &str)> {
    address
        // The last colon, since an IPv6 address has several.
        .rsplit_once(':')
        .ok_or_else(|| zerror!("received {address:?}, expected <host>:<port>").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ipv6_address_is_compared_without_its_brackets() {
        let name = server_name("[::1]:7447").expect("an address");
        assert_eq!(name, ServerName::IpAddress("::1".try_into().expect("one")));
        let name = server_name("press.local:7447").expect("a name");
        assert_eq!(name.to_str(), "press.local");
        assert!(server_name("press.local").is_err());
    }
}
