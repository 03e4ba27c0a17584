//! The side of ROS: a node with its topics, and the tokens by which others see them.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use coaxle_host::network::transport::{Declared, Publisher, Transport, Urgency};
use coaxle_ros::attachment::Attachment;
use coaxle_ros::entity::{Endpoint, EndpointRole, RosName, RosNode};
use coaxle_ros::message::{JOINT_STATE, JOINT_TRAJECTORY, JointState};

/// The topics, in the namespace.
const JOINT_STATES: &str = "joint_states";
const TRAJECTORIES: &str = "joint_trajectory";
/// Most trajectories that wait, and greatest length of one, bytes: a hundred thousand positions.
// Taken every 10 ms: more at a time is a fault or an attack.
const MOST_WAITING: usize = 16;
// A number of CDR has eight bytes: 2^20 / 8 = 131 072.
const LONGEST: usize = 1 << 20;

/// The topics of the node. Its tokens are there until this is dropped.
pub(super) struct Topics {
    publisher: Box<dyn Publisher>,
    gid: [u8; 16],
    published: i64,
    trajectories: Receiver<Vec<u8>>,
    described: String,
    _declared: Vec<Declared>,
}

impl Topics {
    /// Declares the node and its topics; that of trajectories only if these are wanted.
    ///
    /// # Errors
    /// The transport refuses.
    pub(super) fn open(
        transport: &dyn Transport,
        node: &RosNode,
        commands: bool,
    ) -> anyhow::Result<Self> {
        let topic = RosName::new(JOINT_STATES)?;
        // Ids of entities differ within a session: 1 publishes, 2 subscribes.
        let states = node.endpoint(1, EndpointRole::Publisher, &topic, JOINT_STATE);
        let publisher = transport.publisher(&states.key, Urgency::Ordinary)?;
        let mut declared = vec![
            transport.announce(&node.token())?,
            transport.announce(&states.token)?,
        ];
        let mut described = format!("publishes {}", node.topic(&topic));
        let (queue, trajectories) = sync_channel(MOST_WAITING);
        if commands {
            let topic = RosName::new(TRAJECTORIES)?;
            let taken = node.endpoint(2, EndpointRole::Subscription, &topic, JOINT_TRAJECTORY);
            declared.extend(subscribe(transport, &taken, queue)?);
            described = format!("{described}, takes {}", node.topic(&topic));
        }
        Ok(Self {
            publisher,
            gid: states.gid,
            published: 0,
            trajectories,
            described,
            _declared: declared,
        })
    }

    /// Names of node, domain and topics, for messages.
    pub(super) fn described(&self) -> &str {
        &self.described
    }

    /// Publishes states of joints. `unix_now` is the reading of CLOCK_REALTIME, ns.
    pub(super) fn publish(&mut self, state: &JointState, unix_now: i64) {
        // Sequences of rmw_zenoh begin at 1.
        self.published += 1;
        let attachment = Attachment {
            sequence: self.published,
            published: unix_now,
            gid: self.gid,
        };
        let sent = (self.publisher).publish_with(state.to_bytes(), attachment.to_bytes().to_vec());
        if let Err(error) = sent {
            // Not above debug, since it would repeat a hundred times a second; the next states are newer anyway.
            tracing::debug!(%error, "the transport refused joint states");
        }
    }

    /// The trajectories that have come.
    pub(super) fn trajectories(&self) -> Vec<Vec<u8>> {
        self.trajectories.try_iter().take(MOST_WAITING).collect()
    }
}

fn subscribe(
    transport: &dyn Transport,
    endpoint: &Endpoint,
    queue: SyncSender<Vec<u8>>,
) -> anyhow::Result<[Declared; 2]> {
    let on_bytes = move |_, bytes: &[u8]| {
        // Before the copy into the queue.
        if bytes.len() > LONGEST {
            let received = bytes.len();
            tracing::warn!(
                "a trajectory is refused: received {received} bytes, expected at most {LONGEST}"
            );
        } else if queue.try_send(bytes.to_vec()).is_err() {
            tracing::warn!("a trajectory is refused: {MOST_WAITING} others wait already");
        }
    };
    Ok([
        transport.subscribe(&endpoint.key, Box::new(on_bytes))?,
        transport.announce(&endpoint.token)?,
    ])
}
