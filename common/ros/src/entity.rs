//! A ROS node on Zenoh in the conventions of rmw_zenoh: the keys of its topics, and the liveliness tokens
//! for discovery.
//!
//! Source: rmw_zenoh's `docs/design.md` and `liveliness_utils.cpp`.

use std::fmt;

use coaxle_node::config::Wrong;
use twox_hash::XxHash3_128;

use crate::message::MessageType;

/// A ROS domain: nodes of other domains receive nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RosDomain(u16);

/// A namespace: `/`, or `/line1`, `/plant/line1`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosNamespace(String);

/// The name of a ROS node, or of a topic in its namespace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosName(String);

/// Greatest length of a name, in characters (`rmw/validate_node_name.h`, `validate_namespace.h`).
const LONGEST: usize = 255;

impl RosDomain {
    /// The greatest domain for which DDS has ports.
    pub const LARGEST: u16 = 232;

    /// # Errors
    /// [`Wrong`] unless it is a number from 0 to [`Self::LARGEST`].
    pub fn new(text: &str) -> Result<Self, Wrong> {
        let number = text.parse().ok().filter(|number| *number <= Self::LARGEST);
        number.map(Self).ok_or_else(|| {
            let expected = format!("a whole number from 0 to {}", Self::LARGEST);
            Wrong::value(format_args!("{text:?}"), expected)
        })
    }
}

impl RosName {
    /// # Errors
    /// [`Wrong`] unless it is a name.
    pub fn new(name: &str) -> Result<Self, Wrong> {
        if is_name(name) {
            return Ok(Self(name.to_owned()));
        }
        let expected = format!(
            "letters, digits and underscores, no digit first, at most {LONGEST} characters"
        );
        Err(Wrong::value(format_args!("{name:?}"), expected))
    }
}

impl RosNamespace {
    /// # Errors
    /// [`Wrong`] unless it is a namespace. The first slash may be omitted.
    pub fn new(text: &str) -> Result<Self, Wrong> {
        let inner = text.strip_prefix('/').unwrap_or(text);
        // Less, because the slash in front counts as well.
        let is_good = inner.len() < LONGEST && inner.split('/').all(is_name);
        if inner.is_empty() || is_good {
            return Ok(Self(format!("/{inner}")));
        }
        let expected = "names with a slash before each, such as /line1, or / alone";
        Err(Wrong::value(format_args!("{text:?}"), expected))
    }

    /// Returns the full name of a topic or node in it.
    #[must_use]
    pub fn topic(&self, name: &RosName) -> String {
        match self.0.as_str() {
            "/" => format!("/{name}"),
            namespace => format!("{namespace}/{name}"),
        }
    }
}

fn is_name(name: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let starts_well = name.starts_with(|c: char| !c.is_ascii_digit());
    // Bytes are characters here, since only ASCII passes.
    starts_well && name.len() <= LONGEST && name.chars().all(is_plain)
}

impl fmt::Display for RosDomain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for RosNamespace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Display for RosName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A ROS node.
#[derive(Clone, Debug)]
pub struct RosNode {
    /// Domain of the node.
    pub domain: RosDomain,
    /// The id of its Zenoh session, in hexadecimal digits.
    pub session: String,
    /// Namespace of the node.
    pub namespace: RosNamespace,
    /// Name of the node.
    pub name: RosName,
}

/// Role of a node for a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndpointRole {
    /// Publisher: `MP`.
    Publisher,
    /// Subscription: `MS`.
    Subscription,
}

/// A publisher, or a subscription, of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// The key that its samples travel under.
    pub key: String,
    /// Liveliness token.
    pub token: String,
    /// Unique id: the XXH3-128 of its token.
    pub gid: [u8; 16],
}

/// Reliable, volatile, history of the last ten, no deadlines: only the ten differs from rmw_zenoh's own
/// defaults.
const QUALITY: &str = "::,10:,:,:,,";
/// A session has one node here, which is its first entity.
const NODE_ID: u32 = 0;
/// Nodes without a security enclave are in that of the root.
const ENCLAVE: &str = "%";

impl RosNode {
    /// Liveliness token of the node: it makes the node visible.
    #[must_use]
    pub fn token(&self) -> String {
        self.entity("NN", NODE_ID)
    }

    /// Returns the full name of a topic in its namespace.
    #[must_use]
    pub fn topic(&self, name: &RosName) -> String {
        self.namespace.topic(name)
    }

    /// Returns the endpoint number `id`, from 1 on, of a topic in its namespace.
    #[must_use]
    pub fn endpoint(
        &self,
        id: u32,
        role: EndpointRole,
        topic: &RosName,
        message: MessageType,
    ) -> Endpoint {
        let role = match role {
            EndpointRole::Publisher => "MP",
            EndpointRole::Subscription => "MS",
        };
        let MessageType { name, hash } = message;
        let topic = self.topic(topic);
        let token = format!(
            "{}/{}/{name}/{hash}/{QUALITY}",
            self.entity(role, id),
            mangled(&topic)
        );
        Endpoint {
            key: format!("{}{topic}/{name}/{hash}", self.domain),
            // rmw_zenoh derives the gid of an endpoint from its token in the same way.
            gid: XxHash3_128::oneshot(token.as_bytes()).to_le_bytes(),
            token,
        }
    }

    fn entity(&self, kind: &str, id: u32) -> String {
        let Self {
            domain,
            session,
            namespace,
            name,
        } = self;
        let namespace = mangled(&namespace.0);
        format!("@ros2_lv/{domain}/{session}/{NODE_ID}/{id}/{kind}/{ENCLAVE}/{namespace}/{name}")
    }
}

/// Replaces slashes, which separate keys, by another character.
fn mangled(name: &str) -> String {
    name.replace('/', "%")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::JOINT_STATE;

    fn node(namespace: &str) -> RosNode {
        RosNode {
            domain: RosDomain::new("2").unwrap(),
            session: "8b20917502ee955ac4476e0266340d5c".to_owned(),
            namespace: RosNamespace::new(namespace).unwrap(),
            name: RosName::new("talker").unwrap(),
        }
    }

    #[test]
    fn tokens_are_those_of_the_design() {
        let string = MessageType {
            name: "std_msgs::msg::dds_::String_",
            hash: "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
        };
        assert_eq!(
            node("").token(),
            "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/0/NN/%/%/talker"
        );
        let chatter = RosName::new("chatter").unwrap();
        let endpoint = node("/").endpoint(10, EndpointRole::Publisher, &chatter, string);
        assert_eq!(
            endpoint.token,
            format!(
                "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/{}/{}/::,10:,:,:,,",
                string.name, string.hash
            )
        );
        assert_eq!(
            endpoint.key,
            format!("2/chatter/{}/{}", string.name, string.hash)
        );
    }

    #[test]
    fn a_namespace_is_in_key_and_token() {
        let topic = RosName::new("joint_states").unwrap();
        let endpoint =
            node("plant/line1").endpoint(1, EndpointRole::Subscription, &topic, JOINT_STATE);
        assert!(endpoint.key.starts_with(
            "2/plant/line1/joint_states/sensor_msgs::msg::dds_::JointState_/RIHS01_a13e"
        ));
        assert!(
            (endpoint.token).contains("/0/1/MS/%/%plant%line1/talker/%plant%line1%joint_states/"),
            "{}",
            endpoint.token
        );
    }

    /// The bytes that `xxhash` gives in Python and C: the seedless hash of nothing, low half first.
    #[test]
    fn the_gid_is_the_hash_with_its_low_half_first() {
        let empty = XxHash3_128::oneshot(b"").to_le_bytes();
        let [low, high] = [0x6001_c324_468d_497f_u64, 0x99aa_06d3_0147_98d8];
        assert_eq!(empty[..8], low.to_le_bytes());
        assert_eq!(empty[8..], high.to_le_bytes());
    }

    #[test]
    fn what_is_no_name_is_refused() {
        for wrong in ["", "1a", "a-b", "a b", "a/b", "ä"] {
            let error = RosName::new(wrong).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("received {wrong:?}, expected letters")),
                "{error}"
            );
        }
        for wrong in ["//", "/a/", "a//b", "/1", "a-b"] {
            let error = RosNamespace::new(wrong).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("received {wrong:?}, expected names with")),
                "{error}"
            );
        }
        // Beyond the ports of DDS (232), and beyond u16.
        for wrong in ["", "-1", "233", "1.5", "70000"] {
            let error = RosDomain::new(wrong).unwrap_err().to_string();
            assert!(
                error.ends_with("expected a whole number from 0 to 232"),
                "{error}"
            );
        }
    }
}
