//! The contract of a node, its config and its faults.
//!
//! A [`Node`] decides and never does I/O: time and messages come in as arguments, messages to send
//! go out as bytes. The real world (`coaxle-host`) and the simulation (`coaxle-sim`) call the very
//! same code.

pub mod arrival;
pub mod circles;
pub mod config;
pub mod contract;
pub mod faults;
mod fields;
pub mod guess;
pub mod lab;
pub mod signal;
pub mod text_file;
pub mod two_columns;
pub mod wiring;

pub use arrival::{Arrival, Arrived};
pub use coaxle_wire::{
    AxisPlan, AxisSample, BeaconIntake, BeaconRequest, BeaconResponse, BeaconServer,
    BeaconServerCounters, CommandAnswer, CommandOrder, CommandOutcome, FollowerReport,
    FollowerState, Frame, FrameHeader, Intake, InvalidScan, KeptMessage, MOST_CHARACTERS, NodeScan,
    PlanIntake, PlannedPiece, PresentAfter, Reader, ReceivedMessage, ReceivedReport, Rejection,
    RejectionCounters, ReportIntake, RunCycle, Stamps, TimeRequest, TimeServer, TimeServerCounters,
    audit, beacon, command, document, exchange, followers, frame, intake, keys, one_line, plan,
    time_server,
};
pub use contract::{Channel, Message, Node, Outgoing};
pub use fields::fields_of;
