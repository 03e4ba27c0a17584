//! A pretend world.
//!
//! True time flows in an event queue; every node lives on a drifting clock of its own and calls the
//! very code that real machines run. Same seed, same bytes. Nodes cannot name [`True`] time; only
//! the world and its [`Oracle`] see it.

mod events;
mod invariants;
mod oracle;
mod world;

pub use invariants::Violation;
pub use oracle::{Oracle, Truth, TruthSample};
pub use world::{CycleSeen, Factory, LinkSetup, NodeSetup, Observer, True, World};
