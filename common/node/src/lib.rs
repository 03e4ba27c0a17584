//! What a node is.
//!
//! A [`Node`] decides and never does I/O: time and messages come in as arguments, what it wants
//! sent goes out as bytes. The real world (`coaxle-host`) and the pretend one (`coaxle-sim`) call
//! the very same code.

pub mod answering;
pub mod arrival;
pub mod cam_file;
mod channel;
pub mod command;
pub mod config;
pub mod contract;
pub mod exchange;
pub mod faults;
pub mod frame;
pub mod intake;
pub mod keys;
mod message;
mod rejection;
pub mod saw_file;

pub use answering::{Answering, AnsweringCounters};
pub use arrival::Arrival;
pub use command::{CommandAnswer, CommandOrder, CommandOutcome};
pub use contract::{Channel, Message, Node, Outgoing};
pub use exchange::Question;
pub use frame::{FrameHeader, Sample};
pub use intake::{Intake, Reader, Rejection, RejectionCounters};
