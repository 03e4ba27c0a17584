//! Access of a program to its machine: nodes, the experiments and the tool are built on it.
//!
//! * [`System`] is the operating system, in one place: threads, sockets, files, processes. [`Os`] is the
//!   one this was built for; nothing outside of it depends on which one that is.
//! * [`ClaimedPort`] is a free port for a program that is to be started.
//! * [`machine`] is the machine's clock: reading it, and sleeping until a time.
//! * [`exit`] has the exit codes of a program, and the mistakes of users, with the values received and
//!   expected.
//! * [`Trace`] and [`ArrivalsTrace`] are files of rows that can be read at any moment, however the
//!   program ends.
//! * `Interrupt`, with the feature `signals`, is Ctrl-C while a tool works.
//!
//! The crate knows no transport: programs on it alone are built without one.

mod arrivals;
mod clock_pair;
#[cfg(feature = "signals")]
mod end_reason;
pub mod exit;
#[cfg(feature = "signals")]
mod interrupt;
pub mod machine;
mod ports;
mod ptp;
mod system;
mod trace;

pub use arrivals::{ArrivalsTrace, arrivals_beside, exchanges_beside};
pub use clock_pair::ClockPair;
#[cfg(feature = "signals")]
pub use end_reason::EndReason;
#[cfg(feature = "signals")]
pub use interrupt::Interrupt;
pub use machine::Machine;
pub use ports::ClaimedPort;
pub use ptp::{PtpService, PtpState};
pub use system::*;
pub use trace::Trace;
