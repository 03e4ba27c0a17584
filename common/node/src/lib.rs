//! What a node is.
//!
//! A [`Node`] decides and never does I/O: time and messages come in as arguments, what it wants
//! sent goes out as bytes. The real world (`coaxle-host`) and the pretend one (`coaxle-sim`) call
//! the very same code.

pub mod arrival;
pub mod cam_file;
pub mod config;
pub mod contract;
pub mod faults;
pub mod saw_file;

pub use arrival::Arrival;
pub use coaxle_wire::{
    Answering, AnsweringCounters, CommandAnswer, CommandOrder, CommandOutcome, FrameHeader, Intake,
    Question, Reader, Rejection, RejectionCounters, Sample, answering, command, exchange, frame,
    intake, keys,
};
pub use contract::{Channel, Message, Node, Outgoing};
