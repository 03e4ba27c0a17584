//! Firewalls that keep others from the endpoints of a config.

use coaxle_host::network::transport::{host_and_port, is_over_udp};
use coaxle_os::Firewall;

use super::{ConfigFinding, note, shut};

/// Findings about the ports in `listens`: closed by the firewall, or a note if the firewall cannot be read.
pub(super) fn of_ports(
    listens: &[String],
    firewall: &Result<Firewall, String>,
) -> Vec<ConfigFinding> {
    let ports = listens.iter().filter_map(|endpoint| {
        let (_, port) = host_and_port(endpoint)?;
        // Port 0 is chosen by the system: no rule can name it.
        (port > 0).then(|| (endpoint, port, is_over_udp(endpoint)))
    });
    let ports: Vec<_> = ports.collect();
    // Before the firewall is looked at: without ports it does not matter whether it can be read.
    if ports.is_empty() {
        return Vec::new();
    }
    let firewall = match firewall {
        Ok(firewall) => firewall,
        Err(reason) => {
            let text = format!("whether a firewall keeps others out cannot be read ({reason})");
            // A note and no fault, as the firewall may well be open.
            return vec![note(&text, "with sudo it can be")];
        }
    };
    let kept_out = ports
        .into_iter()
        .filter(|(_, port, is_udp)| !firewall.admits(*port, *is_udp));
    let told = |(endpoint, port, is_udp): (&String, u16, bool)| {
        let (kind, remedy) = if is_udp {
            (
                "udp",
                "let it in: ufw allow PORT/udp, or a rule of nft: udp dport PORT accept",
            )
        } else {
            (
                "tcp",
                "let it in: ufw allow PORT/tcp, or a rule of nft: tcp dport PORT accept",
            )
        };
        let text =
            format!("a firewall keeps others from {endpoint}: no rule lets in {kind} port {port}");
        shut(text, remedy)
    };
    kept_out.map(told).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_os::AdmittedPorts;

    #[test]
    fn a_port_that_no_rule_lets_in_is_shut() {
        let listens = ["tcp/0.0.0.0:7447", "tcp/0.0.0.0:0", "udp/0.0.0.0:7448"].map(str::to_owned);
        let firewall = Firewall {
            drops: true,
            admitted: vec![AdmittedPorts {
                is_udp: false,
                ports: 7400..=7500,
            }],
            ..Firewall::default()
        };
        let found = of_ports(&listens, &Ok(firewall));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].is_bad() && found[0].text.contains("udp port 7448"));
        assert!(found[0].remedy.contains("udp dport"), "{found:?}");
        let unread = of_ports(&listens, &Err("nft: you must be root".to_owned()));
        assert!(!unread[0].is_bad() && unread[0].text.contains("must be root"));
        assert!(of_ports(&listens, &Ok(Firewall::default())).is_empty());
    }
}
