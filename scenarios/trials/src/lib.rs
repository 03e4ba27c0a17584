//! The real path tried: real nodes, real processes, real Zenoh.
//!
//! From the top down:
//!
//! * [`processes`] plays a scenario as processes of this machine: a [`Stage`](coaxle_lab::stage::Stage) of the lab;
//! * [`recording`] records how messages between such processes arrive;
//! * [`bench`] measures how late cycles wake and how long a sample is on its way;
//! * [`scale`] finds the largest number of axes that fit into a cycle;
//! * [`conform`] judges a sender or a receiver of somebody else by docs/WIRE.md;
//! * [`Bar`] shows how far something is, and hears Ctrl-C.
//!
//! What is measured or judged here depends on the machine: nothing of it is in a test but that it works.

mod bar;
pub mod bench;
pub mod conform;
pub mod processes;
pub mod recording;
pub mod scale;

pub use bar::Bar;
