//! The timing channel: beacons apart from the transport.

use std::net::SocketAddr;

use coaxle_clock::Span;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checked::BeaconsPerSecond;
use super::clock::ClockConfig;
use super::common_time::{CommonTimeConfig, CommonTimeFaults};
use super::link::LinkConfig;

/// Timing server of a node, which responds to the beacons of its followers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct TimingServerConfig {
    /// The UDP address and port to listen on, such as `0.0.0.0:7450`.
    #[schemars(with = "String")]
    pub listen: SocketAddr,
}

/// The timing channel to a node that is followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct TimingLinkConfig {
    /// Timing server of that node: its UDP address and port, such as `192.168.1.10:7450`.
    #[schemars(with = "String")]
    pub connect: SocketAddr,
    /// Beacons a second. 50 by default.
    #[serde(default)]
    pub per_s: BeaconsPerSecond,
    /// Faults applied to the beacons, in both directions.
    // Not written where nothing is injected, so that a config of a machine has no field of the lab.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("x-lab" = "[[lab.far]] with its node and timing-faults = {}"))]
    pub faults: LinkConfig,
}

fn is_default(faults: &LinkConfig) -> bool {
    *faults == LinkConfig::default()
}

impl TimingLinkConfig {
    /// Interval between beacons.
    #[must_use]
    pub fn interval(&self) -> Span {
        // 1 to 200 a second, so that the interval is 5 ms to a second.
        Span::from_secs_f64(1.0 / self.per_s.get())
    }
}

impl Default for BeaconsPerSecond {
    fn default() -> Self {
        Self::USUAL
    }
}

/// The addresses of a node's timing channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimingEndpoints {
    /// Address on which it responds to beacons.
    pub listen: Option<SocketAddr>,
    /// Addresses of the timing servers that it sends beacons to, each with the number of the node
    /// among all that it receives from.
    pub nodes: Vec<(usize, SocketAddr)>,
    /// Time in common with other nodes, read with each beacon.
    pub common_time: Option<CommonTimeSetup>,
}

/// A common time, and what is injected into it.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonTimeSetup {
    /// The time.
    pub config: CommonTimeConfig,
    /// Faults injected into it.
    pub faults: CommonTimeFaults,
}

impl CommonTimeSetup {
    /// Makes the set-up of a node with this config and this clock, if it has such a time.
    #[must_use]
    pub fn of(config: Option<&CommonTimeConfig>, clock: &ClockConfig) -> Option<Self> {
        config.map(|config| Self {
            config: config.clone(),
            faults: clock.common_time.clone(),
        })
    }
}

impl TimingEndpoints {
    /// True if there is no timing channel.
    #[must_use]
    pub const fn is_none(&self) -> bool {
        self.listen.is_none() && self.nodes.is_empty()
    }
}
