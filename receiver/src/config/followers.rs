//! The axes that a receiver publishes, with the axes of other nodes that they follow.

use coaxle_node::circles::{AxisAddress, Circle, Follower, circles};
use coaxle_node::{Channel, keys::NodeName};

use super::{FarChannel, FarConfig, MasterRef, ReceiverConfig};

impl ReceiverConfig {
    /// Slaves, and far axes published as corrected, each with all configured masters on other
    /// nodes, standbys included. Slaves with invalid masters are left out.
    #[must_use]
    pub fn followers(&self) -> Vec<Follower> {
        let slaves = (0..self.slaves.len()).map(|n| Follower {
            axis: self.published(Channel::Slaves, self.slave_id(n)),
            masters: self.far_masters_of_slave(n),
            // A config does not tell what is coupled later: a circle counts if it can be closed at all.
            is_coupled: true,
        });
        // Published ids count from 1, in the order of the list.
        let far_axes = self.published_far_axes().into_iter().zip(1..);
        let far_axes = far_axes.map(|(axis, id)| Follower {
            axis: self.published(Channel::FarAxes, id),
            masters: self.addresses_of(axis),
            is_coupled: true,
        });
        slaves.chain(far_axes).collect()
    }

    /// True if it reports to the nodes of its masters: only senders listen, and only slaves are reported.
    #[must_use]
    pub fn reports(&self) -> bool {
        let is_of_sender = |far: &FarConfig| far.channel == FarChannel::Axes;
        !self.slaves.is_empty() && self.far.iter().any(is_of_sender)
    }

    /// A circle of its own axes, closed over the network.
    pub(super) fn own_circle(&self) -> Option<Circle> {
        // A single one is enough for a refusal.
        circles(&self.followers()).into_iter().next()
    }

    fn published(&self, channel: Channel, id: u32) -> AxisAddress {
        let node = self.name.clone();
        AxisAddress { node, channel, id }
    }

    /// Addresses of the far axes at the roots of the n-th slave, including those of the slaves that
    /// it follows.
    #[must_use]
    pub fn far_masters_of_slave(&self, slave: usize) -> Vec<AxisAddress> {
        let (mut due, mut seen) = (vec![slave], vec![slave]);
        let mut found = Vec::new();
        while let Some(slave) = due.pop() {
            for master in self.masters_of(slave).unwrap_or_default() {
                match master {
                    MasterRef::Far(axis) => found.extend(self.addresses_of(axis)),
                    // Slaves may follow each other in a circle, which another check refuses.
                    MasterRef::Slave(next) if !seen.contains(&next) => {
                        seen.push(next);
                        due.push(next);
                    }
                    MasterRef::Slave(_) | MasterRef::Virtual(_) => {}
                }
            }
        }
        found
    }

    /// Addresses of the far axis of this number: at its node, and at each standby.
    #[must_use]
    pub fn addresses_of(&self, axis: usize) -> Vec<AxisAddress> {
        let Some((_, far, axis)) = self.far_axes().nth(axis) else {
            return Vec::new();
        };
        let of = |node: &NodeName| AxisAddress {
            node: node.clone(),
            channel: far.channel.into(),
            id: axis.id,
        };
        far.nodes().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn config(text: &str) -> Result<ReceiverConfig, String> {
        parse("r.toml", text).map_err(|error| error.to_string())
    }

    /// `far-axis/circle-a.toml` and `circle-b.toml`: two nodes, a slave of each follows that of the
    /// other.
    fn node(name: &str, other: &str, axis: u32) -> ReceiverConfig {
        let text = format!(
            "name = '{name}'\ncycle-time-us = 2000\n[[far]]\nnode = '{other}'\nchannel = 'slaves'\n\
             axes = [{{ id = {axis}, name = 'far' }}]\n\
             [[virtual-axis]]\nid = 1\nname = 'shaft'\n[virtual-axis.program]\n\
             limits = {{ velocity = 100, acceleration = 100, jerk = 1000 }}\n\
             [[slave]]\nname = 'loop'\nid = 1\nmaster = 'far'\ncouple = 'off'\n\
             [[slave]]\nname = 'other'\nid = 2\nmaster = 'shaft'\n"
        );
        config(&text).unwrap()
    }

    fn circles_of(configs: [ReceiverConfig; 2]) -> Vec<String> {
        let followers: Vec<_> = configs.iter().flat_map(ReceiverConfig::followers).collect();
        circles(&followers).iter().map(Circle::to_string).collect()
    }

    #[test]
    fn two_nodes_that_follow_each_other_are_a_circle_where_the_axes_are() {
        let found = circles_of([node("a", "b", 1), node("b", "a", 1)]);
        assert_eq!(found, ["a/slaves/1 follows b/slaves/1 follows a/slaves/1"]);
        // Every slave follows an axis of the other node that a virtual axis leads.
        assert_eq!(circles_of([node("a", "b", 2), node("b", "a", 2)]), [""; 0]);
        assert_eq!(circles_of([node("a", "b", 1), node("b", "a", 2)]), [""; 0]);
    }

    #[test]
    fn a_node_that_follows_itself_is_refused() {
        let text = "name = 'a'\nmaster = { node = 'a', channel = 'slaves', axis = 1 }\ncycle-time-us = 1000";
        let error = config(text).unwrap_err();
        assert!(error.contains("0x816f"), "{error}");
        assert!(error.contains("a/slaves/1 follows a/slaves/1"), "{error}");
        // A slave of its own that follows a virtual axis may be followed.
        let text = "name = 'a'\ncycle-time-us = 1000\nslave = [{ id = 1, name = 'x', master = 'v' }, \
                    { id = 2, name = 'y', master = 'a.1' }]\n\
                    [[far]]\nnode = 'a'\nchannel = 'slaves'\naxes = [1]\n\
                    [[virtual-axis]]\nid = 1\nname = 'v'\n[virtual-axis.program]\n\
                    limits = { velocity = 100, acceleration = 100, jerk = 1000 }\n";
        assert!(config(text).is_ok(), "{:?}", config(text));
    }

    #[test]
    fn far_axes_as_corrected_and_standbys_are_followed_too() {
        let text = "name = 'a'\ncycle-time-us = 1000\npublish-far-axes = true\n\
                    [[far]]\nnode = 'b'\nstandby = ['c']\naxes = [7]\n";
        let followers = config(text).unwrap().followers();
        let texts: Vec<_> = (followers.iter())
            .map(|follower| (follower.axis.to_string(), follower.masters.len()))
            .collect();
        assert!(texts.contains(&("a/far-axes/1".to_owned(), 2)), "{texts:?}");
    }
}
