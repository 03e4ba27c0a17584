//! Endpoints: `<protocol>/<host>:<port>`.

use std::net::IpAddr;

use anyhow::bail;

/// Host and port of an endpoint that has them. An IPv6 address is in brackets.
#[must_use]
pub fn host_and_port(endpoint: &str) -> Option<(&str, u16)> {
    let (_, rest) = endpoint.split_once('/')?;
    // An endpoint of Zenoh may have metadata after `?` and a config after `#`, with colons of their own.
    // The last colon: an IPv6 address has more of them, within its brackets.
    let (host, port) = rest.split(['?', '#']).next()?.rsplit_once(':')?;
    Some((host, port.parse().ok()?))
}

/// True if the endpoint uses UDP datagrams.
#[must_use]
pub fn is_over_udp(endpoint: &str) -> bool {
    // QUIC runs over UDP.
    endpoint.starts_with("udp/") || endpoint.starts_with("quic/")
}

/// True if only programs on this machine can be at the other end.
#[must_use]
pub fn is_local(endpoint: &str) -> bool {
    if endpoint.starts_with("unixsock-stream/") {
        return true;
    }
    let Some((host, _)) = host_and_port(endpoint) else {
        return false;
    };
    let address = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || address.parse().is_ok_and(|ip: IpAddr| ip.is_loopback())
}

/// Checks an endpoint of a secure network, which must use TLS: the rest of the profile relies on
/// the names in certificates.
///
/// QUIC has such names, too. Its listener in Zenoh 1.10 takes one connection after the other, each
/// for as long as its handshake lasts, so a silent stranger keeps all members out.
pub(super) fn check_secure_endpoint(endpoint: &str) -> anyhow::Result<()> {
    check_endpoint(endpoint)?;
    match endpoint.split_once('/') {
        // An endpoint without a protocol was refused by the check above.
        Some(("tls", _)) | None => Ok(()),
        Some((protocol, rest)) => bail!(
            "received the protocol {protocol:?} beside transport.secure, expected tls, as in tls/{rest}"
        ),
    }
}

/// Parses an endpoint of the command line.
///
/// # Errors
/// The text received and the expected form.
pub fn endpoint(text: &str) -> Result<String, String> {
    match check_endpoint(text) {
        Ok(()) => Ok(text.to_owned()),
        Err(reason) => Err(reason.to_string()),
    }
}

// The transports that the dependency is built with: any other one is refused by Zenoh at the start.
const PROTOCOLS: [&str; 5] = ["tcp", "udp", "tls", "quic", "unixsock-stream"];

/// Checks an endpoint: Zenoh itself would retry one that can never work, silently and for ever.
pub(super) fn check_endpoint(endpoint: &str) -> anyhow::Result<()> {
    let Some((protocol, rest)) = endpoint.split_once('/') else {
        bail!("is no endpoint, expected <protocol>/<address>, such as tcp/192.168.1.10:7447");
    };
    if !PROTOCOLS.contains(&protocol) {
        bail!(
            "received the protocol {protocol:?}, expected one of {}",
            PROTOCOLS.join(", ")
        );
    }
    let address = rest.split(['?', '#']).next().unwrap_or_default();
    // A path of a socket may hold anything, but not nothing.
    if address.is_empty() {
        bail!("has no address after the protocol");
    }
    if protocol == "unixsock-stream" {
        return Ok(());
    }
    let Some((host, port)) = address.rsplit_once(':') else {
        bail!("has no port, expected <host>:<port>, such as 192.168.1.10:7447");
    };
    if host.is_empty() {
        bail!("has no host, expected <host>:<port>, such as 192.168.1.10:7447");
    }
    // Port 0 is allowed: the system chooses one, which tests rely on.
    if port.parse::<u16>().is_err() {
        bail!("received the port {port:?}, expected 0 to 65535");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stays_on_this_machine_is_known() {
        for endpoint in [
            "tcp/127.0.0.1:7447",
            "tls/localhost:7447",
            "udp/[::1]:7447",
            "unixsock-stream/a.sock",
            // All of 127.0.0.0/8 is loopback, not only 127.0.0.1.
            "tcp/127.0.0.9:1#iface=lo",
        ] {
            assert!(is_local(endpoint), "{endpoint}");
        }
        for endpoint in [
            // An unspecified address is every interface of the machine, and a name may be any machine.
            "tcp/0.0.0.0:7447",
            "tcp/[::]:7447",
            "tls/press:7447",
            "quic/10.0.0.1:7447",
        ] {
            assert!(!is_local(endpoint), "{endpoint}");
        }
    }

    #[test]
    fn the_secure_profile_takes_nothing_but_tls() {
        for endpoint in [
            "tls/0.0.0.0:7447",
            "tls/press.local:7447",
            "tls/[::]:7447",
            "tls/[fd00::7]:7447",
        ] {
            check_secure_endpoint(endpoint).unwrap();
        }
        for (endpoint, expected) in [
            ("tcp/10.0.0.1:7447", "expected tls, as in tls/10.0.0.1:7447"),
            ("quic/10.0.0.1:7447", "received the protocol \"quic\""),
            ("tls/10.0.0.1", "has no port"),
        ] {
            let message = check_secure_endpoint(endpoint).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
