//! Tests of the simulation itself, with nodes that only record.

mod clocks;
mod faults;
mod invariants;
mod links;
mod repeated;
mod routers;
mod toy;
