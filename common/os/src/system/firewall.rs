//! What a system lets in from the network.

use std::ops::RangeInclusive;

/// The rules for what comes in, as far as ports depend on them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Firewall {
    /// Who was asked.
    pub asked: Vec<String>,
    /// Whether anything that comes in is dropped or rejected.
    pub drops: bool,
    /// Ports that a rule lets in, whoever it is from.
    pub admitted: Vec<Admitted>,
}

/// Ports that a rule lets in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Admitted {
    /// Datagrams, or streams.
    pub is_udp: bool,
    /// Which.
    pub ports: RangeInclusive<u16>,
}

impl Firewall {
    /// Whether somebody elsewhere reaches this port. Rules that ask for more than the port may say otherwise.
    #[must_use]
    pub fn admits(&self, port: u16, is_udp: bool) -> bool {
        let mut admitted = self.admitted.iter();
        let is_it = |by: &Admitted| by.is_udp == is_udp && by.ports.contains(&port);
        !self.drops || admitted.any(is_it)
    }

    /// With what another one says besides.
    pub(super) fn and(mut self, other: Self) -> Self {
        self.asked.extend(other.asked);
        self.drops |= other.drops;
        self.admitted.extend(other.admitted);
        self
    }
}
