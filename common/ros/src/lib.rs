//! ROS 2 over Zenoh, compatible with rmw_zenoh: axes as joint states out, trajectories in. docs/ROS2.md
//! is its manual.
//!
//! * [`message`]: `sensor_msgs/JointState` and `trajectory_msgs/JointTrajectory`, as bytes ([`CdrError`]).
//! * [`entity`]: a ROS node, the keys of its topics and its liveliness tokens; [`attachment`]: the data
//!   beside each sample.
//! * [`mod@unit`]: metres and radians; [`catalog`]: the joints of a node, from its status.
//! * [`source`]: frames of a node in, joint states out, dated by [`cycle_starts`].
//! * [`trajectory`]: the plan of a trajectory, or its refusal; [`trajectory_queue`]: the schedule of its orders.
//!
//! Nothing here sends or receives, and every instant is an argument. All I/O is elsewhere.
//!
//! ```
//! use coaxle_ros::entity::{EndpointRole, RosDomain, RosName, RosNamespace, RosNode};
//! use coaxle_ros::message::{JOINT_STATE, JointState};
//!
//! let node = RosNode {
//!     domain: RosDomain::default(),
//!     session: "aac3178e146ba6f1fc6e6a4085e77f21".to_owned(),
//!     namespace: RosNamespace::new("/line1")?,
//!     name: RosName::new("coaxle")?,
//! };
//! let endpoint = node.endpoint(1, EndpointRole::Publisher, &RosName::new("joint_states")?, JOINT_STATE);
//! assert!(endpoint.key.starts_with("0/line1/joint_states/sensor_msgs::msg::dds_::JointState_/RIHS01_"));
//!
//! let state = JointState {
//!     name: vec!["conveyor/belt".to_owned()],
//!     position: vec![1.5],
//!     ..JointState::default()
//! };
//! assert_eq!(JointState::from_bytes(&state.to_bytes())?, state);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod attachment;
pub mod catalog;
mod cdr;
pub mod cycle_starts;
pub mod entity;
pub mod message;
pub mod source;
pub mod trajectory;
pub mod trajectory_queue;
pub mod unit;

pub use cdr::CdrError;
