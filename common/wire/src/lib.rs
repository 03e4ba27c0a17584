//! Messages between nodes: `docs/WIRE.md` is their manual, byte by byte.
//!
//! * [`frame`]: the axes of a node, once per cycle of its own clock.
//! * [`exchange`]: time requests and responses; [`TimeServer`] responds.
//! * [`plan`]: motions of axes, promised ahead.
//! * [`followers`]: reports on the slaves of an axis, to its node.
//! * [`beacon`]: time requests and responses near the wire, beside the transport.
//!   [`BeaconServer`] responds.
//! * [`command`]: orders to the slaves of a node from anywhere, and their results: JSON.
//! * [`document`]: what a file or a message holds, and the field of it that is wrong.
//! * [`audit`]: who was refused what by a node, and who did what there: JSON.
//! * [`keys`]: the key expressions under which all of it travels.
//! * [`intake`]: arriving bytes become a [`Message`], or a [`Rejection`] with its reason.
//!
//! Nothing here sends or receives. A node returns an [`Outgoing`] body to be sent; the publishing thread
//! seals it with the send stamp and the check sum at the last moment.
//!
//! ```
//! use coaxle_axis::NcToPlcAxis;
//! use coaxle_clock::{CycleIndex, CycleTime, Span};
//! use coaxle_wire::frame::{body_capacity, encode_body, sender_id};
//! use coaxle_wire::keys::NodeName;
//! use coaxle_wire::{Channel, FrameHeader, Intake, Rejection};
//!
//! let conveyor = NodeName::new("conveyor")?;
//! let header = FrameHeader {
//!     sender: sender_id(&conveyor),
//!     epoch: 5,
//!     index: CycleIndex(9),
//!     count: 9,
//!     cycle_time: CycleTime::new(Span::from_millis(1))?,
//!     present_after: None,
//!     send_stamp: None,
//! };
//! let axis = NcToPlcAxis { axis_id: 3, set_position: 2.5, ..NcToPlcAxis::default() };
//! let mut body = vec![0; body_capacity(1)];
//! let length = encode_body(&header, &[axis], &mut body)?;
//!
//! // Without its send stamp and check sum it is no frame yet.
//! let mut intake = Intake::new(&conveyor.channel_key(Channel::Axes), &conveyor, &[3]);
//! assert!(intake.accept(&body[..length]).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod audit;
pub mod beacon;
pub mod beacon_intake;
pub mod beacon_server;
mod channel;
mod circle_change;
pub mod command;
pub mod document;
pub mod exchange;
pub mod followers;
pub mod frame;
pub mod intake;
pub mod keys;
mod message;
mod one_line;
pub mod plan;
mod present_after;
mod rejection;
mod run_cycle;
mod scan;
pub mod time_server;

pub use beacon::{BeaconRequest, BeaconResponse, Stamps};
pub use beacon_intake::BeaconIntake;
pub use beacon_server::{BeaconServer, BeaconServerCounters};
pub use channel::Channel;
pub use circle_change::CircleChange;
pub use command::{CommandAnswer, CommandOrder, CommandOutcome};
pub use exchange::TimeRequest;
pub use followers::{FollowerReport, ReportIntake};
pub use frame::{AxisSample, Frame, FrameHeader};
pub use intake::{Intake, Reader};
pub use message::{FollowerState, KeptMessage, Message, Outgoing, PlannedPiece, ReceivedReport};
pub use one_line::{MOST_CHARACTERS, one_line};
pub use plan::{AxisPlan, PlanIntake};
pub use present_after::PresentAfter;
pub use rejection::{Rejection, RejectionCounters};
pub use run_cycle::RunCycle;
pub use scan::{InvalidScan, NodeScan, ReceivedMessage, SCAN_VERSION};
pub use time_server::{TimeServer, TimeServerCounters};
