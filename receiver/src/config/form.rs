//! The two forms of a receiver's file: a list of far nodes, or one master in the short form. Both
//! may have virtual axes; the first form may have only these.

use coaxle_axis::Modulo;
use coaxle_clock::far_clock::DelaySource;
use coaxle_clock::observer::ObserverParameters;
use coaxle_node::circles::CIRCLE_CODE;
use coaxle_node::config::{
    ClockConfig, CommonTimeConfig, CycleMicros, LinkConfig, Positive, RealTimeConfig,
    TimingLinkConfig, TimingServerConfig, TransportConfig, Unit, Wrong, at_most,
};
use coaxle_node::keys::NodeName;
use coaxle_remote::{AxisSyncParameters, EncoderParameters, FilterMode};
use coaxle_source::config::AxisConfig;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::far::delay_in_range;
use super::far_limits::FarLimits;
use super::names::check_names;
use super::{
    AsymmetryConfig, AxisList, CamSource, FarAxisConfig, FarChannel, FarConfig, Lag,
    LockCycleConfig, Positions, Present, PublishFarAxes, ReceiverConfig, SlaveConfig,
};

/// A receiver's file as written.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct Form {
    /// The node's name, part of its key expressions.
    name: NodeName,
    /// Nominal cycle time, µs.
    cycle_time_us: CycleMicros,
    /// Lock of its cycle to that of a node that it follows, so that the newest frame is equally old in each cycle. None by default.
    lock_cycle: Option<LockCycleConfig>,
    /// The nodes that it follows.
    #[serde(default, deserialize_with = "at_most::<MOST_HEARD, _, _>")]
    far: Vec<FarConfig>,
    /// Short form, instead of `far`: the one axis that it follows.
    master: Option<Master>,
    /// Short form, with `master`: calculation of the set values.
    mode: Option<FilterMode>,
    /// Short form, with `master`: instant that is shown, `auto` or `now`.
    present: Option<Present>,
    /// Short form, with `master`: lag of an axis that is shown later, `full`, `auto` or ms.
    lag_ms: Option<Lag>,
    /// Short form, with `master`: parameters of the TS5066 blocks.
    sync: Option<AxisSyncParameters>,
    /// Short form, with `master`: parameters of the phase observer.
    observer: Option<ObserverParameters>,
    /// Short form, with `master`: the constant part of the delay, in observer mode.
    #[serde(default, deserialize_with = "stated_delay")]
    delay: Option<DelaySource>,
    /// Short form, with `master`: asymmetry of the paths to it and from it.
    asymmetry: Option<AsymmetryConfig>,
    /// Short form, with `master`: the timing channel to the node.
    timing: Option<TimingLinkConfig>,
    /// Short form, with `master`: faults applied to all messages from the node.
    #[schemars(extend("x-lab" = "[[lab.far]] with its node and faults = {}"))]
    faults: Option<LinkConfig>,
    /// Short form, with `master`: other faults for the time requests.
    #[schemars(extend("x-lab" = "[[lab.far]] with its node and request-faults = {}"))]
    request_faults: Option<LinkConfig>,
    /// Former name of the field.
    #[schemars(skip)]
    question_faults: Option<toml::Value>,
    /// Far axes that it publishes as corrected.
    #[serde(default)]
    publish_far_axes: PublishFarAxes,
    /// Virtual axes of its own, which its slaves can follow, for example a local line shaft.
    #[serde(rename = "virtual-axis", default)]
    virtual_axes: Vec<AxisConfig>,
    /// The cam plates that can couple all of its slaves.
    #[serde(default)]
    cams: Vec<CamSource>,
    /// The slaves. With `master`, one that follows by a gear of 1 by default; otherwise none.
    #[serde(rename = "slave")]
    slaves: Option<Vec<SlaveConfig>>,
    /// Injected clock faults. None by default.
    #[serde(default)]
    #[schemars(extend("x-lab" = "lab.clock = {}"))]
    clock: ClockConfig,
    /// Seed of all its randomness. 0 by default.
    #[serde(default)]
    #[schemars(extend("x-lab" = "lab.seed = {}"))]
    seed: u64,
    /// Connection to other nodes.
    #[serde(default)]
    transport: TransportConfig,
    /// The timing channel to itself, apart from the transport, for those who follow its slaves or far axes. None by default.
    timing_server: Option<TimingServerConfig>,
    /// Time that this PC has in common with others, exchanged on timing channels and followed as long as these do not contradict it. None
    /// by default.
    time: Option<CommonTimeConfig>,
    /// Settings requested from the operating system.
    #[serde(default)]
    real_time: RealTimeConfig,
}

/// The one master of the short form.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "ShortMaster")]
struct Master {
    /// The node that publishes it.
    node: NodeName,
    /// Channel of the axis: a sender's axes, or the slaves of another receiver.
    #[serde(default)]
    channel: FarChannel,
    /// Nodes with the same axis that take over when that one falls silent.
    #[serde(default)]
    standby: Vec<NodeName>,
    /// Silence before a standby takes over, ms.
    take_over_after_ms: Option<Positive>,
    /// Axis id.
    #[serde(default = "first_axis")]
    axis: u32,
    /// Unit of its position.
    unit: Option<Unit>,
    /// Length of its modulo period, u.
    modulo: Option<Modulo>,
    /// Count of its set position: continuous or within the modulo period.
    #[serde(default)]
    position: Positions,
    /// Smoothing of the increments of an encoder axis; given if the axis is only measured.
    encoder: Option<EncoderParameters>,
    /// Limits kept by its corrected set values.
    limits: Option<FarLimits>,
}

impl Master {
    fn axis(&self) -> FarAxisConfig {
        FarAxisConfig {
            position: self.position,
            encoder: self.encoder,
            limits: self.limits,
            ..FarAxisConfig::with_id(self.axis)
        }
    }
}

fn stated_delay<'de, D: Deserializer<'de>>(file: D) -> Result<Option<DelaySource>, D::Error> {
    delay_in_range(file).map(Some)
}

const fn first_axis() -> u32 {
    1
}

/// Greatest number of nodes that a receiver receives from.
const MOST_HEARD: usize = 128;

/// A field of the short form in a file of the long one.
fn mixed(field: &str) -> Wrong {
    let expected = "it in the [[far]] of the node that it is for";
    Wrong::of(field, "one beside [[far]]", expected)
}

/// Expected where a file follows nothing.
const FOLLOWED: &str = "at least one, such as node = \"conveyor\" with axes = [1, 2]; or in short, for one axis, \
                        master = { node = \"conveyor\", axis = 1 }; or a [[virtual-axis]]";

impl TryFrom<Form> for ReceiverConfig {
    type Error = Wrong;

    fn try_from(form: Form) -> Result<Self, Wrong> {
        // First, because only its present name helps with an older file.
        if form.question_faults.is_some() {
            let reason = "is called request-faults now";
            return Err(Wrong::with_reason("question-faults", reason));
        }
        // Errors name fields as the file has them, and the two forms have them in different places.
        let is_short = form.master.is_some();
        let far = match form.master {
            // Both at once would leave open which of them a slave without a master follows.
            Some(_) if !form.far.is_empty() => return Err(mixed("master")),
            // Slaves of virtual axes alone need no far node.
            None if form.far.is_empty() && form.virtual_axes.is_empty() => {
                return Err(Wrong::of("far", "no [[far]]", FOLLOWED));
            }
            Some(master) => vec![FarConfig {
                axes: AxisList::one(master.axis()),
                node: master.node,
                standby: master.standby,
                take_over_after_ms: master.take_over_after_ms,
                channel: master.channel,
                unit: master.unit,
                modulo: master.modulo,
                // The defaults of a [[far]], which serde fills in there.
                mode: form.mode.unwrap_or(FilterMode::Observer),
                present: form.present.unwrap_or_default(),
                lag_ms: form.lag_ms.unwrap_or_default(),
                sync: form.sync.unwrap_or_default(),
                observer: form.observer.unwrap_or_default(),
                delay: form.delay.unwrap_or(DelaySource::Measured),
                asymmetry: form.asymmetry,
                timing: form.timing,
                faults: form.faults.unwrap_or_default(),
                request_faults: form.request_faults,
            }],
            None => {
                // Fields of the short form are options, which tell a given default from an absent one.
                let short = [
                    ("mode", form.mode.is_some()),
                    ("present", form.present.is_some()),
                    ("lag-ms", form.lag_ms.is_some()),
                    ("sync", form.sync.is_some()),
                    ("observer", form.observer.is_some()),
                    ("delay", form.delay.is_some()),
                    ("asymmetry", form.asymmetry.is_some()),
                    ("timing", form.timing.is_some()),
                    ("faults", form.faults.is_some()),
                    ("request-faults", form.request_faults.is_some()),
                ];
                if let Some((field, _)) = short.into_iter().find(|(_, is_there)| *is_there) {
                    return Err(mixed(field));
                }
                form.far
            }
        };
        // Standbys count: each has an inbox and a clock of its own.
        let heard: usize = far.iter().map(|far| 1 + far.standby.len()).sum();
        if heard > MOST_HEARD {
            let received = format!("{heard} nodes with their standbys");
            let expected = format!("at most {MOST_HEARD}");
            return Err(Wrong::of("far", received, expected));
        }
        // A node has one clock: two entries would estimate it twice, and its requests would mix.
        for (n, node) in far.iter().enumerate() {
            if far[..n].iter().any(|other| other.node == node.node) {
                let received = format!("the node {:?} twice", node.node.as_str());
                return Err(Wrong::of(
                    "far",
                    received,
                    "each once, with all of its axes",
                ));
            }
        }
        let one_slave = || {
            if is_short {
                vec![SlaveConfig::default()]
            } else {
                Vec::new()
            }
        };
        let config = Self {
            name: form.name,
            cycle_time_us: form.cycle_time_us,
            lock_cycle: form.lock_cycle,
            far,
            publish_far_axes: form.publish_far_axes,
            virtual_axes: form.virtual_axes,
            cams: form.cams,
            slaves: form.slaves.unwrap_or_else(one_slave),
            clock: form.clock,
            seed: form.seed,
            transport: form.transport,
            timing_server: form.timing_server,
            time: form.time,
            real_time: form.real_time,
        };
        // Before all checks that resolve axes by their names.
        check_names(&config)?;
        config.check_standbys(is_short)?;
        config.check_lock_cycle()?;
        config.check_common_time()?;
        config.check_turns()?;
        config.check_encoders(is_short)?;
        config.check_virtual_axes()?;
        config.check_published()?;
        // Last, because circles can be followed only in a config that is valid otherwise.
        config.check_circles()?;
        Ok(config)
    }
}

impl ReceiverConfig {
    /// Checks that positions within a modulo period have its length.
    fn check_turns(&self) -> Result<(), Wrong> {
        let mut axes = self.far_axes();
        let unknown = axes.find(|(_, far, axis)| {
            axis.position == Positions::WithinTurn && axis.modulo.or(far.modulo).is_none()
        });
        let Some((_, far, axis)) = unknown else {
            return Ok(());
        };
        let received = format!(
            "none for the axis {:?}, whose position is \"within-turn\"",
            far.axis_name(axis)
        );
        Err(Wrong::of("modulo", received, "the length of its turn"))
    }

    fn check_circles(&self) -> Result<(), Wrong> {
        let Some(circle) = self.own_circle() else {
            return Ok(());
        };
        let expected = "a sender's axis or a virtual axis at the root";
        let wrong = Wrong::of("far", format_args!("a circle: {circle}"), expected);
        Err(wrong.with_code(CIRCLE_CODE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::MasterRef;
    use crate::config::test_config::config;

    #[test]
    fn positions_within_the_turn_need_its_length() {
        let master = "master = { node = 'spindle', position = 'within-turn'";
        let error = config(&format!("{master} }}")).unwrap_err();
        assert!(error.contains("modulo: received none"), "{error}");
        let config = config(&format!("{master}, modulo = 360 }}")).unwrap();
        let axis = config.far[0].axes.iter().next().unwrap();
        assert_eq!(axis.position, Positions::WithinTurn);
    }

    const SHORT: &str =
        "master = { node = 'conveyor', axis = 3 }\nmode = 'sync'\nrequest-faults.loss = 0.5";
    const LONG: &str = "slave = [{}]\n[[far]]\nnode = 'conveyor'\naxes = [3]\nmode = 'sync'\n\
        request-faults.loss = 0.5";

    #[test]
    fn the_short_form_is_the_long_one() {
        assert_eq!(config(SHORT), config(LONG));
        let written = toml::to_string(&config(SHORT).unwrap()).unwrap();
        let read = coaxle_node::config::parse("r.toml", &written).map_err(|e| e.to_string());
        assert_eq!(read, config(LONG));
    }

    #[test]
    fn what_is_neither_says_what_to_write() {
        for (rest, expected) in [
            ("", "far: received no [[far]], expected at least one"),
            (
                "mode = 'sync'\n[[far]]\nnode = 'a'",
                "mode: received one beside [[far]], expected it in the [[far]]",
            ),
            (
                "master.node = 'b'\n[[far]]\nnode = 'a'",
                "master: received one beside [[far]]",
            ),
            (
                "master.node = 'b'\nquestion-faults.loss = 1",
                "question-faults: is called request-faults now",
            ),
            (
                "[[far]]\nnode = 'a'\n[[far]]\nnode = 'a'\naxes = [2]",
                "received the node \"a\" twice",
            ),
            (
                "[[far]]\nnode = 'a'\naxes = [{ id = 1, name = 'x' }, { id = 2, name = 'x' }]",
                "received the name \"x\" for two axes",
            ),
            ("[[far]]\nnode = 'a'\nmode = 'fast'", "far \"a\".mode"),
        ] {
            let error = config(rest).unwrap_err();
            assert!(error.contains(expected), "{rest}: {error}");
        }
    }

    const MANY: &str = "[[far]]\nnode = 'a'\naxes = ['1-2']\n[[far]]\nnode = 'b'\n\
        axes = [7, { id = 9, name = 'belt' }]\n\
        [[slave]]\nname = 'x'\nmaster = 'a.2'\n[[slave]]\nname = 'y'\nmaster = 'belt'\n\
        [[slave]]\nname = 'z'\nmaster = 'y'\n[[slave]]\nname = 'v'\nmaster = 'b.9'\n";

    #[test]
    fn masters_are_named_by_node_and_id_or_by_their_own_name() {
        let config = config(MANY).unwrap();
        let masters: Vec<_> = (0..4).map(|n| config.master_of(n).unwrap()).collect();
        let (far, slave) = (MasterRef::Far, MasterRef::Slave);
        assert_eq!(masters, [far(1), far(3), slave(1), far(3)]);
        assert_eq!(config.far_axis_names(), ["a.1", "a.2", "b.7", "belt"]);
        assert_eq!(config.root_of(2), Some(far(3)));
        assert_eq!((config.first_axis_of(0), config.first_axis_of(1)), (0, 2));
    }

    #[test]
    fn a_master_that_is_not_there_is_told_with_those_that_are() {
        for (rest, received) in [
            ("[[slave]]\nname = 'w'\nmaster = 'b.8'", "b.8"),
            ("[[slave]]\nname = 'w'", ""),
        ] {
            let config = config(&format!("{MANY}{rest}")).unwrap();
            let error = config.master_of(4).unwrap_err();
            assert_eq!(error.field(), "slave[4].master");
            let expected = format!(
                "slave[4].master: received {received:?}, expected one of: a.1, a.2, b.7, belt, x, y, z, v"
            );
            assert!(error.to_string().starts_with(&expected), "{error}");
        }
    }
}
