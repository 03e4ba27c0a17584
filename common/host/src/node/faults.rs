//! Faults applied to real links.

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_node::config::{LinkConfig, Wrong};
use coaxle_node::faults::{Deliveries, LinkModel, Tampering};
use coaxle_node::wiring::far_link_seed;
use coaxle_os::machine::{self, Machine};

/// Faults applied to the frames of one channel.
pub(crate) struct Faults {
    tampering: Option<Tampering>,
    link: Option<LinkModel>,
    start: Instant<Machine>,
}

impl Faults {
    /// Creates the faults for the frames of `key`. `far` is the number of the followed node at the
    /// other end of the link.
    ///
    /// # Errors
    /// A file that its delay names cannot be used.
    pub(crate) fn new(
        config: &LinkConfig,
        seed: u64,
        key: &str,
        channel: Channel,
        far: usize,
    ) -> Result<Self, Wrong> {
        // A link without faults passes no model: no random number is drawn, and no delay added.
        let any = *config != LinkConfig::default();
        let seed = far_link_seed(seed, "link", channel, far);
        Ok(Self {
            tampering: Tampering::new(config, seed, key),
            link: any.then(|| LinkModel::new(config, seed)).transpose()?,
            // Times of faults in a config count from the start of the node.
            start: machine::now(),
        })
    }

    /// The delays after which a frame that is handed over at `at` arrives.
    pub(crate) fn deliveries(&mut self, at: Instant<Machine>) -> Deliveries {
        match &mut self.link {
            Some(link) => link.offer(at - self.start),
            None => Deliveries::once(Span::ZERO),
        }
    }

    /// Passes the possibly altered frames for a frame handed over at `at` to `arrive`.
    pub(crate) fn tamper(
        &mut self,
        at: Instant<Machine>,
        frame: &[u8],
        mut arrive: impl FnMut(&[u8]),
    ) {
        match &mut self.tampering {
            Some(tampering) => tampering.pass(at - self.start, frame, arrive),
            None => arrive(frame),
        }
    }
}
