//! The receiver's config file.

mod marks;
mod slave;

use std::path::Path;

use coaxle_clock::observer::ObserverParameters;
use coaxle_motion::remote::{AxisSyncParameters, FilterMode};
use coaxle_node::Channel;
use coaxle_node::config::{
    ClockConfig, CycleMicros, DelayMicros, LinkConfig, RealTimeConfig, TransportConfig,
};
use coaxle_node::keys::NodeName;
use serde::{Deserialize, Serialize};

pub use marks::{MarksConfig, SpacingSwing, WrongMarks};
pub use slave::{CamSource, CoupleConfig, GearConfig, MOST_SLAVES, SlaveConfig, ToolConfig};

/// A receiver: whose axis it follows, how, and what it drives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct ReceiverConfig {
    /// The node's name.
    pub name: NodeName,
    /// Nominal cycle time, µs.
    pub cycle_time_us: CycleMicros,
    /// The axis it follows.
    pub master: MasterConfig,
    /// How the set values are calculated.
    #[serde(default)]
    pub mode: Mode,
    /// Parameters of the TS5066 blocks.
    #[serde(default)]
    pub sync: AxisSyncParameters,
    /// Parameters of the phase observer.
    #[serde(default)]
    pub observer: ObserverParameters,
    /// The constant part of the delay, in observer mode.
    #[serde(default)]
    pub delay: DelayConfig,
    /// The slaves, 1 to 8.
    #[serde(rename = "slave", default = "one_slave")]
    pub slaves: Vec<SlaveConfig>,
    /// Faults laid over everything that comes from the followed node, and over the questions to it.
    #[serde(default)]
    pub faults: LinkConfig,
    /// Faults laid over the questions instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub question_faults: Option<LinkConfig>,
    /// The node's clock.
    #[serde(default)]
    pub clock: ClockConfig,
    /// Seed of everything random in it.
    #[serde(default)]
    pub seed: u64,
    /// How it reaches the others.
    #[serde(default)]
    pub transport: TransportConfig,
    /// What it asks of its operating system.
    #[serde(default)]
    pub real_time: RealTimeConfig,
}

impl ReceiverConfig {
    /// Whether the node asks the one it follows, to measure the delay.
    #[must_use]
    pub fn asks(&self) -> bool {
        self.mode == Mode::Observer && self.delay == DelayConfig::Measured
    }

    /// Takes the files that the config names by relative paths from `folder`, say the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        for slave in &mut self.slaves {
            slave.relative_to(folder);
        }
    }

    /// The axis id of the n-th slave.
    #[must_use]
    pub fn slave_id(&self, n: usize) -> u32 {
        let counted = (n + 1) as u32;
        self.slaves.get(n).and_then(|s| s.id).unwrap_or(counted)
    }

    /// The number of the slave with an axis id.
    #[must_use]
    pub fn slave_with_id(&self, id: u32) -> Option<usize> {
        (0..self.slaves.len()).find(|n| self.slave_id(*n) == id)
    }

    /// The one gear from the far axis to the n-th slave, if gears alone couple them from the start.
    #[must_use]
    pub fn gear_to(&self, n: usize) -> Option<GearConfig> {
        let mut slave = self.slaves.get(n)?;
        let mut whole = GearConfig::default();
        for _ in 0..self.slaves.len() {
            if slave.couple() != CoupleConfig::Gear || !slave.steps.is_empty() {
                return None;
            }
            whole = GearConfig {
                ratio: whole.ratio * slave.gear.ratio,
                offset: whole.ratio * slave.gear.offset + whole.offset,
            };
            if slave.master.is_empty() {
                return Some(whole);
            }
            let is_master = |other: &&SlaveConfig| other.name.as_str() == slave.master;
            slave = self.slaves.iter().find(is_master)?;
        }
        None
    }

    /// Faults laid over its questions.
    #[must_use]
    pub fn faults_of_questions(&self) -> &LinkConfig {
        self.question_faults.as_ref().unwrap_or(&self.faults)
    }
}

/// The axis to follow.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct MasterConfig {
    /// The node that publishes it.
    pub node: NodeName,
    /// Whether it is one of a sender's axes, or the slave of another receiver.
    #[serde(default)]
    pub channel: MasterChannel,
    /// Its axis id.
    #[serde(default = "first_axis")]
    pub axis: u32,
}

/// Where a master axis is published.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MasterChannel {
    /// A sender's own axes.
    #[default]
    Axes,
    /// A receiver's slaves.
    Slaves,
}

impl From<MasterChannel> for Channel {
    fn from(channel: MasterChannel) -> Self {
        match channel {
            MasterChannel::Axes => Self::Axes,
            MasterChannel::Slaves => Self::Slaves,
        }
    }
}

/// How the set values are calculated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// TS5066's automatic mode: start-up mode, sync mode, fallback.
    Sync,
    /// As received, beats and all.
    Bypass,
    /// Through the PT1 filter.
    Pt1,
    /// Beats are hidden when they happen.
    Time,
    /// By the phase observer: locked within a second whatever the drift. Time mode bridges.
    #[default]
    Observer,
}

/// Where the constant part of the delay comes from, in observer mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DelayConfig {
    /// The followed node is asked: the set values are those that the master has at the same moment.
    #[default]
    Measured,
    /// It is this much, µs.
    FixedUs(DelayMicros),
    /// Nothing is done about it, as in TS5066.
    Off,
}

impl Mode {
    /// The mode's name in config, status and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sync => "sync",
            Self::Bypass => "bypass",
            Self::Pt1 => "pt1",
            Self::Time => "time",
            Self::Observer => "observer",
        }
    }

    /// Whether the mode ever synchronises.
    #[must_use]
    pub const fn synchronises(self) -> bool {
        matches!(self, Self::Sync | Self::Observer)
    }
}

impl From<Mode> for FilterMode {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Sync => Self::Auto,
            Mode::Bypass => Self::Bypass,
            Mode::Pt1 => Self::Pt1,
            Mode::Time => Self::Time,
            Mode::Observer => Self::Observer,
        }
    }
}

fn one_slave() -> Vec<SlaveConfig> {
    vec![SlaveConfig::default()]
}

const fn first_axis() -> u32 {
    1
}
