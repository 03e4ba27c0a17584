//! Reasons why listening fails on a configured endpoint, and remedies.

use std::io::{self, ErrorKind};
use std::net::{TcpListener, UdpSocket};

use super::endpoint::{host_and_port, is_over_udp};

/// Remedy for the first of these endpoints that cannot be listened on, to be appended to the
/// reason; empty if all can.
pub(super) fn remedy(endpoints: &[String]) -> String {
    let tried = endpoints.iter().find_map(|endpoint| {
        // Bound again after Zenoh failed: its error gives the text, and this one the kind.
        let error = listen(endpoint).err()?;
        remedy_of(endpoint, error.kind())
    });
    tried.map_or_else(String::new, |remedy| format!("; {remedy}"))
}

/// Listens for a moment.
fn listen(endpoint: &str) -> io::Result<()> {
    let Some((host, port)) = host_and_port(endpoint) else {
        return Ok(());
    };
    let host = host.trim_start_matches('[').trim_end_matches(']');
    match is_over_udp(endpoint) {
        true => UdpSocket::bind((host, port)).map(drop),
        false => TcpListener::bind((host, port)).map(drop),
    }
}

fn remedy_of(endpoint: &str, kind: ErrorKind) -> Option<String> {
    let (host, port) = host_and_port(endpoint)?;
    let protocol = endpoint.split('/').next()?;
    match kind {
        ErrorKind::AddrInUse => {
            // After the last port comes Zenoh's own.
            let other = port.checked_add(1).unwrap_or(7447);
            Some(format!(
                "another program has port {port}: end it, or listen on another port, such as --listen {protocol}/{host}:{other}"
            ))
        }
        ErrorKind::AddrNotAvailable => Some(format!(
            "this PC has no address {host}: listen on one that it has, or on all: --listen {protocol}/0.0.0.0:{port}"
        )),
        ErrorKind::PermissionDenied => Some(format!(
            "this user may not listen on port {port}: take one from 1024 on, such as --listen {protocol}/{host}:7447"
        )),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_help_is_told_with_the_endpoint() {
        let taken = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = taken.local_addr().unwrap().port();
        let told = remedy(&[format!("tcp/127.0.0.1:{port}")]);
        assert!(told.contains(&format!("has port {port}")), "{told}");
        // 192.0.2.0/24 is for documentation (RFC 5737): no machine has it.
        let told = remedy(&["tcp/192.0.2.1:7447".to_owned()]);
        assert!(told.contains("--listen tcp/0.0.0.0:7447"), "{told}");
        let fine = ["tcp/127.0.0.1:0", "unixsock-stream/a"].map(str::to_owned);
        assert_eq!(remedy(&fine), "");
    }
}
