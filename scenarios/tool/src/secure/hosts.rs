//! Addresses of nodes. A certificate must name them, or a connecting node takes it for another node's.

use std::collections::{BTreeMap, BTreeSet};
use std::net::{IpAddr, Ipv6Addr};

use coaxle_host::network::transport::host_and_port;
use coaxle_node::config::Wrong;
use coaxle_node::keys::NodeName;

use super::member::Member;

/// The hosts of each node: IP addresses and host names.
#[derive(Clone, Debug, Default)]
pub struct Addresses(BTreeMap<NodeName, BTreeSet<String>>);

/// Addresses of a node for programs on its own PC.
// Both: a connecting end compares the name as its config spells it.
const HERE: [&str; 2] = ["127.0.0.1", "localhost"];

impl Addresses {
    /// Collects the given addresses, those where nodes listen, and those that others connect to.
    pub(super) fn of(nodes: &[Member], given: &[(NodeName, String)]) -> Result<Self, Wrong> {
        let mut hosts = Self::default();
        // First, because a given address settles which of several nodes an endpoint is.
        for (name, host) in given {
            if !nodes.iter().any(|node| node.name == *name) {
                let received = format!("the node {:?}", name.as_str());
                return Err(Wrong::of("--at", received, "one whose config is given"));
            }
            hosts.add(name, host);
        }
        for node in nodes {
            let listens = node.listen.iter().filter_map(|at| host_and_port(at));
            // `0.0.0.0` is no address that others could connect to.
            for (host, _) in listens.filter(|(host, _)| !is_every_interface(host)) {
                hosts.add(&node.name, host);
            }
        }
        for node in nodes {
            // After all `listen`s of all nodes, by which an endpoint may be known already.
            for endpoint in &node.connect {
                hosts.attribute(node, endpoint, nodes)?;
            }
        }
        Ok(hosts)
    }

    /// Names in the certificate of a node: its addresses, and this PC for the nodes on it, too.
    #[must_use]
    pub fn in_certificate(&self, node: &NodeName) -> Vec<String> {
        let here = HERE.into_iter().map(str::to_owned);
        let beyond = self.beyond_its_pc(node).into_iter();
        here.chain(beyond).collect()
    }

    /// The addresses of a node that mean no other PC's own.
    #[must_use]
    pub fn beyond_its_pc(&self, node: &NodeName) -> Vec<String> {
        let known = self.0.get(node).into_iter().flatten();
        known.filter(|host| !is_own_pc(host)).cloned().collect()
    }

    /// Endpoints of a node for others; its own PC if no other address is known.
    #[must_use]
    pub fn endpoints(&self, node: &Member) -> Vec<String> {
        let mut hosts = self.beyond_its_pc(&node.name);
        if hosts.is_empty() {
            hosts.push(HERE[0].to_owned());
        }
        let ports: BTreeSet<u16> = ports(node).collect();
        let of_host = |host: &String| {
            let endpoint = |port| format!("tls/{host}:{port}");
            ports.iter().map(endpoint).collect::<Vec<_>>()
        };
        hosts.iter().flat_map(of_host).collect()
    }

    /// Adds a host as endpoints have it, an IPv6 address in brackets.
    fn add(&mut self, node: &NodeName, host: &str) {
        let hosts = self.0.entry(node.clone()).or_default();
        // A single spelling for each IPv6 address: `[fd00:0::7]` and `[fd00::7]` are one host.
        hosts.insert(match host.parse::<Ipv6Addr>() {
            Ok(address) => format!("[{address}]"),
            Err(_) => host.to_owned(),
        });
    }

    /// Finds the node that is at an endpoint, if no node is known to be there yet.
    fn attribute(&mut self, from: &Member, endpoint: &str, nodes: &[Member]) -> Result<(), Wrong> {
        let Some((host, port)) = host_and_port(endpoint) else {
            return Ok(());
        };
        // By the port: addresses of a node are what is looked for.
        let listens = |node: &&Member| node.name != from.name && ports(node).any(|at| at == port);
        let candidates: Vec<&Member> = nodes.iter().filter(listens).collect();
        let is_known = |node: &&Member| self.0.get(&node.name).is_some_and(|at| at.contains(host));
        // The own PC is in every certificate already.
        if is_own_pc(host) || candidates.iter().any(is_known) {
            return Ok(());
        }
        match candidates[..] {
            // An error and no guess: without the name in a certificate that connection would be refused later.
            [] => Err(Wrong::with_reason(
                format!("node {:?}", from.name.as_str()),
                format_args!(
                    "connects to {endpoint:?}, and no config that is given listens on that port, expected it \
                     among them"
                ),
            )),
            [only] => {
                self.add(&only.name, host);
                Ok(())
            }
            _ => {
                let names: Vec<_> = candidates.iter().map(|node| node.name.as_str()).collect();
                let reason = format!(
                    "connects to {endpoint:?}, where any of {} may listen, expected --at NODE={host} for the one \
                     that does",
                    names.join(", ")
                );
                Err(Wrong::with_reason(
                    format!("node {:?}", from.name.as_str()),
                    reason,
                ))
            }
        }
    }
}

fn ports(node: &Member) -> impl Iterator<Item = u16> {
    let ports = node.listen.iter().filter_map(|at| host_and_port(at));
    ports.map(|(_, port)| port)
}

fn is_every_interface(host: &str) -> bool {
    matches!(host, "0.0.0.0" | "[::]")
}

fn is_own_pc(host: &str) -> bool {
    // Endpoints have IPv6 addresses in brackets, the parser without.
    let address = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || address.parse().is_ok_and(|ip: IpAddr| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secure::samples::{LINE, SAW, member, name};

    fn addresses(nodes: &[&str], given: &[(&str, &str)]) -> Result<Addresses, String> {
        let nodes: Vec<_> = nodes.iter().map(|text| member(text)).collect();
        let given: Vec<_> = given
            .iter()
            .map(|(node, host)| (name(node), (*host).to_owned()))
            .collect();
        Addresses::of(&nodes, &given).map_err(|error| error.to_string())
    }

    #[test]
    fn a_node_is_where_others_connect_to_on_its_port() {
        let found = addresses(&[LINE, SAW], &[("line", "line.local")]).unwrap();
        assert_eq!(
            found.in_certificate(&name("line")),
            ["127.0.0.1", "localhost", "10.0.0.1", "line.local"]
        );
        assert_eq!(found.in_certificate(&name("saw")), HERE);
        assert_eq!(
            found.endpoints(&member(LINE)),
            ["tls/10.0.0.1:7447", "tls/line.local:7447"]
        );
        let found = addresses(&[LINE], &[("line", "fd00::7")]).unwrap();
        assert_eq!(found.endpoints(&member(LINE)), ["tls/[fd00::7]:7447"]);
        assert_eq!(found.endpoints(&member(SAW)), ["tls/127.0.0.1:7448"]);
    }

    #[test]
    fn what_the_configs_leave_open_is_asked_for() {
        let twin = LINE.replace("'line'", "'twin'");
        let error = addresses(&[LINE, &twin, SAW], &[]).unwrap_err();
        assert!(error.contains("any of line, twin may listen"), "{error}");
        assert!(error.contains("--at NODE=10.0.0.1"), "{error}");
        let found = addresses(&[LINE, &twin, SAW], &[("twin", "10.0.0.1")]).unwrap();
        assert_eq!(found.beyond_its_pc(&name("twin")), ["10.0.0.1"]);
        assert!(found.beyond_its_pc(&name("line")).is_empty());

        let elsewhere = SAW.replace(":7447", ":7440");
        let error = addresses(&[LINE, &elsewhere], &[]).unwrap_err();
        assert!(
            error.contains("no config that is given listens on that port"),
            "{error}"
        );
        let error = addresses(&[LINE], &[("saw", "10.0.0.1")]).unwrap_err();
        assert!(error.contains("\"saw\""), "{error}");
    }
}
