//! `[lab]` of a receiver.

use std::path::Path;

use coaxle_node::config::{ClockConfig, LinkConfig, Wrong};
use coaxle_node::document::{Document, Misread};
use coaxle_node::faults::check_link;
use coaxle_node::keys::NodeName;
use coaxle_node::lab::{LabTable, WithLab, check_lab_clock};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FarConfig, MarksConfig, ReceiverConfig, SlaveConfig, ToolConfig};

/// Faults injected into a receiver and what is simulated in it, for experiments: a receiver with this table starts with
/// `--lab` only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct ReceiverLab {
    /// Seeds whatever is random in its clock and links.
    pub seed: u64,
    /// Deviation injected into its clock.
    pub clock: ClockConfig,
    /// Faults on the links to the nodes that it follows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub far: Vec<FarLab>,
    /// Marks and tools of slaves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub slave: Vec<SlaveLab>,
}

/// Faults on the links to a node that is followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct FarLab {
    /// The node, as in `[[far]]` or `[master]`.
    pub node: NodeName,
    /// Faults laid over everything that comes from the node, and over the time requests to it.
    #[serde(default)]
    pub faults: LinkConfig,
    /// Faults laid over the time requests instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request_faults: Option<LinkConfig>,
    /// Faults laid over the beacons of the timing channel, either way.
    #[serde(default)]
    pub timing_faults: LinkConfig,
}

/// Simulation of a slave: its registration marks and its tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct SlaveLab {
    /// The slave, as in `[[slave]]`.
    pub name: NodeName,
    /// Registration marks on the material that its master moves, and the sensor that sees them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marks: Option<MarksConfig>,
    /// Tool of the slave, to judge the cuts of an experiment.
    #[serde(default)]
    pub tool: ToolConfig,
}

impl LabTable for ReceiverLab {
    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn check_files(&self, folder: &Path) -> Result<(), Wrong> {
        check_lab_clock(&self.clock, folder)?;
        for (n, far) in self.far.iter().enumerate() {
            far.check_files(folder)
                .map_err(|wrong| wrong.within(format_args!("far[{n}]")))?;
        }
        Ok(())
    }
}

impl FarLab {
    fn check_files(&self, folder: &Path) -> Result<(), Wrong> {
        let links = [
            ("faults", Some(&self.faults)),
            ("request-faults", self.request_faults.as_ref()),
            ("timing-faults", Some(&self.timing_faults)),
        ];
        for (field, link) in links {
            let Some(mut link) = link.cloned() else {
                continue;
            };
            // On a copy: paths of the table itself are resolved with the whole config later.
            link.relative_to(folder);
            check_link(&link).map_err(|wrong| wrong.within(field))?;
        }
        Ok(())
    }

    fn of(far: &FarConfig) -> Option<Self> {
        let lab = Self {
            node: far.node.clone(),
            faults: far.faults.clone(),
            request_faults: far.request_faults.clone(),
            timing_faults: match &far.timing {
                Some(timing) => timing.faults.clone(),
                None => LinkConfig::default(),
            },
        };
        let none = LinkConfig::default();
        let is_none =
            lab.faults == none && lab.request_faults.is_none() && lab.timing_faults == none;
        (!is_none).then_some(lab)
    }

    /// Lays the faults over the links to the node.
    fn put_into(self, far: &mut FarConfig) -> Result<(), Wrong> {
        match &mut far.timing {
            Some(timing) => timing.faults = self.timing_faults,
            // Faults of the default are as good as none, so that the table may list a node without a channel.
            None if self.timing_faults != LinkConfig::default() => {
                let received = "faults of a timing channel";
                let expected = "`timing` with `connect` in the far node";
                return Err(Wrong::of("timing-faults", received, expected));
            }
            None => {}
        }
        far.faults = self.faults;
        // Replaced as a whole, even by none: a node's file has its faults in this table only.
        far.request_faults = self.request_faults;
        Ok(())
    }
}

impl SlaveLab {
    fn of(slave: &SlaveConfig) -> Option<Self> {
        let (marks, tool) = (slave.marks, slave.tool);
        let name = slave.name.clone();
        let is_none = marks.is_none() && tool == ToolConfig::default();
        (!is_none).then_some(Self { name, marks, tool })
    }

    fn put_into(self, slave: &mut SlaveConfig) -> Result<(), Wrong> {
        if let Some(marks) = &self.marks {
            marks.check().map_err(|wrong| wrong.within("marks"))?;
        }
        (slave.marks, slave.tool) = (self.marks, self.tool);
        // Once the tool is there, since it may contradict the steps of the slave.
        slave.check_tool()
    }
}

impl WithLab for ReceiverConfig {
    type Lab = ReceiverLab;

    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn set_lab(&mut self, lab: ReceiverLab) -> Result<(), Wrong> {
        (self.seed, self.clock) = (lab.seed, lab.clock);
        let nodes: Vec<_> = self.far.iter().map(|far| far.node.clone()).collect();
        // Names apart from their entries, which the loop consumes.
        let wanted: Vec<_> = lab.far.iter().map(|far| far.node.clone()).collect();
        for (n, far) in lab.far.into_iter().enumerate() {
            place_of("node", &wanted, n, &nodes)
                .and_then(|place| far.put_into(&mut self.far[place]))
                .map_err(|wrong| wrong.within(format_args!("far[{n}]")))?;
        }
        let slaves: Vec<_> = self.slaves.iter().map(|slave| slave.name.clone()).collect();
        let wanted: Vec<_> = lab.slave.iter().map(|slave| slave.name.clone()).collect();
        for (n, slave) in lab.slave.into_iter().enumerate() {
            place_of("name", &wanted, n, &slaves)
                .and_then(|place| slave.put_into(&mut self.slaves[place]))
                .map_err(|wrong| wrong.within(format_args!("slave[{n}]")))?;
        }
        Ok(())
    }

    fn lab(&self) -> ReceiverLab {
        ReceiverLab {
            seed: self.seed,
            clock: self.clock.clone(),
            far: self.far.iter().filter_map(FarLab::of).collect(),
            slave: self.slaves.iter().filter_map(SlaveLab::of).collect(),
        }
    }
}

/// The place of the n-th wanted name, which is in this field, among those that there are.
fn place_of(
    field: &str,
    wanted: &[NodeName],
    n: usize,
    known: &[NodeName],
) -> Result<usize, Wrong> {
    let name = wanted[n].as_str();
    // Otherwise the later entry would replace the earlier one without a word.
    if wanted[..n].contains(&wanted[n]) {
        return Err(Wrong::of(
            field,
            format_args!("{name:?} twice"),
            "each once",
        ));
    }
    let place = known.iter().position(|known| known.as_str() == name);
    place.ok_or_else(|| {
        let known: Vec<_> = known.iter().map(NodeName::as_str).collect();
        let expected = match &known[..] {
            [] => "none".to_owned(),
            known => format!("one of: {}", known.join(", ")),
        };
        Wrong::of(field, format_args!("{name:?}"), expected)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::lab::NodeFile;

    const SHORT: &str = "name = 'r'\ncycle-time-us = 1000\nmaster = { node = 'belt' }\n";
    const LONG: &str = "name = 'r'\ncycle-time-us = 1000\n\
        [[far]]\nnode = 'press'\n[[far]]\nnode = 'belt'\ntiming.connect = '10.0.0.1:7450'\n\
        [[slave]]\nname = 'roll'\nmaster = 'press.1'\n[[slave]]\nname = 'knife'\nmaster = 'belt.1'\n";
    const LAB: &str = "[lab]\nseed = 3\nclock.drift-ppm = -300\n\
        [[lab.far]]\nnode = 'belt'\nfaults.loss = 0.1\nrequest-faults.latency-us = 5\ntiming-faults.loss = 0.2\n\
        [[lab.slave]]\nname = 'knife'\nmarks = { spacing = 600, sensor-distance = 700 }\ntool.cuts-every = 360\n";

    fn read(text: &str) -> Result<NodeFile<ReceiverConfig>, String> {
        NodeFile::parse("r.toml", text).map_err(|error| error.lines().join("\n"))
    }

    #[test]
    fn each_field_of_the_table_goes_to_the_node_or_slave_that_it_names() {
        let config = read(&format!("{LONG}{LAB}")).unwrap().config;
        assert_eq!((config.seed, config.clock.drift_ppm.get()), (3, -300.0));
        let [press, belt] = &config.far[..] else {
            panic!("{config:?}");
        };
        assert_eq!(press.faults, LinkConfig::default());
        assert_eq!(belt.faults.loss.get(), 0.1);
        assert_eq!(belt.faults_of_requests().latency_us.get(), 5.0);
        assert_eq!(belt.timing.as_ref().unwrap().faults.loss.get(), 0.2);
        let [roll, knife] = &config.slaves[..] else {
            panic!("{config:?}");
        };
        assert_eq!((roll.marks, roll.tool), (None, ToolConfig::default()));
        assert_eq!(knife.marks.unwrap().spacing.get(), 600.0);
        assert_eq!(knife.tool.cuts_every.unwrap().get(), 360.0);
        let written = NodeFile::text_of(&config).unwrap();
        assert_eq!(read(&written).unwrap().config, config, "{written}");
    }

    #[test]
    fn the_short_form_has_the_table_too() {
        let lab = "[[lab.far]]\nnode = 'belt'\nfaults.loss = 0.1\n[[lab.slave]]\nname = 'slave'\ntool.ratio = 2.0\n";
        let config = read(&format!("{SHORT}{lab}")).unwrap().config;
        assert_eq!(config.far[0].faults.loss.get(), 0.1);
        assert_eq!(config.slaves[0].tool.ratio, 2.0);
    }

    #[test]
    fn the_old_places_are_answered_with_what_to_write() {
        let answer = |place: &str, write: &str| {
            format!(
                "r.toml:{place}: what is injected or simulated lives in [lab]: write {write}, and start the node with --lab"
            )
        };
        for (text, expected) in [
            (
                format!("{SHORT}faults.loss = 0.1"),
                answer(
                    "4:1: faults",
                    "[[lab.far]] with its node and faults = { loss = 0.1 }",
                ),
            ),
            (
                format!("{SHORT}request-faults.loss = 0.1"),
                answer(
                    "4:1: request-faults",
                    "[[lab.far]] with its node and request-faults = { loss = 0.1 }",
                ),
            ),
            (
                format!("{SHORT}seed = 0"),
                answer("4:8: seed", "lab.seed = 0"),
            ),
            (
                format!("{SHORT}clock.drift-ppm = 5"),
                answer("4:1: clock", "lab.clock = { drift-ppm = 5 }"),
            ),
            (
                format!("{SHORT}timing = {{ connect = '10.0.0.1:1', faults.loss = 0.1 }}"),
                answer(
                    "4:36: timing.faults",
                    "[[lab.far]] with its node and timing-faults = { loss = 0.1 }",
                ),
            ),
            (
                LONG.replace("node = 'press'", "node = 'press'\nfaults.loss = 0.1"),
                answer(
                    "5:1: far \"press\".faults",
                    "[[lab.far]] with its node and faults = { loss = 0.1 }",
                ),
            ),
            (
                format!("{LONG}tool = {{ cuts-every = 360 }}"),
                answer(
                    "14:8: slave \"knife\".tool",
                    "[[lab.slave]] with its name and tool = { cuts-every = 360 }",
                ),
            ),
            (
                format!("{LONG}marks = {{ spacing = 6, sensor-distance = 7 }}"),
                answer(
                    "14:9: slave \"knife\".marks",
                    "[[lab.slave]] with its name and marks = { sensor-distance = 7, spacing = 6 }",
                ),
            ),
        ] {
            assert_eq!(read(&text).unwrap_err(), expected);
        }
    }

    #[test]
    fn a_field_without_a_place_is_named() {
        for (lab, expected) in [
            (
                "[[lab.far]]\nnode = 'line'\n",
                "lab.far \"line\".node: received \"line\", expected one of: press, belt",
            ),
            (
                "[[lab.far]]\nnode = 'belt'\n[[lab.far]]\nnode = 'belt'\n",
                "lab.far \"belt\".node: received \"belt\" twice, expected each once",
            ),
            (
                "[[lab.far]]\nnode = 'press'\ntiming-faults.loss = 1\n",
                "lab.far \"press\".timing-faults: received faults of a timing channel",
            ),
            (
                "[[lab.slave]]\nname = 'saw'\n",
                "lab.slave[0].name: received \"saw\", expected one of: roll, knife",
            ),
            (
                "[[lab.slave]]\nname = 'knife'\ntool.ratio = 0\n",
                "lab.slave \"knife\".tool.ratio: received 0, expected a number other than 0",
            ),
            (
                "[[lab.slave]]\nname = 'knife'\nmarks = { spacing = 6, sensor-distance = 7, spacing-swing = { amplitude = 1, marks = 1 } }\n",
                "lab.slave \"knife\".marks.spacing-swing.marks: received 1",
            ),
        ] {
            let error = read(&format!("{LONG}{lab}")).unwrap_err();
            assert!(error.contains(expected), "{error}\nnot\n{expected}");
        }
    }
}
