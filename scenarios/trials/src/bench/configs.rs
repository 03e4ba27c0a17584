//! Config files of the two nodes that are measured.

use std::fmt::Write;

use anyhow::Context;
use coaxle_clock::{Instant, Span};
use coaxle_host::node::{Recorder, Setup};
use coaxle_node::config::{RealTimeConfig, parse};
use coaxle_node::frame::KeySeal;
use coaxle_node::{Channel, Node};
use coaxle_receiver::{Receiver, ReceiverConfig, ReceiverSnapshot};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;

/// Settings that both nodes share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NodesConfig {
    pub(super) cycle: Span,
    pub(super) axes: u32,
    pub(super) real_time: RealTimeConfig,
}

const SENDER: &str = "bench-sender";
const RECEIVER: &str = "bench-receiver";
/// As in the configs of the tour: a PC without real-time priority pauses for longer than the defaults allow.
const PATIENT: &str = "[far.sync.time-sync]\nmax-cycle-index-difference = 120.0\nage-of-data-limit = 100\nautomatic-re-init = true\n";

impl NodesConfig {
    /// The file of the sender, which listens there.
    pub(super) fn sender(&self, listen: Option<&str>) -> anyhow::Result<String> {
        let mut text = self.head(SENDER, "listen", listen)?;
        // From 1, as an id of 0 is no axis.
        for id in 1..=self.axes {
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "[[axis]]\nid = {id}\nname = 'a{id}'\nprogram = {{ start-velocity = {}, limits = {{ velocity = 2000.0, \
                 acceleration = 1000.0, jerk = 10000.0 }} }}\n",
                500 + id
            );
        }
        Ok(text)
    }

    /// The file of the receiver, which connects to there and follows every axis.
    pub(super) fn receiver(&self, connect: &str) -> anyhow::Result<String> {
        let head = self.head(RECEIVER, "connect", Some(connect))?;
        let axes = self.axes;
        Ok(format!(
            "{head}[[far]]\nnode = '{SENDER}'\naxes = ['1-{axes}']\n{PATIENT}"
        ))
    }

    fn head(&self, name: &str, way: &str, endpoint: Option<&str>) -> anyhow::Result<String> {
        let real_time = toml::to_string(&self.real_time).context("real-time wishes as TOML")?;
        let transport = endpoint.map_or(String::new(), |endpoint| {
            format!("[transport]\n{way} = ['{endpoint}']\n")
        });
        // `{:?}` below writes a point in any case, as floats have in TOML.
        let micros = self.cycle.as_nanos() as f64 / 1e3;
        Ok(format!(
            "name = '{name}'\ncycle-time-us = {micros:?}\n[real-time]\n{real_time}{transport}"
        ))
    }

    /// Length of a frame of the sender as transmitted, bytes.
    ///
    /// # Errors
    /// The config is no sender's, or the sender published nothing.
    pub(super) fn frame_bytes(&self) -> anyhow::Result<usize> {
        let config = sender_config(&self.sender(None)?)?;
        let seal = KeySeal::new(&config.name.channel_key(Channel::Axes));
        let mut node = Sender::new(&config, Instant::EPOCH, u64::MAX)?;
        // Later frames are longer by a few bytes at most: the count grows, and is encoded with varying length.
        let _ = node.cycle(Instant::EPOCH);
        let frame = node.transmit().context("a sender published no frame")?;
        let mut sealed = Vec::new();
        // A stamp of a usual length.
        seal.seal(frame.body, Some(Span::from_micros(50)), &mut sealed);
        Ok(sealed.len())
    }
}

/// Reads a file of [`NodesConfig::sender`].
pub(super) fn sender_config(text: &str) -> anyhow::Result<SenderConfig> {
    Ok(parse(SENDER, text)?)
}

/// The sender as its own program runs it, except for its recorder and for the node that `wrap` makes of it.
pub(super) fn sender_setup<N: Node + 'static>(
    config: &SenderConfig,
    recorder: Box<dyn Recorder<N::Snapshot>>,
    wrap: impl FnOnce(Sender) -> N + 'static,
) -> Setup<N> {
    // The closure builds the node on the cycle thread and must own the config.
    let node = config.clone();
    let build = move |start, epoch| Ok(wrap(Sender::new(&node, start, epoch)?));
    coaxle_sender::run::setup(config, Box::new(build), recorder)
}

/// The receiver as its own program runs it, except for its recorder.
pub(super) fn receiver_setup(
    text: &str,
    recorder: Box<dyn Recorder<ReceiverSnapshot>>,
) -> anyhow::Result<Setup<Receiver>> {
    let config: ReceiverConfig = parse(RECEIVER, text)?;
    let node = config.clone();
    let build = move |start, epoch| Ok(Receiver::new(&node, start, epoch)?);
    Ok(coaxle_receiver::run::setup(
        &config,
        Box::new(build),
        recorder,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_are_those_of_nodes_and_a_frame_grows_with_its_axes() {
        let nodes = |axes| NodesConfig {
            cycle: Span::from_millis(1),
            axes,
            real_time: RealTimeConfig {
                priority: Some(80),
                ..RealTimeConfig::default()
            },
        };
        let config = sender_config(&nodes(100).sender(Some("tcp/127.0.0.1:1")).unwrap()).unwrap();
        assert_eq!(config.axes.len(), 100);
        assert_eq!(config.transport.listen, ["tcp/127.0.0.1:1"]);
        let text = nodes(100).receiver("tcp/127.0.0.1:1").unwrap();
        let config: ReceiverConfig = parse("receiver", &text).unwrap();
        assert_eq!(config.far_axes().count(), 100);
        assert_eq!(config.real_time.priority, Some(80));
        let bytes = [1, 100].map(|axes| nodes(axes).frame_bytes().unwrap());
        assert!(
            (100..200).contains(&bytes[0]) && (50 * bytes[0]..100 * bytes[0]).contains(&bytes[1]),
            "{bytes:?}"
        );
    }
}
