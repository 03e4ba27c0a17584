//! The simulation itself, with nodes that only remember.

mod clocks;
mod faults;
mod invariants;
mod links;
mod repeated;
mod routers;
mod toy;
