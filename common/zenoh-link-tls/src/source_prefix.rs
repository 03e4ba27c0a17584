//! Source of a connection, as far as connections are counted and paced by it.

use std::fmt;
use std::net::{IpAddr, Ipv6Addr, SocketAddr};

/// Bits of an IPv6 address that name a network: the other half is chosen by each host as it likes, and
/// changes all the time (RFC 8981).
const NETWORK_BITS: u32 = 64;

/// An IPv4 address, or the network of an IPv6 address (/64).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct SourcePrefix(IpAddr);

impl SourcePrefix {
    pub(crate) fn of(from: SocketAddr) -> Self {
        // A listener on [::] sees IPv4 clients as ::ffff:a.b.c.d, all of them in one /64.
        Self(match from.ip().to_canonical() {
            IpAddr::V6(ip) => {
                let network = u128::from(ip) & (u128::MAX << (128 - NETWORK_BITS));
                IpAddr::V6(Ipv6Addr::from(network))
            }
            v4 @ IpAddr::V4(_) => v4,
        })
    }
}

impl fmt::Display for SourcePrefix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            IpAddr::V4(ip) => write!(f, "{ip}"),
            IpAddr::V6(ip) => write!(f, "{ip}/{NETWORK_BITS}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(address: &str) -> String {
        SourcePrefix::of(address.parse().expect("an address")).to_string()
    }

    #[test]
    fn hosts_of_ipv4_and_networks_of_ipv6_are_origins() {
        assert_eq!(origin("10.0.0.7:40000"), "10.0.0.7");
        assert_eq!(origin("[::ffff:10.0.0.7]:40000"), "10.0.0.7");
        assert_eq!(origin("[fd00::1:2:3:4]:1"), "fd00::/64");
        assert_eq!(origin("[fd00:0:0:1::4]:1"), "fd00:0:0:1::/64");
    }
}
