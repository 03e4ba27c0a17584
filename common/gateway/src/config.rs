//! Config file of a gateway.
//!
//! ```
//! use coaxle_gateway::config::GatewayConfig;
//! use coaxle_node::lab::NodeFile;
//!
//! let config: GatewayConfig = NodeFile::parse_machine(
//!     "press.toml",
//!     r#"
//!     name = "press"
//!     cycle-time-us = 1000
//!
//!     [ads]
//!     address = "192.168.1.20"
//!     net-id = "5.12.34.56.1.1"
//!     cycle-index = "GVL_Coaxle.nCycleIndex"
//!
//!     [[axis]]
//!     id = 1
//!     name = "conveyor"
//!     symbol = "GVL_Coaxle.stConveyor"
//!     "#,
//! )?;
//! config.check()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::num::NonZeroU32;

use coaxle_axis::ImageLayout;
use coaxle_clock::{CycleTime, Span};
use coaxle_node::config::{ClockConfig, CycleMicros, RealTimeConfig, TransportConfig, Unit, Wrong};
use coaxle_node::frame::MAX_AXES;
use coaxle_node::keys::NodeName;
use coaxle_node::signal::{Instance, trace_columns};
use coaxle_node::wiring::{Publication, Subscription, Wiring};
use coaxle_node::{Channel, Intake};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::signals::{GatewaySignals, PlcAxisSignals};
pub use address::{HostPort, NetId};
pub use lab::GatewayLab;

mod address;
mod check;
mod lab;
mod outputs;
mod plant;

/// A gateway: one PLC, the connection to it, its axes, and its outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct GatewayConfig {
    /// The node's name, part of its key expressions.
    pub name: NodeName,
    /// The cycle time of the PLC task that counts the cycle index, µs of its clock.
    pub cycle_time_us: CycleMicros,
    /// Layout of the images of the PLC's axes.
    #[serde(default)]
    pub layout: Layout,
    /// Faults of the gateway's own clock, injected on purpose. None by default.
    #[serde(default)]
    #[schemars(extend("x-lab" = "lab.clock = {}"))]
    pub clock: ClockConfig,
    /// Transport to the other nodes.
    #[serde(default)]
    pub transport: TransportConfig,
    /// Requirements on its operating system.
    #[serde(default)]
    pub real_time: RealTimeConfig,
    /// The PLC is reached by ADS.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ads: Option<AdsConfig>,
    /// Or by UDP datagrams.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub udp: Option<UdpConfig>,
    /// Or by standard input and output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pipe: Option<PipeConfig>,
    /// Axes of the PLC, which are published: up to 128. None by default.
    #[serde(rename = "axis", default, skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<PlcAxisConfig>,
    /// Axes for the PLC, each entry of one node and channel: any number by ADS, otherwise one, since a
    /// record has one cycle index. None by default.
    #[serde(
        rename = "output",
        default,
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "outputs::deserialize"
    )]
    pub outputs: Vec<OutputConfig>,
}

/// An ADS server, say the router of a TwinCAT PLC.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct AdsConfig {
    /// Address: a host, or host:port. The port is 48898 by default.
    pub address: HostPort,
    /// The AMS net id of the PLC.
    pub net_id: NetId,
    /// The AMS port of the PLC: 851 by default, the first one of TwinCAT 3; 801 is that of TwinCAT 2.
    #[serde(default = "twincat_3")]
    pub port: u16,
    /// The AMS net id of this PC in the route of the PLC. Its IP address with .1.1 behind it by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_net_id: Option<NetId>,
    /// The symbol of the cycle index, a UINT or WORD. Required for axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_index: Option<String>,
    /// Method of reading axes.
    #[serde(default)]
    pub read: ReadMode,
    /// Mean time between two polls, µs: 100 to 100000. Half of the cycle time by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poll_us: Option<CycleMicros>,
}

/// Method of reading axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReadMode {
    /// The gateway polls the index, and reads the axes whenever it is new.
    #[default]
    Polling,
    /// The PLC sends index and axes each cycle.
    Notifications,
}

/// Datagrams of the cycle index and the images.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct UdpConfig {
    /// Address for datagrams of the PLC, address:port of this PC. Required for axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub listen: Option<HostPort>,
    /// Address for datagrams to the PLC, host:port. Required for an output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub send_to: Option<HostPort>,
}

/// Records on standard input and output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PipeConfig {
    /// Format of the records.
    #[serde(default)]
    pub format: PipeFormat,
}

/// Format of records on a pipe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PipeFormat {
    /// A line each: the cycle index, then position, velocity and acceleration of each axis.
    #[default]
    Csv,
    /// As in datagrams: the cycle index as two bytes, then the images.
    Binary,
}

/// An axis of the PLC.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PlcAxisConfig {
    /// Axis id by which receivers select it, unique. The id in the image is not used.
    pub id: NonZeroU32,
    /// Name for people and for columns: a name like a node's.
    pub name: NodeName,
    /// Unit of its positions.
    #[serde(default)]
    pub unit: Unit,
    /// By ADS: the symbol of its structure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub symbol: Option<String>,
}

/// An output to a PLC: axes of one node, of the same cycle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct OutputConfig {
    /// The node that publishes them.
    pub node: NodeName,
    /// Channel of the node with the axes.
    #[serde(default)]
    pub channel: OutputChannel,
    /// By ADS: the symbol for the receiver's cycle index, a UINT or WORD. It is written last. Not written
    /// by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_index: Option<String>,
    /// The axes: 1 to 128.
    #[serde(rename = "axis")]
    pub axes: Vec<OutputAxisConfig>,
}

/// Axes of a node for a PLC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OutputChannel {
    /// The axes that a receiver follows, as corrected: requires `publish-far-axes` in its config.
    #[default]
    FarAxes,
    /// A receiver's slaves.
    Slaves,
    /// A sender's own axes, uncorrected.
    Axes,
}

/// An axis that a PLC gets.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct OutputAxisConfig {
    /// Id in the frames of the node, unique.
    pub id: NonZeroU32,
    /// By ADS: the symbol to write.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub symbol: Option<String>,
    /// Image of the axis.
    #[serde(default)]
    pub image: ImageKind,
}

/// Image of an axis for a PLC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ImageKind {
    /// The 128 bytes of its structure.
    #[default]
    NcToPlc,
    /// Position, velocity, acceleration and direction for `MC_ExtSetPointGenFeed`: 28 bytes.
    ExternalSetValues,
}

/// Layout of the 128 bytes of an axis structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// `AXIS_REF.NcToPlc`, `NCTOPLC_AXIS_REF`: with control loops, target position and command.
    #[default]
    AxisRef,
    /// `NCTOPLC_AXLESTRUCT` of TwinCAT 2 and TS5066: those bytes are reserved.
    Axlestruct,
}

impl From<Layout> for ImageLayout {
    fn from(layout: Layout) -> Self {
        match layout {
            Layout::AxisRef => Self::AxisRef,
            Layout::Axlestruct => Self::TwinCat2,
        }
    }
}

impl From<OutputChannel> for Channel {
    fn from(channel: OutputChannel) -> Self {
        match channel {
            OutputChannel::FarAxes => Self::FarAxes,
            OutputChannel::Slaves => Self::Slaves,
            OutputChannel::Axes => Self::Axes,
        }
    }
}

const fn twincat_3() -> u16 {
    851
}

impl GatewayConfig {
    /// Checks that its fields fit each other.
    ///
    /// # Errors
    /// [`Wrong`] with the field.
    pub fn check(&self) -> Result<(), Wrong> {
        check::check(self)
    }

    /// Returns the cycle time of the gateway itself, for the PLC's samples and everything else: half the
    /// cycle time of the PLC.
    #[must_use]
    pub fn scan_time(&self) -> CycleTime {
        // Twice as fast as the PLC, so that no cycle waits for longer than half of one.
        let half = self.cycle_time_us.0.span() / 2;
        // A PLC of 100 µs would ask for 50 µs, below the shortest cycle of a node.
        let within = half.clamp(CycleTime::MIN, CycleTime::MAX);
        CycleTime::new(within).unwrap_or(self.cycle_time_us.0)
    }

    /// Returns the mean time between two polls.
    #[must_use]
    pub fn poll_period(&self) -> Span {
        let own = self.ads.as_ref().and_then(|ads| ads.poll_us);
        // Pauses go up to one and a half of it, three quarters of a cycle: each cycle is polled.
        own.map_or(self.cycle_time_us.0.span() / 2, |own| own.0.span())
    }

    /// Returns the axes that the PLC gets, of all outputs.
    pub fn output_axes(&self) -> impl Iterator<Item = &OutputAxisConfig> + Clone {
        self.outputs.iter().flat_map(|output| &output.axes)
    }

    /// Returns the names of these axes in the head line of a pipe: node and id.
    #[must_use]
    pub fn output_names(&self) -> Vec<String> {
        let names = |output: &OutputConfig| {
            let ids = output.ids().into_iter();
            ids.map(|id| format!("{}.{id}", output.node))
                .collect::<Vec<_>>()
        };
        self.outputs.iter().flat_map(names).collect()
    }

    /// Publications and subscriptions: time requests are the first subscription, axes for the PLC follow,
    /// in the order of the outputs.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        // The node numbers subscriptions by their place: outputs begin at 1.
        let mut subscriptions = vec![Subscription::time_requests_to(&self.name)];
        subscriptions.extend(self.outputs.iter().map(OutputConfig::subscription));
        Wiring {
            node: self.name.clone(),
            // Axes, and the PLC's time for receivers that ask.
            publications: [Channel::Axes, Channel::TimeResponses]
                .map(|channel| Publication::new(&self.name, channel))
                .into(),
            subscriptions,
        }
    }

    /// Returns the instances with signals, in the order of a row.
    #[must_use]
    pub fn instances(&self) -> Vec<Instance> {
        let node = std::iter::once(Instance::of::<GatewaySignals>(""));
        let axis = |axis: &PlcAxisConfig| {
            Instance::of::<PlcAxisSignals>(axis.name.as_str()).in_unit(axis.unit.clone())
        };
        node.chain(self.axes.iter().map(axis)).collect()
    }

    /// Returns the columns of a trace.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        trace_columns(&self.instances())
    }
}

impl OutputConfig {
    /// Returns the ids of its axes.
    #[must_use]
    pub fn ids(&self) -> Vec<u32> {
        self.axes.iter().map(|axis| axis.id.get()).collect()
    }

    fn subscription(&self) -> Subscription {
        let channel = Channel::from(self.channel);
        let intake = Intake::new(&self.node.channel_key(channel), &self.node, &self.ids());
        Subscription {
            node: self.node.clone(),
            channel,
            reader: intake.into(),
            // The `[lab]` of a gateway has faults of its clock only.
            faults: coaxle_node::config::LinkConfig::default(),
            far: 0,
        }
    }
}

/// Axes that one frame holds.
const MOST_AXES: usize = MAX_AXES;

#[cfg(test)]
mod tests;
