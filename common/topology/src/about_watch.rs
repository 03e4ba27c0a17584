//! Comparison of a receiver's config with what the nodes that it follows say of their axes.

use std::collections::BTreeMap;

use coaxle_node::Channel;
use coaxle_node::circles::AxisAddress;
use coaxle_node::config::Unit;
use coaxle_node::keys::NodeName;

use crate::about::{InvalidAbout, about_from_json};
use crate::graph::far_of;
use crate::plant::{PlantAxis, PlantNode};

/// Watch over the descriptions of the nodes that a receiver follows.
#[derive(Clone, Debug)]
pub struct AboutWatch {
    /// Followed axes, with the unit and the modulo period that the config states.
    expected: Vec<PlantAxis>,
    known: BTreeMap<NodeName, KnownAbout>,
}

/// Descriptions of one followed node.
#[derive(Clone, Debug, Default)]
struct KnownAbout {
    /// The newest description of each of the last two runs: a new one may come before its frames.
    runs: Vec<(u64, PlantNode)>,
    ignored: u64,
}

/// Contradiction between a config and a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AboutContradiction {
    /// The node that says otherwise.
    pub node: NodeName,
    /// Channel of the axis.
    pub channel: Channel,
    /// Name of the axis in the config.
    pub axis: String,
    /// Place in the config: `far[0].axes[1].unit`.
    pub field: String,
    /// Value of the config.
    pub received: String,
    /// Value of the description, with the name of the axis there.
    pub expected: String,
}

impl std::fmt::Display for AboutContradiction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            field,
            received,
            expected,
            ..
        } = self;
        write!(f, "{field}: received {received}, expected {expected}")
    }
}

impl AboutWatch {
    /// Creates the watch of a receiver.
    #[must_use]
    pub fn new(own: &PlantNode) -> Self {
        let expected = own.axes.iter().filter(|axis| far_of(axis).is_some());
        let expected: Vec<_> = expected.cloned().collect();
        let sources = expected
            .iter()
            .filter_map(far_of)
            .flat_map(|far| &far.sources);
        let known = sources.map(|source| (source.node.clone(), KnownAbout::default()));
        Self {
            known: known.collect(),
            expected,
        }
    }

    /// The nodes whose descriptions it reads.
    pub fn nodes(&self) -> impl Iterator<Item = &NodeName> {
        self.known.keys()
    }

    /// Takes a description that came under the key of a node.
    ///
    /// # Errors
    /// [`InvalidAbout`]: it is ignored, and counted.
    pub fn take(&mut self, node: &NodeName, bytes: &[u8]) -> Result<(), InvalidAbout> {
        let Some(known) = self.known.get_mut(node) else {
            return Ok(());
        };
        let read = about_from_json(bytes).and_then(|(about, epoch)| match about.name == *node {
            true => Ok((epoch, about)),
            false => Err(InvalidAbout {
                field: "node".to_owned(),
                received: format!("{:?}", about.name.as_str()),
                expected: format!("{:?}, by its key", node.as_str()),
            }),
        });
        match read {
            Ok(about) => {
                // The newest last, even if it repeats the run before.
                known.runs.retain(|(epoch, _)| *epoch != about.0);
                known.runs.push(about);
                // Two runs: the one that is followed, and one that takes over.
                if known.runs.len() > 2 {
                    known.runs.remove(0);
                }
                Ok(())
            }
            Err(error) => {
                known.ignored += 1;
                Err(error)
            }
        }
    }

    /// Number of descriptions of a node that were ignored.
    #[must_use]
    pub fn ignored(&self, node: &NodeName) -> u64 {
        self.known.get(node).map_or(0, |known| known.ignored)
    }

    /// True if a node has described its axes.
    #[must_use]
    pub fn describes(&self, node: &NodeName) -> bool {
        self.newest(node).is_some()
    }

    /// True if the config states a unit or a modulo period of an axis of a node.
    #[must_use]
    pub fn states_something_of(&self, node: &NodeName) -> bool {
        let mut expected = self.expected.iter();
        expected.any(|axis| {
            let sources = far_of(axis).map_or(&[][..], |far| &far.sources);
            let is_its = sources.iter().any(|source| source.node == *node);
            is_its && (axis.unit.is_some() || axis.modulo.is_some())
        })
    }

    /// Runs of a node that have described their axes, each with whether it contradicts the config.
    #[must_use]
    pub fn runs(&self, node: &NodeName) -> Vec<(u64, bool)> {
        let runs = self.known.get(node).map_or(&[][..], |known| &known.runs);
        let runs = runs.iter();
        runs.map(|(epoch, about)| (*epoch, !self.against(about).is_empty()))
            .collect()
    }

    /// Contradictions with the newest run of a node.
    #[must_use]
    pub fn newest_contradictions(&self, node: &NodeName) -> Vec<AboutContradiction> {
        self.newest(node)
            .map_or_else(Vec::new, |about| self.against(about))
    }

    /// Unit of an axis, as the newest run of its node describes it.
    #[must_use]
    pub fn unit(&self, source: &AxisAddress) -> Option<Unit> {
        described(self.newest(&source.node)?, source)?.unit.clone()
    }

    fn against(&self, about: &PlantNode) -> Vec<AboutContradiction> {
        let expected = self.expected.iter();
        expected
            .flat_map(|axis| contradictions(axis, about))
            .collect()
    }

    fn newest(&self, node: &NodeName) -> Option<&PlantNode> {
        let newest = self.known.get(node)?.runs.last();
        newest.map(|(_, about)| about)
    }
}

fn described<'a>(about: &'a PlantNode, source: &AxisAddress) -> Option<&'a PlantAxis> {
    let published = Some((source.channel, source.id));
    about.axes.iter().find(|axis| axis.published == published)
}

fn contradictions(expected: &PlantAxis, about: &PlantNode) -> Vec<AboutContradiction> {
    let sources = far_of(expected).map_or(&[][..], |far| &far.sources);
    let Some(source) = sources.iter().find(|source| source.node == about.name) else {
        return Vec::new();
    };
    // An axis that it does not describe may be one of a later version.
    let Some(axis) = described(about, source) else {
        return Vec::new();
    };
    let contradiction =
        |field: &str, received: String, expected_value: String| AboutContradiction {
            node: about.name.clone(),
            channel: source.channel,
            axis: expected.name.clone(),
            field: format!("{}.{field}", expected.field),
            received: format!("{received} for {}", expected.name),
            expected: format!(
                "{expected_value}, as {} says of its axis {}",
                about.name, axis.name
            ),
        };
    let mut found = Vec::new();
    if let (Some(own), Some(unit)) = (&expected.unit, &axis.unit)
        && own != unit
    {
        let [own, unit] = [own, unit].map(|unit| format!("{:?}", unit.as_str()));
        found.push(contradiction("unit", own, unit));
    }
    if let (Some(own), Some(modulo)) = (expected.modulo, axis.modulo)
        && own != modulo
    {
        let [own, modulo] = [own, modulo].map(|modulo| modulo.length().to_string());
        found.push(contradiction("modulo", own, modulo));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::about::about_to_json;
    use crate::plant::{AxisOrigin, FarReference, LagRule, PlantRole, RootMotion, Showing};
    use crate::way::WaySource;
    use coaxle_axis::Modulo;
    use coaxle_clock::{CycleTime, Span};

    fn name(name: &str) -> NodeName {
        NodeName::new(name).unwrap()
    }

    fn node(of: &str, unit: &str, modulo: Option<f64>, origin: AxisOrigin) -> PlantNode {
        PlantNode {
            file: String::new(),
            name: name(of),
            role: PlantRole::Sender,
            cycle_time: CycleTime::new(Span::from_millis(1)).ok(),
            axes: vec![PlantAxis {
                name: "belt".to_owned(),
                field: "far[0].axes[0]".to_owned(),
                published: Some((Channel::Axes, 3)),
                unit: Unit::new(unit).ok(),
                modulo: modulo.and_then(|length| Modulo::new(length).ok()),
                limits: None,
                origin,
            }],
            is_complete: true,
            hold_back: None,
        }
    }

    fn line(unit: &str, modulo: Option<f64>) -> PlantNode {
        let motion = RootMotion::Program;
        let origin = AxisOrigin::Root {
            motion,
            present_after: None,
            followers: Vec::new(),
        };
        node("line", unit, modulo, origin)
    }

    fn watch(unit: &str, modulo: Option<f64>) -> AboutWatch {
        let far = FarReference {
            field: "far[0]".to_owned(),
            sources: ["line/axes/3", "spare/axes/3"]
                .map(|source| AxisAddress::read(source).unwrap())
                .to_vec(),
            way: WaySource::Unknown,
            showing: Showing::Later(LagRule::Full),
            measured: None,
        };
        AboutWatch::new(&node("saw", unit, modulo, AxisOrigin::Far(far)))
    }

    fn texts(watch: &AboutWatch) -> Vec<String> {
        let found = watch.newest_contradictions(&name("line"));
        found.iter().map(ToString::to_string).collect()
    }

    fn runs(watch: &AboutWatch) -> Vec<(u64, bool)> {
        watch.runs(&name("line"))
    }

    #[test]
    fn a_config_that_says_otherwise_is_named_with_both_values() {
        let mut watch = watch("inch", Some(360.0));
        let about = about_to_json(&line("mm", Some(600.0)), 5);
        assert_eq!(watch.nodes().count(), 2);
        watch.take(&name("line"), about.as_bytes()).unwrap();
        assert_eq!(
            texts(&watch),
            [
                "far[0].axes[0].unit: received \"inch\" for belt, expected \"mm\", as line says of its axis belt",
                "far[0].axes[0].modulo: received 360 for belt, expected 600, as line says of its axis belt",
            ]
        );
        assert_eq!(runs(&watch), [(5, true)]);
        assert!(
            watch.states_something_of(&name("spare")) && !watch.states_something_of(&name("other"))
        );
        // A restart with another config: the old run still contradicts.
        let repaired = about_to_json(&line("inch", Some(360.0)), 6);
        watch.take(&name("line"), repaired.as_bytes()).unwrap();
        assert_eq!(
            (texts(&watch), runs(&watch)),
            (Vec::new(), vec![(5, true), (6, false)])
        );
    }

    #[test]
    fn what_either_leaves_open_is_no_contradiction_and_the_unit_is_taken() {
        let mut open = watch("", None);
        open.take(
            &name("line"),
            about_to_json(&line("mm", Some(600.0)), 5).as_bytes(),
        )
        .unwrap();
        assert!(texts(&open).is_empty());
        let source = AxisAddress::read("line/axes/3").unwrap();
        assert_eq!(open.unit(&source), Unit::new("mm").ok());
        assert_eq!(open.unit(&AxisAddress::read("line/axes/4").unwrap()), None);
        let mut stated = watch("mm", Some(360.0));
        let silent = about_to_json(&line("", None), 5);
        stated.take(&name("line"), silent.as_bytes()).unwrap();
        assert!(texts(&stated).is_empty());
    }

    #[test]
    fn a_bad_description_is_ignored_and_counted_and_the_good_one_stays() {
        let mut watch = watch("inch", None);
        let good = about_to_json(&line("mm", None), 5);
        watch.take(&name("line"), good.as_bytes()).unwrap();
        let foreign = good.replace("\"line\"", "\"press\"");
        for bad in ["", "{}", foreign.as_str()] {
            watch.take(&name("line"), bad.as_bytes()).unwrap_err();
        }
        assert_eq!(watch.ignored(&name("line")), 3);
        assert_eq!(texts(&watch).len(), 1);
        // Of nodes that nobody follows nothing is kept.
        watch.take(&name("other"), b"").unwrap();
        assert_eq!(watch.ignored(&name("other")), 0);
    }

    #[test]
    fn the_last_two_runs_are_kept() {
        let mut watch = watch("inch", None);
        for epoch in 1..=4 {
            let about = about_to_json(&line("mm", None), epoch);
            watch.take(&name("line"), about.as_bytes()).unwrap();
        }
        assert_eq!(runs(&watch), [(3, true), (4, true)]);
        assert!(watch.describes(&name("line")) && !watch.describes(&name("spare")));
    }
}
