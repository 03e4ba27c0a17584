//! Finds out why an endpoint refuses: dials it with TLS as Zenoh does, and evaluates the alert.
//!
//! Zenoh itself only reports that there is no link. With TLS 1.3 the client finishes its handshake
//! before the server has checked its certificate, so the alert is the first data read afterwards.

use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::time::Duration;

use rustls::pki_types::ServerName;
use rustls::{AlertDescription, CertificateError, ClientConfig, ClientConnection};

use super::endpoint::host_and_port;
use crate::network::credentials::common_name;

/// Timeout of each step.
// A handshake takes two round trips: two seconds suffice even over a radio link.
const CONNECTING: Duration = Duration::from_secs(2);
/// Time without data after which the connection counts as accepted.
// A server that refuses sends its alert within a round trip after the handshake.
const SILENCE: Duration = Duration::from_millis(500);

/// Result of dialling.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum DialResult {
    /// No response.
    Unreachable(String),
    /// A response without TLS.
    WithoutTls,
    /// A response, but one end does not trust the other.
    Refused(String),
    /// Mutual trust, with the name in the certificate of the other end.
    Trusted(Option<String>),
}

/// Dials an endpoint. Takes a few seconds at most for each address of its host.
pub(super) fn dial(endpoint: &str, config: Arc<ClientConfig>) -> DialResult {
    let Some((host, port)) = host_and_port(endpoint) else {
        return DialResult::Unreachable("it has no address".to_owned());
    };
    // `connect_timeout` and the verifier take an IPv6 address without the brackets of an endpoint.
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let socket = match connected(host, port) {
        Ok(socket) => socket,
        Err(error) => return DialResult::Unreachable(error.to_string()),
    };
    let Ok(name) = ServerName::try_from(host.to_owned()) else {
        return DialResult::Refused(format!("{host:?} cannot be compared with a certificate"));
    };
    match ClientConnection::new(config, name) {
        Ok(connection) => shake_hands(connection, socket),
        Err(error) => DialResult::Refused(error.to_string()),
    }
}

fn connected(host: &str, port: u16) -> io::Result<TcpStream> {
    let mut last = io::Error::new(ErrorKind::NotFound, "its name has no address");
    // A host may have several addresses, of IPv6 and IPv4: the node may listen on either.
    for address in (host, port).to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECTING) {
            Ok(socket) => {
                socket.set_read_timeout(Some(CONNECTING))?;
                socket.set_write_timeout(Some(CONNECTING))?;
                return Ok(socket);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

fn shake_hands(mut connection: ClientConnection, mut socket: TcpStream) -> DialResult {
    while connection.is_handshaking() {
        if let Err(error) = connection.complete_io(&mut socket) {
            return result_of(&error);
        }
    }
    // In TLS 1.3 the certificate of the server is known here, although its verdict on ours is not.
    let certificates = connection.peer_certificates().unwrap_or_default();
    let name = certificates.first().and_then(common_name);
    // A failure to set it leaves the timeout of connecting: slower, not wrong.
    let _ = socket.set_read_timeout(Some(SILENCE));
    loop {
        match connection.read_tls(&mut socket) {
            // Closed without an alert, or silent: not a refusal.
            Ok(0) | Err(_) => return DialResult::Trusted(name),
            Ok(_) => {
                if let Err(error) = connection.process_new_packets() {
                    return refused(&error);
                }
            }
        }
    }
}

/// Result from a failed handshake: a TLS error, or a connection to a server without TLS.
fn result_of(error: &io::Error) -> DialResult {
    let inner = error.get_ref();
    match inner.and_then(|inner| inner.downcast_ref::<rustls::Error>()) {
        Some(error) => refused(error),
        // A read timeout is `WouldBlock` on Unix and `TimedOut` on Windows.
        None if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            DialResult::Unreachable("it says nothing".to_owned())
        }
        None => DialResult::WithoutTls,
    }
}

/// Text for a received alert, or for a wrong certificate of the other end.
fn refused(error: &rustls::Error) -> DialResult {
    use AlertDescription as Alert;
    use CertificateError as Found;
    let text = match error {
        // The first bytes were no TLS record.
        rustls::Error::InvalidMessage(_) => return DialResult::WithoutTls,
        rustls::Error::AlertReceived(alert) => match alert {
            Alert::CertificateRequired => {
                "it wants a certificate, and this end has none".to_owned()
            }
            // rustls sends `decrypt_error` where the authority has the same name and another key.
            Alert::UnknownCA | Alert::DecryptError => {
                "it does not know the authority of the certificate here".to_owned()
            }
            Alert::CertificateExpired => "the certificate here has expired".to_owned(),
            Alert::CertificateRevoked => "the certificate here is revoked".to_owned(),
            other => format!("it refuses the certificate here: {other:?}"),
        },
        rustls::Error::InvalidCertificate(found) => match found {
            Found::UnknownIssuer | Found::BadSignature => {
                "its certificate is of another authority".to_owned()
            }
            Found::Expired | Found::ExpiredContext { .. } => {
                "its certificate has expired".to_owned()
            }
            Found::NotValidForName | Found::NotValidForNameContext { .. } => {
                "its certificate does not name this address".to_owned()
            }
            other => format!("its certificate is refused: {other}"),
        },
        other => other.to_string(),
    };
    DialResult::Refused(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::credentials::provider;
    use rustls::RootCertStore;
    use std::io::Write;
    use std::net::TcpListener;

    fn nobody() -> Arc<ClientConfig> {
        let config = ClientConfig::builder_with_provider(provider());
        let config = config.with_safe_default_protocol_versions().unwrap();
        let config = config.with_root_certificates(RootCertStore::empty());
        Arc::new(config.with_no_client_auth())
    }

    #[test]
    fn nobody_and_somebody_without_tls_are_told_apart() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("tcp/{}", listener.local_addr().unwrap());
        let answers = std::thread::spawn(move || {
            let (mut socket, _) = listener.accept().unwrap();
            socket.write_all(b"this is not TLS at all").unwrap();
        });
        assert_eq!(dial(&endpoint, nobody()), DialResult::WithoutTls);
        answers.join().unwrap();
        let closed = dial(&endpoint, nobody());
        assert!(matches!(closed, DialResult::Unreachable(_)), "{closed:?}");
    }
}
