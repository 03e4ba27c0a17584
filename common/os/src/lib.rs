//! What a program has of its machine, whatever it does: nodes, the experiments and the tool stand on it.
//!
//! * [`System`] is the operating system, in one place: threads, sockets, files, processes. [`Os`] is the one this was built for;
//!   nothing outside of it asks which that is.
//! * [`machine`] is the machine's clock: what it reads, and waiting until it reads something.
//! * [`exit`] says how a program ends: exit codes, and the mistakes of users, with what was received and what is expected.
//! * [`Trace`] and [`ArrivalsTrace`] are files of rows that can be read at any moment, however the program ends.
//! * `Interrupt`, with the feature `signals`, is Ctrl-C while a tool works.
//!
//! It knows no transport: what stands on it alone is built without one.

mod arrivals;
#[cfg(feature = "signals")]
mod ended;
pub mod exit;
#[cfg(feature = "signals")]
mod interrupt;
pub mod machine;
mod system;
mod trace;

pub use arrivals::{ArrivalsTrace, arrivals_beside, exchanges_beside};
#[cfg(feature = "signals")]
pub use ended::Ended;
#[cfg(feature = "signals")]
pub use interrupt::Interrupt;
pub use machine::Machine;
pub use system::*;
pub use trace::Trace;
