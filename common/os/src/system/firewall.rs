//! Firewall rules of a system for incoming packets.

use std::ops::RangeInclusive;

/// The rules for incoming packets, as far as they depend on ports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Firewall {
    /// Programs that listed the rules.
    pub sources: Vec<String>,
    /// True if any incoming packets are dropped or rejected.
    pub drops: bool,
    /// Ports admitted by a rule, from any source.
    pub admitted: Vec<AdmittedPorts>,
}

/// Ports admitted by a rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdmittedPorts {
    /// True for datagrams, false for streams.
    pub is_udp: bool,
    /// Range of ports.
    pub ports: RangeInclusive<u16>,
}

impl Firewall {
    /// True if this port can be reached from elsewhere. Rules with conditions beyond the port may differ.
    #[must_use]
    pub fn admits(&self, port: u16, is_udp: bool) -> bool {
        let mut admitted = self.admitted.iter();
        let is_it = |by: &AdmittedPorts| by.is_udp == is_udp && by.ports.contains(&port);
        // Without any rule that drops, all ports are open, whatever else is listed.
        !self.drops || admitted.any(is_it)
    }

    /// Adds the rules of another list.
    pub(super) fn and(mut self, other: Self) -> Self {
        self.sources.extend(other.sources);
        self.drops |= other.drops;
        self.admitted.extend(other.admitted);
        self
    }
}
