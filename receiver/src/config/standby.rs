//! `standby` of a far node: other nodes with the same axes, which take over when it falls silent.

use coaxle_node::config::Wrong;
use coaxle_node::keys::NodeName;

use super::ReceiverConfig;

/// A node received from: a far node, or a standby.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceivedNode<'a> {
    /// Number of the far node, or of the one that it stands by for, counted from 0.
    pub far: usize,
    /// 0: the far node itself; n: its n-th standby.
    pub place: usize,
    /// Name of the node.
    pub node: &'a NodeName,
}

impl ReceiverConfig {
    /// Every node received from, in the order of the numbers: the far nodes, then their standbys.
    #[must_use]
    pub fn received_nodes(&self) -> Vec<ReceivedNode<'_>> {
        let far = || self.far.iter().enumerate();
        let nodes = far().map(|(far, config)| ReceivedNode {
            far,
            place: 0,
            node: &config.node,
        });
        let standbys = far().flat_map(|(far, config)| {
            let standbys = (1..).zip(&config.standby);
            standbys.map(move |(place, node)| ReceivedNode { far, place, node })
        });
        // Far nodes first: lists by node can then be read by far node without a second index.
        nodes.chain(standbys).collect()
    }

    /// The numbers of a far node and of its standbys, in their order, among all nodes received from.
    #[must_use]
    pub fn numbers_of(&self, far: usize) -> Vec<usize> {
        let heard = self.received_nodes().into_iter().enumerate();
        let own = heard.filter(|(_, heard)| heard.far == far);
        own.map(|(number, _)| number).collect()
    }

    /// Checks the standbys: a node responds to a receiver's time requests once, so it may be listed once.
    pub(super) fn check_standbys(&self, is_short: bool) -> Result<(), Wrong> {
        let heard = self.received_nodes();
        // Far nodes come first, and have been compared with each other.
        for (n, standby) in heard.iter().enumerate().skip(self.far.len()) {
            let known = heard[..n].iter().find(|other| other.node == standby.node);
            let expected = match known {
                // First of all reasons: its own name is wrong wherever else it may be listed.
                _ if *standby.node == self.name => "another node than this receiver",
                None => continue,
                Some(known) if known.far == standby.far && known.place == 0 => {
                    "another node than the one that it stands by for"
                }
                Some(known) if known.far == standby.far => "each standby once",
                Some(known) if known.place == 0 => "a node that is not followed already",
                Some(_) => "a node that stands by for no other one",
            };
            // Places count from 1 here, as 0 is the far node, and from 0 in the file.
            let (far, place) = (standby.far, standby.place - 1);
            let field = match is_short {
                true => format!("master.standby[{place}]"),
                false => format!("far[{far}].standby[{place}]"),
            };
            let received = format!("{:?}", standby.node.as_str());
            return Err(Wrong::of(field, received, expected));
        }
        for (n, far) in self.far.iter().enumerate() {
            // A field without effect would hide that the standby was forgotten.
            if let (Some(after), true) = (far.take_over_after_ms, far.standby.is_empty()) {
                let received = format!("{} without a standby", after.get());
                let expected = "standby = [\"line-b\"], say, beside it";
                let wrong = Wrong::of("take-over-after-ms", received, expected);
                return Err(match is_short {
                    true => wrong.within("master"),
                    false => wrong.within(format_args!("far[{n}]")),
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::config::test_config::config;
    use coaxle_node::Channel;

    const TWO: &str = "[[far]]\nnode = 'a'\nstandby = ['b', 'c']\ntake-over-after-ms = 20\n\
        [[far]]\nnode = 'd'\nstandby = ['e']\naxes = [3]\n";

    #[test]
    fn standbys_are_heard_and_asked_as_far_nodes_are() {
        let config = config(TWO).unwrap();
        let heard = config.received_nodes();
        let numbers: Vec<_> = heard
            .iter()
            .map(|heard| (heard.node.as_str(), heard.far, heard.place))
            .collect();
        let expected = [
            ("a", 0, 0),
            ("d", 1, 0),
            ("b", 0, 1),
            ("c", 0, 2),
            ("e", 1, 1),
        ];
        assert_eq!(numbers, expected);
        let wiring = config.wiring();
        let heard_on = |channel| {
            let of = wiring.subscriptions.iter();
            let of = of.filter(move |subscription| subscription.channel == channel);
            of.map(|subscription| (subscription.node.as_str(), subscription.far))
                .collect::<Vec<_>>()
        };
        let expected = [("a", 0), ("d", 1), ("b", 2), ("c", 3), ("e", 4)];
        assert_eq!(heard_on(Channel::Axes), expected);
        assert_eq!(heard_on(Channel::TimeResponses), expected);
        let asked = wiring.publications.iter();
        let asked = asked.filter(|publication| publication.channel == Channel::TimeRequests);
        let asked: Vec<_> = asked
            .map(|asked| (asked.node.as_str(), asked.far))
            .collect();
        assert_eq!(asked, expected);
        let written = toml::to_string(&config).unwrap();
        assert_eq!(
            self::config(&written.replacen("name = \"r\"\ncycle-time-us = 1000.0", "", 1)),
            Ok(config)
        );
    }

    #[test]
    fn a_standby_that_cannot_be_one_is_told_why() {
        for (rest, expected) in [
            (
                "[[far]]\nnode = 'a'\nstandby = ['r']",
                "far \"a\".standby[0]: received \"r\", expected another node than this receiver",
            ),
            (
                "[[far]]\nnode = 'a'\nstandby = ['b', 'a']",
                "far \"a\".standby[1]: received \"a\", expected another node than the one that it stands by for",
            ),
            (
                "master = { node = 'a', standby = ['b', 'b'] }",
                "master.standby[1]: received \"b\", expected each standby once",
            ),
            (
                "[[far]]\nnode = 'a'\n[[far]]\nnode = 'b'\nstandby = ['a']",
                "far \"b\".standby[0]: received \"a\", expected a node that is not followed already",
            ),
            (
                "[[far]]\nnode = 'a'\nstandby = ['c']\n[[far]]\nnode = 'b'\nstandby = ['c']",
                "far \"b\".standby[0]: received \"c\", expected a node that stands by for no other one",
            ),
            (
                "[[far]]\nnode = 'a'\nstandby = ['b/c']",
                "far \"a\".standby[0]",
            ),
            (
                "[[far]]\nnode = 'a'\nstandby = ['b']\ntake-over-after-ms = 0",
                "a finite number above 0",
            ),
            (
                "[[far]]\nnode = 'a'\ntake-over-after-ms = 5",
                "far \"a\".take-over-after-ms: received 5 without a standby, expected standby = [\"line-b\"], say",
            ),
        ] {
            let error = config(rest).unwrap_err();
            assert!(error.contains(expected), "{rest}: {error}");
        }
    }
}
