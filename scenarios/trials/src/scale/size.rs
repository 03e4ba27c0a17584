//! Sizes to measure: numbers of nodes and axes.

use std::fmt::Write as _;
use std::str::FromStr;

use anyhow::Context;
use clap::ValueEnum;
use coaxle_node::config::parse;
use coaxle_receiver::ReceiverConfig;
use coaxle_sender::config::SenderConfig;
use serde::{Deserialize, Serialize};

/// The growing quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SizeSeries {
    /// Receivers of one sender: one axis, a slave in each receiver
    Receivers,
    /// Senders of one receiver: an axis each, a slave for each of them
    Senders,
    /// Axes and slaves, at most 125 in a node: a receiver for each sender
    Axes,
}

/// A size of a series, as `receivers:64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Size {
    pub(crate) series: SizeSeries,
    pub(crate) count: usize,
}

/// Axes and slaves of a node: 1000 in eight of them. A frame holds 128.
const AXES_OF_A_NODE: usize = 125;

/// Largest size.
// Ten times the largest size of a series.
const MOST: usize = 10_000;

impl SizeSeries {
    pub(crate) const ALL: [Self; 3] = [Self::Receivers, Self::Senders, Self::Axes];

    /// The sizes that are measured.
    pub(crate) fn sizes(self) -> impl Iterator<Item = Size> {
        // Doubled, or about three times as many each: equal distances on the logarithmic axis of the plot.
        let counts: &[usize] = match self {
            Self::Receivers | Self::Senders => &[1, 2, 4, 8, 16, 32, 64],
            Self::Axes => &[1, 10, 30, 100, 300, 1000],
        };
        counts.iter().map(move |&count| Size {
            series: self,
            count,
        })
    }

    /// Returns the name on the command line.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Receivers => "receivers",
            Self::Senders => "senders",
            Self::Axes => "axes",
        }
    }
}

impl Size {
    /// Number of axes of each sender.
    pub(crate) fn axes_of_senders(self) -> Vec<usize> {
        match self.series {
            SizeSeries::Receivers => vec![1],
            SizeSeries::Senders => vec![1; self.count],
            SizeSeries::Axes => {
                // At least one, as the split below divides by it.
                let nodes = self.count.div_ceil(AXES_OF_A_NODE).max(1);
                // As even as they can be.
                let of = |node| (self.count * (node + 1)) / nodes - (self.count * node) / nodes;
                (0..nodes).map(of).collect()
            }
        }
    }

    /// The senders that each receiver follows.
    fn followed(self) -> Vec<std::ops::Range<usize>> {
        match self.series {
            SizeSeries::Receivers => vec![0..1; self.count],
            SizeSeries::Senders => vec![0..self.count; 1],
            SizeSeries::Axes => (0..self.axes_of_senders().len())
                .map(|n| n..n + 1)
                .collect(),
        }
    }

    pub(crate) fn receivers(self) -> usize {
        self.followed().len()
    }

    /// Far axes of all receivers, which is also the number of slaves.
    pub(crate) fn axes(self) -> usize {
        let axes = self.axes_of_senders();
        let followed = self.followed().into_iter().flatten();
        followed.map(|sender| axes[sender]).sum()
    }

    /// # Errors
    /// The size makes no valid config.
    pub(crate) fn senders(self) -> anyhow::Result<Vec<SenderConfig>> {
        let axes = self.axes_of_senders().into_iter().enumerate();
        axes.map(|(n, axes)| Ok(parse("sender", &sender(n, axes))?))
            .collect()
    }

    /// # Errors
    /// The size makes no valid config.
    pub(crate) fn receiver_configs(self) -> anyhow::Result<Vec<ReceiverConfig>> {
        let axes = self.axes_of_senders();
        let followed = self.followed().into_iter().enumerate();
        followed
            .map(|(n, senders)| Ok(parse("receiver", &receiver(n, senders, &axes))?))
            .collect()
    }
}

fn sender(number: usize, axes: usize) -> String {
    let mut text = format!("name = 's{number}'\ncycle-time-us = 1000\n");
    for axis in 1..=axes {
        let _ = write!(
            text,
            "[[axis]]\nid = {axis}\nname = 'a{axis}'\n[axis.program]\nstart-velocity = {}\n\
             limits = {{ velocity = 1000, acceleration = 5000, jerk = 100000 }}\n",
            100 + axis
        );
    }
    text
}

fn receiver(number: usize, senders: std::ops::Range<usize>, axes: &[usize]) -> String {
    let mut text = format!("name = 'r{number}'\ncycle-time-us = 1000\n");
    for sender in senders.clone() {
        let _ = writeln!(
            text,
            "[[far]]\nnode = 's{sender}'\naxes = ['1-{}']",
            axes[sender]
        );
    }
    for sender in senders {
        for axis in 1..=axes[sender] {
            let _ = writeln!(
                text,
                "[[slave]]\nname = 'x{sender}-{axis}'\nmaster = 's{sender}.{axis}'\n\
                 limits = {{ velocity = 3000, acceleration = 100000, jerk = 1e7, on-master-loss = 'follow' }}"
            );
        }
    }
    text
}

impl FromStr for Size {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let read = || {
            let (series, count) = text.split_once(':')?;
            let series = SizeSeries::ALL
                .into_iter()
                .find(|one| one.name() == series)?;
            let count = count.parse().ok().filter(|n| (1..=MOST).contains(n))?;
            Some(Self { series, count })
        };
        read().with_context(|| format!("received {text:?}, expected a size such as receivers:64"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_has_as_many_nodes_and_axes_as_it_says() {
        for (text, senders, receivers, axes) in [
            ("receivers:64", 1, 64, 64),
            ("senders:64", 64, 1, 64),
            ("axes:1", 1, 1, 1),
            ("axes:125", 1, 1, 125),
            ("axes:300", 3, 3, 300),
            ("axes:1000", 8, 8, 1000),
        ] {
            let size: Size = text.parse().unwrap();
            let configs = size.senders().unwrap();
            assert_eq!(configs.len(), senders, "{text}");
            let followers = size.receiver_configs().unwrap();
            assert_eq!(followers.len(), receivers, "{text}");
            let slaves: usize = followers.iter().map(|one| one.slaves.len()).sum();
            assert_eq!((size.axes(), slaves), (axes, axes), "{text}");
            assert!(configs.iter().all(|one| one.axes.len() <= 125));
        }
        for text in ["receivers", "axes:0", "slaves:1", "axes:10001"] {
            let error = text.parse::<Size>().unwrap_err().to_string();
            assert!(error.contains("expected a size such as"), "{error}");
        }
    }
}
