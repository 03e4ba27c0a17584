//! `[[far]]`: a followed node, its axes, and the way they are followed.

use std::path::Path;

use coaxle_axis::Modulo;
use coaxle_clock::delay::Asymmetry;
use coaxle_clock::far_clock::DelaySource;
use coaxle_clock::observer::ObserverParameters;
use coaxle_node::Channel;
use coaxle_node::command::FarRefusal;
use coaxle_node::config::{
    DelayMicros, FaultMicros, LinkConfig, Positive, TimingLinkConfig, Unit, Wrong,
};
use coaxle_node::faults::check_link;
use coaxle_node::keys::NodeName;
use coaxle_remote::{AxisSyncParameters, FilterMode};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use super::axes::{AxisList, FarAxisConfig};
use super::lag::Lag;

/// A followed node. Its clock is estimated once, for all of its axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct FarConfig {
    /// The node that publishes the axes.
    pub node: NodeName,
    /// Channel of the axes: a sender's axes, the slaves of another receiver, or the far axes that
    /// it corrects.
    #[serde(default)]
    pub channel: FarChannel,
    /// Nodes with the same axes, of which the first one received takes over when this one falls silent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub standby: Vec<NodeName>,
    /// Silence of the followed node before a standby takes over, ms: half of the age limit by
    /// default, or 100 ms without one. At least four of its cycles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub take_over_after_ms: Option<Positive>,
    /// Followed axes: ids, ranges of ids, or ids with names of their own here. The axis 1 by default.
    #[serde(default)]
    pub axes: AxisList,
    /// Unit of the positions, where an axis has no unit of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Length of the modulo periods, u, where an axis has none of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modulo: Option<Modulo>,
    /// Calculation of the set values.
    #[serde(default = "observer")]
    pub mode: FilterMode,
    /// Instant that is shown: `auto`, as much later as its frames say, or `now`. `auto` by default.
    #[serde(default)]
    pub present: Present,
    /// Lag of axes that are shown later: `full`, `auto`, or ms. The slaves are held back by the rest. `full` by default.
    #[serde(default)]
    pub lag_ms: Lag,
    /// Parameters of the TS5066 blocks.
    #[serde(default)]
    pub sync: AxisSyncParameters,
    /// Parameters of the phase observer.
    #[serde(default)]
    pub observer: ObserverParameters,
    /// The constant part of the delay, in observer mode.
    #[serde(default = "measured", deserialize_with = "delay_in_range")]
    pub delay: DelaySource,
    /// Asymmetry of the paths to it and from it, for a measured delay: no exchange can show it.
    /// Unknown by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asymmetry: Option<AsymmetryConfig>,
    /// The timing channel to it, apart from the transport: for a measured delay, in observer mode.
    /// None by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<TimingLinkConfig>,
    /// Faults applied to all messages from the node, and to the time requests to it.
    #[serde(default)]
    #[schemars(extend("x-lab" = "[[lab.far]] with its node and faults = {}"))]
    pub faults: LinkConfig,
    /// Faults applied to the time requests instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-lab" = "[[lab.far]] with its node and request-faults = {}"))]
    pub request_faults: Option<LinkConfig>,
}

impl FarConfig {
    /// Resolves the relative paths of its faults' files from `folder`.
    pub(super) fn relative_to(&mut self, folder: &Path) {
        self.faults.relative_to(folder);
        if let Some(faults) = &mut self.request_faults {
            faults.relative_to(folder);
        }
        if let Some(timing) = &mut self.timing {
            timing.faults.relative_to(folder);
        }
    }

    /// Checks the files that its faults name.
    pub(super) fn check_files(&self) -> Result<(), Wrong> {
        check_link(&self.faults).map_err(|wrong| wrong.within("faults"))?;
        let mut requests = self.request_faults.iter();
        let requests = requests.try_for_each(check_link);
        requests.map_err(|wrong| wrong.within("request-faults"))?;
        let mut beacons = self.timing.iter();
        let beacons = beacons.try_for_each(|timing| check_link(&timing.faults));
        beacons.map_err(|wrong| wrong.within("timing.faults"))
    }

    /// The node itself, then its standbys.
    pub fn nodes(&self) -> impl Iterator<Item = &NodeName> {
        std::iter::once(&self.node).chain(&self.standby)
    }

    /// Faults applied to the time requests to it.
    #[must_use]
    pub fn faults_of_requests(&self) -> &LinkConfig {
        // Both directions of a link are alike unless stated otherwise.
        self.request_faults.as_ref().unwrap_or(&self.faults)
    }

    /// True if plans of its axes can be used: only senders publish them. In any mode, as an order may change it to that of
    /// the observer, which knows the instants that they are for.
    #[must_use]
    pub fn uses_plans(&self) -> bool {
        let has_use = self.axes.iter().any(FarAxisConfig::uses_plans);
        has_use && self.channel == FarChannel::Axes
    }

    /// Name of one of its axes among the masters of slaves: its own name, or node and id.
    #[must_use]
    pub fn axis_name(&self, axis: &FarAxisConfig) -> String {
        match &axis.name {
            Some(name) => name.to_string(),
            None => self.full_name(axis.id),
        }
    }

    /// Node and id, which is always accepted.
    pub(super) fn full_name(&self, id: u32) -> String {
        format!("{}.{id}", self.node)
    }
}

/// Instant of a far node's axes that is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Present {
    /// As much later as its frames say; now, where they say nothing.
    #[default]
    Auto,
    /// The newest values moved to now.
    Now,
}

/// Channel on which far axes are published.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FarChannel {
    /// A sender's own axes.
    #[default]
    Axes,
    /// A receiver's slaves.
    Slaves,
    /// The corrected axes that a receiver follows.
    FarAxes,
}

impl From<FarChannel> for Channel {
    fn from(channel: FarChannel) -> Self {
        match channel {
            FarChannel::Axes => Self::Axes,
            FarChannel::Slaves => Self::Slaves,
            FarChannel::FarAxes => Self::FarAxes,
        }
    }
}

/// Asymmetry of the paths to a node and from it, as measured by other means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct AsymmetryConfig {
    /// Longer path delay of its messages compared with the requests to it, µs; negative: shorter.
    pub longer_us: DelayMicros,
    /// Greatest error of this value, µs, in both directions.
    pub within_us: FaultMicros,
}

impl From<AsymmetryConfig> for Asymmetry {
    fn from(stated: AsymmetryConfig) -> Self {
        Self {
            // In the direction of the frames: positive where they take longer than the requests.
            longer: stated.longer_us.span(),
            within: coaxle_clock::Span::from_micros_f64(stated.within_us.get()),
        }
    }
}

/// Reads a delay whose fixed value is one that an order may set, too.
pub(super) fn delay_in_range<'de, D: Deserializer<'de>>(file: D) -> Result<DelaySource, D::Error> {
    match DelaySource::deserialize(file)? {
        // Checked while reading, so that the error has the line of the field.
        delay @ DelaySource::Fixed(fixed) if !delay.is_in_range() => {
            let received = fixed.as_micros_f64();
            let wrong = Wrong::of("fixed-us", received, FarRefusal::DELAYS);
            Err(D::Error::custom(wrong))
        }
        delay => Ok(delay),
    }
}

/// Default of `delay`.
const fn measured() -> DelaySource {
    DelaySource::Measured
}

/// Default of `mode`: every drift from the first second on, where the blocks of TS5066 first have to meet beats.
const fn observer() -> FilterMode {
    FilterMode::Observer
}
