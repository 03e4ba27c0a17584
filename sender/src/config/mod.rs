//! The sender's config file.
//!
//! ```
//! use coaxle_node::lab::NodeFile;
//! use coaxle_sender::config::SenderConfig;
//!
//! let config: SenderConfig = NodeFile::parse_machine(
//!     "sender.toml",
//!     r#"
//!     name = "infeed"
//!     cycle-time-us = 1000
//!
//!     [[axis]]
//!     id = 1
//!     name = "conveyor"
//!
//!     [axis.program]
//!     start-velocity = 500.0
//!     limits = { velocity = 1000.0, acceleration = 5000.0, jerk = 50000.0 }
//!     "#,
//! )?;
//! assert_eq!(config.axes[0].id.get(), 1);
//! # Ok::<(), coaxle_node::config::ConfigError>(())
//! ```

mod lab;
mod plant;
mod shown;

use std::ops::Deref;
use std::path::Path;

use coaxle_clock::Span;
use coaxle_node::config::{
    ClockConfig, CommonTimeConfig, CommonTimeSetup, CycleMicros, LinkConfig, PresentAfterChoice,
    PresentAfterRange, RealTimeConfig, TimingEndpoints, TimingServerConfig, TransportConfig, Wrong,
};
use coaxle_node::faults::check_clock;
use coaxle_node::frame::MAX_AXES;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{Publication, Subscription, Wiring};
use coaxle_node::{Channel, ReportIntake};
use coaxle_source::config::AxisConfig;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use lab::SenderLab;
pub use shown::{SHOWN_BY_DEFAULT, ShownAxes};

/// A sender: its name, its clock and its axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct SenderConfig {
    /// The node's name, part of its key expressions.
    pub name: NodeName,
    /// Publishing interval, µs of its own clock.
    pub cycle_time_us: CycleMicros,
    /// Send stamps in the frames: the delay of their departure. On by default.
    #[serde(default = "on")]
    pub send_stamps: bool,
    /// Seed of the randomness in its clock. 0 by default.
    #[serde(default)]
    #[schemars(extend("x-lab" = "lab.seed = {}"))]
    pub seed: u64,
    /// Injected clock faults. None by default.
    #[serde(default)]
    #[schemars(extend("x-lab" = "lab.clock = {}"))]
    pub clock: ClockConfig,
    /// Connection to other nodes.
    #[serde(default)]
    pub transport: TransportConfig,
    /// The timing channel, apart from the transport, for receivers that have one to it. None by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<TimingServerConfig>,
    /// Time that this PC has in common with others, stated in the responses of the timing channel. None by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<CommonTimeConfig>,
    /// Settings requested from the operating system.
    #[serde(default)]
    pub real_time: RealTimeConfig,
    /// The axes that its snapshots, status and trace show: up to 4 ids. The first ones by id by
    /// default.
    #[serde(default, skip_serializing_if = "ShownAxes::is_default")]
    pub show_axes: ShownAxes,
    /// Axes of the sender.
    #[serde(rename = "axis")]
    pub axes: AxisList,
}

impl SenderConfig {
    /// Resolves the relative paths of the config's files from `folder`, for example the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        for axis in &mut self.axes.0 {
            axis.relative_to(folder);
        }
        self.clock.relative_to(folder);
    }

    /// Checks the files that its clock names, as at its start.
    ///
    /// # Errors
    /// [`Wrong`] names the field and the file.
    pub fn check_files(&self) -> Result<(), Wrong> {
        check_clock(&self.clock).map_err(|wrong| wrong.within("clock"))
    }

    /// Publications and subscriptions of the node.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        // Time requests are subscribed to even without receivers that measure: whether any will is not known.
        let wiring = Wiring {
            node: self.name.clone(),
            publications: [Channel::Axes, Channel::TimeResponses]
                .into_iter()
                .chain(self.axes.plans().then_some(Channel::Plans))
                .map(|channel| Publication::new(&self.name, channel))
                .collect(),
            subscriptions: vec![Subscription::time_requests_to(&self.name)],
        };
        let mut wiring = match &self.timing {
            Some(_) => wiring.with_timing_server(),
            None => wiring,
        };
        // After all others, whose numbers they leave as they are.
        let followers = self.followers().into_iter().enumerate();
        let reports = followers.map(|(far, follower)| Subscription {
            channel: Channel::Followers,
            reader: ReportIntake::new(&follower, &self.name).into(),
            faults: LinkConfig::default(),
            node: follower,
            far,
        });
        wiring.subscriptions.extend(reports);
        wiring
    }

    /// Followers of all axes, each once, in the order of the config.
    #[must_use]
    pub fn followers(&self) -> Vec<NodeName> {
        let of_axes = self.axes.iter().filter_map(|axis| axis.followers.as_ref());
        let mut followers: Vec<NodeName> = Vec::new();
        for node in of_axes.flat_map(|followers| &followers.nodes) {
            if !followers.contains(node) {
                followers.push(node.clone());
            }
        }
        followers
    }

    /// Address on which it responds to beacons.
    #[must_use]
    pub fn timing_endpoints(&self) -> TimingEndpoints {
        TimingEndpoints {
            listen: self.timing.as_ref().map(|timing| timing.listen),
            nodes: Vec::new(),
            common_time: CommonTimeSetup::of(self.time.as_ref(), &self.clock),
        }
    }
}

const fn on() -> bool {
    true
}

/// 1 to 128 axes, each with an id of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<AxisConfig>")]
#[schemars(inline, extend("minItems" = 1, "maxItems" = MAX_AXES))]
pub struct AxisList(Vec<AxisConfig>);

impl AxisList {
    /// # Errors
    /// [`Wrong`] if there are none or too many, or for a duplicate id.
    pub fn new(axes: Vec<AxisConfig>) -> Result<Self, Wrong> {
        if !(1..=MAX_AXES).contains(&axes.len()) {
            let received = format!("{} axes", axes.len());
            return Err(Wrong::value(received, format_args!("1 to {MAX_AXES}")));
        }
        // Sorted, duplicates are neighbours: one pass finds them.
        let mut ids: Vec<u32> = axes.iter().map(|axis| axis.id.get()).collect();
        ids.sort_unstable();
        if let Some(pair) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
            let received = format!("id {} twice", pair[0]);
            return Err(Wrong::value(received, "an id of its own for each axis"));
        }
        check_presentation(&axes)?;
        Ok(Self(axes))
    }

    /// True if the motion of any of them is planned ahead.
    #[must_use]
    pub fn plans(&self) -> bool {
        self.0.iter().any(|axis| axis.lead() > Span::ZERO)
    }

    /// Delays by which its frames may be shown later.
    #[must_use]
    pub fn present_after(&self) -> Option<PresentAfterRange> {
        // One for all axes.
        self.0.first()?.present_after()
    }
}

/// Checks that the axes are shown at one instant: a frame is shown as a whole. So an axis that is only measured or
/// replayed is never shown later by accident.
fn check_presentation(axes: &[AxisConfig]) -> Result<(), Wrong> {
    let range_of = |axis: &AxisConfig| (axis.present_after_ms, axis.present_after_limits);
    let differs = |axis: &&AxisConfig| range_of(axis) != range_of(&axes[0]);
    let named = |axis: &AxisConfig| {
        let time = match axis.present_after_ms {
            None => "none".to_owned(),
            Some(PresentAfterChoice::Fixed(time)) => format!("{} ms", time.get()),
            Some(PresentAfterChoice::Auto) => "\"auto\" with its limits".to_owned(),
        };
        format!("{time} for {:?}", axis.name)
    };
    if let Some((n, other)) = (0..).zip(axes).find(|(_, axis)| differs(axis)) {
        let received = format!("{} and {}", named(&axes[0]), named(other));
        let expected = "one for all axes of a sender, stated at each: its frames are shown as a whole; \
                        or another sender for the other axes";
        return Err(Wrong::of("present-after-ms", received, expected).within(format_args!("[{n}]")));
    }
    let has_followers = axes.iter().any(|axis| axis.followers.is_some());
    if axes[0].present_after_ms == Some(PresentAfterChoice::Auto) && !has_followers {
        let expected = "a time, or an axis with followers = { nodes = [...] }: these decide it";
        return Err(Wrong::of("present-after-ms", "\"auto\"", expected).within("[0]"));
    }
    Ok(())
}

impl Deref for AxisList {
    type Target = [AxisConfig];
    fn deref(&self) -> &[AxisConfig] {
        &self.0
    }
}

impl TryFrom<Vec<AxisConfig>> for AxisList {
    type Error = Wrong;
    fn try_from(axes: Vec<AxisConfig>) -> Result<Self, Wrong> {
        Self::new(axes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;
    use coaxle_source::config::SourceConfig;

    const HEAD: &str = "name = 'a'\ncycle-time-us = 1000\n";
    const CONVEYOR: &str = "name = 'x'\nprogram = { start-velocity = 5.0, \
                            limits = { velocity = 10, acceleration = 10, jerk = 10 } }\n";

    fn axis(id: u32) -> String {
        format!("[[axis]]\nid = {id}\n{CONVEYOR}")
    }

    fn read(axes: &str) -> Result<SenderConfig, String> {
        parse("s.toml", &format!("{HEAD}{axes}")).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_left_out_has_its_default() {
        let config = read(&axis(1)).unwrap();
        assert!(config.send_stamps);
        assert_eq!(config.seed, 0);
        assert_eq!(config.clock, ClockConfig::default());
        assert_eq!(config.transport, TransportConfig::default());
        assert_eq!(config.real_time, RealTimeConfig::default());
        assert_eq!(config.show_axes, ShownAxes::default());
    }

    #[test]
    fn a_config_survives_being_written_and_read() {
        let axes = "
            [[axis]]
            id = 7
            name = 'table'
            modulo = 360.0
            [axis.encoder]
            resolution = 0.01
            differentiate-acceleration = true
            [axis.encoder.program]
            limits = { velocity = 10, acceleration = 20, deceleration = 30, jerk = 40 }
            repeat = 3
            steps = [
                { enable = true },
                { loop = { count = 2, steps = [{ move-relative = { distance = 1.0 } }] } },
                { velocity = { value = -3.0, for-s = 0.5 } },
                { halt = {} },
                { dwell = { for-s = 1.0 } },
                { move-absolute = { position = 0.0, velocity = 5.0 } },
            ]
            [[axis]]
            id = 8
            name = 'taught'
            replay = { file = 'taught.csv', repeat = true, interpolation = 'linear' }
        ";
        let config = read(&format!("show-axes = [8, 7]\n{axes}")).unwrap();
        let text = toml::to_string(&config).unwrap();
        assert_eq!(parse::<SenderConfig>("again.toml", &text).unwrap(), config);
    }

    #[test]
    fn files_are_found_from_the_config() {
        let axes = "[[axis]]\nid = 1\nname = 'x'\nreplay = { file = 'a/b.csv' }";
        let mut config = read(axes).unwrap();
        config.relative_to(Path::new("there"));
        let SourceConfig::Replay(replay) = &config.axes[0].source else {
            panic!("{config:?}");
        };
        assert_eq!(replay.file, Path::new("there").join("a/b.csv"));
    }

    #[test]
    fn errors_name_the_field_what_came_and_what_is_expected() {
        // A frame holds 128.
        let many: String = (1..=129).map(axis).collect();
        for (axes, expected) in [
            // An id of 0 is no axis in the structure of a PLC.
            (axis(0), "axis \"x\".id: "),
            (
                axis(1) + &axis(2) + &axis(1),
                "axis: received id 1 twice, expected an id of its own for each axis",
            ),
            (
                "axis = []".to_owned(),
                "axis: received 0 axes, expected 1 to 128",
            ),
            (many, "axis: received 129 axes, expected 1 to 128"),
            (
                "[[axis]]\nid = 1\nname = 'x'".to_owned(),
                "axis \"x\": received no source, expected one of `program`, `encoder` and \
                 `replay`",
            ),
            (
                axis(1) + "replay = { file = 'x.csv' }",
                "axis \"x\": received `program` and `replay`, expected one of `program`, \
                 `encoder` and `replay`",
            ),
            (
                axis(1).replace("'x'", "''"),
                "axis[0].name: received \"\", expected 1 to 64 characters",
            ),
            (
                axis(1).replace("jerk = 10", "jerk = -10"),
                "axis \"x\".program.limits.jerk: received -10, expected a number above 0, \
                 at most 1000000000000000",
            ),
            (
                axis(1).replace("5.0", "nan"),
                "axis \"x\".program.start-velocity: received NaN, expected a number from \
                 -1000000000000 to 1000000000000",
            ),
            (
                axis(1).replace("5.0", "11.0"),
                "axis \"x\".program.start-velocity: received 11, expected -10 to 10",
            ),
            (
                "show-axes = [2, 1, 2]\n".to_owned() + &axis(1),
                "show-axes: received id 2 twice, expected each id once",
            ),
            (
                axis(1) + "present-after-ms = 0",
                "axis \"x\".present-after-ms: received 0, expected a number from 0.1 to 4000",
            ),
            (
                axis(1) + "present-after-ms = 10001",
                "axis \"x\".present-after-ms: received 10001, expected a number from 0.1 to 4000",
            ),
            (
                axis(1)
                    + "present-after-ms = 8\n[[axis]]\nid = 2\nname = 'belt'\n\
                           replay = { file = 'x.csv' }",
                "axis \"belt\".present-after-ms: received 8 ms for \"x\" and none for \"belt\", expected \
                 one for all axes of a sender",
            ),
            (
                axis(1) + "encodr = { }",
                "axis \"x\".encodr: unknown field `encodr`",
            ),
        ] {
            let message = read(&axes).unwrap_err();
            let place = message.split_once(&format!(": {expected}"));
            assert!(
                place.is_some_and(|(file, _)| file.starts_with("s.toml:")),
                "{message}"
            );
        }
    }
}
