//! Faults laid over real links.

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_node::config::LinkConfig;
use coaxle_node::faults::{Deliveries, LinkModel};
use coaxle_node::wiring::far_link_seed;

use crate::machine::{self, Machine};

/// What is laid over the frames of one channel.
pub(crate) struct Faults {
    link: Option<LinkModel>,
    start: Instant<Machine>,
}

impl Faults {
    /// `far` is the number of the followed node that the link is to.
    pub(crate) fn new(config: &LinkConfig, seed: u64, channel: Channel, far: usize) -> Self {
        let any = *config != LinkConfig::default();
        Self {
            link: any.then(|| LinkModel::new(config, far_link_seed(seed, "link", channel, far))),
            start: machine::now(),
        }
    }

    /// The delays after which a frame that is handed over at `at` arrives.
    pub(crate) fn of(&mut self, at: Instant<Machine>) -> Deliveries {
        match &mut self.link {
            Some(link) => link.offer(at - self.start),
            None => Deliveries::once(Span::ZERO),
        }
    }
}
