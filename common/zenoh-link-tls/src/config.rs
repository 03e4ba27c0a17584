//! Settings: from Zenoh's config to an endpoint, and from an endpoint to rustls.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use base64::Engine;
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::{NoServerSessionStorage, WebPkiClientVerifier};
use rustls::version::TLS13;
use rustls::{ClientConfig, RootCertStore, ServerConfig};
use secrecy::ExposeSecret;
use zenoh_config::{Config as ZenohConfig, SecretValue};
use zenoh_link_commons::tcp::TcpSocketConfig;
use zenoh_link_commons::tls::{WebPkiVerifierAnyServerName, config as key};
use zenoh_link_commons::{
    BIND_INTERFACE, BIND_SOCKET, ConfigurationInspector, TCP_SO_RCV_BUF, TCP_SO_SND_BUF, parse_dscp,
};
use zenoh_protocol::core::endpoint::Config;
use zenoh_protocol::core::parameters;
use zenoh_result::{ZResult, bail, zerror};

use crate::revocation::{RevocationWatch, UnrevokedClients};

/// Puts `transport/link/tls` of Zenoh's config into each endpoint.
#[derive(Clone, Copy, Debug, Default)]
pub struct TlsConfigurator;

impl ConfigurationInspector<ZenohConfig> for TlsConfigurator {
    fn inspect_config(&self, config: &ZenohConfig) -> ZResult<String> {
        let tls = config.transport().link().tls();
        let mut settings = Vec::new();
        let sources = [
            (
                &AUTHORITY,
                tls.root_ca_certificate(),
                tls.root_ca_certificate_base64(),
            ),
            (
                &LISTEN_KEY,
                tls.listen_private_key(),
                tls.listen_private_key_base64(),
            ),
            (
                &LISTEN_CERTIFICATE,
                tls.listen_certificate(),
                tls.listen_certificate_base64(),
            ),
            (
                &CONNECT_KEY,
                tls.connect_private_key(),
                tls.connect_private_key_base64(),
            ),
            (
                &CONNECT_CERTIFICATE,
                tls.connect_certificate(),
                tls.connect_certificate_base64(),
            ),
        ];
        for (pem, file, base64) in sources {
            settings.extend(pem.setting(file.as_deref(), base64.as_ref())?);
        }
        let switches = [
            (key::TLS_ENABLE_MTLS, tls.enable_mtls()),
            (
                key::TLS_VERIFY_NAME_ON_CONNECT,
                tls.verify_name_on_connect(),
            ),
            (
                key::TLS_CLOSE_LINK_ON_EXPIRATION,
                tls.close_link_on_expiration(),
            ),
        ];
        // Absent settings are left out: the defaults are those of Zenoh, in one place.
        let switches = switches.map(|(name, on)| on.map(|on| (name, on.to_string())));
        settings.extend(switches.into_iter().flatten());
        let sizes = [
            (TCP_SO_RCV_BUF, tls.so_rcvbuf()),
            (TCP_SO_SND_BUF, tls.so_sndbuf()),
        ];
        let sizes = sizes.map(|(name, bytes)| bytes.map(|bytes| (name, bytes.to_string())));
        settings.extend(sizes.into_iter().flatten());
        let settings = settings.iter().map(|(name, value)| (*name, value.as_str()));
        Ok(parameters::from_iter(settings))
    }
}

/// A setting that is PEM text, in one of three ways.
struct Pem {
    /// The setting's name in Zenoh's config.
    name: &'static str,
    file: &'static str,
    base64: &'static str,
    raw: &'static str,
}

const AUTHORITY: Pem = Pem {
    name: "root_ca_certificate",
    file: key::TLS_ROOT_CA_CERTIFICATE_FILE,
    base64: key::TLS_ROOT_CA_CERTIFICATE_BASE64,
    raw: key::TLS_ROOT_CA_CERTIFICATE_RAW,
};
const LISTEN_KEY: Pem = Pem {
    name: "listen_private_key",
    file: key::TLS_LISTEN_PRIVATE_KEY_FILE,
    base64: key::TLS_LISTEN_PRIVATE_KEY_BASE64,
    raw: key::TLS_LISTEN_PRIVATE_KEY_RAW,
};
const LISTEN_CERTIFICATE: Pem = Pem {
    name: "listen_certificate",
    file: key::TLS_LISTEN_CERTIFICATE_FILE,
    base64: key::TLS_LISTEN_CERTIFICATE_BASE64,
    raw: key::TLS_LISTEN_CERTIFICATE_RAW,
};
const CONNECT_KEY: Pem = Pem {
    name: "connect_private_key",
    file: key::TLS_CONNECT_PRIVATE_KEY_FILE,
    base64: key::TLS_CONNECT_PRIVATE_KEY_BASE64,
    raw: key::TLS_CONNECT_PRIVATE_KEY_RAW,
};
const CONNECT_CERTIFICATE: Pem = Pem {
    name: "connect_certificate",
    file: key::TLS_CONNECT_CERTIFICATE_FILE,
    base64: key::TLS_CONNECT_CERTIFICATE_BASE64,
    raw: key::TLS_CONNECT_CERTIFICATE_RAW,
};

impl Pem {
    /// Returns the setting of an endpoint.
    fn setting(
        &self,
        file: Option<&str>,
        base64: Option<&SecretValue>,
    ) -> ZResult<Option<(&'static str, String)>> {
        match (file, base64) {
            (Some(_), Some(_)) => bail!(
                "transport/link/tls: received {0} and {0}_base64, expected one of them",
                self.name
            ),
            (Some(file), None) => Ok(Some((self.file, file.to_owned()))),
            (None, Some(text)) => Ok(Some((self.base64, text.expose_secret().to_string()))),
            (None, None) => Ok(None),
        }
    }

    /// Reads the text; none if the endpoint does not have it.
    async fn read(&self, endpoint: &Config<'_>) -> ZResult<Option<Vec<u8>>> {
        // Text in the endpoint itself comes before files: set by a program, it is the more specific one.
        if let Some(text) = endpoint.get(self.raw) {
            return Ok(Some(text.as_bytes().to_vec()));
        }
        if let Some(text) = endpoint.get(self.base64) {
            let text = base64::engine::general_purpose::STANDARD.decode(text);
            return Ok(Some(text.map_err(|error| self.wrong(&error))?));
        }
        let Some(file) = endpoint.get(self.file) else {
            return Ok(None);
        };
        // Read for each connection: a renewed certificate needs no restart of the connecting side.
        let text = tokio::fs::read(file).await;
        let text = text.map_err(|error| self.wrong(&format!("{file}: {error}")))?;
        Ok(Some(text))
    }

    async fn certificates(
        &self,
        endpoint: &Config<'_>,
    ) -> ZResult<Option<Vec<CertificateDer<'static>>>> {
        let Some(text) = self.read(endpoint).await? else {
            return Ok(None);
        };
        let certificates: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
        match certificates {
            // A file without PEM blocks parses without an error, as a list of none.
            Ok(certificates) if certificates.is_empty() => {
                Err(self.wrong(&"received no certificate, expected one in PEM"))
            }
            Ok(certificates) => Ok(Some(certificates)),
            Err(error) => Err(self.wrong(&error)),
        }
    }

    async fn key(&self, endpoint: &Config<'_>) -> ZResult<PrivateKeyDer<'static>> {
        let text = self.read(endpoint).await?;
        let text = text.ok_or_else(|| self.missing())?;
        PrivateKeyDer::from_pem_slice(&text).map_err(|error| self.wrong(&error))
    }

    fn missing(&self) -> zenoh_result::Error {
        self.wrong(&"received none, expected one")
    }

    fn wrong(&self, reason: &dyn std::fmt::Display) -> zenoh_result::Error {
        zerror!("transport/link/tls/{}: {reason}", self.name).into()
    }
}

/// The settings that both ends of a connection share.
pub(crate) struct Common {
    /// A link is closed when a certificate of the other end expires.
    pub(crate) closes_on_expiry: bool,
    /// Certificates that the authority has revoked; none if its certificate is no file.
    pub(crate) revoked: Option<Arc<RevocationWatch>>,
    /// A handshake that takes longer has failed.
    pub(crate) handshake_timeout: Duration,
}

impl Common {
    pub(crate) fn of(endpoint: &Config<'_>) -> ZResult<Self> {
        let milliseconds = number(endpoint, key::TLS_HANDSHAKE_TIMEOUT_MS)?;
        let milliseconds = milliseconds.unwrap_or(key::TLS_HANDSHAKE_TIMEOUT_MS_DEFAULT);
        Ok(Self {
            closes_on_expiry: switch(
                endpoint,
                key::TLS_CLOSE_LINK_ON_EXPIRATION,
                key::TLS_CLOSE_LINK_ON_EXPIRATION_DEFAULT,
            )?,
            revoked: (endpoint.get(AUTHORITY.file))
                .map(|file| Arc::new(RevocationWatch::beside(Path::new(file)))),
            handshake_timeout: Duration::from_millis(milliseconds),
        })
    }
}

/// Makes the TLS of a listener: its own certificate, and the authority required of clients.
///
/// # Errors
/// A file that cannot be read; no authority if both ends need certificates; a key that does not fit.
pub(crate) async fn server(endpoint: &Config<'_>, common: &Common) -> ZResult<Arc<ServerConfig>> {
    let chain = LISTEN_CERTIFICATE.certificates(endpoint).await?;
    let chain = chain.ok_or_else(|| LISTEN_CERTIFICATE.missing())?;
    let key = LISTEN_KEY.key(endpoint).await?;
    let builder = ServerConfig::builder_with_provider(provider())
        // TLS 1.2 sends certificates in clear, and a peer that offers only that is refused.
        .with_protocol_versions(&[&TLS13])
        .map_err(|error| zerror!(error))?;
    let builder = if is_mutual(endpoint)? {
        let roots = Arc::new(authority(endpoint).await?);
        let verifier = WebPkiClientVerifier::builder_with_provider(roots, provider()).build();
        let verifier = verifier.map_err(|error| zerror!(error))?;
        builder.with_client_cert_verifier(match &common.revoked {
            Some(watch) => Arc::new(UnrevokedClients::new(verifier, Arc::clone(watch))),
            None => verifier,
        })
    } else {
        builder.with_no_client_auth()
    };
    let mut config = builder
        .with_single_cert(chain, key)
        .map_err(|error| LISTEN_KEY.wrong(&error))?;
    // Certificates are checked on every connect: no session is resumed on an earlier check.
    config.session_storage = Arc::new(NoServerSessionStorage {});
    // Without tickets a client has nothing to resume with.
    config.send_tls13_tickets = 0;
    Ok(Arc::new(config))
}

/// Makes the TLS of a client: the authority required of listeners, and its own certificate.
///
/// # Errors
/// As of [`server`]; no authority.
pub(crate) async fn client(endpoint: &Config<'_>) -> ZResult<Arc<ClientConfig>> {
    let roots = authority(endpoint).await?;
    let builder = ClientConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])
        .map_err(|error| zerror!(error))?;
    let compares_names = switch(
        endpoint,
        key::TLS_VERIFY_NAME_ON_CONNECT,
        key::TLS_VERIFY_NAME_ON_CONNECT_DEFAULT,
    )?;
    let builder = if compares_names {
        builder.with_root_certificates(roots)
    } else {
        let any_name = WebPkiVerifierAnyServerName::new(roots);
        // Any name of the configured authority is admitted, as the config asks; the chain is still verified.
        let builder = builder.dangerous();
        builder.with_custom_certificate_verifier(Arc::new(any_name))
    };
    if !is_mutual(endpoint)? {
        return Ok(Arc::new(builder.with_no_client_auth()));
    }
    let chain = CONNECT_CERTIFICATE.certificates(endpoint).await?;
    let chain = chain.ok_or_else(|| CONNECT_CERTIFICATE.missing())?;
    let key = CONNECT_KEY.key(endpoint).await?;
    let config = builder.with_client_auth_cert(chain, key);
    Ok(Arc::new(config.map_err(|error| CONNECT_KEY.wrong(&error))?))
}

/// Makes the TCP sockets below.
///
/// # Errors
/// An invalid size, class of service or address.
pub(crate) async fn sockets<'a>(endpoint: &'a Config<'_>) -> ZResult<TcpSocketConfig<'a>> {
    let interface = endpoint.get(BIND_INTERFACE);
    let bind = match endpoint.get(BIND_SOCKET) {
        // Each of them determines the address to connect from.
        Some(_) if interface.is_some() => bail!(
            "received {BIND_INTERFACE} and {BIND_SOCKET}, expected one of them: each says where from to connect"
        ),
        Some(address) => Some(resolve(address).await?),
        None => None,
    };
    Ok(TcpSocketConfig::new(
        number(endpoint, TCP_SO_SND_BUF)?,
        number(endpoint, TCP_SO_RCV_BUF)?,
        interface,
        bind,
        parse_dscp(endpoint)?,
    ))
}

/// Returns the first socket address of `<host>:<port>`.
pub(crate) async fn resolve(address: &str) -> ZResult<SocketAddr> {
    let mut found = tokio::net::lookup_host(address)
        .await
        .map_err(|error| zerror!("{address}: {error}"))?;
    found
        .next()
        .ok_or_else(|| zerror!("{address}: no address is known of it").into())
}

/// Authorities that sign the certificates of peers, and no others: public authorities sign for everybody.
async fn authority(endpoint: &Config<'_>) -> ZResult<RootCertStore> {
    let certificates = AUTHORITY.certificates(endpoint).await?;
    let mut roots = RootCertStore::empty();
    for certificate in certificates.ok_or_else(|| AUTHORITY.missing())? {
        roots
            .add(certificate)
            .map_err(|error| AUTHORITY.wrong(&error))?;
    }
    Ok(roots)
}

/// True if both ends have certificates.
fn is_mutual(endpoint: &Config<'_>) -> ZResult<bool> {
    switch(endpoint, key::TLS_ENABLE_MTLS, key::TLS_ENABLE_MTLS_DEFAULT)
}

fn switch(endpoint: &Config<'_>, name: &str, default: bool) -> ZResult<bool> {
    match endpoint.get(name) {
        None => Ok(default),
        Some(text) => text
            .parse()
            .map_err(|_| zerror!("{name}: received {text:?}, expected true or false").into()),
    }
}

fn number<T: std::str::FromStr>(endpoint: &Config<'_>, name: &str) -> ZResult<Option<T>> {
    let Some(text) = endpoint.get(name) else {
        return Ok(None);
    };
    let number = text.parse();
    let number = number.map_err(|_| zerror!("{name}: received {text:?}, expected a number"))?;
    Ok(Some(number))
}

fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}
